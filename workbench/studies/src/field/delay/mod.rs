//! Hours between false alarms and runs until the alarm: the alarm by directions on drives that were not in training.
//!
//! A draw trains on the runs of some drives by the trainer of the workbench and judges the core's alarm on the runs of
//! others, under all effects of the field. A judged drive is watched from its first run, or after fourteen runs of its
//! own; plain alternatives (`peers`) watch it after these fourteen runs too. Histories
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
mod peers;
mod records;
mod render;
#[cfg(test)]
mod tests;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use judge::{Core, History, Watch, judge};
pub use judge::{FalseAlarms, Judged, Outcome};
use peers::{Cusum, Threshold, Usual, band, mean};
pub(super) use records::{Place, record};
pub use render::{text, to_json};

use super::recipe::recipe;
use crate::campaign::{Cell, Purpose};
use bearing_watch::Decision;
use bearing_watch::model::FeatureValue;
use bearing_watch::plan::RunTime;
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
/// Runs of its own after which a drive counts as known.
pub const KNOWN: usize = 14;
/// What watches the drive: the core's alarm from the first day on and after [`KNOWN`] runs, a threshold and a sum of
/// the residual's band, and sums of the features that the core watches.
pub const WATCHES: [&str; 5] =
    ["first day", "14 runs of its own", "threshold", "CUSUM of the band", "CUSUM of features"];

/// Size of a fleet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fleet {
    /// Number of drives.
    pub units: u32,
    /// Number of runs of each drive.
    pub sessions: u32,
}

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

/// One judged drive.
#[derive(Clone, Debug, PartialEq)]
pub struct Judgement {
    /// By each of [`WATCHES`].
    pub judged: [Judged; WATCHES.len()],
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
    let bench = Bench::new(condition, draw, settings)?;
    let cell = |purpose, defect| Cell { purpose, repetition: draw, condition, defect };
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

/// Simulates the records of training, and trains.
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
    /// Number of directions.
    directions: usize,
    /// Places of the coordinates that a defect raises.
    raised: Vec<usize>,
    /// C of (1) in these, inverted.
    precision: DMatrix<f64>,
}

impl<'a> Bench<'a> {
    /// Of a trained model.
    fn new(condition: Condition, draw: u32, settings: &'a Settings) -> Result<Self, Error> {
        let trained = trained(condition, draw, settings)?;
        let Some(directions) = &trained.watch.directions else {
            let why = trained.watch.warning.clone().unwrap_or_default();
            return Err(Error::Training(format!("training chose no directions: {why}")));
        };
        let mut raised: Vec<usize> = directions.list.iter().map(|direction| direction.coordinate).collect();
        raised.dedup();
        let covariance = covariance(&trained, &raised);
        let singular = || Error::Training("the covariance of the runs is singular".into());
        let precision = covariance.cholesky().ok_or_else(singular)?.inverse();
        let (directions, model) = (directions.list.len(), trained.embed()?);
        Ok(Self { trained, model, settings, directions, raised, precision })
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
        let (known, later) = all.split_at(KNOWN);
        let seed = u64::from(unit) << 8;
        let history = |place: u64| History { run_h: self.run_h(), seed: seed + 1000 * place };
        let decided = |run: &[Observed]| run.iter().map(|record| record.decision.clone()).collect();
        let mut core = Core::new(&self.model);
        let first_day = judge(&core, (later, &observed), decided, history(0));
        known.iter().for_each(|run| {
            core.run(&decided(run));
        });
        let learned = judge(&core, (later, &observed), decided, history(1));
        let banded = |run: &[Observed]| run.iter().map(|record| vec![record.band]).collect::<Vec<_>>();
        let usual = Usual::of(known.iter().map(|run| mean(run.iter().map(|record| record.band))));
        let runs = self.settings.hours / self.run_h();
        let threshold = judge(&Threshold::new(usual, runs), (later, &observed), banded, history(2));
        let cusum = judge(&Cusum::new(vec![usual], runs), (later, &observed), banded, history(3));
        let directed = |run: &[Observed]| run.iter().map(|record| record.directed.clone()).collect::<Vec<_>>();
        let of_direction = |k: usize| known.iter().map(move |run| mean(run.iter().map(|record| record.directed[k])));
        let usual = (0..self.directions).map(|k| Usual::of(of_direction(k))).collect();
        let features = judge(&Cusum::new(usual, runs), (later, &observed), directed, history(4));
        Ok(Judgement { judged: [first_day, learned, threshold, cusum, features], bounds })
    }

    fn run_h(&self) -> f64 {
        f64::from(self.settings.records) * self.segment_s() / 3600.0
    }

    fn segment_s(&self) -> f64 {
        self.trained.segment_samples as f64 * self.trained.interval_s
    }

    /// Records of runs of a unit: the values of the directions, and those of the raised coordinates.
    fn runs(&self, cell: Cell, unit: u32, sessions: std::ops::Range<u32>) -> Result<Vec<Vec<Observed>>, Error> {
        let count = self.settings.records;
        let places = places(unit..unit + 1, sessions, count);
        let one = |place: &Place| {
            let recorded = record(cell, *place)?.trace;
            let band = band(&recorded);
            Ok(self.model.run(&recorded).iter().map(|segment| self.observed(segment, band)).collect::<Vec<_>>())
        };
        let records: Vec<Vec<Observed>> = places.par_iter().map(one).collect::<Result<_, Error>>()?;
        Ok(records.chunks(count as usize).map(|run| run.concat()).filter(|run| !run.is_empty()).collect())
    }

    fn observed(&self, segment: &SegmentReport, band: f64) -> Observed {
        let Trained { feature_names, projection, raw, .. } = &self.trained;
        let names = self.trained.catalogue().shaft();
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
        let number = |value: &FeatureValue| if value.is_missing() { f64::NAN } else { value.value.into() };
        Observed {
            decision: self.model.decision(segment),
            directed: (0..self.directions).map(|k| segment.directed.get(k).map_or(f64::NAN, number)).collect(),
            raised: self.raised.iter().map(|&k| if v[k].is_finite() { z[k] } else { f64::NAN }).collect(),
            band,
        }
    }

    /// Mean of the raised coordinates over the means of runs.
    fn mean(&self, runs: &[Vec<Observed>]) -> DVector<f64> {
        let of = |k: usize| {
            let run = |run: &Vec<Observed>| mean(run.iter().map(|record| record.raised[k]));
            mean(runs.iter().map(run))
        };
        DVector::from_fn(self.raised.len(), |k, _| of(k))
    }

    /// (1).
    fn bound(&self, shift: &DVector<f64>) -> f64 {
        let information = 0.5 * shift.dot(&(&self.precision * shift));
        (self.settings.hours / self.run_h()).ln() / information
    }
}

/// What is known of a record; a value that is missing is not a number.
#[derive(Clone, Debug)]
struct Observed {
    /// The core's decision.
    decision: Option<Decision<RunTime>>,
    /// Values of the directions.
    directed: Vec<f64>,
    /// Those of the raised coordinates.
    raised: Vec<f64>,
    /// The band of its residual.
    band: f64,
}

/// C of (1): run means of these coordinates less those of their drive, over the training records.
fn covariance(trained: &Trained, raised: &[usize]) -> DMatrix<f64> {
    let (table, units) = (&trained.coordinates, &trained.recipe.validation.units);
    let runs = &trained.candidates.groups;
    let mut order = runs.clone();
    order.dedup();
    let of_run = |run: usize| {
        let rows = || (0..runs.len()).filter(move |&row| runs[row] == run);
        let present = |k: usize| rows().filter(move |&row| table.variances[row][k].is_finite());
        let values: Vec<f64> = raised.iter().map(|&k| mean(present(k).map(|row| table.rows[row][k]))).collect();
        let complete = values.iter().all(|value| value.is_finite());
        complete.then(|| (units[run].as_str(), DVector::from_vec(values)))
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
