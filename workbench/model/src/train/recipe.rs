//! The settings of training, without the traces.

use std::borrow::Cow;

use bearing_watch::Park;
use bearing_watch::plan::Kind;

use super::{Alarms, Candidates, Estimation, ProjectionKind, ShaftPlan, Shrink, Validation};
use crate::Error;
use crate::core::Wiring;
use crate::core::features::{self, Catalogue};
use crate::identify::Structure;
use crate::trace::Channels;

/// Structure, estimator, features, projection, discriminant and alarms of a model.
#[derive(Clone, Debug)]
pub struct Recipe {
    /// Columns of the signals; they name the model's channels.
    pub columns: Channels,
    /// Sign convention of the quadrature current, if it is known.
    pub park: Option<Park>,
    /// Model structure.
    pub structure: Structure,
    /// How the core estimates its parameters.
    pub estimation: Estimation,
    /// The watched signals of the shaft, if any.
    pub shaft: Option<ShaftPlan>,
    /// Whether training chooses the features, by healthy traces with added defects or by the classes; the features
    /// of the recipe are then empty.
    pub automatic: bool,
    /// Feature names or groups; none means every parameter.
    pub features: Vec<String>,
    /// Names of the features that explain a part of the others.
    pub covariates: Vec<String>,
    /// Whether training itself proposes the covariates, and may leave them out.
    pub offered: bool,
    /// Names of the features that a defect only raises, besides scores and amplitudes of bearing orders: the gate
    /// judges them upwards only, given the other features.
    pub rising: Vec<String>,
    /// Projection of the features.
    pub projection: ProjectionKind,
    /// Shared or separate covariances, if they are not shrunk.
    pub discriminant: Kind,
    /// Shrinkage: covariances between separate and shared ones.
    pub shrink: Shrink,
    /// τ: relative deviation of a defect's size from the trained one; 0 if classes cover the trained sizes alone.
    pub size_spread: f64,
    /// Split of the rows for cross-validation.
    pub validation: Validation,
    /// Prior of each class; equal priors if empty.
    pub priors: Vec<f64>,
    /// `cost[i][k]`: cost of deciding i if k is true; 0/1 if empty.
    pub cost: Vec<Vec<f64>>,
    /// Novelty gate, reject option and alarm.
    pub alarms: Alarms,
    /// Whether the detector also estimates the parameters of the difference model if no feature reads them.
    pub identify: bool,
    /// Whether training takes the first recipe that can be trained, and does not look for the best.
    pub trial: bool,
}

impl Recipe {
    /// Returns a recipe with least squares on whole traces, every parameter as a feature, no projection, a linear
    /// discriminant, equal priors, 0/1 costs, and no healthy class.
    #[must_use]
    pub fn new(structure: Structure) -> Self {
        Self {
            columns: Channels::new("y", "u1", "u2"),
            park: None,
            structure,
            estimation: Estimation::default(),
            shaft: None,
            automatic: false,
            features: vec![],
            covariates: vec![],
            offered: false,
            rising: vec![],
            projection: ProjectionKind::None,
            discriminant: Kind::Linear,
            shrink: Shrink::Not,
            size_spread: 0.0,
            validation: Validation::default(),
            priors: vec![],
            cost: vec![],
            alarms: Alarms::default(),
            identify: false,
            trial: false,
        }
    }

    /// Returns the run of each row if the false-alarm rate is that of the next run. If it is that of another drive, and
    /// the labels name the drives, returns the drive of each row.
    pub(super) fn runs<'a>(&self, candidates: &'a Candidates) -> Option<Cow<'a, [usize]>> {
        let counts = self.alarms.by_run && !self.validation.groups.is_empty();
        let drives = counts && self.alarms.other_drive && !self.validation.units.is_empty();
        if drives {
            return Some(candidates.groups.iter().map(|&group| self.validation.whole(group)).collect());
        }
        counts.then_some(Cow::Borrowed(candidates.groups.as_slice()))
    }

    /// Returns the catalogue of available features.
    #[must_use]
    pub fn catalogue(&self) -> Catalogue {
        let channels = self.wiring(&self.columns).channels;
        let asked: Vec<&str> = self.averaged().collect();
        let averaged =
            channels.into_iter().map(|(name, _)| name).zip(0_u8..).filter(|(name, _)| asked.contains(&name.as_str()));
        let orders = self.shaft.as_ref().map(ShaftPlan::names);
        Catalogue { structure: self.structure, orders, averaged: averaged.collect() }
    }

    /// Returns the number of coordinates that only rise with a defect; a projection mixes features, so that none do.
    #[must_use]
    pub fn rising(&self, names: &[String]) -> usize {
        let catalogue = self.catalogue();
        let all = catalogue.names();
        let rises =
            |name: &&String| all.iter().position(|own| own == *name).is_some_and(|k| self.rises(&catalogue, &all, k));
        if matches!(self.projection, ProjectionKind::None) { names.iter().filter(rises).count() } else { 0 }
    }

    /// Returns the places of features with those last that only rise with a defect, as the gate has them.
    ///
    /// # Errors
    /// [`Error::Usage`] if a name of [`Recipe::rising`] is none of the features, or a projection mixes them.
    pub fn rising_last(&self, catalogue: &Catalogue, mut places: Vec<usize>) -> Result<Vec<usize>, Error> {
        let unmixed = matches!(self.projection, ProjectionKind::None);
        if !unmixed && !self.rising.is_empty() {
            return Err(Error::Usage("--rising names features that no projection mixes: use --projection none".into()));
        }
        let names = catalogue.names();
        let is_missing = |name: &&String| !places.iter().any(|&place| names[place] == **name);
        if let Some(name) = self.rising.iter().find(is_missing) {
            let features: Vec<&str> = places.iter().map(|&place| names[place].as_str()).collect();
            return Err(Error::Usage(format!("--rising: {name} is none of the features {}", features.join(", "))));
        }
        if unmixed {
            places.sort_by_key(|&place| self.rises(catalogue, &names, place));
        }
        Ok(places)
    }

    fn rises(&self, catalogue: &Catalogue, names: &[String], place: usize) -> bool {
        catalogue.rises(place) || self.rising.contains(&names[place])
    }

    /// Returns the recipe with the columns that averages name and no other part uses.
    #[must_use]
    pub fn with_averaged_columns(mut self) -> Self {
        let others = self.wiring(&Channels { further: vec![], ..self.columns.clone() }).channels;
        let mut further: Vec<String> = vec![];
        for name in self.averaged() {
            if !others.iter().any(|(own, _)| own == name) && !further.iter().any(|own| own == name) {
                further.push(name.to_string());
            }
        }
        self.columns.further = further;
        self
    }

    /// Returns the channels whose averages are features or covariates.
    fn averaged(&self) -> impl Iterator<Item = &str> {
        self.features.iter().chain(&self.covariates).filter_map(|name| features::averaged(name))
    }

    /// Returns whether averages of the shaft's velocity are features or covariates.
    pub(super) fn averages_velocity(&self) -> bool {
        let velocity = self.columns.shaft.as_ref().and_then(|shaft| shaft.velocity.as_deref());
        self.averaged().any(|name| Some(name) == velocity)
    }

    pub(super) fn wiring(&self, columns: &Channels) -> Wiring {
        Wiring::new(columns, self.structure, self.shaft.as_ref().map(ShaftPlan::measured))
    }
}
