//! Segments from a CAN bus as lines of text and as JSON.

use std::collections::BTreeMap;

use bearing_watch::telemetry::SegmentFrame;
use bearing_watch::{Cause, Verdict};
use serde_json::{Value, json};

use super::course::{CourseCounts, Segment};
use super::log::Counts;
use crate::drive::can_id::CanId;
use crate::drive::listen::names::Names;
use crate::drive::listen::{alarm, report_text};
use model::core::coordinates::Side;
use pages::conclusion::risen::{Others, sentence};

/// The most deviations that a frame can tell ([`SegmentFrame::deviations`]).
const MOST: f32 = 63.75;

pub(super) fn verdict(names: &Names, frame: SegmentFrame) -> String {
    report_text::verdict(names, frame.verdict())
}

/// Why there is no verdict; the rows of a reason are not in the frame.
fn reason(frame: SegmentFrame) -> Option<String> {
    let Verdict::Undetermined(reason) = frame.verdict() else { return None };
    let text = reason.to_string();
    Some(["(0)", "(0 rows)"].iter().fold(text.as_str(), |text, rows| text.trim_end_matches(rows)).trim_end().into())
}

pub(super) fn alarm_name(names: &Names, cause: Cause) -> String {
    alarm::name(names, cause)
}

/// The first frame with an alarm, its cause, and of a coordinate by how much it has risen.
pub(super) fn alarm_line(names: &Names, Segment { time_s, number, frame, .. }: &Segment, cause: Cause) -> String {
    let what = match (cause, frame.deviations()) {
        (Cause::Coordinate(_), by) => {
            // The last step also stands for more.
            let least = if by >= MOST { "at least " } else { "" };
            sentence((&alarm_name(names, cause), Side::Risen), &format!("{least}{by:.1}"), "", &Others::default())
        }
        (Cause::Class(_) | Cause::Unknown | Cause::Fallen(_), _) => alarm::words(names, cause),
    };
    format!("ALARM at segment {number}, {time_s:.3} s: {what}")
}

pub(super) fn segment_line(names: &Names, segment: &Segment) -> String {
    let Segment { time_s, number, frame, again } = *segment;
    let again = if again { " again" } else { "" };
    let outcome = match reason(frame) {
        Some(reason) => format!("undetermined: {reason}"),
        None => format!("{}, distance {:.2}", verdict(names, frame), frame.distance()),
    };
    format!("{time_s:.3} s  segment {number}{again}  {outcome}, {} % usable", frame.usable_percent())
}

pub(super) fn segment_value(names: &Names, segment: &Segment) -> Value {
    let Segment { time_s, number, frame, again } = *segment;
    let class = matches!(frame.verdict(), Verdict::Class(_)).then(|| verdict(names, frame));
    let cause = |cause| json!({ "cause": alarm_name(names, cause), "deviations": frame.deviations() });
    json!({
        "kind": "segment",
        "time_s": time_s,
        "segment": number,
        "again": again,
        "class": class,
        "verdict": verdict(names, frame),
        "undetermined": reason(frame),
        "distance": frame.distance(),
        "alarm": frame.alarm().map(cause),
        "usable_percent": frame.usable_percent(),
        "silent": frame.is_silent(),
    })
}

/// What came in all.
pub(super) struct End<'a> {
    pub(super) id: CanId,
    pub(super) course: CourseCounts,
    pub(super) counts: &'a Counts,
    /// Number of segments with each verdict.
    pub(super) verdicts: &'a BTreeMap<String, u64>,
    /// The cause of the alarm that stands, and the first segment with it.
    pub(super) alarm: Option<(String, u64)>,
}

impl End<'_> {
    pub(super) fn line(&self) -> String {
        let Self { id, course, counts, verdicts, alarm } = self;
        let verdicts = verdicts.iter().filter(|(_, count)| **count > 0);
        let verdicts: Vec<String> = verdicts.map(|(name, count)| format!("{name} {count}")).collect();
        let alarm = alarm
            .as_ref()
            .map_or_else(|| "no alarm".into(), |(cause, since)| format!("ALARM since segment {since}: {cause}"));
        let mut line = format!(
            "{} segments of {id}: {}; {alarm}; {} lost, {} repeated, {} withdrawn",
            course.segments,
            verdicts.join(", "),
            course.lost,
            course.repeated,
            course.withdrawn,
        );
        if course.restarts > 0 {
            line.push_str(&format!(", {} restarts of the drive", course.restarts));
        }
        further(&mut line, counts, "frames that are no segment");
        line
    }

    pub(super) fn value(&self) -> Value {
        let Self { id, course, counts, verdicts, alarm } = self;
        let mut value = json!({
            "kind": "end",
            "id": id.to_string(),
            "segments": course.segments,
            "verdicts": verdicts,
            "alarm": alarm.as_ref().map(|(cause, segment)| json!({ "segment": segment, "cause": cause })),
            "lost": course.lost,
            "repeated": course.repeated,
            "withdrawn": course.withdrawn,
            "again": course.again,
            "restarts": course.restarts,
        });
        counted(&mut value, counts);
        value
    }
}

/// Adds what else a log has to a line.
pub(super) fn further(line: &mut String, counts: &Counts, bad: &str) {
    let further = [
        (counts.bad, bad),
        (counts.other_buses, "frames on another bus"),
        (counts.others, "frames of other identifiers"),
        (counts.remote, "remote frames"),
        (counts.errors, "error frames"),
        (counts.unread, "lines that were not read"),
    ];
    for (count, what) in further.into_iter().filter(|(count, _)| *count > 0) {
        line.push_str(&format!(", {count} {what}"));
    }
}

/// The same as keys of an object.
pub(super) fn counted(value: &mut Value, counts: &Counts) {
    let counts = [
        ("bad", counts.bad),
        ("other_buses", counts.other_buses),
        ("other_ids", counts.others),
        ("remote", counts.remote),
        ("error_frames", counts.errors),
        ("unread_lines", counts.unread),
    ];
    let object = value.as_object_mut().into_iter();
    object.for_each(|object| object.extend(counts.map(|(name, count)| (name.to_owned(), json!(count)))));
}

/// Why none of what is expected came.
pub(super) fn nothing(id: CanId, counts: &Counts, expected: &str) -> String {
    let Counts { bad, others, other_buses: _, remote, errors, unread } = counts;
    match (*bad, others + remote + errors, *unread) {
        (1.., _, _) => format!("{bad} frames of {id}, but none is {expected}; check the identifier and the versions"),
        (0, 0, 1..) => format!("none of {unread} lines is of a log by candump -L or of an ASC file"),
        (0, 0, 0) => format!("no frame of {id}; the log is empty"),
        (0, other, _) => format!("no frame of {id} among {other} others; check the identifier"),
    }
}
