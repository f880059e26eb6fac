//! What is trained, apart from the traces.

use bearing_watch::Park;
use bearing_watch::plan::Kind;

use super::{Alarms, Estimation, ProjectionKind, ShaftPlan, Shrink, Validation};
use crate::core::features::Catalogue;
use crate::identify::Structure;
use crate::trace::Channels;

/// Structure, estimator, features, projection, discriminant and alarms of a model.
#[derive(Clone, Debug)]
pub struct Recipe {
    /// Columns of the signals, which name the channels of the model.
    pub columns: Channels,
    /// Sign convention of the quadrature current, if it is known.
    pub park: Option<Park>,
    /// Model structure.
    pub structure: Structure,
    /// How the core estimates its parameters.
    pub estimation: Estimation,
    /// What is watched of the shaft, if anything.
    pub shaft: Option<ShaftPlan>,
    /// Feature names or groups; none means every parameter.
    pub features: Vec<String>,
    /// Projection of the features.
    pub projection: ProjectionKind,
    /// Shared or own covariances, where they are not shrunk.
    pub discriminant: Kind,
    /// Covariances between the two.
    pub shrink: Shrink,
    /// How training splits its rows to judge by cross-validation.
    pub validation: Validation,
    /// Prior of each class; equal where empty.
    pub priors: Vec<f64>,
    /// `cost[i][k]`: what deciding i costs when k is true; 0/1 where empty.
    pub cost: Vec<Vec<f64>>,
    /// Novelty gate, reject option and alarm.
    pub alarms: Alarms,
}

impl Recipe {
    /// Least squares on whole traces, every parameter as feature, no projection, linear discriminant, equal priors, 0/1
    /// costs, no healthy class.
    #[must_use]
    pub fn new(structure: Structure) -> Self {
        Self {
            columns: Channels::new("y", "u1", "u2"),
            park: None,
            structure,
            estimation: Estimation::default(),
            shaft: None,
            features: vec![],
            projection: ProjectionKind::None,
            discriminant: Kind::Linear,
            shrink: Shrink::Not,
            validation: Validation::default(),
            priors: vec![],
            cost: vec![],
            alarms: Alarms::default(),
        }
    }

    /// What features there are to choose from.
    #[must_use]
    pub fn catalogue(&self) -> Catalogue {
        Catalogue { structure: self.structure, orders: self.shaft.as_ref().map(ShaftPlan::names) }
    }
}
