//! Named conditions of axes of a machine, on top of [`Condition::MIX`]: a weight that the drive does not measure.
//!
//! The motion reverses, the payload varies by ± 30 % from record to record, and there is no load sensor.

use super::Condition;
use super::axis::{Axis, Gravity, Motion};
use super::field::Duty;

const LEVEL: Condition = Condition {
    name: "axis-level",
    number: 44,
    about: "level axis of ratio 50 without load sensor, motion that reverses",
    duty: Some(Duty::AnyReversing),
    axis: Some(&Axis::LEVEL),
    ..Condition::MIX
};

/// An arm: a weight, partly balanced, whose payload changes while it rests, and whose inertia depends on both.
const ARM: Axis =
    Axis { gravity: Some(Gravity { weight_nm: 0.15, ..Gravity::ROTARY }), payload_steps: true, ..Axis::LEVEL };

impl Condition {
    /// A level axis, axes with weights, and machines with their cycles.
    pub const AXES: [Self; 8] = [
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
        Self {
            name: "axis-cycle",
            number: 49,
            about: "a weight of 0.15 N·m, and the same cycle of five moves again and again",
            axis: Some(&Axis::with_weight(0.15)),
            duty: Some(Duty::Cycle(Motion::Same)),
            ..LEVEL
        },
        Self {
            name: "axis-cycle-steps",
            number: 50,
            about: "the same cycle of an arm whose payload changes at every second rest",
            axis: Some(&ARM),
            duty: Some(Duty::Cycle(Motion::Same)),
            ..LEVEL
        },
        Self {
            name: "axis-any-cycle-steps",
            number: 51,
            about: "this arm, moved otherwise in each cycle",
            axis: Some(&ARM),
            duty: Some(Duty::Cycle(Motion::Any)),
            ..LEVEL
        },
    ];
}
