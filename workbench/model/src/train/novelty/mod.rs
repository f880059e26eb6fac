//! Healthy training segments → the novelty gate and the constants of the alarm.
//!
//! Mean and covariance are those of the healthy class alone. The gate follows from the distribution of a further
//! segment's distance ([`law`]), so that the mean false-alarm rate over training sets of any size is the set one. The
//! deviation of a single gate from the set rate depends on the number of segments ([`spread`]).
//!
//! Coordinates may have errors of known variance, or be missing (`super::distribution::moments`). The distance of each
//! segment is that of its available coordinates, with their errors, and [`law::equivalent`] converts it to all
//! coordinates, as the core does. The number of segments is then that of the coordinate that is missing most often.
//!
//! Segments of one run are more alike than those of different runs. If the runs are known ([`Alarms::by_run`]), mean,
//! covariance and law are those for a segment of the next run ([`runs`]), and the number of runs, not of segments, must
//! suffice for the set rate.
//!
//! The alarm collects e-values of runs ([`alarm`]), divided by their mean for 95 % of baselines of this size:
//! [`baseline`] finds it for the novelty, `ratios` for the likelihood ratios of the defects.

pub mod alarm;
mod alarms;
pub mod baseline;
mod gate;
mod laws;
mod of_rows;
pub mod of_sums;
mod ratios;
pub mod runs;
mod trend;

use bearing_watch::model::EvidenceConstants;

use super::directions::{Directions, DirectionsOrReason};
use super::{GaussianClasses, Recipe};
use crate::Error;
pub use alarm::BET;
use alarms::segments_between;
pub use alarms::{ACCEPTABLE, AlarmInterval, Alarms};
pub use gate::Gate;
use gate::GateOrReason;
pub use laws::law::fewest;
pub use laws::{law, rising, score, spread};
pub(crate) use of_rows::{Rows, required_gate};
pub use of_rows::{gate_of_rising, gate_of_runs};
use ratios::TrainingSet;

/// Gate and alarm of a trained model.
#[derive(Clone, Debug)]
pub struct Watch {
    /// The gate, if there is one.
    pub gate: Option<Gate>,
    /// Constants of the alarm.
    pub evidence: EvidenceConstants,
    /// What the alarm watches; without directions it adds up the surprises of segments.
    pub directions: Option<Directions>,
    /// Mean number of segments between false alarms.
    pub segments: f64,
    /// A warning for the user.
    pub warning: Option<String>,
}

impl Watch {
    const fn without(warning: Option<String>) -> Self {
        let (evidence, segments) = (EvidenceConstants::NONE, f64::INFINITY);
        Self { gate: None, evidence, directions: None, segments, warning }
    }
}

/// Trains on the coordinates and their densities by the `recipe`; `runs` is the run of each row, if the rate is that of
/// the next run, and `segment_s` is the duration of a segment, if known. The alarm is that of `directions` if there are
/// any.
pub(crate) fn train(
    rows: Rows<'_>,
    (runs, segment_s): (Option<&[usize]>, Option<f64>),
    recipe: &Recipe,
    (densities, directions): (&GaussianClasses, DirectionsOrReason),
) -> Result<Watch, Error> {
    let Rows { table, names, .. } = rows;
    let rows_of_runs = TrainingSet::Rows { table, runs };
    let gate = |alarms: &Alarms| of_rows::gate(rows, runs, alarms);
    watch((names, segment_s), recipe, (densities, directions), &gate, &rows_of_runs)
}

/// Returns the gate by `gate`, and the constants of the alarm.
fn watch(
    (names, segment_s): (&[String], Option<f64>),
    recipe: &Recipe,
    (densities, directions): (&GaussianClasses, DirectionsOrReason),
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
    let (directions, no_directions) = match directions {
        Ok(directions) => (Some(directions), None),
        Err(why) => (None, why),
    };
    if let Some(directions) = directions {
        let evidence = alarm::of_directions(&directions, segments, alarms.segments_a_run)?;
        let warning = gate.warning(alarms.false_alarm);
        return Ok(Watch { gate: Some(gate), evidence, directions: Some(directions), segments, warning });
    }
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
    let warnings: Vec<String> =
        gate.warning(alarms.false_alarm).into_iter().chain(no_directions).chain(refused).collect();
    let warning = (!warnings.is_empty()).then(|| warnings.join("; "));
    Ok(Watch { gate: Some(gate), evidence, directions: None, segments, warning })
}
