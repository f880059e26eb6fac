//! A trained model in double precision.

use bearing_watch::model::{Covariates, Feature};
use bearing_watch::plan::RunTime;
use nalgebra::DVector;

use super::{
    AffineMap, Automatic, Candidates, Choice, ClassStatistics, Dependence, Doubted, Explained, FeatureTable,
    GaussianClasses, LeftOut, Recipe, Sight, Watch,
};
use crate::core::Parts;

/// A trained model, with the parts of the core's [`bearing_watch::Model`].
#[derive(Clone, Debug)]
pub struct Trained {
    /// The settings of the training.
    pub recipe: Recipe,
    /// Class names.
    pub classes: Vec<String>,
    /// Names of the raw features in use.
    pub feature_names: Vec<String>,
    /// Why these features, if the program chose them.
    pub automatic: Option<Automatic>,
    /// What covariates explain of the features.
    pub explained: Option<Explained>,
    /// Map from the chosen raw features, less what covariates explain, to the coordinates.
    pub projection: AffineMap,
    /// The chosen raw features of the training traces.
    pub raw: FeatureTable,
    /// The training traces in projected coordinates.
    pub coordinates: FeatureTable,
    /// Names of the coordinates: those of the features if there is no projection.
    pub coordinate_names: Vec<String>,
    /// Means and covariances of the coordinates.
    pub statistics: ClassStatistics,
    /// Training segments that have none of the features.
    pub left_out: LeftOut,
    /// What healthy traces depend on.
    pub dependence: Option<Dependence>,
    /// What is unusual about the healthy segments.
    pub doubted: Option<Doubted>,
    /// Class densities over the coordinates.
    pub densities: GaussianClasses,
    /// The shrinkage of the covariances, if it was chosen by cross-validation.
    pub choice: Option<Choice>,
    /// All features of the training segments, chosen or not.
    pub candidates: Candidates,
    /// Novelty gate and alarm.
    pub watch: Watch,
    /// What segments show of each bearing order.
    pub sight: Sight,
    /// The core's features.
    pub core_features: Vec<Feature>,
    /// The core's covariates.
    pub core_covariates: Covariates<RunTime>,
    /// Map from the core features to the coordinates.
    pub core_projection: AffineMap,
    /// Usual variances of the core features' errors.
    pub core_usual: DVector<f64>,
    /// The core's channels, regression and shaft.
    pub parts: Parts,
    /// Samples per segment at the identification rate.
    pub segment_samples: usize,
    /// Sampling interval of the detector's input, s; 0 if unknown.
    pub interval_s: f64,
    /// Block mean inside the detector.
    pub block_mean: usize,
}
