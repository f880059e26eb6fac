//! Alarm rates: false-alarm rates of the gate over many training draws, and number of records until a defect alarms.

use rayon::prelude::*;

use super::experiments::{Training, full_size};
use super::run::{class_names, ours, training_set};
use super::seeds::Purpose;
use super::sets::{Cell, map_traces};
use model::Error;
use model::train::train;
use rig::{Condition, Defect, DefectKind, Scenario};

/// False-alarm rates of gates, one for each draw of healthy training traces; each gate is tested on separate traces.
#[derive(Clone, Debug, PartialEq)]
pub struct Rates {
    /// Condition of all traces.
    pub condition: &'static str,
    /// Number of healthy training traces per draw.
    pub traces: u32,
    /// Number of test traces per draw.
    pub judged: u32,
    /// Nominal rate, and the measured rate of the gate of each draw.
    pub rates: Vec<(f64, Vec<f64>)>,
    /// Number of healthy traces from which on 95 % of the gates have at most three times the nominal rate.
    pub needed: Vec<usize>,
}

/// Trains one gate per draw and measures its false-alarm rate at each nominal rate of `set`.
///
/// # Errors
/// Same as training and simulation.
pub fn false_alarms(
    condition: Condition,
    (draws, traces, judged): (u32, u32, u32),
    set: &[f64],
    done: impl Fn(),
) -> Result<Rates, Error> {
    let mut rates: Vec<(f64, Vec<f64>)> = set.iter().map(|rate| (*rate, Vec::new())).collect();
    let mut needed = Vec::new();
    // Far from the repetition numbers of the experiments, so that no trace is shared.
    for draw in 1000..1000 + draws {
        let training = Training { condition, classes: vec![Defect::HEALTHY], count: traces };
        let training_traces = training_set(&training, draw)?;
        let trained = train(&training_traces, &class_names(&training.classes), &ours(set[0]))?;
        if needed.is_empty() {
            needed = set.iter().map(|&rate| rows_needed(trained.feature_names.len(), rate)).collect();
        }
        let model = trained.embed()?;
        let cell = Cell { purpose: Purpose::Validation, repetition: draw, condition, defect: Defect::HEALTHY };
        let surprises = map_traces(&Scenario::WITH_RESOLVER, &[cell], judged, |recording| {
            let segments = model.run(&super::run::labelled(recording, 0).trace);
            // A healthy trace without a verdict also counts as an alarm.
            Ok(segments.first().filter(|s| s.verdict.is_ok()).map_or(f64::INFINITY, |s| f64::from(s.surprise)))
        })?;
        for (rate, found) in &mut rates {
            let limit = -rate.ln();
            found.push(surprises.iter().filter(|s| **s >= limit).count() as f64 / surprises.len() as f64);
        }
        done();
    }
    Ok(Rates { condition: condition.name, traces, judged, rates, needed })
}

fn rows_needed(coordinates: usize, rate: f64) -> usize {
    model::train::novelty::spread::rows_needed(coordinates, rate)
}

/// Number of records until a defect at full size alarms, for each sequence.
#[derive(Clone, Debug, PartialEq)]
pub struct Alarmed {
    /// The defect; healthy sequences must not alarm.
    pub kind: DefectKind,
    /// Number of records in a sequence.
    pub length: usize,
    /// Number of records until the alarm, for each sequence; `None` without alarm.
    pub records: Vec<Option<usize>>,
}

/// Passes sequences of records through the gate and the evidence accumulation.
///
/// # Errors
/// Same as training and simulation.
pub fn alarms(repetitions: u32, count: u32, length: usize, done: impl Fn()) -> Result<Vec<Alarmed>, Error> {
    let kinds = [DefectKind::Spall, DefectKind::Roughness, DefectKind::Healthy];
    let mut all = kinds.map(|kind| Alarmed { kind, length, records: vec![] }).to_vec();
    for repetition in 2000..2000 + repetitions {
        let training = Training { condition: Condition::STANDARD, classes: full_size(), count };
        let set = training_set(&training, repetition)?;
        let model = train(&set, &class_names(&training.classes), &ours(0.01))?.embed()?;
        for alarmed in &mut all {
            let cell = Cell {
                purpose: Purpose::Validation,
                repetition,
                condition: Condition::STANDARD,
                defect: Defect::full(alarmed.kind),
            };
            let segments = map_traces(&Scenario::WITH_RESOLVER, &[cell], 5 * length as u32, |recording| {
                Ok(model.run(&super::run::labelled(recording, 0).trace))
            })?;
            let sequences = segments.par_chunks(length).map(|sequence| {
                let watched = model.watch(&sequence.concat());
                watched.iter().position(|state| state.alarm.is_some()).map(|k| k + 1)
            });
            alarmed.records.extend(sequences.collect::<Vec<_>>());
        }
        done();
    }
    Ok(all)
}
