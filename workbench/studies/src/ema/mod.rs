//! Studies on the simulated actuator: from phase currents and resolver counts to verdicts.
//!
//! | module | content |
//! |---|---|
//! | [`record`] | records through the core's front end, or as the source prepared its own |
//! | [`sets`] | labelled records at the control rate |
//! | [`recipe`] | the one configuration |
//! | [`experiments`] | what the campaign measures |
//! | [`run`] | one draw of the experiments with the embedded detector |
//! | [`source`] | the source's method on the actuator |
//! | [`render`] | results as text, rows and JSON |
//! | [`park`] | the angle of the Park transform (thesis Fig. 5.35) |

pub mod experiments;
pub mod park;
pub mod recipe;
pub mod record;
pub mod render;
pub mod run;
pub mod sets;
pub mod source;

use crate::literal::Judged;
use crate::tables::chapter5::published::TRACES_MOOG;
use experiments::Experiment;
use model::Error;
use rig::ema::EmaCondition;
use run::Count;
pub use run::Settings;

/// One experiment over all draws.
#[derive(Clone, Debug)]
pub struct Figure {
    /// The experiment.
    pub experiment: Experiment,
    /// One count per draw.
    pub counts: Vec<Count>,
}

/// Errors of the source's method with defects of one size.
#[derive(Clone, Debug)]
pub struct Calibration {
    /// Condition, logged as at Moog.
    pub condition: EmaCondition,
    /// Size of both defects.
    pub severity: f64,
    /// Decisions, one per draw.
    pub judged: Vec<Judged>,
}

/// Results of the campaign.
#[derive(Clone, Debug)]
pub struct Findings {
    /// Its size.
    pub settings: Settings,
    /// The experiments.
    pub figures: Vec<Figure>,
    /// Decisions of the source's method in MIX, for each of [`run::MODELS`] one per draw.
    pub source: Vec<Vec<Judged>>,
    /// Errors of the source's method by size.
    pub calibration: Vec<Calibration>,
}

/// Records per class and set of the calibration: the number that the source has of the rig at Moog.
const CALIBRATION_RECORDS: u32 = TRACES_MOOG;

/// Conditions and sizes of the calibration: fixed conditions, and random ones.
const SIZES: [(&str, &[f64]); 2] = [("moog-1", &[0.25, 0.5, 1.0, 2.0]), ("moog-1-mix", &[0.5, 24.0])];

impl Settings {
    /// Number of progress steps of [`study`].
    #[must_use]
    pub fn steps(&self) -> usize {
        let sizes: usize = SIZES.iter().map(|(_, sizes)| sizes.len()).sum();
        self.draws as usize * experiments::all().len() + self.calibrations() * sizes
    }

    /// Number of draws of the calibration, which has no goal.
    const fn calibrations(&self) -> usize {
        if self.default { 0 } else { self.draws.div_ceil(2) as usize }
    }
}

/// Runs the campaign; `done` is called once per step.
///
/// # Errors
/// Returns an error if simulation, training or embedding fails.
pub fn study(settings: Settings, done: impl Fn()) -> Result<Findings, Error> {
    let experiments = experiments::all();
    let numbers = settings.first..settings.first + settings.draws;
    let draws = numbers.clone().map(|number| run::draw(&experiments, (number, &settings), &done));
    let draws = draws.collect::<Result<Vec<_>, _>>()?;
    let figure = |(k, experiment): (usize, Experiment)| Figure {
        experiment,
        counts: draws.iter().map(|draw| draw.counts[k]).collect(),
    };
    let source = |k: usize| draws.iter().filter_map(|draw| draw.source.get(k).cloned()).collect();
    let source = (0..run::MODELS.len()).map(source).filter(|all: &Vec<_>| !all.is_empty()).collect();
    let sizes = SIZES
        .iter()
        .filter(|_| !settings.default)
        .flat_map(|(name, sizes)| sizes.iter().map(move |size| (*name, *size)));
    let calibrated = |(name, severity): (&str, f64)| -> Result<Calibration, Error> {
        let condition = EmaCondition::named(name).unwrap_or(EmaCondition::STANDARD);
        let one = |number| run::calibration(&condition, severity, (number, CALIBRATION_RECORDS));
        let judged = numbers.clone().take(settings.calibrations()).map(one).collect::<Result<_, _>>()?;
        (0..settings.calibrations()).for_each(|_| done());
        Ok(Calibration { condition, severity, judged })
    };
    let calibration = sizes.map(calibrated).collect::<Result<_, _>>()?;
    Ok(Findings { settings, figures: experiments.into_iter().enumerate().map(figure).collect(), source, calibration })
}
