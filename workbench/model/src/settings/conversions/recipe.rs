//! From the settings to the recipe of a training: structure, preparation, estimator and folds.

use bearing_watch::model::{MAX_SEGMENT_ROWS, MAX_SEGMENT_SAMPLES};

use crate::Error;
use crate::identify::Structure;
use crate::near::among;
use crate::settings::sections::choices::Method;
use crate::settings::sections::model::Model;
use crate::settings::sections::order::Order;
use crate::settings::sections::settings::Settings;
use crate::settings::sections::validation::{self, FOLD_SEED, FOLDS};
use crate::trace::{Channels, Preparation};
use crate::train::{Estimation, Recipe, ShaftPlan, Validation};

impl Settings {
    /// The recipe without columns and folds.
    ///
    /// # Errors
    /// Settings that are out of range, do not go together, or name unknown classes.
    pub fn recipe(&self, classes: &[String], shaft: Option<ShaftPlan>) -> Result<Recipe, Error> {
        let structure = self.clone().completed().model.structure()?;
        let plain = Recipe {
            columns: Channels::new("", "", ""),
            shaft: shaft.map(|plan| self.watched(plan)),
            estimation: self.model.estimation(structure, classes, self.alarm.healthy_class(classes)?)?,
            covariates: self.model.covariates.clone(),
            alarms: self.alarm.alarms(classes)?,
            ..Recipe::new(structure)
        };
        self.classifier(plain, classes)
    }
}

impl validation::Validation {
    /// The split into folds, with the run and the unit of each trace; they are empty if they are not known.
    ///
    /// # Errors
    /// Fewer than two folds.
    pub fn folds(&self, groups: Vec<String>, units: Vec<String>) -> Result<Validation, Error> {
        let (folds, seed) = (self.folds.unwrap_or(FOLDS), self.fold_seed.unwrap_or(FOLD_SEED));
        if folds < 2 {
            return Err(Error::Usage(format!("--folds {folds}: at least 2")));
        }
        Ok(Validation { folds, seed, groups, units, columns: None, doubted: false })
    }
}

impl Model {
    /// The structure of the difference model.
    ///
    /// # Errors
    /// It is not given.
    pub fn structure(&self) -> Result<Structure, Error> {
        let Some(Order(order)) = self.order else { return Err(Error::Usage("the order is not given".into())) };
        Ok(Structure { offset: self.offset, ..order })
    }

    /// What is done to the traces before.
    ///
    /// # Errors
    /// Factors that the filters do not have.
    pub fn preparation(&self) -> Result<Preparation, Error> {
        let preparation =
            Preparation { block_mean: self.block_mean.unwrap_or(1), decimate: self.decimate.unwrap_or(1) };
        preparation.factor().map(|_| preparation)
    }

    /// The estimator of the detector; `healthy` is the index of the healthy class, if there is one.
    ///
    /// # Errors
    /// A segment that is too short or too long, not three saturations, or an unknown class.
    pub fn estimation(
        &self,
        structure: Structure,
        classes: &[String],
        healthy: Option<usize>,
    ) -> Result<Estimation, Error> {
        let method = self.method.unwrap_or_default();
        if let Some(segment) = self.segment {
            let outputs = if method == Method::Instruments { structure.na as usize } else { 0 };
            let least = structure.depth() + structure.parameters() + outputs + 2;
            let most = self.memory.map_or(MAX_SEGMENT_ROWS, |_| MAX_SEGMENT_SAMPLES);
            if segment < least || segment > most as usize {
                let problem = format!("--segment {segment}: at this order it is {least} to {most}");
                return Err(Error::Usage(problem));
            }
        }
        let saturation = match self.saturation[..] {
            [] => None,
            [y, u1, u2] => Some([y, u1, u2]),
            _ => return Err(Error::Usage("--saturation: three magnitudes Y,U1,U2, e.g. 20,300,5".into())),
        };
        let nominal = match &self.nominal {
            None => healthy.unwrap_or(0),
            Some(name) => classes.iter().position(|class| class == name).ok_or_else(|| {
                let near = among(name, classes);
                Error::Usage(format!("--nominal: unknown class {name}{near}"))
            })?,
        };
        Ok(Estimation {
            method: method.core(),
            nominal,
            segment: self.segment,
            saturation,
            stuck: self.stuck.unwrap_or(0),
            memory: self.memory,
            handover: self.handover.unwrap_or(0),
        })
    }
}
