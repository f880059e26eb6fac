//! Samples of a segment → [`Estimate`](estimate::Estimate): parameters, covariance, residual variance.
//!
//! Enters: output and inputs of the regression, [`Inputs`], at the rate of identification. Leaves: the estimate of each
//! segment. [`Rows`] makes rows by least squares or by instrumental variables, as the plan says; [`factor`] sums and
//! solves them; [`estimate`] ties both together.

mod auxiliary;
mod constants;
mod delays;
pub mod estimate;
pub mod factor;
mod inputs;
mod instruments;
mod rows;
mod squares;

pub use constants::Regression;
pub use inputs::{Inputs, Reference};
pub use rows::Rows;
