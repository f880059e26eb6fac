//! The steps of the training of a fleet, from files to files.
//!
//! ```text
//! traces ─► features ─► part.parquet ─► train_features ─► model.bwm
//! ```

mod features;
mod labelled;
mod plans;
mod train;

pub use features::{Featured, FeaturesOptions, features};
pub use train::{PartOptions, TrainedOnParts, train_features};
