//! Second wing: samples → [`Estimate`].
//!
//! [`Estimator`] is the face of the wing: output and two inputs go in a sample at a time, a parameter vector with
//! covariance and residual variance comes out a segment.

pub mod accumulator;
pub mod estimator;
mod factor;
pub mod gate;
pub mod instruments;
mod kernels;
pub mod order;
mod reference;
pub mod regression;
pub mod regressor;
pub mod result;
pub mod rows;
mod solve;
pub mod stability;
pub mod triangle;

pub use accumulator::{Accumulator, Fading, MAX_LAMBDA, MAX_LONG_SEGMENT_SAMPLES, MAX_SEGMENT_SAMPLES, Mass, TwoLevel};
pub use estimator::{Estimator, Segment, Solver};
pub use gate::Counts;
pub use instruments::Instruments;
pub use order::Order;
pub use regression::{Guard, MAX_OUTPUT_TERMS, Memory, Method, Nominal, Regression};
pub use regressor::Regressor;
pub use result::{Estimate, Reason};
pub use rows::{AnyShape, Form, Row, Rows, Shape};
pub use stability::is_stable;
pub use triangle::{Forgetting, Triangle};
