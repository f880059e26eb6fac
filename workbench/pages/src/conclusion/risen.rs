//! What an alarm by a direction says, in the words of `replay` and `listen`.

use model::train::directions::in_words;

/// A run this many deviations above the drive's usual mean is not as usual.
pub(crate) const USUAL: f32 = 3.0;

/// What has risen, `by` how many deviations, since when (empty if that is not known), and what else has risen or not.
#[must_use]
pub fn sentence(cause: &str, by: &str, since: &str, [too, usual]: &[Vec<String>; 2]) -> String {
    let others = list(too, "has risen too", "have risen too") + &list(usual, "is as usual", "are as usual");
    let since = if since.is_empty() { String::new() } else { format!(", since {since}") };
    format!(
        "{} has risen. It is {by} standard deviations of runs above what is usual for this drive{since}{others}.",
        in_words(cause)
    )
}

/// Of features, with their deviations at the end of a run, those beside the cause that have risen, and those that have
/// not, in words.
#[must_use]
pub fn others(features: &[(String, f32)], cause: &str) -> [Vec<String>; 2] {
    let risen = |name: &String| features.iter().any(|(other, deviations)| other == name && *deviations >= USUAL);
    let mut others = [vec![], vec![]];
    for (name, _) in features.iter().filter(|(name, _)| name != cause) {
        let (words, list) = (in_words(name), &mut others[usize::from(!risen(name))]);
        if !list.contains(&words) {
            list.push(words);
        }
    }
    others
}

fn list(names: &[String], one: &str, several: &str) -> String {
    match names {
        [] => String::new(),
        [name] => format!("; {name} {one}"),
        [first @ .., last] => format!("; {} and {last} {several}", first.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sentence_names_what_has_risen_and_what_has_not() {
        let features = [("drag", 0.4), ("order_outer", 19.3), ("viscous", -5.0), ("order_inner", 3.0), ("drag", 0.1)];
        let features = features.map(|(name, deviations)| (name.to_owned(), deviations));
        assert_eq!(
            sentence("order_outer", "19.3", "segment 34", &others(&features, "order_outer")),
            "outer order has risen. It is 19.3 standard deviations of runs above what is usual for this drive, since \
             segment 34; inner order has risen too; drag and viscous friction are as usual."
        );
        assert_eq!(
            sentence("drag", "at least 63.8", "", &others(&[], "drag")),
            "drag has risen. It is at least 63.8 standard deviations of runs above what is usual for this drive."
        );
    }
}
