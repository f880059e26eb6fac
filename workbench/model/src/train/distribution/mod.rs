//! Means and covariances of rows whose values may have errors or be missing.

pub mod covariance;
pub(crate) mod least_covariance;
pub mod moments;
pub mod statistics;

pub use statistics::ClassStatistics;
