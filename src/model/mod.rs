//! The trained constants: a `const` in flash, or read from a checked binary form.
//!
//! Enters: the constants of all other rooms as plain numbers, or bytes. Leaves: a [`Model`], whose constants fit its
//! plan and each other.

mod bytes;
mod checked;
mod constants;
mod error;
mod parts;
mod ranges;
mod reader;
mod sampling;
mod stored;
mod validate;

pub use crate::alarm::evidence::EvidenceConstants;
pub use crate::decide::{
    Background, Classifier, Covariate, Covariates, Departure, Direction, Directions, Discriminant, Estimates, Fall,
    Feature, FeatureValue, KNOTS, Law, MAX_BACKGROUND, Most, Novelty, Projection, Rise,
};
pub use crate::record::Field;
pub use crate::regression::Regression;
pub use crate::regression::factor::{Forgetting, MAX_LAMBDA, MAX_SEGMENT_ROWS};
pub use crate::shaft::balance::{RESTING, RESTING_ROWS, StateVariable, TERMS, TorqueBalance};
pub use crate::shaft::delays::{Lags, MAX_LAG};
pub use crate::shaft::orders::{Blocks, CONTROLS, LAGS, TrackedOrder, Tracking, q16};
pub use crate::shaft::state::{BRIDGE, ShaftConstants};
pub use crate::signal::{Channel, Label, Name};
pub use bytes::{MAX_BYTES, layout, notes, stored_len};
pub use checked::Model;
pub use constants::Constants;
pub use error::ModelError;
#[doc(hidden)]
pub use parts::{ModelView, RegressionView, RunsView, ShaftView};
pub use sampling::{MAX_BLOCK_MEAN, MAX_SEGMENT_SAMPLES, Sampling};
#[doc(hidden)]
pub use stored::identity;
#[doc(hidden)]
pub use validate::check;
