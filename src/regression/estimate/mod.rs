//! Rows of a segment → [`Estimate`]: parameters, covariance, residual variance.
//!
//! Enters: the inputs of each sample that may be used. Leaves: the sums of a closed segment, and by a solve in
//! steps the estimate.

#[cfg(any(test, feature = "internals"))]
mod alone;
mod estimator;
mod result;
mod stability;

#[cfg(any(test, feature = "internals"))]
pub use alone::{Alone, Detached};
pub use estimator::{Estimator, RegressionSolve, RegressionSums};
pub use result::Estimate;
pub use stability::is_stable;
