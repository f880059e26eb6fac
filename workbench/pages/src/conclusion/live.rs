//! What the last reports of a drive say that is listened to.

use super::listed;
use crate::page::counted;
use crate::segments::Judged;

/// What is known of a drive that is listened to.
#[derive(Clone, Debug)]
pub struct Heard<'a> {
    /// Names of the classes.
    pub classes: &'a [String],
    /// The healthy class.
    pub healthy: Option<usize>,
    /// The alarm: number of its segment, and cause.
    pub alarm: Option<&'a (f64, String)>,
    /// What has risen, of an alarm by a direction ([`super::risen`]); else empty.
    pub risen: &'a str,
    /// The last segments.
    pub judged: &'a [Judged],
}

/// The sentences.
#[must_use]
pub fn words(live: &Heard<'_>) -> String {
    let Some(last) = live.judged.last() else {
        return "No statement: no segment was reported yet. Leave the drive running.".into();
    };
    let classes = live.classes.len();
    let with = |places: &dyn Fn(usize) -> bool| live.judged.iter().filter(|own| places(own.place)).count();
    let decided = with(&|place| place <= classes);
    let departs = with(&|place| place <= classes && Some(place) != live.healthy);
    let (all, evidence) = (counted(decided, "decided segment"), evidence(last));
    let without = match live.judged.len() - with(&|place| place <= classes) {
        0 => String::new(),
        count => format!(" Without a decision: {}.", counted(count, "segment")),
    };
    if let Some((at, cause)) = live.alarm {
        let what = if cause == "unknown" { "a defect of no trained class" } else { cause };
        let what = match live.risen {
            "" => format!("{what}, raised in segment {at:.0}."),
            risen => format!("{risen} The alarm was raised in segment {at:.0}."),
        };
        return format!(
            "ALARM: {what} Of the last {all}, {departs} depart from healthy{evidence}.\
             {without} Inspect the bearing."
        );
    }
    if decided == 0 {
        return format!(
            "No statement on the bearing: no segment is decided.{without} Compare its motion with the training."
        );
    }
    if live.healthy.is_none() {
        let names = listed(live.classes);
        return format!(
            "This model has no healthy class among {names}: it raises no alarm.{without} Train with healthy records."
        );
    }
    if departs == 0 {
        let next = "No action is needed. Defects smaller than the model can detect are not excluded.";
        return format!("No defect found in the last {all}{evidence}.{without} {next}");
    }
    let first = live.judged.iter().find(|own| own.place <= classes && Some(own.place) != live.healthy);
    let since = first.map_or(0.0, |own| own.span.1);
    format!(
        "No alarm, but of the last {all}, {departs} depart from healthy, the first in segment {since:.0}{evidence}.\
         {without} Watch on before you decide."
    )
}

/// The evidence after a segment, if there is any.
fn evidence(last: &Judged) -> String {
    last.score.filter(|score| score.is_finite()).map_or_else(String::new, |score| format!("; evidence {score:.1} nats"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Segments of these places, of a healthy class and a spall.
    fn judged(places: &[usize]) -> Vec<Judged> {
        let one = |(k, place): (usize, &usize)| {
            let span = (k as f64, k as f64 + 1.0);
            Judged { span, place: *place, score: Some(1.25), ..Judged::blank(2) }
        };
        places.iter().enumerate().map(one).collect()
    }

    fn said(places: &[usize], healthy: Option<usize>, alarm: Option<&(f64, String)>, risen: &str) -> String {
        let classes = &["healthy", "spall"].map(String::from);
        words(&Heard { classes, healthy, alarm, risen, judged: &judged(places) })
    }

    #[test]
    fn each_state_of_a_drive_has_its_sentence() {
        for (places, start, part) in [
            (&[][..], "No statement: no segment was reported yet.", "Leave"),
            (&[0, 0], "No defect found in the last 2 decided segments; evidence 1.2 nats.", "No action is needed."),
            (&[0, 1, 2], "No alarm, but of the last 3 decided segments, 2 depart", "the first in segment 2"),
            (&[4, 4], "No statement on the bearing", "Without a decision: 2 segments."),
            (&[0, 3], "No defect found in the last 1 decided segment;", "Without a decision: 1 segment."),
        ] {
            let text = said(places, Some(0), None, "");
            assert!(text.starts_with(start) && text.contains(part), "{text}");
        }
        let alarmed = said(&[0, 2], Some(0), Some(&(2.0, "unknown".into())), "");
        assert!(alarmed.starts_with("ALARM: a defect of no trained class, raised in segment 2."), "{alarmed}");
        let risen = said(&[0, 0], Some(0), Some(&(2.0, "order_outer".into())), "outer order has risen.");
        let start =
            "ALARM: outer order has risen. The alarm was raised in segment 2. Of the last 2 decided segments, 0";
        assert!(risen.starts_with(start), "{risen}");
        let without = said(&[0], None, None, "");
        assert!(without.contains("no healthy class among healthy and spall"), "{without}");
    }
}
