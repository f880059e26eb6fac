//! Named conditions of axes of a machine, on top of [`Condition::MIX`]: a weight that the drive does not measure.
//!
//! The motion reverses, the payload varies by ± 30 % from record to record, and there is no load sensor.

use super::Condition;
use super::axis::Axis;
use super::field::Duty;

const LEVEL: Condition = Condition {
    name: "axis-level",
    number: 44,
    about: "level axis of ratio 50 without load sensor, motion that reverses",
    duty: Some(Duty::AnyReversing),
    axis: Some(&Axis::LEVEL),
    ..Condition::MIX
};

impl Condition {
    /// A level axis, and axes with weights.
    pub const AXES: [Self; 5] = [
        LEVEL,
        Self {
            name: "axis-0.15",
            number: 45,
            about: "the same with a weight of 0.15 N·m at the motor",
            axis: Some(&Axis::with_weight(0.15)),
            ..LEVEL
        },
        Self {
            name: "axis-0.4",
            number: 46,
            about: "the same with a weight of 0.4 N·m",
            axis: Some(&Axis::with_weight(0.4)),
            ..LEVEL
        },
        Self {
            name: "axis-0.4-sine",
            number: 47,
            about: "the same moved by a sine",
            axis: Some(&Axis::with_weight(0.4)),
            duty: Some(Duty::Waveform),
            ..LEVEL
        },
        Self {
            name: "axis-0.15-ratio-5",
            number: 48,
            about: "a weight of 0.15 N·m at a ratio of 5",
            axis: Some(&Axis { ratio: 5.0, ..Axis::with_weight(0.15) }),
            ..LEVEL
        },
    ];
}
