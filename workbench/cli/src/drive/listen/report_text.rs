//! Frames as lines of text and as JSON.

use bearing_watch::Verdict;
use bearing_watch::telemetry::{LinkStats, Summary};
use serde_json::{Map, Value, json};

use super::alarm;
use super::names::Names;
use super::traces::Written;
use model::core::{denied, stuck_channels};

pub(super) fn view_line(address: &str) -> String {
    format!("page at {address}")
}

pub(super) fn view_value(address: &str) -> Value {
    json!({ "kind": "view", "address": address })
}

pub(super) fn hello_line(names: &Names) -> String {
    let channels: Vec<String> = names.channels.iter().map(|(name, unit)| format!("{name} in {unit}")).collect();
    let every = names.interval_s.map_or_else(String::new, |step| format!(" every {step} s"));
    let source = names.source;
    format!(
        "model {:08x}, session {}: {}{every}; classes {}",
        source.model_id,
        source.session,
        channels.join(", "),
        names.classes.join(", ")
    )
}

pub(super) fn hello_value(names: &Names) -> Value {
    let channels: Vec<Value> =
        names.channels.iter().map(|(name, unit)| json!({ "name": name, "unit": unit })).collect();
    json!({
        "kind": "hello",
        "model_id": names.source.model_id,
        "session": names.source.session,
        "interval_s": names.interval_s,
        "channels": channels,
        "angle": names.with_angle,
        "classes": names.classes,
        "features": names.features,
        "orders": names.orders,
    })
}

pub(super) fn verdict(names: &Names, verdict: Verdict) -> String {
    match verdict {
        Verdict::Class(class) => names.class(class),
        Verdict::Novel => "novel".into(),
        Verdict::Ambiguous => "ambiguous".into(),
        Verdict::Undetermined(_) => "undetermined".into(),
    }
}

fn posteriors(names: &Names, summary: &Summary<'_>) -> Vec<(String, f32)> {
    (0_u8..).zip(summary.posteriors.iter()).map(|(class, posterior)| (names.class(class), posterior)).collect()
}

pub(super) fn report_line(names: &Names, summary: &Summary<'_>) -> String {
    let Summary { segment, distance, surprise, score, rows, .. } = summary;
    let mut line = format!("segment {segment}  {}", verdict(names, summary.verdict));
    match summary.verdict {
        Verdict::Undetermined(reason) => line.push_str(&format!(": {reason}")),
        _ => {
            let each: Vec<String> =
                posteriors(names, summary).iter().map(|(class, p)| format!("{class} {p:.3}")).collect();
            line.push_str(&format!("  [{}]  distance {distance:.2}, surprise {surprise:.1} nats", each.join(", ")));
        }
    }
    line.push_str(&format!(", score {score:.1}, {rows} rows"));
    let denied = denied(&summary.counts, &names.channel_names());
    if denied.is_empty() { line } else { format!("{line}, {denied}") }
}

pub(super) fn report_value(names: &Names, summary: &Summary<'_>) -> Value {
    let named = |own: Vec<(String, f32)>| own.into_iter().map(|(name, x)| (name, json!(x))).collect::<Map<_, _>>();
    let features = names.features.iter().cloned().zip(summary.features.iter()).collect();
    let (class, reason) = match summary.verdict {
        Verdict::Class(class) => (Some(names.class(class)), None),
        Verdict::Undetermined(reason) => (None, Some(reason.to_string())),
        Verdict::Novel | Verdict::Ambiguous => (None, None),
    };
    json!({
        "kind": "report",
        "segment": summary.segment,
        "class": class,
        "verdict": verdict(names, summary.verdict),
        "undetermined": reason,
        "posteriors": named(posteriors(names, summary)),
        "distance": summary.distance,
        "surprise": summary.surprise,
        "score": summary.score,
        "alarm": alarm::value(names, summary),
        "directions": alarm::directions(names, summary),
        "features": named(features),
        "order_scores": summary.order_scores.iter().collect::<Vec<f32>>(),
        "undetermined_segments": summary.undetermined,
        "rows": summary.rows,
        "rejected": summary.counts.rejected,
        "saturated": summary.counts.saturated,
        "still": summary.counts.resting,
        "stuck": stuck_channels(summary.counts.stuck, &names.channel_names()),
    })
}

pub(super) fn trace_line(Written { file, first, samples }: &Written) -> String {
    format!("{file}: {samples} samples from number {first} on")
}

pub(super) fn trace_value(Written { file, first, samples }: &Written) -> Value {
    json!({ "kind": "trace", "file": file, "first": first, "samples": samples })
}

/// `kept` are the numbers of written samples, of files and of unusable samples, if traces are written.
pub(super) fn end_line(counts: LinkStats, kept: Option<[u64; 3]>, unnamed: u64) -> String {
    let LinkStats { frames, bad, oversize, unknown, lost, repeated } = counts;
    let mut line = format!("{frames} frames, {bad} bad, {lost} lost, {repeated} repeated");
    let further = [(oversize, "too long"), (unknown, "of another format version")];
    for (count, what) in further.into_iter().filter(|(count, _)| *count > 0) {
        line.push_str(&format!(", {count} {what}"));
    }
    if let Some([samples, files, unusable]) = kept {
        line.push_str(&format!("; {samples} samples written to {files} files"));
        let further = [(unusable, "not numbers"), (unnamed, "before the names of their channels came")];
        for (count, what) in further.into_iter().filter(|(count, _)| *count > 0) {
            line.push_str(&format!(", {count} {what}"));
        }
    }
    line
}

pub(super) fn end_value(counts: LinkStats, kept: Option<[u64; 3]>, unnamed: u64) -> Value {
    let LinkStats { frames, bad, oversize, unknown, lost, repeated } = counts;
    json!({
        "kind": "end",
        "frames": frames,
        "bad": bad,
        "oversize": oversize,
        "unknown": unknown,
        "lost": lost,
        "repeated": repeated,
        "samples": kept.map(|kept| kept[0]),
        "files": kept.map(|kept| kept[1]),
        "unusable_samples": kept.map(|kept| kept[2]),
        "unnamed_samples": unnamed,
    })
}

/// Why no frame came.
pub(super) fn nothing(LinkStats { bad, oversize, unknown, .. }: LinkStats) -> String {
    match (bad, oversize, unknown) {
        (_, _, 1..) => format!("{unknown} frames of another format version; use the workbench of that version"),
        (0, 0, 0) => "no frame came; check the line, and that the drive sends".into(),
        _ => format!("no frame among {} damaged ones; check --baud and the source", bad.saturating_add(oversize)),
    }
}
