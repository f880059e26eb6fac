//! Weight, counterbalance and inertia of an axis, referred to the motor, as functions of the angle φ of the axis.
//!
//! ```text
//! T = W (p − c) sin φ                     rotary axis                                   (1)
//! T = W (p − c (1 + κ φ/π))               linear axis: a gas spring, whose force rises with the stroke   (2)
//! J(φ) = J [1 + s (p − 1) + v cos φ]                                                    (3)
//! J(φ) dω/dt = M − ½ J′ ω² − T,   J′ = dJ/dθ                                            (4)
//! ```
//!
//! W: weight at the motor at nominal payload, p: payload, 1 nominal, c: counterbalance, s: share of the payload in the
//! inertia, v: variation of the inertia with the position. With (4) only the work of M − T changes the energy ½ J ω².

use core::f64::consts::PI;

use super::Travel;
use crate::{RigError, fraction, not_negative, within};

/// κ of (2).
const SPRING_RISE: f64 = 0.2;

/// Weight and inertia of an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gravity {
    /// W.
    pub weight_nm: f64,
    /// c.
    pub counterbalance: f64,
    /// Largest |p − 1| from record to record.
    pub payload: f64,
    /// s of (3).
    pub payload_inertia: f64,
    /// v of (3).
    pub inertia_swing: f64,
}

impl Gravity {
    /// A weight without counterbalance, on an axis of constant inertia.
    pub const WEIGHT: Self =
        Self { weight_nm: 0.15, counterbalance: 0.0, payload: 0.3, payload_inertia: 0.0, inertia_swing: 0.0 };

    /// The rotary axis of the conditions.
    pub const ROTARY: Self = Self { counterbalance: 0.3, payload_inertia: 0.2, inertia_swing: 0.15, ..Self::WEIGHT };

    /// The linear axis of the conditions: 2 N·m are 3.3 kN on the standard screw.
    pub const LINEAR: Self = Self { weight_nm: 2.0, payload_inertia: 0.1, inertia_swing: 0.1, ..Self::ROTARY };

    pub(super) fn validate(&self) -> Result<(), RigError> {
        not_negative("axis.gravity.weight_nm", self.weight_nm)?;
        fraction("axis.gravity.counterbalance", self.counterbalance)?;
        fraction("axis.gravity.payload", self.payload)?;
        within("axis.gravity.payload_inertia", self.payload_inertia, [0.0, 0.5])?;
        within("axis.gravity.inertia_swing", self.inertia_swing, [0.0, 0.4])?;
        Ok(())
    }

    /// The torque (1) or (2) that opposes positive motion.
    #[must_use]
    pub fn torque_nm(&self, travel: &Travel, phi: f64, payload: f64) -> f64 {
        if travel.linear {
            self.weight_nm * (payload - self.counterbalance * (1.0 + SPRING_RISE * phi / PI)) // (2)
        } else {
            self.weight_nm * (payload - self.counterbalance) * libm::sin(phi) // (1)
        }
    }

    /// J(φ)/J − 1 of (3), and the derivative J′/J of (4) by the motor's angle.
    #[must_use]
    pub fn inertia(&self, travel: &Travel, phi: f64, payload: f64) -> [f64; 2] {
        let v = self.inertia_swing;
        let added = self.payload_inertia * (payload - 1.0) + v * libm::cos(phi); // (3)
        [added, -v * libm::sin(phi) / travel.motor_rad_per_rad]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_weight_of_a_lever_and_of_a_slide() {
        let lever = Gravity { weight_nm: 0.4, counterbalance: 0.25, ..Gravity::WEIGHT };
        // 0.4 (1.3 − 0.25) sin 30°, and none where the lever hangs or stands; rounding only.
        for (phi, torque) in [(PI / 6.0, 0.21), (0.0, 0.0), (PI, 0.0), (-PI / 2.0, -0.42)] {
            assert!((lever.torque_nm(&Travel::rotary(50.0), phi, 1.3) - torque).abs() < 1e-15, "{phi}");
        }
        let slide = Gravity { weight_nm: 2.0, counterbalance: 0.5, ..Gravity::WEIGHT };
        // 2 (0.9 − 0.5 (1 ± 0.2)) at the ends of the stroke.
        for (phi, torque) in [(0.0, 0.8), (PI, 0.6), (-PI, 1.0)] {
            assert!((slide.torque_nm(&Travel::linear(6e-4, 0.07), phi, 0.9) - torque).abs() < 1e-15, "{phi}");
        }
    }

    #[test]
    fn the_derivative_is_that_of_the_inertia() {
        let (axis, travel, h) = (Gravity::ROTARY, Travel::rotary(5.0), 1e-4);
        for phi in [-2.0, -0.3, 0.0, 1.1, 3.0] {
            let at = |theta: f64| axis.inertia(&travel, phi + theta / 5.0, 1.2)[0];
            // The third derivative of v cos(θ/r) is v/r³ = 1.2e-3: 2e-12; rounding of 1e-16/h.
            assert!(((at(h) - at(-h)) / (2.0 * h) - axis.inertia(&travel, phi, 1.2)[1]).abs() < 5e-12);
        }
    }
}
