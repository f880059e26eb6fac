//! A set of simulated traces.

use rayon::prelude::*;

use super::dc::Dc;
use super::ema::Ema;
use super::experiment::{Experiment, Simulated};
use super::options::{Rig, Simulation};
use model::Error;
use model::trace::{Cells, FrontEndFile, Recorded};
use rig::{DefectKind, trace_seed};

/// A set of simulated traces, each of whose classes can be simulated.
pub struct Set<'a> {
    options: &'a Simulation,
    experiment: Box<dyn Experiment>,
}

impl std::fmt::Debug for Set<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Set").field("options", &self.options).finish_non_exhaustive()
    }
}

impl<'a> Set<'a> {
    /// The traces of these options.
    ///
    /// # Errors
    /// Options that do not go together, or a class that the rig cannot simulate.
    pub fn new(options: &'a Simulation) -> Result<Self, Error> {
        if options.count == 0 || options.class.is_empty() {
            return Err(Error::Usage("--count 0 makes no traces; give at least 1".into()));
        }
        let experiment: Box<dyn Experiment> = match options.rig {
            Rig::Dc => Box::new(Dc::new(options)?),
            Rig::Ema => Box::new(Ema::new(options)?),
        };
        for (k, kind) in options.class.iter().enumerate() {
            if options.class[..k].contains(kind) {
                return Err(Error::Usage(format!("--class names {} twice", kind.name())));
            }
            experiment.validate(*kind)?;
        }
        Ok(Self { options, experiment })
    }

    /// Class and number of each trace.
    #[must_use]
    pub fn jobs(&self) -> Vec<(DefectKind, u32)> {
        let Simulation { class, count, .. } = self.options;
        class.iter().flat_map(|&kind| (0..*count).map(move |k| (kind, k))).collect()
    }

    /// Name of the condition.
    #[must_use]
    pub fn condition(&self) -> &str {
        self.experiment.condition()
    }

    /// The front end of the traces, if they are raw samples.
    #[must_use]
    pub fn front_end(&self) -> Option<FrontEndFile> {
        self.experiment.front_end()
    }

    /// Simulates one trace, and returns its name.
    ///
    /// # Errors
    /// The rig refuses it.
    pub fn simulate(&self, kind: DefectKind, k: u32) -> Result<(String, Simulated), Error> {
        let seed = self.options.seed;
        let simulated = self.experiment.simulate(kind, trace_seed(seed, kind, k))?;
        Ok((format!("{}_{seed}_{k:03}", self.stem(kind)), simulated))
    }

    /// Simulates all traces in memory, and returns their classes too.
    ///
    /// # Errors
    /// The rig refuses one.
    pub fn tables(&self) -> Result<Vec<(Recorded, &'static str)>, Error> {
        let each = |(kind, k): (DefectKind, u32)| {
            let (name, simulated) = self.simulate(kind, k)?;
            let column = |(name, column): (&str, Vec<f64>)| (name.to_string(), Cells::Numbers(column));
            Ok((Recorded::new(name, simulated.table.into_iter().map(column).collect())?, kind.name()))
        };
        self.jobs().into_par_iter().map(each).collect()
    }

    /// Returns the file name of the traces of one class, without seed and number.
    fn stem(&self, kind: DefectKind) -> String {
        let experiment = self.experiment.as_ref();
        let mut parts: Vec<String> = experiment.prefix(kind).map(String::from).into_iter().collect();
        parts.push(kind.name().into());
        if kind != DefectKind::Healthy && self.options.severity != 1.0 {
            parts.push(self.options.severity.to_string());
        }
        if experiment.condition() != "standard" {
            parts.push(experiment.condition().into());
        }
        parts.extend(experiment.suffix().map(String::from));
        parts.join("_")
    }
}
