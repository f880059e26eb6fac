//! Results of a segment → [`Decision`] with its contributions.
//!
//! Enters: the estimate, friction and orders of a segment, and means of channels. Leaves: the decision, once a segment,
//! by features → covariates → projection → discriminant and gates, and the size of the smallest defect that the segment
//! would have shown. A feature without a result is missing: the decision
//! uses the others, and says which were missing.

mod classification;
mod classifier;
mod covariates;
mod discriminant;
mod features;
pub(crate) mod gates;
mod projection;
mod sight;
mod verdict;

pub use classification::Classification;
pub use classifier::Classifier;
pub use covariates::{Covariate, Covariates};
pub use discriminant::{Decision, Discriminant, NO_MODEL};
pub use features::{Estimates, Feature, FeatureValue};
pub use gates::{
    Background, Departure, Direction, Directions, Fall, KNOTS, Law, MAX_BACKGROUND, MAX_SURPRISE, Most, Novelty, Rise,
};
pub use projection::Projection;
pub use verdict::Verdict;
