//! What an alarm by a direction says, in the words of `replay` and `listen`.

use model::core::coordinates::{Side, in_words};

/// A run this many deviations from the drive's usual mean is not as usual.
pub(crate) const USUAL: f32 = 3.0;

/// Coordinates beside that of the alarm, in words.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Others {
    risen: Vec<String>,
    fallen: Vec<String>,
    usual: Vec<String>,
}

/// What has risen or fallen, `by` how many deviations, since when (empty if that is not known), and what the others
/// have done.
#[must_use]
pub fn sentence((cause, side): (&str, Side), by: &str, since: &str, others: &Others) -> String {
    let again = |other: Side| if other == side { " too" } else { "" };
    let moved = |names: &[String], other: Side| {
        let too = again(other);
        list(names, &format!("has {other}{too}"), &format!("have {other}{too}"))
    };
    let others = moved(&others.risen, Side::Risen)
        + &moved(&others.fallen, Side::Fallen)
        + &list(&others.usual, "is as usual", "are as usual");
    let since = if since.is_empty() { String::new() } else { format!(", since {since}") };
    format!(
        "{} has {side}. It is {by} standard deviations of runs {} what is usual for this drive{since}{others}.",
        in_words(cause),
        side.place(),
    )
}

/// Of coordinates, with their deviations at the end of a run, those beside the cause. One that several directions watch
/// has moved if one of them has.
#[must_use]
pub fn others(all: &[(String, f32)], cause: &str) -> Others {
    let largest = |name: &String| {
        let own = all.iter().filter(|(other, _)| other == name).map(|(_, deviations)| *deviations);
        own.max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or_default()
    };
    let mut others = Others::default();
    for (name, _) in all.iter().filter(|(name, _)| name != cause) {
        let deviations = largest(name);
        let list = match Side::of(deviations) {
            _ if deviations.abs() < USUAL => &mut others.usual,
            Side::Risen => &mut others.risen,
            Side::Fallen => &mut others.fallen,
        };
        let words = in_words(name);
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
        let all = [("drag", 0.4), ("order_outer", 19.3), ("viscous", -2.0), ("order_inner", 3.0), ("drag", 0.1)];
        let all = all.map(|(name, deviations)| (name.to_owned(), deviations));
        assert_eq!(
            sentence(("order_outer", Side::Risen), "19.3", "segment 34", &others(&all, "order_outer")),
            "outer order has risen. It is 19.3 standard deviations of runs above what is usual for this drive, since \
             segment 34; inner order has risen too; drag and viscous friction are as usual."
        );
        assert_eq!(
            sentence(("drag", Side::Risen), "at least 63.8", "", &Others::default()),
            "drag has risen. It is at least 63.8 standard deviations of runs above what is usual for this drive."
        );
    }

    #[test]
    fn a_fall_is_named_like_a_rise() {
        let all = [("drag", -7.5), ("viscous", -3.0), ("drag", 0.4), ("order_inner", 6.0), ("z4", 0.0)];
        let all = all.map(|(name, deviations)| (name.to_owned(), deviations));
        assert_eq!(
            sentence(("drag", Side::Fallen), "7.5", "segment 5", &others(&all, "drag")),
            "drag has fallen. It is 7.5 standard deviations of runs below what is usual for this drive, since segment \
             5; inner order has risen; viscous friction has fallen too; coordinate 4 is as usual."
        );
        let of_spall = sentence(("order_inner", Side::Risen), "6.0", "", &others(&all, "order_inner"));
        assert!(of_spall.ends_with("; drag and viscous friction have fallen; coordinate 4 is as usual."), "{of_spall}");
    }
}
