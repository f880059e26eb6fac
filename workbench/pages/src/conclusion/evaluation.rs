//! What an evaluation says of a model.

use model::core::Finding;
use model::evaluate::{Confusion, TraceVerdict};

/// The sentences, from the counts of the trained classes and all verdicts with the names of their true classes.
#[must_use]
pub fn words(confusion: &Confusion, verdicts: &[TraceVerdict], classes: &[String]) -> String {
    let trained = confusion.classes.len();
    let mut text = if confusion.total() == 0 {
        "No trace is of a trained class, so no error rate is known.".to_owned()
    } else {
        known(confusion, verdicts, classes)
    };
    let other: Vec<&TraceVerdict> = verdicts.iter().filter(|own| own.class >= trained).collect();
    if let Some(healthy) = confusion.healthy.filter(|_| !other.is_empty()) {
        let missed = other.iter().filter(|own| own.decided == Some(Finding::Class(healthy))).count();
        text += &format!(" Of {} traces of classes that were not trained, {missed} are called healthy.", other.len());
    }
    if confusion.healthy.is_none() {
        text += " The model has no healthy class: it cannot say that a drive is healthy.";
    }
    text
}

fn known(confusion: &Confusion, verdicts: &[TraceVerdict], classes: &[String]) -> String {
    let (wrong, total) = (confusion.wrong(), confusion.total());
    let rate = confusion.error_rate();
    let sure = format!("95 % interval {:.1} to {:.1} %", 100.0 * rate.low, 100.0 * rate.high);
    if wrong == 0 {
        return format!(
            "All {total} decisions are right; the error rate is 0 % ({sure}). More traces narrow the interval."
        );
    }
    let n = confusion.classes.len();
    let errors = (0..n).flat_map(|truth| (0..n + 3).map(move |decided| (truth, decided)));
    let errors = errors.filter(|(truth, decided)| truth != decided).rev();
    let Some((truth, decided)) = errors.max_by_key(|(truth, decided)| confusion.counts[*truth][*decided]) else {
        return String::new();
    };
    let called = match decided - decided.min(n) {
        _ if decided < n => format!("called {}", confusion.classes[decided]),
        0 => "without verdict".to_owned(),
        1 => "called novel".to_owned(),
        _ => "called ambiguous".to_owned(),
    };
    let example = verdicts.iter().find(|own| own.class == truth && own.decided != Some(Finding::Class(truth)));
    let example = example.map_or_else(String::new, |own| format!(", for example in {}", own.id));
    let name = classes.get(truth).map_or("–", String::as_str);
    let count = confusion.counts[truth][decided];
    format!(
        "{wrong} of {total} decisions are wrong: {:.1} % ({sure}). Most frequent: {name} {called}, {count} times{example}. \
         Look at these traces below before you use the model.",
        100.0 * rate.value
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names() -> Vec<String> {
        ["healthy", "spall"].map(String::from).to_vec()
    }

    #[test]
    fn without_an_error_the_interval_says_how_sure() {
        let mut confusion = Confusion { healthy: Some(0), ..Confusion::new(&names()) };
        (0..10).for_each(|_| confusion.add(0, Some(0)));
        let text = words(&confusion, &[], &names());
        assert!(
            text.starts_with("All 10 decisions are right; the error rate is 0 % (95 % interval 0.0 to 2"),
            "{text}"
        );
    }

    #[test]
    fn the_most_frequent_error_is_named() {
        let mut confusion = Confusion::new(&names());
        confusion.add(0, Some(0));
        confusion.add(0, None);
        (0..2).for_each(|_| confusion.add(1, Some(0)));
        let text = words(&confusion, &[], &names());
        assert!(text.starts_with("3 of 4 decisions are wrong: 75.0 %"), "{text}");
        assert!(text.contains("Most frequent: spall called healthy, 2 times."), "{text}");
        assert!(text.ends_with("The model has no healthy class: it cannot say that a drive is healthy."), "{text}");
    }

    #[test]
    fn traces_of_other_classes_give_no_error_rate() {
        let text = words(&Confusion { healthy: Some(0), ..Confusion::new(&names()) }, &[], &names());
        assert_eq!(text, "No trace is of a trained class, so no error rate is known.");
    }
}
