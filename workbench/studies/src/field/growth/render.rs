//! The table as text and JSON.

use serde_json::{Value, json};

use super::{Asked, Draw, Healthy, Kind, Outcome, PARTS};
use crate::campaign::render::grid;
use model::evaluate::Rate;

/// What is said at one part of the life.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Told {
    /// Histories in which a time left is told, of all.
    pub(super) told: [usize; 2],
    /// Share of these whose interval contains the truth, with its interval.
    pub(super) covered: Rate,
    /// Median of half the width as part of the truth; NaN if none is told.
    pub(super) width: f64,
}

pub(super) fn told(outcomes: &[Outcome], part: usize) -> Told {
    let asked: Vec<&Asked> = outcomes.iter().map(|outcome| &outcome[part]).collect();
    let covered: Vec<bool> = asked.iter().filter_map(|asked| asked.covers()).collect();
    let mut widths: Vec<f64> = asked.iter().filter_map(|asked| asked.width()).collect();
    widths.sort_by(f64::total_cmp);
    Told {
        told: [covered.len(), asked.len()],
        covered: Rate::wilson(covered.iter().filter(|covered| **covered).count(), covered.len()),
        width: widths.get(widths.len() / 2).copied().unwrap_or(f64::NAN),
    }
}

/// Share of runs after which healthy drives are said to grow, and of histories with such a run.
pub(super) fn growing(all: &[Healthy]) -> [f64; 2] {
    let of = |count: usize, all: usize| count as f64 / all.max(1) as f64;
    let sum = |count: fn(&Healthy) -> usize| all.iter().map(count).sum::<usize>();
    let histories = sum(|healthy| usize::from(healthy.growing > 0));
    [of(sum(|healthy| healthy.growing), sum(|healthy| healthy.runs)), of(histories, all.len())]
}

/// All laws together, in a row of their own.
fn rows(kind: &Kind) -> Vec<(&'static str, Vec<Outcome>)> {
    let all = kind.grown.iter().flat_map(|(_, outcomes)| outcomes.clone()).collect();
    let laws = kind.grown.iter().map(|(law, outcomes)| (law.name(), outcomes.clone()));
    laws.chain([("all laws", all)]).collect()
}

fn cell(Told { told: [count, of], covered, width }: Told) -> String {
    let share = 100.0 * count as f64 / of.max(1) as f64;
    if count == 0 {
        return format!("{share:.0} | –");
    }
    let [value, low, high] = [covered.value, covered.low, covered.high].map(|x| 100.0 * x);
    format!("{share:.0} | {value:.0} [{low:.0}, {high:.0}] | {:.0}", 100.0 * width)
}

/// The table as plain text.
#[must_use]
pub fn text(all: &[Draw]) -> String {
    let of_draw = |draw: &Draw| draw.kinds.iter().map(|kind| of_kind(draw.condition, kind)).collect::<String>();
    all.iter().map(of_draw).collect()
}

fn of_kind(condition: &str, kind: &Kind) -> String {
    let title = format!(
        "{condition}, {}: histories with a time left, % | of these the truth is within the 90 % interval, % [95 %] | \
         half of its width, % of the truth, median",
        kind.kind.name()
    );
    let head: Vec<String> = PARTS.iter().map(|part| format!("at {:.0} % of the life", 100.0 * part)).collect();
    let head: Vec<&str> = [""].into_iter().chain(head.iter().map(String::as_str)).collect();
    let row = |(name, outcomes): (&'static str, Vec<Outcome>)| {
        let cells = (0..PARTS.len()).map(|part| cell(told(&outcomes, part)));
        [name.to_string()].into_iter().chain(cells).collect::<Vec<_>>()
    };
    let mut text = grid(&title, &head, &rows(kind).into_iter().map(row).collect::<Vec<_>>());
    for (name, healthy) in ["in random order", "with lasting offsets"].into_iter().zip(&kind.healthy) {
        let [runs, histories] = growing(healthy).map(|share| 100.0 * share);
        text += &format!(
            "healthy runs {name}: said to grow after {runs:.2} % of the runs, in {histories:.0} % of the histories\n"
        );
    }
    text + &format!("watched: {}; named size: {:.1} deviations of a usual run\n", kind.direction, kind.named)
}

/// Key `rows`, one for each draw and kind.
#[must_use]
pub fn to_json(all: &[Draw]) -> Value {
    let of_part = |outcomes: &[Outcome], part: usize| {
        let Told { told: [count, of], covered, width } = told(outcomes, part);
        json!({
            "part": PARTS[part], "told": count, "histories": of,
            "covered": { "value": covered.value, "low": covered.low, "high": covered.high },
            "half_width": width.is_finite().then_some(width),
        })
    };
    let row = |draw: &Draw, kind: &Kind| {
        let laws = rows(kind).into_iter().map(|(name, outcomes)| {
            json!({ "law": name, "parts": (0..PARTS.len()).map(|part| of_part(&outcomes, part)).collect::<Vec<_>>() })
        });
        let healthy = kind.healthy.each_ref().map(|healthy| {
            let [runs, histories] = growing(healthy);
            json!({ "runs": runs, "histories": histories })
        });
        json!({ "condition": draw.condition, "kind": kind.kind.name(), "direction": kind.direction,
                "named": kind.named, "laws": laws.collect::<Vec<_>>(), "healthy": healthy[0], "lasting": healthy[1] })
    };
    let rows = all.iter().flat_map(|draw| draw.kinds.iter().map(move |kind| row(draw, kind)));
    json!({ "rows": rows.collect::<Vec<_>>() })
}
