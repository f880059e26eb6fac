//! What estimates in a detector: the constants of regression and shaft, from traces.
//!
//! ```text
//! traces ─► estimating ─┬─► regression: scales, nominal model, settling time
//!                       └─► shaft_plan ─► shaft: torque balance, lags, orders ─► filters of the residual, by bench
//! ```

pub(crate) mod axis;
pub(crate) mod bench;
pub(crate) mod estimating;
pub(crate) mod filtered;
pub(crate) mod filters;
pub(crate) mod lags;
pub(crate) mod loop_noise;
pub(crate) mod nominal;
pub(crate) mod period;
pub(crate) mod pulses;
pub(crate) mod reference_instruments;
pub(crate) mod regression;
pub(crate) mod shaft;
pub(crate) mod shaft_plan;
pub(crate) mod velocity_source;

pub use axis::{Axis, Weight};
pub use estimating::{Estimating, estimating, usual_errors};
pub(crate) use estimating::{spans, with_segment};
pub use period::weight_in;
pub use regression::Estimation;
pub use shaft_plan::{NextToRotor, Remedy, ShaftPlan, compared_turns, next_to_rotor};
pub use velocity_source::VelocitySource;

/// The motion of a simulated record, whose load is not measured.
#[cfg(test)]
pub(crate) fn motion_of(recorded: rig::RigTrace) -> crate::trace::MotionTrace {
    crate::trace::MotionTrace {
        load_nm: vec![0.0; recorded.current_a.len()],
        current_a: recorded.current_a,
        velocity_rad_s: recorded.velocity_rad_s,
        angle_rad: recorded.angle_rad,
        reference_rad_s: recorded.velocity_ref_rad_s,
    }
}
