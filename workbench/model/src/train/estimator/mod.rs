//! What estimates in a detector: the constants of regression and shaft, from traces.
//!
//! ```text
//! traces ─► estimating ─┬─► regression: scales, nominal model, settling time
//!                       └─► shaft_plan ─► shaft: torque balance, lags, orders ─► filters of the residual, by bench
//! ```

pub(crate) mod bench;
pub(crate) mod estimating;
pub(crate) mod filters;
pub(crate) mod lags;
pub(crate) mod nominal;
pub(crate) mod pulses;
pub(crate) mod reference_instruments;
pub(crate) mod regression;
pub(crate) mod shaft;
pub(crate) mod shaft_plan;
pub(crate) mod velocity_source;

pub use estimating::{Estimating, estimating, usual_errors};
pub(crate) use estimating::{spans, with_segment};
pub use regression::Estimation;
pub use shaft_plan::{NextToRotor, Remedy, ShaftPlan, compared_turns, next_to_rotor};
pub use velocity_source::VelocitySource;
