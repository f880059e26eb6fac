//! What a drive moves in a machine: an axis behind a gear, with weight, gear, belt and brake.
//!
//! An [`Axis`] is a plain struct literal, a part of the scenario of each rig; without one, the rig is as it is without
//! this module. All torques are those at the motor shaft. The angle φ of the axis is
//!
//! ```text
//! φ = (θ − θ₀)/r          rotary axis, θ of the load side, r the ratio                    (1)
//! φ = π x/S               linear axis, x from mid-stroke, ± S the stroke                  (2)
//! ```
//!
//! A rotary axis is at the angle θ/r of the recorded motor angle, as behind an absolute encoder: a record starts at θ
//! = r φ₀, and the motor has made a random number of whole turns before it, so that the balls of the bearing are at
//! any phase.
//!
//! | module | content |
//! |---|---|
//! | [`gravity`] | weight, counterbalance and inertia as functions of φ |
//! | [`gear`] | friction by direction and load, orders of mesh, two-per-turn of a strain-wave gear |
//! | [`payload`] | payload of a record, and its steps |
//! | [`brake`] | holding brake that closes at rest |
//! | [`cycle`] | cycles of a machine: moves and rests |
//! | [`load`] | all torques of the axis together |
//! | [`parts`] | the parts of an axis by name |
//! | [`columns`] | the columns of a record that say what the axis was |
//!
//! Belt and backlash are the two inertias of [`Mechanics`], on both rigs.

pub mod brake;
pub mod columns;
pub mod cycle;
pub mod gear;
pub mod gravity;
pub mod load;
pub mod parts;
pub mod payload;

pub use brake::Brake;
pub use columns::AxisColumns;
pub use cycle::Motion;
pub use gear::Gear;
pub use gravity::Gravity;
pub use load::AxisLoad;
pub use parts::AxisPart;
pub use payload::Payloads;

use core::f64::consts::PI;

use super::field::Mechanics;
use super::{NoiseSource, RigError, Stream, within};

/// Smallest and largest ratio.
pub const RATIOS: [f64; 2] = [1.0, 160.0];

/// Angle of a rotary axis at the start of a cycle, which is the same in all records.
const HOME_RAD: f64 = 0.6;

/// The bearing of a motor has made up to this number of whole turns before a record.
const TURNS: f64 = 1000.0;

/// An axis of a machine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axis {
    /// Turns of the motor per turn of a rotary axis; of a linear axis, turns of the motor per turn of the screw, whose
    /// lead is so much longer that the travel per turn of the motor stays the same.
    pub ratio: f64,
    /// Weight and inertia; `None` for a level axis.
    pub gravity: Option<Gravity>,
    /// Friction and ripple of the gear.
    pub gear: Option<Gear>,
    /// Belt, or the stiffness and backlash of the gear.
    pub transmission: Option<Mechanics>,
    /// Holding brake.
    pub brake: Option<Brake>,
    /// Whether the payload changes within a record.
    pub payload_steps: bool,
}

impl Axis {
    /// A level axis of ratio 50 without friction.
    pub const LEVEL: Self =
        Self { ratio: 50.0, gravity: None, gear: None, transmission: None, brake: None, payload_steps: false };

    /// The level axis with a weight at the motor, and a payload of ± 30 % from record to record.
    #[must_use]
    pub const fn with_weight(weight_nm: f64) -> Self {
        Self { gravity: Some(Gravity { weight_nm, ..Gravity::WEIGHT }), ..Self::LEVEL }
    }

    /// Returns an error with the name of a value that cannot be simulated.
    pub fn validate(&self) -> Result<(), RigError> {
        within("axis.ratio", self.ratio, RATIOS)?;
        self.gravity.map_or(Ok(()), |part| part.validate())?;
        self.gear.map_or(Ok(()), |part| part.validate())?;
        self.transmission.map_or(Ok(()), |part| part.validate())?;
        self.brake.map_or(Ok(()), |part| part.validate())
    }
}

/// How the axis moves with the motor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Travel {
    /// Angle of the motor per angle φ of the axis.
    pub motor_rad_per_rad: f64,
    /// Whether φ is (2).
    pub linear: bool,
}

impl Travel {
    /// A rotary axis (1).
    #[must_use]
    pub const fn rotary(ratio: f64) -> Self {
        Self { motor_rad_per_rad: ratio, linear: false } // (1)
    }

    /// A linear axis (2) of `metres_per_rad` of the motor and a stroke of ± `stroke_m`.
    #[must_use]
    pub const fn linear(metres_per_rad: f64, stroke_m: f64) -> Self {
        Self { motor_rad_per_rad: stroke_m / (PI * metres_per_rad), linear: true } // (2)
    }
}

/// Angle of a rotary axis at the start of a record, and whole turns of the motor before it.
pub(crate) fn start(motion: Option<Motion>, seed: u64) -> [f64; 2] {
    let mut source = NoiseSource::new(seed, Stream::Axis);
    let [anywhere, turns] = [source.uniform(-PI, PI), source.uniform(0.0, TURNS).floor()];
    [if motion == Some(Motion::Same) { HOME_RAD } else { anywhere }, turns]
}

#[cfg(test)]
mod tests;
