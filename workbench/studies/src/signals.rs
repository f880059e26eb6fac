//! The signals of a simulated trace as those of a recorded one.

use model::trace::MotionTrace;
use rig::RigTrace;

/// The signals of the shaft.
#[must_use]
pub fn motion(recorded: &RigTrace) -> MotionTrace {
    MotionTrace {
        current_a: recorded.current_a.clone(),
        velocity_rad_s: recorded.velocity_rad_s.clone(),
        load_nm: recorded.recorded_load_nm(),
        angle_rad: recorded.angle_rad.clone(),
        reference_rad_s: recorded.velocity_ref_rad_s.clone(),
    }
}
