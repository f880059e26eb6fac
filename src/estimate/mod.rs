//! Second wing: samples → [`Estimate`].
//!
//! [`Estimator`] is the face of the wing: output and two inputs go in a sample at a time, a parameter vector with
//! covariance and residual variance comes out a segment.

pub mod estimator;
pub mod order;
pub mod regressor;
pub mod triangle;

pub use estimator::{Estimate, Estimator, Reason};
pub use order::Order;
pub use regressor::{Regression, Regressor};
pub use triangle::{Forgetting, Triangle};
