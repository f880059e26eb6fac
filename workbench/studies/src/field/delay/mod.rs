//! Hours between false alarms and runs until the alarm: the alarm by directions on drives that were not in training.
//!
//! A draw trains on the runs of some drives by the trainer of the workbench and judges it on the runs of others, under
//! all effects of the field. A judged drive is watched from its first run, or after fourteen runs of its own. Histories
//! draw whole runs of the drive, with repetition: healthy ones until an alarm or for a set length, and with a defect of
//! each kind and size from their first run on. A history without an alarm within a hundred runs counts as none. A run
//! that is recorded once comes again and again, and none is rarer than the runs are many: hours far above the recorded
//! ones are an extrapolation.
//!
//! Beside the runs until the alarm is the least that any detector needs which knows the defect (Lorden 1971):
//!
//! ```text
//! runs = ln(T)/KL,   KL = Δᵀ C⁻¹ Δ/2,   T: runs between false alarms                                      (1)
//! ```
//!
//! Δ is what the defect adds to the mean of the drive's runs, in the coordinates that a defect raises, and C the
//! covariance of runs of a drive in training.

mod judge;
mod records;
mod render;
#[cfg(test)]
mod tests;
mod watch;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

pub use judge::{FalseAlarms, Outcome};
use judge::{Runs, defective, healthy, one_run};
pub(super) use records::{Place, record};
pub use render::{text, to_json};
use watch::{Record, Watch};

use super::recipe::recipe;
use super::sessions::Fleet;
use crate::campaign::{Cell, Purpose};
use model::Error;
use model::core::{Embedded, SegmentReport};
use model::trace::labels::LabelledTrace;
use model::train::{AlarmInterval, Alarms, Recipe, ShaftPlan, Trained, train};
use rig::{BearingGeometry, Condition, Defect, DefectKind};

/// Features: what is on the torque balance, and all orders, each of which tells the noise of the others.
const FEATURES: [&str; 7] =
    ["inverse_kt", "load_friction", "viscous", "drag", "order_outer", "order_inner", "order_ball"];
/// First session with a defect.
const DEFECTIVE: u32 = 500;
/// Runs of healthy histories, and of all of them, a drive.
const HISTORY: usize = 1500;
const TOTAL: usize = 150_000;
/// Histories of each defect a drive.
const HISTORIES: u32 = 60;
/// Runs of its own after which a drive counts as known.
pub const KNOWN: usize = 14;

/// Size of the study.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Drives of training, and runs of each.
    pub training: Fleet,
    /// Records a run.
    pub records: u32,
    /// Judged drives.
    pub drives: u32,
    /// Healthy runs of each after those of its own.
    pub healthy: u32,
    /// Runs with each defect.
    pub defective: u32,
    /// Set hours between false alarms.
    pub hours: f64,
}

impl Settings {
    /// 20 drives of 6 runs of 12 records, and 12 judged ones.
    pub const STANDARD: Self = Self {
        training: Fleet { units: 20, sessions: 6 },
        records: 12,
        drives: 12,
        healthy: 30,
        defective: 4,
        hours: 1000.0,
    };
}

/// The defects: both kinds from full size to a sixteenth.
#[must_use]
pub fn defects() -> Vec<Defect> {
    let kinds = [DefectKind::Spall, DefectKind::Roughness];
    kinds.into_iter().flat_map(|kind| (0..5).map(move |k| Defect { kind, severity: 0.5_f64.powi(k) })).collect()
}

/// The conditions: all effects of the field under a sine, and under any motion.
#[must_use]
pub fn conditions() -> Vec<Condition> {
    Condition::all().filter(|condition| ["field-sine", "field-any"].contains(&condition.name)).collect()
}

/// What is found of one drive from the first day on, and of one that is known.
#[derive(Clone, Debug, PartialEq)]
pub struct Judged {
    /// Healthy histories.
    pub healthy: FalseAlarms,
    /// Histories of each of the defects.
    pub defective: Vec<Vec<Outcome>>,
}

/// One judged drive.
#[derive(Clone, Debug, PartialEq)]
pub struct Judgement {
    /// From the first run on, and after [`KNOWN`] runs.
    pub judged: [Judged; 2],
    /// (1) of each defect, runs.
    pub bounds: Vec<f64>,
}

/// What one draw of one condition gives.
#[derive(Clone, Debug, PartialEq)]
pub struct Draw {
    /// The condition.
    pub condition: &'static str,
    /// What is watched, in words.
    pub directions: String,
    /// Whether each direction is an order.
    pub orders: Vec<bool>,
    /// The judged drives.
    pub drives: Vec<Judgement>,
}

/// Trains and judges one draw.
///
/// # Errors
/// Simulation or training fails; training chooses no directions.
pub fn draw(condition: Condition, draw: u32, settings: &Settings) -> Result<Draw, Error> {
    let cell = |purpose, defect| Cell { purpose, repetition: draw, condition, defect };
    let bench = Bench::of(trained(condition, draw, settings)?, settings)?;
    let names = &bench.trained.coordinate_names;
    let drives = (0..settings.drives).map(|unit| bench.judge(&cell, unit)).collect::<Result<_, _>>()?;
    let directions = bench.trained.watch.directions.as_ref();
    Ok(Draw {
        condition: condition.name,
        directions: directions.map(|directions| directions.words(names)).unwrap_or_default(),
        orders: directions
            .map(|directions| directions.list.iter().map(|one| names[one.coordinate].starts_with("order_")).collect())
            .unwrap_or_default(),
        drives,
    })
}

/// Trains on the fleet of one draw.
pub(super) fn trained(condition: Condition, draw: u32, settings: &Settings) -> Result<Trained, Error> {
    let cell = Cell { purpose: Purpose::Training, repetition: draw, condition, defect: Defect::HEALTHY };
    let Fleet { units, sessions } = settings.training;
    let places = places(0..units, 0..sessions, settings.records);
    let set: Vec<LabelledTrace> = places.par_iter().map(|place| record(cell, *place)).collect::<Result<_, _>>()?;
    train(&set, &["healthy".into()], &recipe_of(condition, &places, settings))
}

pub(super) fn places(units: std::ops::Range<u32>, sessions: std::ops::Range<u32>, records: u32) -> Vec<Place> {
    let of_unit = |unit: u32| sessions.clone().flat_map(move |session| (0..records).map(move |k| [unit, session, k]));
    units.flat_map(of_unit).collect()
}

fn recipe_of(condition: Condition, places: &[Place], settings: &Settings) -> Recipe {
    let mut training = recipe(&condition, &FEATURES.map(String::from));
    let orders = BearingGeometry::THESIS.orders();
    let named = [("outer", orders.outer), ("inner", orders.inner), ("ball", orders.ball)];
    let slip = training.shaft.as_ref().map_or(0.0, |shaft| shaft.slip);
    training.shaft = Some(ShaftPlan {
        slip,
        ..ShaftPlan::new(named.into_iter().map(|(name, order)| (name.to_string(), order)).collect())
    });
    training.validation.units = places.iter().map(|[unit, ..]| format!("drive {unit}")).collect();
    training.validation.groups = places.iter().map(|[unit, session, _]| format!("drive {unit}/{session}")).collect();
    training.alarms =
        Alarms { by_run: true, other_drive: true, interval: AlarmInterval::Hours(settings.hours), ..training.alarms };
    training
}

/// The trained model, and what its runs say.
struct Bench<'a> {
    trained: Trained,
    model: Embedded,
    settings: &'a Settings,
    /// Places of the coordinates that a defect raises.
    raised: Vec<usize>,
    /// C of (1) in these, inverted.
    precision: DMatrix<f64>,
}

impl<'a> Bench<'a> {
    fn of(trained: Trained, settings: &'a Settings) -> Result<Self, Error> {
        let Some(directions) = &trained.watch.directions else {
            let why = trained.watch.warning.clone().unwrap_or_default();
            return Err(Error::Training(format!("training chose no directions: {why}")));
        };
        let mut raised: Vec<usize> = directions.list.iter().map(|direction| direction.coordinate).collect();
        raised.dedup();
        let covariance = covariance(&trained, &raised);
        let singular = || Error::Training("the covariance of the runs is singular".into());
        let precision = covariance.cholesky().ok_or_else(singular)?.inverse();
        let model = trained.embed()?;
        Ok(Self { trained, model, settings, raised, precision })
    }

    fn judge(&self, cell: &dyn Fn(Purpose, Defect) -> Cell, unit: u32) -> Result<Judgement, Error> {
        let runs =
            |defect, sessions: std::ops::Range<u32>| self.runs(cell(Purpose::Validation, defect), unit, sessions);
        let known = KNOWN as u32;
        let all = runs(Defect::HEALTHY, 0..known + self.settings.healthy)?;
        let observed: Vec<Vec<Vec<Observed>>> = defects()
            .into_iter()
            .map(|defect| runs(defect, DEFECTIVE..DEFECTIVE + self.settings.defective))
            .collect::<Result<_, _>>()?;
        let usual = self.mean(&all);
        let bounds = observed.iter().map(|runs| self.bound(&(self.mean(runs) - &usual))).collect();
        let values = |runs: &[Vec<Observed>]| -> Runs {
            runs.iter().map(|run| run.iter().map(|(record, _)| record.clone()).collect()).collect()
        };
        let (known, later) = all.split_at(KNOWN);
        let (known, later) = (values(known), values(later));
        let defective_runs: Vec<Runs> = observed.iter().map(|runs| values(runs)).collect();
        let new = Watch::new(&self.trained.watch).ok_or_else(|| Error::Training("no directions".into()))?;
        let mut learned = new.clone();
        known.iter().for_each(|run| {
            one_run(&mut learned, run);
        });
        let run_h = f64::from(self.settings.records) * self.segment_s() / 3600.0;
        let judged = |start: &Watch<'_>, seed: u64| Judged {
            healthy: healthy(start, &later, (TOTAL, HISTORY), (run_h, seed)),
            defective: defective_runs
                .iter()
                .zip(0..)
                .map(|(runs, k)| defective(start, runs, HISTORIES, seed + k))
                .collect(),
        };
        let seed = u64::from(unit) << 8;
        Ok(Judgement { judged: [judged(&new, seed), judged(&learned, seed + 1000)], bounds })
    }

    fn segment_s(&self) -> f64 {
        self.trained.segment_samples as f64 * self.trained.interval_s
    }

    /// Records of runs of a unit: the values of the directions, and those of the raised coordinates.
    fn runs(&self, cell: Cell, unit: u32, sessions: std::ops::Range<u32>) -> Result<Vec<Vec<Observed>>, Error> {
        let count = self.settings.records;
        let places = places(unit..unit + 1, sessions, count);
        let one = |place: &Place| {
            let recorded = record(cell, *place)?;
            Ok(self.model.run(&recorded.trace).iter().map(|segment| self.observed(segment)).collect::<Vec<_>>())
        };
        let records: Vec<Vec<Observed>> = places.par_iter().map(one).collect::<Result<_, Error>>()?;
        Ok(records.chunks(count as usize).map(|run| run.concat()).filter(|run| !run.is_empty()).collect())
    }

    fn observed(&self, segment: &SegmentReport) -> Observed {
        let Trained { feature_names, projection, raw, .. } = &self.trained;
        let names = self.trained.recipe.catalogue().shaft();
        let place = |name: &String| names.iter().position(|(feature, _)| feature == name);
        let of = |name: &String| place(name).and_then(|k| segment.shaft_features.get(k));
        let value = |name: &String| of(name).map_or(0.0, |feature| f64::from(feature.value));
        let variance = |(name, usual): (&String, &f64)| {
            let variance = of(name).map_or(f64::INFINITY, |feature| f64::from(feature.variance));
            if segment.verdict.is_ok() { (variance - usual).max(0.0) } else { f64::INFINITY }
        };
        let features = feature_names.len();
        let values = DVector::from_iterator(features, feature_names.iter().map(value));
        let variances = DVector::from_iterator(features, feature_names.iter().zip(raw.usual.iter()).map(variance));
        let (z, v) = projection.apply_with(&values, &variances);
        let directions = self.trained.watch.directions.iter().flat_map(|directions| &directions.list);
        let record = directions.map(|direction| direction.value(&z, &v)).collect();
        (record, self.raised.iter().map(|&k| v[k].is_finite().then_some(z[k])).collect())
    }

    /// Mean of the raised coordinates over the means of runs.
    fn mean(&self, runs: &[Vec<Observed>]) -> DVector<f64> {
        let of = |k: usize| {
            let run = |run: &Vec<Observed>| mean(run.iter().filter_map(|(_, z)| z[k]));
            mean(runs.iter().filter_map(run)).unwrap_or(0.0)
        };
        DVector::from_fn(self.raised.len(), |k, _| of(k))
    }

    /// (1).
    fn bound(&self, shift: &DVector<f64>) -> f64 {
        let run_h = f64::from(self.settings.records) * self.segment_s() / 3600.0;
        let information = 0.5 * shift.dot(&(&self.precision * shift));
        (self.settings.hours / run_h).ln() / information
    }
}

/// A record: the values of the directions, and those of the raised coordinates.
type Observed = (Record, Vec<Option<f64>>);

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), x| (sum + x, count + 1.0_f64));
    (count > 0.0).then(|| sum / count)
}

/// C of (1): run means of these coordinates less those of their drive, over the training records.
fn covariance(trained: &Trained, raised: &[usize]) -> DMatrix<f64> {
    let (table, units) = (&trained.coordinates, &trained.recipe.validation.units);
    let runs = &trained.candidates.groups;
    let mut order = runs.clone();
    order.dedup();
    let of_run = |run: usize| {
        let rows = || (0..runs.len()).filter(move |&row| runs[row] == run);
        let value_of =
            |k: &usize| mean(rows().filter(|&row| table.variances[row][*k].is_finite()).map(|row| table.rows[row][*k]));
        let values: Option<Vec<f64>> = raised.iter().map(value_of).collect();
        values.map(|values| (units[run].as_str(), DVector::from_vec(values)))
    };
    let means: Vec<(&str, DVector<f64>)> = order.into_iter().filter_map(of_run).collect();
    let mut sum = DMatrix::zeros(raised.len(), raised.len());
    let mut freedom = 0.0;
    for of_drive in means.chunk_by(|a, b| a.0 == b.0) {
        let centre = of_drive.iter().map(|row| &row.1).sum::<DVector<f64>>() / of_drive.len() as f64;
        sum += of_drive.iter().map(|row| (&row.1 - &centre) * (&row.1 - &centre).transpose()).sum::<DMatrix<f64>>();
        freedom += of_drive.len() as f64 - 1.0;
    }
    sum / freedom.max(1.0)
}
