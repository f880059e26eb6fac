//! Campaigns: many labelled traces of the rig, under many conditions, with seeds that never meet, and what the detector
//! makes of them.
//!
//! | room | what it holds |
//! |---|---|
//! | [`sets`] | cells, their seeds, and the traces in them |
//! | [`experiments`] | what is trained, what is judged, what counts, what is wanted |
//! | [`run`] | repetitions through the core |
//! | [`alarms`] | rates that are set: false alarms, and how soon a defect alarms |
//! | [`render`] | figures as text, rows and JSON |

pub mod alarms;
pub mod experiments;
pub mod render;
pub mod run;
pub mod sets;

use super::statistics::mean_sd;
use crate::Error;
use crate::evaluate::Rate;
use alarms::{Alarmed, Rates};
use experiments::Experiment;
use run::Count;

pub use experiments::Goal;
pub use sets::{Cell, Purpose, Recording, map_traces, record};

/// How large a campaign is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Draws of training and validation sets.
    pub repetitions: u32,
    /// The first repetition's number: other numbers, other traces.
    pub first: u32,
    /// Traces a class and set.
    pub traces: u32,
    /// Whether the false alarms of many gates are measured too.
    pub false_alarms: bool,
}

/// One experiment over all repetitions.
#[derive(Clone, Debug)]
pub struct Figure {
    /// What was asked.
    pub experiment: Experiment,
    /// A count each repetition.
    pub counts: Vec<Count>,
}

impl Figure {
    /// Mean and standard deviation of a repetition, percent.
    #[must_use]
    pub fn mean_sd(&self) -> (f64, f64) {
        mean_sd(&self.counts.iter().map(|c| 100.0 * c.counted as f64 / c.judged.max(1) as f64).collect::<Vec<_>>())
    }

    /// All repetitions pooled, with a 95 % interval.
    #[must_use]
    pub fn pooled(&self) -> Rate {
        Rate::wilson(self.counts.iter().map(|c| c.counted).sum(), self.counts.iter().map(|c| c.judged).sum())
    }

    /// Mean of the source's method on the same records, percent.
    #[must_use]
    pub fn literal(&self) -> Option<f64> {
        let known: Vec<f64> = self.counts.iter().filter_map(|c| c.literal).collect();
        (!known.is_empty()).then(|| 100.0 * known.iter().sum::<f64>() / known.len() as f64)
    }

    /// Whether the mean meets the goal; nothing where there is none.
    #[must_use]
    pub fn met(&self) -> Option<bool> {
        self.experiment.goal.map(|goal| goal.met(self.mean_sd().0))
    }
}

/// What a campaign found.
#[derive(Clone, Debug)]
pub struct Findings {
    /// Its size.
    pub settings: Settings,
    /// The experiments.
    pub figures: Vec<Figure>,
    /// How soon defects alarm.
    pub alarms: Vec<Alarmed>,
    /// False alarms of many gates, where asked for.
    pub rates: Vec<Rates>,
}

/// Rates that are set.
const RATES: [f64; 2] = [1e-2, 1e-3];
/// Draws, healthy training traces and judged traces a draw of [`alarms::false_alarms`].
const GATES: (u32, u32, u32) = (20, 200, 2000);
/// Records of a sequence, and the repetitions of them.
const SEQUENCE: (usize, u32) = (5, 4);

impl Settings {
    /// Steps of progress.
    #[must_use]
    pub fn steps(&self) -> usize {
        let gates = if self.false_alarms { 2 * GATES.0 } else { 0 };
        self.repetitions as usize * experiments::all(self.traces).len() + (SEQUENCE.1 + gates) as usize
    }
}

/// Runs a campaign; `done` is called once a step.
///
/// # Errors
/// Where simulation, training or embedding fails.
pub fn campaign(settings: Settings, done: impl Fn()) -> Result<Findings, Error> {
    let experiments = experiments::all(settings.traces);
    let mut figures: Vec<Figure> =
        experiments.iter().map(|experiment| Figure { experiment: experiment.clone(), counts: vec![] }).collect();
    for repetition in settings.first..settings.first + settings.repetitions {
        let counts = run::repetition(&experiments, (repetition, settings.traces), &done)?;
        figures.iter_mut().zip(counts).for_each(|(figure, count)| figure.counts.push(count));
    }
    let (length, repetitions) = SEQUENCE;
    let alarms = alarms::alarms(repetitions, settings.traces, length, &done)?;
    let mut rates = vec![];
    if settings.false_alarms {
        for condition in [crate::rig::Condition::STANDARD, crate::rig::Condition::MIX] {
            rates.push(alarms::false_alarms(condition, GATES, &RATES, &done)?);
        }
    }
    Ok(Findings { settings, figures, alarms, rates })
}
