//! The alarm of a report in words and as JSON.

use bearing_watch::alarm::Contribution;
use bearing_watch::telemetry::Summary;
use bearing_watch::{Alarm, Cause};
use serde_json::{Value, json};

use super::names::Names;
use model::core::coordinates::{Side, in_words};
use pages::conclusion::risen::{others, sentence};

/// What an alarm says, and of one by a direction when it began; `None` if none stands.
pub(super) fn line(names: &Names, summary: &Summary<'_>) -> Option<String> {
    let Alarm { segment, cause } = summary.alarm?;
    let after =
        names.time_s(segment).map_or_else(String::new, |time_s| format!(", after {} of segments", span(time_s)));
    let what = risen(names, summary).unwrap_or_else(|| words(names, cause));
    Some(format!("ALARM at segment {segment}{after}: {what}"))
}

/// What has risen, by how much and since when; `None` without an alarm by a direction.
pub(super) fn risen(names: &Names, summary: &Summary<'_>) -> Option<String> {
    let (Some(Alarm { cause: Cause::Coordinate(place), .. }), Some(main)) = (summary.alarm, summary.risen) else {
        return None;
    };
    let cause = names.coordinate(place);
    let all = summary.contributions.iter().map(|(coordinate, one)| (names.coordinate(coordinate), one.deviations));
    let others = others(&all.collect::<Vec<_>>(), &cause);
    let since = format!("segment {}", main.since.saturating_add(1));
    let (side, by) = (Side::of(main.deviations), format!("{:.1}", main.deviations.abs()));
    Some(sentence((&cause, side), &by, &since, &others))
}

/// The cause of an alarm of which no more is known.
pub(super) fn words(names: &Names, cause: Cause) -> String {
    match cause {
        Cause::Coordinate(place) => format!("{} has {}", in_words(&names.coordinate(place)), Side::Risen),
        Cause::Fallen(place) => format!("{} has {}", in_words(&names.coordinate(place)), Side::Fallen),
        Cause::Class(_) | Cause::Unknown => name(names, cause),
    }
}

/// The name of a cause.
pub(super) fn name(names: &Names, cause: Cause) -> String {
    match cause {
        Cause::Class(class) => names.class(class),
        Cause::Unknown => "unknown".into(),
        Cause::Coordinate(place) => names.coordinate(place),
        Cause::Fallen(place) => format!("{} lower than usual", names.coordinate(place)),
    }
}

pub(super) fn value(names: &Names, summary: &Summary<'_>) -> Option<Value> {
    let Alarm { segment, cause } = summary.alarm?;
    Some(json!({
        "segment": segment,
        "cause": name(names, cause),
        "after_s": names.time_s(segment),
        "deviations": summary.risen.map(|main| main.deviations),
        "since": summary.risen.map(|main| main.since.saturating_add(1)),
    }))
}

/// What each direction contributes, with the keys of `replay`.
pub(super) fn directions(names: &Names, summary: &Summary<'_>) -> Vec<Value> {
    let value = |(coordinate, one): (u8, Contribution)| {
        json!({
            "direction": names.coordinate(coordinate),
            "deviations": one.deviations,
            "score": one.score,
            "since": (one.score > 0.0).then_some(one.since.saturating_add(1)),
        })
    };
    summary.contributions.iter().map(value).collect()
}

/// A time in a unit in which it has few digits.
fn span(time_s: f64) -> String {
    match time_s {
        ..600.0 => format!("{time_s:.1} s"),
        ..36_000.0 => format!("{:.1} min", time_s / 60.0),
        _ => format!("{:.1} h", time_s / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_have_few_digits() {
        assert_eq!([43.2, 660.0, 7.2e4].map(span), ["43.2 s", "11.0 min", "20.0 h"]);
    }
}
