//! The temperatures among the columns of the recordings: each is a covariate if it explains what training watches.
//!
//! ```text
//! columns ─► named as temperatures ─► in every trace ─► explain left-out segments ─► covariates of the training
//! ```

use bearing_watch::plan::MAX_COVARIATES;

use crate::Error;
use crate::core::features::MEAN;
use crate::session::source::TemperatureColumn;
use crate::trace::labels::LabelledTrace;
use crate::train::{Recipe, Temperature, temperatures};

/// The temperatures of the recordings.
#[derive(Clone, Debug, Default)]
pub(crate) struct Temperatures(pub(crate) Vec<Temperature>);

impl Temperatures {
    /// Of these columns without those that are used already; `read` reads the traces with some. With the traces, if
    /// they have been read with what is taken.
    pub(crate) fn of(
        named: Vec<TemperatureColumn>,
        used: &[&str],
        read: impl Fn(&[String]) -> Result<Traces, Error>,
    ) -> Result<(Self, Option<Traces>), Error> {
        let (mut all, mut offered) = (vec![], vec![]);
        for TemperatureColumn { name, lacking, of } in named {
            if used.contains(&name.as_str()) {
                continue;
            }
            match lacking {
                0 if offered.len() < MAX_COVARIATES => offered.push(name),
                0 => all.push(Temperature::refused(&name, "there are too many before it".into())),
                _ => {
                    let why = format!("it is missing in {lacking} of {of} recordings");
                    all.push(Temperature::refused(&name, why));
                }
            }
        }
        let Some(traces) = readable(read, &mut offered, &mut all)? else { return Ok((Self(all), None)) };
        match temperatures(&traces.prepared, &traces.classes, &traces.recipe) {
            Ok(judged) => all.extend(judged),
            // What is wrong with the traces themselves is told where the model is trained.
            Err(problem) => all.extend(offered.iter().map(|name| Temperature::refused(name, problem.to_string()))),
        }
        let temperatures = Self(all);
        let all_are_taken = temperatures.taken() == offered;
        Ok((temperatures, all_are_taken.then_some(traces)))
    }

    /// The columns of those that are taken.
    pub(crate) fn taken(&self) -> Vec<String> {
        self.0.iter().filter(|own| own.refused.is_none()).map(|own| own.column.clone()).collect()
    }

    /// None of them is taken, for this reason.
    pub(crate) fn refuse(&mut self, why: &str) {
        let taken = self.0.iter_mut().filter(|own| own.refused.is_none());
        taken.for_each(|own| own.refused = Some(why.into()));
    }
}

/// Reads the traces with the offered temperatures, without those that cannot be read; `None` if none is left.
fn readable(
    read: impl Fn(&[String]) -> Result<Traces, Error>,
    offered: &mut Vec<String>,
    all: &mut Vec<Temperature>,
) -> Result<Option<Traces>, Error> {
    if offered.is_empty() {
        return Ok(None);
    }
    if let Ok(traces) = read(offered) {
        return Ok(Some(traces));
    }
    offered.retain(|name| match read(std::slice::from_ref(name)) {
        Ok(_) => true,
        Err(problem) => {
            all.push(Temperature::refused(name, problem.to_string()));
            false
        }
    });
    (!offered.is_empty()).then(|| read(offered)).transpose()
}

/// The names of the covariates of these columns.
pub(crate) fn covariates(columns: &[String]) -> Vec<String> {
    columns.iter().map(|name| format!("{MEAN}{name}")).collect()
}

/// Traces with their classes, and the recipe for them.
pub(crate) struct Traces {
    pub(crate) classes: Vec<String>,
    /// As recorded.
    pub(crate) training: Vec<LabelledTrace>,
    pub(crate) prepared: Vec<LabelledTrace>,
    pub(crate) recipe: Recipe,
}
