//! What an audit says of recordings.

use crate::page::counted;

/// The sentences, from the number of recordings, and what was found in which of them.
#[must_use]
pub fn words(count: usize, findings: &[(&str, &[String])]) -> String {
    let all = counted(count, "recording");
    let Some((what, traces)) = findings.iter().rev().max_by_key(|(_, traces)| traces.len()) else {
        return format!("Nothing wrong was found in {all}. Train with them, or replay them.");
    };
    let first = traces.first().map_or("–", String::as_str);
    let more = match traces.len() {
        0 | 1 => String::new(),
        n => format!(" and {} more", n - 1),
    };
    format!(
        "{} in {all}. Most frequent: {what} (in {first}{more}). Correct the recordings, or leave these out, before you \
         train with them.",
        counted(findings.len(), "finding"),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_most_frequent_finding_is_named() {
        assert_eq!(words(1, &[]), "Nothing wrong was found in 1 recording. Train with them, or replay them.");
        let (one, two) = (["a".to_owned()], ["b".to_owned(), "c".to_owned()]);
        let text = words(3, &[("gaps in time", &one), ("irregular times", &two)]);
        assert!(
            text.starts_with("2 findings in 3 recordings. Most frequent: irregular times (in b and 1 more)."),
            "{text}"
        );
    }
}
