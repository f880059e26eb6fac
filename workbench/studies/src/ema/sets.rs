//! Labelled records of the actuator at the control rate, through the core's front end.

use model::Error;
use model::trace::labels::LabelledTrace;
use rig::ema::{EmaCondition, EmaDefect, EmaScenario, EmaTrace, Logging, Race, simulate};
use rig::{Defect, DefectKind};

use super::record::cleaned;

/// Rows of the control rate per sample: 12 kHz → 1 kHz.
pub const FACTOR: usize = 12;

/// Classes, healthy first, with the size at which the source's method errs as in its chapter 5.
pub const CLASSES: [Defect; 3] = [
    Defect { kind: DefectKind::Healthy, severity: 0.0 },
    Defect { kind: DefectKind::Spall, severity: EmaDefect::CALIBRATED },
    Defect { kind: DefectKind::Roughness, severity: EmaDefect::CALIBRATED },
];

/// Names of [`CLASSES`].
#[must_use]
pub fn class_names() -> Vec<String> {
    CLASSES.map(|defect| defect.kind.name().to_string()).to_vec()
}

/// A record with a row each control interval, and its experiment. A spall is one of the inner race.
///
/// # Errors
/// Returns an error if the rig refuses the scenario.
pub fn recorded(condition: &EmaCondition, defect: Defect, seed: u64) -> Result<(EmaScenario, EmaTrace), Error> {
    recorded_on(condition, EmaDefect::of(defect.kind, defect.severity, Race::Inner), seed)
}

/// Same as [`recorded`], with any defect of the actuator.
///
/// # Errors
/// Same as [`recorded`].
pub fn recorded_on(condition: &EmaCondition, defect: EmaDefect, seed: u64) -> Result<(EmaScenario, EmaTrace), Error> {
    let scenario = condition.scenario(seed).with_defect(defect).logged(Logging { every: 1, hold: 1 });
    let recorded = simulate(&scenario, seed).map_err(Error::other)?;
    Ok((scenario, recorded))
}

/// A record behind the front end, with its class.
///
/// # Errors
/// Returns an error if the rig refuses the scenario, or the front end a sample.
pub fn labelled(condition: &EmaCondition, (class, defect): (usize, Defect), seed: u64) -> Result<LabelledTrace, Error> {
    let (scenario, recorded) = recorded(condition, defect, seed)?;
    let id = format!("{}_{}_{seed:016x}", condition.name, defect.kind.name());
    Ok(LabelledTrace { trace: cleaned::<FACTOR>(&scenario, &recorded)?.into_trace(id), class })
}
