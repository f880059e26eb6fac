//! Compares the lines of a document with new ones.

/// How many lines of a difference are shown.
const SHOWN: usize = 6;

/// How far numbers may differ; the text between them must be equal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tolerance {
    /// Not at all.
    Exact,
    /// By this part of the larger one.
    Within(f64),
    /// At will: measured times.
    Any,
}

/// The first lines that differ, or none. A number is compared with the one at the same place of the same line.
pub fn difference(documented: &[String], found: &[String], tolerance: Tolerance) -> Option<String> {
    let mut text = Vec::new();
    for k in 0..documented.len().max(found.len()) {
        let (old, new) = (documented.get(k), found.get(k));
        if old.zip(new).is_some_and(|(old, new)| alike(old, new, tolerance)) {
            continue;
        }
        text.extend(old.map(|line| format!("- {line}")));
        text.extend(new.map(|line| format!("+ {line}")));
    }
    if text.len() > SHOWN {
        let more = text.len() - SHOWN;
        text.truncate(SHOWN);
        text.push(format!("  … and {more} more lines"));
    }
    (!text.is_empty()).then(|| text.join("\n"))
}

fn alike(old: &str, new: &str, tolerance: Tolerance) -> bool {
    if tolerance == Tolerance::Exact {
        return old == new;
    }
    let (old, new) = (pieces(old), pieces(new));
    old.len() == new.len()
        && old.iter().zip(&new).all(|(old, new)| match (old.parse::<f64>(), new.parse::<f64>()) {
            (Ok(a), Ok(b)) => match tolerance {
                Tolerance::Within(part) => (a - b).abs() <= part * a.abs().max(b.abs()),
                _ => true,
            },
            _ => old == new,
        })
}

/// Cuts a line into numbers (`12`, `0.5`, `1.2e-3`, `1e+06`) and the text between them.
fn pieces(line: &str) -> Vec<&str> {
    let mut pieces = Vec::new();
    let mut rest = line;
    while !rest.is_empty() {
        let text = rest.find(|c: char| c.is_ascii_digit()).unwrap_or(rest.len());
        let (before, number) = rest.split_at(text);
        let (number, after) = number.split_at(number_length(number));
        pieces.extend([before, number].into_iter().filter(|piece| !piece.is_empty()));
        rest = after;
    }
    pieces
}

/// Length of the number at the start of a text that starts with a digit, or 0.
fn number_length(text: &str) -> usize {
    let digits = |text: &str| text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
    let mut length = digits(text);
    let after = |length: usize, start: &[&str]| {
        let rest = text.get(length..).unwrap_or_default();
        let start = start.iter().find(|start| rest.starts_with(**start))?;
        let count = digits(rest.get(start.len()..).unwrap_or_default());
        (count > 0).then_some(length + start.len() + count)
    };
    length = after(length, &["."]).unwrap_or(length);
    after(length, &["e-", "e+", "e"]).unwrap_or(length)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_a_tolerance_and_text_has_none() {
        let differ = |old: &str, new: &str, tolerance| difference(&[old.into()], &[new.into()], tolerance).is_some();
        assert_eq!(pieces("LS 5 / 8.25 | 1.2e-3, 7e"), ["LS ", "5", " / ", "8.25", " | ", "1.2e-3", ", ", "7", "e"]);
        let close = Tolerance::Within(0.05);
        assert!(!differ("| a | 100 |", "| a | 104 |", close) && differ("| a | 100 |", "| a | 106 |", close));
        assert!(differ("| a | 100 |", "| b | 100 |", close) && differ("| a | 100 |", "| a | 100 | 1 |", close));
        assert!(differ("| a | 100 |", "| a | 104 |", Tolerance::Exact));
        assert!(!differ("| a | 1.5 ms |", "| a | 27 ms |", Tolerance::Any));
        let many: Vec<String> = (0..20).map(|k| format!("line {k}")).collect();
        let text = difference(&many, &[], Tolerance::Exact).unwrap_or_default();
        assert!(text.starts_with("- line 0\n") && text.ends_with("… and 14 more lines"), "{text}");
    }
}
