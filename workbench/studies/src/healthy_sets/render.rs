//! The table.

use serde_json::{Value, json};

use super::{FALSE_ALARM, Found, JUDGED, SHIFT, TRAINED};
use crate::campaign::render::grid;
use crate::field::render::percent;
use model::evaluate::Rate;

/// The table as plain text, with a reason or doubt of each set.
#[must_use]
pub fn text(all: &[Found]) -> String {
    let title = format!(
        "Gates of {TRAINED} records set to {} % false alarms, judged on {JUDGED} other records of the same law, and on \
         {JUDGED} that are shifted by {SHIFT} standard deviations; % [95 % interval]",
        100.0 * FALSE_ALARM
    );
    let row = |found: &Found| {
        let rate = |rate: Option<Rate>| rate.map_or_else(|| "–".into(), percent);
        let of = |count: usize| format!("{count} of {}", found.draws);
        let [refused, doubted] = [found.refused, found.doubted].map(of);
        vec![found.set.name.to_string(), rate(found.false_alarms), rate(found.detected), doubted, refused]
    };
    let head = ["", "false alarms", "detected", "doubted", "refused"];
    let mut text = grid(&title, &head, &all.iter().map(row).collect::<Vec<_>>());
    for found in all {
        text += &found.words.iter().map(|words| format!("{}: {words}\n", found.set.name)).collect::<String>();
    }
    text
}

/// Key `rows`, one for each set.
#[must_use]
pub fn to_json(all: &[Found]) -> Value {
    let row = |found: &Found| {
        json!({
            "set": found.set.name,
            "false_alarms": found.false_alarms.map(|rate| rate.to_json()),
            "detected": found.detected.map(|rate| rate.to_json()),
            "doubted": found.doubted,
            "refused": found.refused,
            "draws": found.draws,
            "words": found.words,
        })
    };
    json!({ "rows": all.iter().map(row).collect::<Vec<_>>() })
}
