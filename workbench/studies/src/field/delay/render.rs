//! The table as text and JSON.

use serde_json::{Value, json};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::judge::LONGEST;
use super::{Draw, FalseAlarms, Judgement, KNOWN, Outcome, Settings, WATCHES, defects};
use crate::campaign::render::grid;
use model::evaluate::Rate;
use rig::{Defect, DefectKind};

/// Runs within which an alarm is soon.
const SOON: u32 = 20;

/// Hours of healthy histories over all drives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Hours {
    /// Drives below the set hours, and all.
    pub(super) below: [usize; 2],
    /// Median drive and worst one.
    pub(super) median: f64,
    pub(super) worst: f64,
    /// All drives together: mean with its 95 % interval, as if alarms were independent.
    pub(super) pooled: [f64; 3],
}

pub(super) fn hours(drives: &[FalseAlarms], set: f64) -> Hours {
    let mut means: Vec<f64> = drives.iter().map(FalseAlarms::mean).collect();
    means.sort_by(f64::total_cmp);
    let below = means.iter().filter(|mean| **mean < set).count();
    let alarms = drives.iter().map(|drive| drive.alarms).sum::<usize>() as f64;
    let total: f64 = drives.iter().map(|drive| drive.hours).sum();
    let quantile = |freedom: f64, p: f64| ChiSquared::new(freedom).map_or(f64::NAN, |law| law.inverse_cdf(p));
    let low = 2.0 * total / quantile(2.0 * alarms + 2.0, 0.975);
    let high = if alarms > 0.0 { 2.0 * total / quantile(2.0 * alarms, 0.025) } else { f64::INFINITY };
    Hours {
        below: [below, means.len()],
        median: means[means.len() / 2],
        worst: means[0],
        pooled: [total / alarms.max(1.0), low, high],
    }
}

/// Runs until the alarm over all histories of all drives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Delay {
    /// Median, and what 90 % do not exceed; `None` for no alarm.
    pub(super) median: Option<u32>,
    pub(super) most: Option<u32>,
    /// Part alarmed within [`SOON`] runs, and by a direction of the right kind of all alarms.
    pub(super) soon: f64,
    pub(super) right: f64,
}

pub(super) fn delay(outcomes: &[Outcome], right: impl Fn(usize) -> bool) -> Delay {
    let mut runs: Vec<u32> = outcomes.iter().map(|outcome| outcome.run.unwrap_or(u32::MAX)).collect();
    runs.sort_unstable();
    let at = |part: f64| runs.get((part * runs.len() as f64) as usize).copied().filter(|run| *run <= LONGEST);
    let part = |count: usize, of: usize| count as f64 / of.max(1) as f64;
    let alarms = outcomes.iter().filter_map(|outcome| outcome.direction);
    Delay {
        median: at(0.5),
        most: at(0.9),
        soon: part(runs.iter().filter(|run| **run <= SOON).count(), runs.len()),
        right: part(alarms.clone().filter(|direction| right(*direction)).count(), alarms.count()),
    }
}

/// The delay of a defect in the draws of one condition by one of the watches.
fn delay_of(draws: &[&Draw], (watch, place): (usize, usize), defect: Defect) -> Delay {
    // Directions differ from draw to draw: whether one is right is asked of its own.
    let is_order = defect.kind == DefectKind::Spall;
    let mut all: Vec<Outcome> = vec![];
    for draw in draws {
        let of_drive = |drive: &Judgement| drive.judged[watch].defective[place].clone();
        let outcomes = draw.drives.iter().flat_map(of_drive);
        all.extend(outcomes.map(|outcome| Outcome {
            direction: outcome.direction.map(|k| usize::from(draw.orders.get(k) == Some(&is_order))),
            ..outcome
        }));
    }
    delay(&all, |direction| direction == 1)
}

fn name(defect: Defect) -> String {
    match (defect.kind.name(), 1.0 / defect.severity) {
        (kind, size) if size < 1.5 => format!("{kind} 1"),
        (kind, size) => format!("{kind} 1/{size:.0}"),
    }
}

fn runs(run: Option<u32>) -> String {
    run.map_or_else(|| "–".into(), |run| run.to_string())
}

/// Median of the bounds of all drives, and the largest.
fn bounds(draws: &[&Draw], place: usize) -> [f64; 2] {
    let mut all: Vec<f64> = draws.iter().flat_map(|draw| &draw.drives).map(|drive| drive.bounds[place]).collect();
    all.sort_by(f64::total_cmp);
    [all[all.len() / 2], all[all.len() - 1]]
}

/// Draws by condition.
fn by_condition(all: &[Draw]) -> Vec<(&'static str, Vec<&Draw>)> {
    let mut conditions: Vec<(&'static str, Vec<&Draw>)> = vec![];
    for draw in all {
        match conditions.iter_mut().find(|(name, _)| *name == draw.condition) {
            Some((_, draws)) => draws.push(draw),
            None => conditions.push((draw.condition, vec![draw])),
        }
    }
    conditions
}

fn hours_of(draws: &[&Draw], watch: usize, set: f64) -> Hours {
    let all: Vec<FalseAlarms> =
        draws.iter().flat_map(|draw| &draw.drives).map(|drive| drive.judged[watch].healthy).collect();
    hours(&all, set)
}

/// The table as plain text.
#[must_use]
pub fn text(all: &[Draw], settings: &Settings) -> String {
    by_condition(all).iter().map(|(condition, draws)| of_condition(condition, draws, settings)).collect()
}

fn of_condition(condition: &str, draws: &[&Draw], settings: &Settings) -> String {
    let title = format!("{condition}: hours between false alarms, set to {} h", settings.hours);
    let row = |(watch, name): (usize, &&str)| {
        let Hours { below: [below, of], median, worst, pooled: [mean, low, high] } =
            hours_of(draws, watch, settings.hours);
        let part = Rate::wilson(below, of);
        let share = format!("{below} of {of} [{:.0}, {:.0}] %", 100.0 * part.low, 100.0 * part.high);
        let high = if high.is_finite() { format!("{high:.0}") } else { "∞".into() };
        let pooled = format!("{mean:.0} [{low:.0}, {high}]");
        vec![(*name).to_owned(), share, format!("{worst:.0}"), format!("{median:.0}"), pooled]
    };
    let rows: Vec<Vec<String>> = WATCHES.iter().enumerate().map(row).collect();
    let head = ["", "drives below [95 %]", "worst drive", "median drive", "all [95 %]"];
    let mut text = grid(&title, &head, &rows);
    let title = format!("{condition}: runs until the alarm, median / 90 % (within {SOON} runs, %)");
    let row = |(place, defect): (usize, Defect)| {
        let cell = |watch: usize| {
            let delay = delay_of(draws, (watch, place), defect);
            format!("{} / {} ({:.0})", runs(delay.median), runs(delay.most), 100.0 * delay.soon)
        };
        let [median, worst] = bounds(draws, place);
        let right = delay_of(draws, (1, place), defect);
        let named = if right.soon > 0.0 { format!("{:.0}", 100.0 * right.right) } else { "–".into() };
        let cells = (0..WATCHES.len()).map(cell);
        std::iter::once(name(defect)).chain(cells).chain([format!("{median:.1} ({worst:.1})"), named]).collect()
    };
    let rows: Vec<Vec<String>> = defects().into_iter().enumerate().map(row).collect();
    let head: Vec<&str> = [""].into_iter().chain(WATCHES).chain(["bound (worst drive)", "named right, %"]).collect();
    text += &grid(&title, &head, &rows);
    for draw in draws {
        text += &format!("{condition} watches {}\n", draw.directions);
    }
    text
}

/// Key `rows`, one for each condition.
#[must_use]
pub fn to_json(all: &[Draw], settings: &Settings) -> Value {
    let by_watch = |draws: &[&Draw], watch: usize| {
        let Hours { below, median, worst, pooled } = hours_of(draws, watch, settings.hours);
        let form = |(place, defect): (usize, Defect)| {
            let Delay { median, most, soon, right } = delay_of(draws, (watch, place), defect);
            json!({
                "kind": defect.kind.name(), "size": defect.severity, "median": median, "most": most, "soon": soon,
                "right": right, "bound": bounds(draws, place)[0],
            })
        };
        json!({
            "watch": WATCHES[watch],
            "own_runs": if watch == 0 { 0 } else { KNOWN },
            "drives_below": below[0],
            "drives": below[1],
            "median_h": median,
            "worst_h": worst,
            "mean_h": { "value": pooled[0], "low": pooled[1], "high": pooled[2].is_finite().then_some(pooled[2]) },
            "defects": defects().into_iter().enumerate().map(form).collect::<Vec<_>>(),
        })
    };
    let row = |(condition, draws): &(&str, Vec<&Draw>)| {
        let words: Vec<&String> = draws.iter().map(|draw| &draw.directions).collect();
        let watches: Vec<Value> = (0..WATCHES.len()).map(|watch| by_watch(draws, watch)).collect();
        json!({ "condition": condition, "set_h": settings.hours, "directions": words, "watches": watches })
    };
    json!({ "rows": by_condition(all).iter().map(row).collect::<Vec<_>>() })
}
