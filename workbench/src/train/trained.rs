//! A trained model in double precision.

use bearing_watch::{Regression, ShaftModel};

use super::{AffineMap, Candidates, Choice, FeatureTable, GaussianClasses, Recipe, Watch};
use crate::core::{MAX_COLUMNS, MAX_ORDERS};

/// A trained model, in the shape of the core's [`bearing_watch::Model`].
#[derive(Clone, Debug)]
pub struct Trained {
    /// What was asked for.
    pub recipe: Recipe,
    /// Class names.
    pub classes: Vec<String>,
    /// Names of the raw features in use.
    pub feature_names: Vec<String>,
    /// Raw chosen features → coordinates.
    pub projection: AffineMap,
    /// Training traces, the chosen raw features.
    pub raw: FeatureTable,
    /// Training traces in projected coordinates.
    pub coordinates: FeatureTable,
    /// Names of the coordinates: those of the features where nothing is projected.
    pub coordinate_names: Vec<String>,
    /// Class densities over the coordinates.
    pub densities: GaussianClasses,
    /// The shrinkage of their covariances, where it was chosen.
    pub choice: Option<Choice>,
    /// Every feature of the training segments, whether chosen or not.
    pub candidates: Candidates,
    /// Novelty gate and alarm.
    pub watch: Watch,
    /// Places in the core's feature list.
    pub core_features: Vec<usize>,
    /// Core features → coordinates.
    pub core_projection: AffineMap,
    /// What the core estimates with.
    pub regression: Box<Regression<MAX_COLUMNS>>,
    /// What the core watches the shaft with.
    pub shaft: Option<ShaftModel<MAX_ORDERS>>,
    /// Samples a segment at the identification rate.
    pub segment_samples: usize,
    /// Sample interval at the rate the detector is fed with, s; 0 where unknown.
    pub interval_s: f64,
    /// Block mean inside the detector.
    pub block_mean: usize,
}
