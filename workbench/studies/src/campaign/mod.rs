//! Campaigns: many labelled traces of the rig under many conditions, with unique seeds, and the results of the detector
//! on them.
//!
//! | module | content |
//! |---|---|
//! | [`sets`] | cells and the traces in them |
//! | [`seeds`] | seeds that encode their trace |
//! | [`experiments`] | training set, test set, counted outcome and goal of each experiment |
//! | [`run`] | repetitions of the experiments with the embedded detector |
//! | [`alarms`] | false-alarm rates, and number of records until a defect alarms |
//! | [`render`] | figures as text, rows and JSON |

pub mod alarms;
pub mod experiments;
pub mod render;
pub mod run;
pub mod seeds;
pub mod sets;

use alarms::{Alarmed, Rates};
use experiments::Experiment;
use model::Error;
use model::evaluate::Rate;
use model::statistics::mean_sd;
use run::Count;

pub use experiments::Goal;
pub use seeds::{Purpose, SeedKey};
pub use sets::{Cell, Recording, map_traces, record};

/// Size of a campaign.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Number of draws of training and validation sets.
    pub repetitions: u32,
    /// Number of the first repetition; other numbers produce other traces.
    pub first: u32,
    /// Number of traces per class and set.
    pub traces: u32,
    /// If true, the false-alarm rates of many gates are measured as well.
    pub false_alarms: bool,
    /// Conditions whose experiments are run; all if there is none. See [`experiments::named`].
    pub only: Vec<String>,
}

/// One experiment over all repetitions.
#[derive(Clone, Debug)]
pub struct Figure {
    /// The experiment.
    pub experiment: Experiment,
    /// One count per repetition.
    pub counts: Vec<Count>,
}

impl Figure {
    /// Mean and standard deviation of the rate over the repetitions, percent.
    #[must_use]
    pub fn mean_sd(&self) -> (f64, f64) {
        mean_sd(&self.counts.iter().map(|c| 100.0 * c.counted as f64 / c.judged.max(1) as f64).collect::<Vec<_>>())
    }

    /// Rate over all repetitions together, with a 95 % interval.
    #[must_use]
    pub fn pooled(&self) -> Rate {
        Rate::wilson(self.counts.iter().map(|c| c.counted).sum(), self.counts.iter().map(|c| c.judged).sum())
    }

    /// Mean error of the source's method on the same records, percent.
    #[must_use]
    pub fn literal(&self) -> Option<f64> {
        let known: Vec<f64> = self.counts.iter().filter_map(|c| c.literal).collect();
        (!known.is_empty()).then(|| 100.0 * known.iter().sum::<f64>() / known.len() as f64)
    }

    /// Whether the mean meets the goal; `None` without a goal.
    #[must_use]
    pub fn met(&self) -> Option<bool> {
        self.experiment.goal.map(|goal| goal.met(self.mean_sd().0))
    }
}

/// Results of a campaign.
#[derive(Clone, Debug)]
pub struct Findings {
    /// Size of the campaign.
    pub settings: Settings,
    /// The experiments.
    pub figures: Vec<Figure>,
    /// Number of records until defects alarm.
    pub alarms: Vec<Alarmed>,
    /// False-alarm rates of many gates, if requested.
    pub rates: Vec<Rates>,
}

/// Nominal false-alarm rates.
const RATES: [f64; 2] = [1e-2, 1e-3];
/// Arguments of [`alarms::false_alarms`]: draws, healthy training traces per draw, test traces per draw.
const GATES: (u32, u32, u32) = (20, 200, 2000);
/// Number of records in a sequence, and number of repetitions, if the campaign has as many.
const SEQUENCE: (usize, u32) = (5, 4);

impl Settings {
    /// Number of progress steps.
    ///
    /// # Errors
    /// Same as [`experiments::named`].
    pub fn steps(&self) -> Result<usize, Error> {
        let gates = if self.false_alarms { 2 * GATES.0 } else { 0 };
        let experiments = experiments::named(self.traces, &self.only)?.len();
        Ok(self.repetitions as usize * experiments + (self.sequences() + gates) as usize)
    }

    /// Number of repetitions of the sequences of records.
    fn sequences(&self) -> u32 {
        SEQUENCE.1.min(self.repetitions)
    }
}

/// Runs a campaign; `done` is called once per step.
///
/// # Errors
/// Returns an error if simulation, training or embedding fails, or if no experiment has one of the names.
pub fn campaign(settings: Settings, done: impl Fn()) -> Result<Findings, Error> {
    let experiments = experiments::named(settings.traces, &settings.only)?;
    let mut figures: Vec<Figure> =
        experiments.iter().map(|experiment| Figure { experiment: experiment.clone(), counts: vec![] }).collect();
    for repetition in settings.first..settings.first + settings.repetitions {
        let counts = run::repetition(&experiments, (repetition, settings.traces), &done)?;
        figures.iter_mut().zip(counts).for_each(|(figure, count)| figure.counts.push(count));
    }
    let alarms = alarms::alarms(settings.sequences(), settings.traces, SEQUENCE.0, &done)?;
    let mut rates = vec![];
    if settings.false_alarms {
        for condition in [rig::Condition::STANDARD, rig::Condition::MIX] {
            rates.push(alarms::false_alarms(condition, GATES, &RATES, &done)?);
        }
    }
    Ok(Findings { settings, figures, alarms, rates })
}
