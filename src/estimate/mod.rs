//! Second wing: samples → [`Estimate`].
//!
//! [`Estimator`] is the face of the wing: output and two inputs go in a sample at a time, a parameter vector with
//! covariance and residual variance comes out a segment.

pub mod accumulator;
pub mod bearing;
pub mod estimator;
mod factor;
pub mod friction;
pub mod gate;
pub mod instruments;
mod kernels;
pub mod order;
pub mod order_tracking;
mod reference;
pub mod regression;
pub mod regressor;
pub mod result;
pub mod rows;
pub mod shaft;
mod solve;
pub mod stability;
pub mod state_variable;
pub mod triangle;

pub use accumulator::{Accumulator, Fading, MAX_LAMBDA, MAX_LONG_SEGMENT_SAMPLES, MAX_SEGMENT_SAMPLES, Mass, TwoLevel};
pub use bearing::Bearing;
pub use estimator::{Estimator, Segment, Solver};
pub use friction::{Balance, FRICTION_PARAMETERS, Friction};
pub use gate::Counts;
pub use instruments::Instruments;
pub use order::Order;
pub use order_tracking::{MAX_HARMONICS, MIN_BLOCKS, OrderStrength, OrderTracking, TrackedOrder, Tracking};
pub use regression::{Guard, MAX_OUTPUT_TERMS, Memory, Method, Nominal, Regression};
pub use regressor::Regressor;
pub use result::{Estimate, Reason};
pub use rows::{AnyShape, Form, Row, Rows, Shape};
pub use shaft::{MAX_CURRENT_DELAY, Motion, NoShaft, Shaft, ShaftEstimate, ShaftModel, ShaftSums, Watch};
pub use stability::is_stable;
pub use state_variable::StateVariable;
pub use triangle::{Forgetting, Triangle};
