//! The steps of the training of a fleet, from files to files.
//!
//! ```text
//! traces ─► features ─► part.parquet ─► features_sum ─► .sums ─► train_features ─► model.bwm
//! ```

mod features;
mod inputs;
mod labelled;
mod memory;
mod plans;
mod sums;
mod train;

pub use features::{Featured, FeaturesOptions, features};
pub use sums::{SumOptions, Summed, features_sum};
pub use train::{PartOptions, TrainedOnParts, train_features};
