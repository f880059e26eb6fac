//! A trained model in double precision, with what segments show of each bearing order ([`super::sizes`]).

use bearing_watch::model::{Covariates, Feature};
use bearing_watch::plan::RunTime;
use nalgebra::DVector;

use crate::core::Parts;
use crate::train::{
    AffineMap, Automatic, Candidates, Choice, ClassStatistics, Dependence, Doubted, Explained, FeatureTable,
    GaussianClasses, LeftOut, Recipe, Watch,
};

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

/// The constants of an order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrderSight {
    /// The place of the order.
    pub order: usize,
    /// The score that a defect needs.
    pub needed_score: f64,
    /// The usual amplitude of the smallest defect, A; `None` if no segment shows one.
    pub usual_a: Option<f64>,
    /// The largest sizes of the smallest defect with which a segment may be called healthy: the amplitude over the
    /// deviation of the noise, and the amplitude, A.
    pub most_relative: f64,
    pub most_a: f64,
}

/// The constants of all orders whose scores a gate judges.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sight {
    /// The orders.
    pub orders: Vec<OrderSight>,
}

impl Sight {
    /// Returns the parts with these constants.
    #[must_use]
    pub fn parts(&self, parts: &Parts) -> Parts {
        let mut parts = parts.clone();
        if let Some((_, shaft)) = &mut parts.shaft {
            for own in &self.orders {
                let order = &mut shaft.tracking.orders[own.order];
                order.needed_score = own.needed_score as f32;
                (order.most_relative, order.most_a) = (own.most_relative as f32, own.most_a as f32);
            }
        }
        parts
    }
}
