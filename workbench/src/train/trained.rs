//! A trained model in double precision.

use bearing_watch::model::Feature;

use super::{AffineMap, Candidates, Choice, FeatureTable, GaussianClasses, Recipe, Watch};
use crate::core::Parts;

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
    /// The core's features.
    pub core_features: Vec<Feature>,
    /// Core features → coordinates.
    pub core_projection: AffineMap,
    /// What the core estimates with: channels, regression, shaft.
    pub parts: Parts,
    /// Samples a segment at the identification rate.
    pub segment_samples: usize,
    /// Sample interval at the rate the detector is fed with, s; 0 where unknown.
    pub interval_s: f64,
    /// Block mean inside the detector.
    pub block_mean: usize,
}
