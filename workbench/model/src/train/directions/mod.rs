//! Healthy runs of drives → the directions that the alarm watches.
//!
//! A direction is a coordinate that a defect only raises, or what `background` leaves of it. Its constants
//! (`levels`) say what a run of a healthy drive is like, and how drives differ. By them the core judges the mean of
//! each run, and learns what is usual for the drive at hand.
//!
//! What is left of a coordinate replaces it if less varies, both from run to run (s₀²) and for a drive that is not yet
//! known (U + s₀²). If only s₀² is smaller, by more than a tenth, both are directions: the rest is sharper once the
//! drive is known.
//!
//! A run must be a run: its offset is that of no other run. Sessions, days and power-ups are; parts of a record are
//! not. The rows say which ([`super::Validation::groups`]), and which drive ([`super::Validation::units`]).

mod background;
mod lasting;
mod levels;
#[cfg(test)]
mod tests;
mod words;

use std::collections::BTreeMap;

use bearing_watch::model as core;
use bearing_watch::plan::RunTime;
use nalgebra::DVector;

pub use levels::{FEWEST, Levels, Sample};

use super::{Candidates, FeatureTable, ProjectionKind, Recipe, Validation};
use crate::core::coordinates::{is_order, quantity};
use crate::error::Error;

/// Most directions of a model.
pub const MOST: usize = 8;
/// The sizes of a defect at which the core bets, in spreads of a usual run.
pub const BETS: [f64; 3] = [1.0, 2.0, 4.0];
/// q: what 95 % of the offsets do not exceed, in standard deviations.
pub const MARGIN: f64 = 1.645;
/// Runs from which the core learns.
pub const MOST_RUNS: u16 = 60;
/// Part by which s₀² must fall for a direction beside the coordinate itself.
const SHARPER: f64 = 0.1;
/// Least part of the records that a direction has of those of its coordinate.
const LEAST_PART: f64 = 0.9;
/// Friction that a defect only raises.
const RISING: [&str; 3] = ["viscous", "coulomb", "drag"];
/// What no defect changes: of friction and orders, this may be subtracted.
const STEADY: [&str; 2] = ["inverse_kt", "inertia"];

/// The most that one run adds to a score, as a part of the limit, and what it leaves of it, nats.
const CAP: f64 = 0.62;
const APART: f64 = 2.0;

/// The limit of the scores of so many directions for so many segments between false alarms, and the most that a run
/// of a usual length adds to a score.
#[must_use]
pub fn limit_and_cap(segments: f64, directions: usize, usual: f64) -> [f64; 2] {
    // One more score is that of falls.
    let limit = segments.ln() + ((directions * BETS.len() + 1) as f64).ln();
    let room = limit - usual.ln();
    [limit, (CAP * room).min(room - APART)]
}

/// What the alarm watches: a coordinate less its background.
#[derive(Clone, Debug, PartialEq)]
pub struct Direction {
    /// Place of the coordinate.
    pub coordinate: usize,
    /// Whether it is the strength of a bearing order.
    pub order: bool,
    /// Places and weights of what is subtracted.
    pub background: Vec<(usize, f64)>,
    /// Mean and spreads.
    pub levels: Levels,
}

impl Direction {
    fn core(&self) -> Result<core::Direction, Error> {
        let many =
            || Error::Training("a direction has more coordinates in its background than a model can have".into());
        let place = |k: usize| u8::try_from(k).map_err(|_| many());
        let mut background = [core::Background::default(); core::MAX_BACKGROUND];
        if self.background.len() > background.len() {
            return Err(many());
        }
        for (cell, (coordinate, weight)) in background.iter_mut().zip(&self.background) {
            *cell = core::Background { coordinate: place(*coordinate)?, weight: *weight as f32 };
        }
        let Levels { centre, between, run, record, skewness, correlation, .. } = self.levels;
        Ok(core::Direction {
            coordinate: place(self.coordinate)?,
            order: self.order,
            background,
            centre: centre as f32,
            between: between as f32,
            run: run as f32,
            segment: record as f32,
            skewness: skewness as f32,
            correlation: correlation.unwrap_or(0.0) as f32,
        })
    }

    /// Its value and the excess variance of the error, from coordinates and theirs; `None` if one is missing.
    #[must_use]
    pub fn value(&self, z: &DVector<f64>, variances: &DVector<f64>) -> Option<[f64; 2]> {
        value((self.coordinate, &self.background), z, variances)
    }
}

fn value(
    (coordinate, background): (usize, &[(usize, f64)]),
    z: &DVector<f64>,
    variances: &DVector<f64>,
) -> Option<[f64; 2]> {
    let terms = || std::iter::once((coordinate, 1.0)).chain(background.iter().map(|(k, w)| (*k, -w)));
    let variance: f64 = terms().map(|(k, w)| w * w * variances[k]).sum();
    let value: f64 = terms().map(|(k, w)| w * z[k]).sum();
    (variance.is_finite() && value.is_finite()).then_some([value, variance])
}

/// The directions, and the runs that they were estimated from.
#[derive(Clone, Debug, PartialEq)]
pub struct Directions {
    /// The directions.
    pub list: Vec<Direction>,
    /// Number of drives and of their runs.
    pub drives: usize,
    /// Number of runs of all drives.
    pub runs: usize,
    /// n₀, the records of the usual run.
    pub usual: f64,
    /// Records of the longest run.
    pub longest: usize,
    /// Rising coordinates that are not watched, because there are more than [`MOST`] or their records say too little.
    pub left_out: Vec<usize>,
}

impl Directions {
    /// The core's form.
    ///
    /// # Errors
    /// A background of more coordinates than the core has places for.
    pub(super) fn core(&self) -> Result<core::Directions<RunTime>, Error> {
        Ok(core::Directions {
            list: self.list.iter().map(Direction::core).collect::<Result<_, _>>()?,
            usual_segments: self.usual as f32,
            margin: MARGIN as f32,
            most_runs: MOST_RUNS,
        })
    }
}

/// Rows with their runs and drives.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Set<'a> {
    /// Coordinates.
    pub(crate) table: &'a FeatureTable,
    /// Their names.
    pub(crate) names: &'a [String],
    /// Run of each row.
    pub(crate) runs: &'a [usize],
    /// Drive of each row; without them all are of one.
    pub(crate) drives: Option<&'a [usize]>,
    /// The healthy class.
    pub(crate) healthy: usize,
}

/// Directions, or why there are none; no reason is given where none are expected.
pub(crate) type DirectionsOrReason = Result<Directions, Option<String>>;

/// Returns the directions of coordinates whose runs and drives the recipe tells.
pub(crate) fn of_candidates(
    (table, names): (&FeatureTable, &[String]),
    candidates: &Candidates,
    recipe: &Recipe,
) -> DirectionsOrReason {
    let Validation { groups, units, columns, .. } = &recipe.validation;
    // Columns are there for runs that are only found, which may be stretches of one.
    let told = recipe.alarms.by_run && !groups.is_empty() && columns.is_none();
    let Some(healthy) = recipe.alarms.healthy.filter(|_| told) else { return Err(None) };
    let whole = |&group: &usize| recipe.validation.whole(group);
    let drives: Option<Vec<usize>> = (!units.is_empty()).then(|| candidates.groups.iter().map(whole).collect());
    of(&Set { table, names, runs: &candidates.groups, drives: drives.as_deref(), healthy }, recipe)
}

/// Returns the directions of a set by a recipe.
pub(crate) fn of(set: &Set<'_>, recipe: &Recipe) -> DirectionsOrReason {
    let refused =
        |why: &str| Err(Some(format!("{why}: the alarm adds up surprises of records in place of directions")));
    if !matches!(recipe.projection, ProjectionKind::None) {
        let any = recipe.features.iter().any(|name| rises(name, recipe));
        return if any { refused("the projection mixes the features") } else { Err(None) };
    }
    let rising: Vec<usize> = (0..set.names.len()).filter(|&k| rises(&set.names[k], recipe)).collect();
    if rising.is_empty() {
        return Err(None);
    }
    if recipe.alarms.other_drive && set.drives.is_none() {
        return refused(
            "the drives have no runs; name the column of the drives by --unit, and of their runs by --group",
        );
    }
    let rows = Rows::of(set);
    if rows.longest() < 2 {
        return refused("runs have one record each");
    }
    let mut directions = Directions {
        list: vec![],
        drives: rows.places.len(),
        runs: rows.places.iter().map(Vec::len).sum(),
        usual: rows.usual(),
        longest: rows.longest(),
        left_out: vec![],
    };
    let (mut sharper, mut twins) = (vec![], vec![]);
    for coordinate in rising {
        let name = &set.names[coordinate];
        if twins.contains(&quantity(name)) {
            continue;
        }
        let Some((first, second)) = rows.directions(coordinate).filter(|_| directions.list.len() < MOST) else {
            directions.left_out.push(coordinate);
            continue;
        };
        twins.push(quantity(name));
        directions.list.push(first);
        sharper.extend(second);
    }
    sharper.truncate(MOST - directions.list.len());
    directions.list.extend(sharper);
    directions.list.sort_by_key(|direction| direction.coordinate);
    if directions.list.is_empty() {
        let freedom = directions.runs - directions.drives;
        return refused(&format!(
            "{} runs of {} drives with {freedom} degrees of freedom say too little, {FEWEST} are needed",
            directions.runs, directions.drives
        ));
    }
    Ok(directions)
}

/// Whether a defect only raises the coordinate of this name.
fn rises(name: &str, recipe: &Recipe) -> bool {
    is_order(name) || RISING.contains(&quantity(name)) || recipe.rising.iter().any(|rising| rising == name)
}

/// Rows of drives and runs.
struct Rows<'a> {
    set: Set<'a>,
    /// The rows by drive and run.
    places: Vec<Vec<Vec<usize>>>,
}

impl<'a> Rows<'a> {
    fn of(set: &Set<'a>) -> Self {
        let mut all: BTreeMap<usize, BTreeMap<usize, Vec<usize>>> = BTreeMap::new();
        for row in (0..set.table.rows.len()).filter(|&row| set.table.classes[row] == set.healthy) {
            let drive = set.drives.map_or(0, |drives| drives[row]);
            all.entry(drive).or_default().entry(set.runs[row]).or_default().push(row);
        }
        Self { set: *set, places: all.into_values().map(|runs| runs.into_values().collect()).collect() }
    }

    fn sizes(&self) -> Vec<usize> {
        self.places.iter().flatten().map(Vec::len).collect()
    }

    fn longest(&self) -> usize {
        self.sizes().into_iter().max().unwrap_or(0)
    }

    /// The median of the sizes of runs.
    fn usual(&self) -> f64 {
        let mut sizes = self.sizes();
        sizes.sort_unstable();
        sizes.get(sizes.len() / 2).map_or(1.0, |size| *size as f64)
    }

    /// Values of a direction in all records that have its coordinates.
    fn sample(&self, coordinate: usize, background: &[(usize, f64)]) -> Sample {
        let FeatureTable { rows, variances, .. } = self.set.table;
        let of_row = |row: usize| value((coordinate, background), &rows[row], &variances[row]);
        let run = |places: &Vec<usize>| places.iter().filter_map(|&row| of_row(row)).collect();
        self.places.iter().map(|runs| runs.iter().map(run).collect()).collect()
    }

    /// The direction of a coordinate, and a second one where what is left of it is sharper but no substitute.
    fn directions(&self, coordinate: usize) -> Option<(Direction, Option<Direction>)> {
        let all = self.sample(coordinate, &[]);
        let order = is_order(&self.set.names[coordinate]);
        let plain = Direction { coordinate, order, background: vec![], levels: Levels::of(&all, 0)? };
        let Some(rest) = self.rest(coordinate, &all) else { return Some((plain, None)) };
        let usual = self.usual();
        let [of_run, of_rest] = [&plain, &rest].map(|direction| direction.levels.usual(usual));
        let [of_drive, of_other] =
            [&plain, &rest].map(|direction| direction.levels.between + direction.levels.usual(usual));
        if of_rest < of_run && of_other < of_drive {
            return Some((rest, None));
        }
        Some((plain, (of_rest < (1.0 - SHARPER) * of_run).then_some(rest)))
    }

    /// What the background leaves of a coordinate, if it has one and few records lack it.
    fn rest(&self, coordinate: usize, all: &Sample) -> Option<Direction> {
        let names = self.set.names;
        let scale = |name: &str| name.split('_').next().unwrap_or_default().to_string();
        let offered = |k: &usize| {
            let name = &names[*k];
            let order = is_order(&names[coordinate]) && is_order(name) && scale(name) == scale(&names[coordinate]);
            *k != coordinate && (order || STEADY.contains(&quantity(name)))
        };
        let offered: Vec<usize> = (0..names.len()).filter(offered).collect();
        let background = background::of(coordinate, &offered, &|k| self.sample(k, &[]));
        let sample = self.sample(coordinate, &background);
        let count = |sample: &Sample| sample.iter().flatten().map(Vec::len).sum::<usize>() as f64;
        let enough = !background.is_empty() && count(&sample) >= LEAST_PART * count(all);
        let levels = Levels::of(&sample, background.len()).filter(|_| enough)?;
        Some(Direction { coordinate, order: is_order(&names[coordinate]), background, levels })
    }
}
