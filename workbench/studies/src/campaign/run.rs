//! Trains and tests each repetition of an experiment with the embedded detector.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use rayon::prelude::*;

use super::experiments::{Experiment, Judge, Training};
use super::seeds::Purpose;
use super::sets::{Cell, Recording, map_traces};
use crate::literal;
use crate::recipes::{self, REFERENCE_ORDER};
use model::Error;
use model::core::{Embedded, Finding, SegmentReport};
use model::trace::labels::LabelledTrace;
use model::trace::{MotionTrace, Trace};
use model::train::{Alarms, Recipe, train};
use rig::{Condition, Defect, RigTrace, Scenario};

/// The configuration of all experiments: [`recipes::shaft`] with [`recipes::SIZE_SPREAD`] and a novelty gate at the
/// given false-alarm rate.
#[must_use]
pub fn ours(false_alarm: f64) -> Recipe {
    let alarms = Alarms { healthy: Some(0), false_alarm, required: true, ..Alarms::default() };
    Recipe { alarms, size_spread: recipes::SIZE_SPREAD, ..recipes::shaft() }
}

/// Result of one repetition of one experiment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Count {
    /// Number of records with the counted outcome.
    pub counted: usize,
    /// Number of test records.
    pub judged: usize,
    /// Error rate of the source's method on the same records; only for three classes and single records.
    pub literal: Option<f64>,
}

/// Names of the trained classes, in order.
#[must_use]
pub fn class_names(classes: &[Defect]) -> Vec<String> {
    classes.iter().map(|defect| defect.kind.name().to_string()).collect()
}

/// The signals of the shaft of a simulated trace, as those of a recorded one.
#[must_use]
pub fn motion(recorded: &RigTrace) -> MotionTrace {
    MotionTrace {
        current_a: recorded.current_a.clone(),
        velocity_rad_s: recorded.velocity_rad_s.clone(),
        load_nm: recorded.recorded_load_nm(),
        angle_rad: recorded.angle_rad.clone(),
        reference_rad_s: recorded.velocity_ref_rad_s.clone(),
    }
}

/// Converts a recording to a labelled trace of the workbench; u1 is the velocity reference.
#[must_use]
pub fn labelled(recording: Recording, class: usize) -> LabelledTrace {
    let Recording { cell, seed, trace: recorded, .. } = recording;
    let motion = motion(&recorded);
    let trace = Trace {
        id: format!("{}_{seed:016x}", cell.defect.kind.name()),
        interval_s: Some(Scenario::STANDARD.sample_time_s),
        u2: recorded.recorded_load_nm(),
        y: recorded.current_a,
        u1: recorded.velocity_ref_rad_s,
        motion: Some(motion),
        further: vec![recorded.temperature_c],
        ..Trace::default()
    };
    LabelledTrace { trace, class }
}

/// Simulates the traces of each cell, in the order of `cells`.
///
/// # Errors
/// Same as [`map_traces`].
pub fn traces(cells: &[(Cell, usize)], count: u32) -> Result<Vec<LabelledTrace>, Error> {
    let only: Vec<Cell> = cells.iter().map(|(cell, _)| *cell).collect();
    let class = |cell: &Cell| cells.iter().find(|(own, _)| own == cell).map_or(0, |(_, class)| *class);
    map_traces(&Scenario::WITH_RESOLVER, &only, count, |recording| {
        let class = class(&recording.cell);
        Ok(labelled(recording, class))
    })
}

/// Simulates the training set of one repetition.
///
/// # Errors
/// Same as [`traces`].
pub fn training_set(training: &Training, repetition: u32) -> Result<Vec<LabelledTrace>, Error> {
    let cell = |defect: &Defect| Cell {
        purpose: Purpose::Training,
        repetition,
        condition: training.condition,
        defect: *defect,
    };
    let cells: Vec<(Cell, usize)> = training.classes.iter().enumerate().map(|(k, defect)| (cell(defect), k)).collect();
    traces(&cells, training.count)
}

/// Runs one repetition of all experiments; `done` is called once per experiment. The results are in the same order.
///
/// # Errors
/// Returns an error if simulation or training fails.
pub fn repetition(
    experiments: &[Experiment],
    (repetition, count): (u32, u32),
    done: impl Fn(),
) -> Result<Vec<Count>, Error> {
    let mut models: Vec<(&Training, Vec<LabelledTrace>, Embedded)> = Vec::new();
    let mut sets: HashMap<String, Vec<LabelledTrace>> = HashMap::new();
    let mut counts = Vec::new();
    for experiment in experiments {
        let training = &experiment.training;
        if !models.iter().any(|(own, _, _)| *own == training) {
            let set = training_set(training, repetition)?;
            let model = train(&set, &class_names(&training.classes), &ours(0.01))?.embed()?;
            models.push((training, set, model));
        }
        for (condition, defect) in &experiment.tests {
            if let Entry::Vacant(place) = sets.entry(key(condition, defect, experiment.records)) {
                let cell = Cell { purpose: Purpose::Validation, repetition, condition: *condition, defect: *defect };
                place.insert(traces(&[(cell, 0)], count * experiment.records)?);
            }
        }
        if let Some((_, set, model)) = models.iter().find(|(own, _, _)| *own == training) {
            counts.push(judge(experiment, set, model, &sets)?);
        }
        done();
    }
    Ok(counts)
}

fn key(condition: &Condition, defect: &Defect, records: u32) -> String {
    format!("{} {:?} {records}", condition.name, defect)
}

fn judge(
    experiment: &Experiment,
    training: &[LabelledTrace],
    model: &Embedded,
    sets: &HashMap<String, Vec<LabelledTrace>>,
) -> Result<Count, Error> {
    let mut count = Count { counted: 0, judged: 0, literal: None };
    let classes = &experiment.training.classes;
    // If the source's method judges the same records.
    let by_literal = experiment.judge == Judge::Error && experiment.records == 1 && classes.len() == 3;
    let mut judged: Vec<LabelledTrace> = Vec::new();
    for (condition, defect) in &experiment.tests {
        let truth = classes.iter().position(|class| class.kind == defect.kind);
        let set = &sets[&key(condition, defect, experiment.records)];
        let segments: Vec<Vec<SegmentReport>> = set.par_iter().map(|t| model.run(&t.trace)).collect();
        for records in segments.chunks(experiment.records as usize) {
            let together: Vec<SegmentReport> = records.iter().flatten().cloned().collect();
            count.judged += 1;
            count.counted += usize::from(counts(experiment.judge, model.combine(&together), truth));
        }
        if by_literal {
            judged.extend(set.iter().map(|t| LabelledTrace { trace: t.trace.clone(), class: truth.unwrap_or(0) }));
        }
    }
    if by_literal {
        // If the source's method cannot estimate a model, it has no error rate.
        let outcome = literal::validate(training, &judged, &class_names(classes), REFERENCE_ORDER);
        count.literal = outcome.ok().map(|outcome| outcome.all_classes.error_rate().value);
    }
    Ok(count)
}

/// Whether a record has the counted outcome; a record without a verdict counts as wrong and as not healthy.
fn counts(judge: Judge, decided: Option<(Finding, Vec<f32>)>, truth: Option<usize>) -> bool {
    let Some((finding, posteriors)) = decided else { return matches!(judge, Judge::Error | Judge::Detected) };
    let most_plausible = (0..posteriors.len()).max_by(|&i, &j| posteriors[i].total_cmp(&posteriors[j]));
    match judge {
        Judge::Error => most_plausible != truth,
        Judge::Misnamed => finding.class().is_some() && finding.class() != truth,
        Judge::CalledHealthy => finding == Finding::Class(0),
        Judge::Detected => finding != Finding::Class(0),
    }
}
