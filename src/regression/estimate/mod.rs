//! Rows of a segment → [`Estimate`]: parameters, covariance, residual variance.
//!
//! Enters: the inputs of each sample that may be used. Leaves: the sums of a closed segment, and by a solve in
//! steps the estimate.

mod alone;
mod estimator;
mod result;
mod stability;

pub use alone::{ClosedSegment, RecursiveEstimator};
pub use estimator::{Estimator, RegressionSolve, RegressionSums};
pub use result::Estimate;
pub use stability::is_stable;
