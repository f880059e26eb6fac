//! Healthy training segments → the novelty gate and the constants of the alarm.
//!
//! Mean and covariance are those of the healthy class alone. The gate follows from the distribution of a further
//! segment's distance ([`law`]), so that the mean false-alarm rate over training sets of any size is the set one. The
//! deviation of a single gate from the set rate depends on the number of segments ([`spread`]).
//!
//! Coordinates may have errors of known variance, or be missing (`super::moments`). The distance of each segment is
//! that of its available coordinates, with their errors, and [`law::equivalent`] converts it to all coordinates, as the
//! core does. The number of segments is then that of the coordinate that is missing most often.
//!
//! Segments of one run are more alike than those of different runs. If the runs are known ([`Alarms::by_run`]), mean,
//! covariance and law are those for a segment of the next run ([`runs`]), and the number of runs, not of segments, must
//! suffice for the set rate.
//!
//! The alarm collects e-values of runs ([`alarm`]), divided by their mean for 95 % of baselines of this size:
//! [`baseline`] finds it for the novelty, `ratios` for the likelihood ratios of the defects.

pub mod alarm;
pub mod baseline;
mod commissioning;
mod knots;
pub mod law;
mod of_rows;
pub mod of_sums;
mod ratios;
pub mod rising;
pub mod runs;
mod scarcity;
pub mod score;
pub mod spread;

use bearing_watch::model::EvidenceConstants;
use bearing_watch::model::KNOTS;
use nalgebra::{DMatrix, DVector};

use super::{GaussianClasses, Recipe, moments};
use crate::Error;
use law::DistanceLaw;
pub(crate) use of_rows::{Rows, required_gate};
pub use of_rows::{gate_of, gate_of_rising, gate_of_runs, gate_of_table};
use ratios::TrainingSet;
use rising::Rising;
use runs::RunSpread;
pub use scarcity::fewest;

/// κ of the evidence: a mean surprise of 5 nats is detected fastest, and a mean surprise of 2 instead of 1 in the
/// healthy state does not yet cause an alarm.
pub const BET: f32 = 0.2;
/// Mean time between false alarms if none is given: in hours if the rate is known, else in segments.
const USUAL_HOURS: f64 = 1000.0;
const USUAL_SEGMENTS: f64 = 1e5;

/// Mean time between false alarms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AlarmInterval {
    /// 1000 hours, or 100 000 segments if the sampling interval is not known.
    Usual,
    /// Hours.
    Hours(f64),
    /// Segments.
    Segments(f64),
}

/// Settings of gate, reject option and alarm.
#[derive(Clone, Debug, PartialEq)]
pub struct Alarms {
    /// The healthy class; no gate and no alarm without one.
    pub healthy: Option<usize>,
    /// Rate of healthy segments called novel.
    pub false_alarm: f64,
    /// Whether too few segments for a gate are an error; if false, the model then has no gate.
    pub required: bool,
    /// Whether the rate is that of the next run, by the groups of the validation; if false, segments are independent.
    pub by_run: bool,
    /// Cost of no decision; infinite if a decision is always required.
    pub reject_cost: f64,
    /// Mean time between false alarms.
    pub interval: AlarmInterval,
    /// Number of segments after which a run ends by itself in service; if not given, that of the longest healthy
    /// training run, or 1 if segments are independent.
    pub segments_a_run: Option<u32>,
    /// Whether the groups of the validation are drives, and the model is for another one, whose offset lasts.
    pub other_drive: bool,
}

impl Default for Alarms {
    fn default() -> Self {
        let interval = AlarmInterval::Usual;
        let reject_cost = f64::INFINITY;
        Self {
            healthy: None,
            false_alarm: 0.01,
            required: false,
            by_run: false,
            reject_cost,
            interval,
            segments_a_run: None,
            other_drive: false,
        }
    }
}

/// The gate in double precision; fields as in [`bearing_watch::model::Novelty`].
#[derive(Clone, Debug)]
pub struct Gate {
    /// The healthy class.
    pub class: usize,
    /// Its mean.
    pub mean: DVector<f64>,
    /// S, its covariance.
    pub covariance: DMatrix<f64>,
    /// Knots (d², surprise).
    pub knots: [[f64; 2]; KNOTS],
    /// −ln of the false-alarm rate.
    pub limit: f64,
    /// The distribution of the distances.
    pub law: DistanceLaw,
    /// The last coordinates, if only larger values than usual are a defect.
    pub rising: Option<Rising>,
    /// Number of healthy segments in training.
    pub rows: usize,
    /// Spread of the runs, if the rate is that of the next run.
    pub runs: Option<RunSpread>,
    /// Number of independent segments from which on 95 % of gates have at most three times the rate.
    pub rows_needed: usize,
}

/// A gate, or why there is none.
type GateOrReason = Result<Gate, String>;

/// Gate and alarm of a trained model.
#[derive(Clone, Debug)]
pub struct Watch {
    /// The gate, if there is one.
    pub gate: Option<Gate>,
    /// Constants of the alarm.
    pub evidence: EvidenceConstants,
    /// Mean number of segments between false alarms.
    pub segments: f64,
    /// A warning for the user.
    pub warning: Option<String>,
}

impl Watch {
    const fn without(warning: Option<String>) -> Self {
        Self { gate: None, evidence: EvidenceConstants::NONE, segments: f64::INFINITY, warning }
    }
}

/// Trains on the coordinates and their densities by the `recipe`; `runs` is the run of each row, if the rate is that of
/// the next run, and `segment_s` is the duration of a segment, if known.
pub(crate) fn train(
    rows: Rows<'_>,
    (runs, segment_s): (Option<&[usize]>, Option<f64>),
    recipe: &Recipe,
    densities: &GaussianClasses,
) -> Result<Watch, Error> {
    let Rows { table, names, .. } = rows;
    let rows_of_runs = TrainingSet::Rows { table, runs };
    watch((names, segment_s), recipe, densities, &|alarms| of_rows::gate(rows, runs, alarms), &rows_of_runs)
}

/// Returns the gate by `gate`, and the constants of the alarm.
fn watch(
    (names, segment_s): (&[String], Option<f64>),
    recipe: &Recipe,
    densities: &GaussianClasses,
    gate: &dyn Fn(&Alarms) -> Result<GateOrReason, Error>,
    set: &TrainingSet<'_>,
) -> Result<Watch, Error> {
    let alarms = &recipe.alarms;
    if alarms.reject_cost.is_nan() || alarms.reject_cost < 0.0 {
        return Err(Error::Usage("--reject-cost is not negative".into()));
    }
    if alarms.healthy.is_none() {
        return Ok(Watch::without(None));
    }
    let segments = segments_between(alarms.interval, segment_s)?;
    let gate = match gate(alarms)? {
        Ok(gate) => gate,
        Err(problem) => return Ok(Watch::without(Some(problem + "; none is set"))),
    };
    let usual = gate.runs.as_ref().filter(|_| !alarms.other_drive).map_or(1, |runs| runs.longest as u32);
    let run = (alarms.segments_a_run.unwrap_or(usual), alarms.other_drive);
    let found = alarm::constants(&gate, densities.means.len(), segments, run).map(|evidence| {
        let defect_log_mean = ratios::log_mean((set, names), recipe, (densities, gate.runs.as_ref()), evidence.cap);
        EvidenceConstants { defect_log_mean, ..evidence }
    });
    let (evidence, refused) = match found {
        Ok(evidence) => (evidence, None),
        Err(Error::Training(problem)) if !alarms.required => {
            (EvidenceConstants::NONE, Some(problem + "; there is none"))
        }
        Err(problem) => return Err(problem),
    };
    let warnings: Vec<String> = gate.warning(alarms.false_alarm).into_iter().chain(refused).collect();
    let warning = (!warnings.is_empty()).then(|| warnings.join("; "));
    Ok(Watch { gate: Some(gate), evidence, segments, warning })
}

/// Returns the gate if rate and segments allow it.
fn checked(
    alarms: &Alarms,
    scarcity: Option<String>,
    gate: impl FnOnce() -> Result<Gate, Error>,
) -> Result<GateOrReason, Error> {
    let rate = alarms.false_alarm;
    if !(1e-9..=0.5).contains(&rate) {
        return Err(Error::Usage(format!("--false-alarm {rate}: give a rate from 1e-9 to 0.5 a segment")));
    }
    match scarcity {
        Some(problem) if alarms.required => Err(Error::Training(problem)),
        Some(problem) => Ok(Err(problem)),
        None => gate().map(Ok),
    }
}

impl Gate {
    /// Returns whether the gate calls these coordinates novel; their errors have these variances.
    pub(crate) fn is_novel(&self, value: &DVector<f64>, variance: &DVector<f64>) -> bool {
        self.surprise(value, variance).is_none_or(|surprise| surprise >= self.limit)
    }

    /// Returns the surprise of these coordinates; `None` if the covariance is singular.
    #[must_use]
    pub fn surprise(&self, value: &DVector<f64>, variance: &DVector<f64>) -> Option<f64> {
        let healthy = (&self.mean, &self.covariance);
        match &self.rising {
            Some(rising) => rising.surprise(healthy, (value, variance)),
            None => moments::squared_distance(healthy, value, variance)
                .map(|(squared, available)| self.law.surprise(law::equivalent(squared, available, value.len()))),
        }
    }

    /// Says what is uncertain about the rate of this gate.
    fn warning(&self, rate: f64) -> Option<String> {
        let Self { rows, runs, rows_needed, .. } = self;
        // So many independent segments have a covariance of the same accuracy.
        let counted = runs.as_ref().map_or(*rows as f64, |runs| runs.freedom + 1.0);
        let counted_as = runs.as_ref().map_or_else(String::new, |runs| {
            format!(" of {} runs, which count as {counted:.0} independent ones,", runs.count)
        });
        (counted < *rows_needed as f64).then(|| {
            format!(
                "{rows} healthy segments{counted_as} keep the false-alarm rate of {rate} in the mean only; from \
                 {rows_needed} on, 95 % of such gates have at most {} times the rate",
                spread::BOUND
            )
        })
    }
}

fn segments_between(interval: AlarmInterval, segment_s: Option<f64>) -> Result<f64, Error> {
    let segments = match (interval, segment_s) {
        (AlarmInterval::Usual, None) => USUAL_SEGMENTS,
        (AlarmInterval::Usual, Some(seconds)) => (USUAL_HOURS * 3600.0 / seconds).max(USUAL_SEGMENTS.sqrt()),
        (AlarmInterval::Segments(segments), _) => segments,
        (AlarmInterval::Hours(hours), Some(seconds)) => hours * 3600.0 / seconds,
        (AlarmInterval::Hours(_), None) => {
            let problem = "the traces have no time, so --alarm-interval-h says nothing; give --alarm-interval-segments";
            return Err(Error::Usage(problem.into()));
        }
    };
    if segments.is_finite() && segments >= 10.0 {
        return Ok(segments);
    }
    Err(Error::Usage(format!("one false alarm in {segments} segments is no interval; give at least 10 segments")))
}
