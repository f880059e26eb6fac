//! From the settings to the recipe of a training.

use super::validation::{self, FOLD_SEED, FOLDS};
use super::whole::Settings;
use crate::Error;
use crate::trace::Channels;
use crate::train::{Recipe, ShaftPlan, Validation};

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
