//! A holding brake on the motor shaft, closed while the motion rests.
//!
//! The drive closes the brake after 0.1 s of rest and switches its output off: voltage zero, controller frozen. It
//! opens the brake and continues at the first sample of the next move.
//!
//! ```text
//! T = clamp(k (θ − θ_b) + c ω, ± T_b),   |k (θ − θ_b)| ≤ T_b: θ_b follows if the brake slips      (1)
//! k = (2πf)² J,   c = 2ζ (2πf) J                                                                   (2)
//! ```
//!
//! θ_b is the angle at which the brake has closed; f = 60 Hz and ζ = 0.3 are those of its lining.

use core::f64::consts::TAU;

use crate::{RigError, positive};

/// Rest before the brake closes.
const DELAY_S: f64 = 0.1;
/// f of (2).
const LINING_HZ: f64 = 60.0;
/// ζ of (2).
const LINING_DAMPING: f64 = 0.3;

/// A holding brake.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Brake {
    /// T_b.
    pub torque_nm: f64,
}

impl Brake {
    /// The brake of the conditions on the DC-motor rig.
    pub const ROTARY: Self = Self { torque_nm: 1.5 };

    /// The brake of the conditions on the actuator.
    pub const LINEAR: Self = Self { torque_nm: 8.0 };

    pub(super) fn validate(&self) -> Result<(), RigError> {
        positive("axis.brake.torque_nm", self.torque_nm)?;
        Ok(())
    }
}

/// The lining of a brake.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Lining {
    limit_nm: f64,
    stiffness_nm_per_rad: f64,
    damping_nm_s_per_rad: f64,
    /// θ_b; `None` if the brake is open.
    closed_rad: Option<f64>,
}

impl Lining {
    pub(super) fn new(brake: &Brake, inertia_kg_m2: f64) -> Self {
        let w = TAU * LINING_HZ;
        Self {
            limit_nm: brake.torque_nm,
            stiffness_nm_per_rad: w * w * inertia_kg_m2, // (2)
            damping_nm_s_per_rad: 2.0 * LINING_DAMPING * w * inertia_kg_m2,
            closed_rad: None,
        }
    }

    /// Opens the brake, or closes it at this angle, if it is not closed already.
    pub(super) const fn set(&mut self, closed: bool, angle_rad: f64) {
        match (closed, self.closed_rad) {
            (false, _) => self.closed_rad = None,
            (true, None) => self.closed_rad = Some(angle_rad),
            (true, Some(_)) => {}
        }
    }

    /// The torque (1) that opposes positive motion.
    pub(super) fn torque_nm(&self, angle_rad: f64, velocity_rad_s: f64) -> f64 {
        let Some(closed_rad) = self.closed_rad else { return 0.0 };
        let elastic = self.stiffness_nm_per_rad * (angle_rad - closed_rad);
        (elastic + self.damping_nm_s_per_rad * velocity_rad_s).clamp(-self.limit_nm, self.limit_nm) // (1)
    }

    /// Lets θ_b follow a shaft that slips in the brake.
    pub(super) fn slip(&mut self, angle_rad: f64) {
        let reach = self.limit_nm / self.stiffness_nm_per_rad;
        self.closed_rad = self.closed_rad.map(|closed| closed.clamp(angle_rad - reach, angle_rad + reach)); // (1)
    }
}

/// When the brake is closed.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Watch {
    rested_s: f64,
}

impl Watch {
    /// Whether the brake is closed at a sample that is `resting` or not, `interval_s` after the last one.
    pub(crate) fn closed(&mut self, resting: bool, interval_s: f64) -> bool {
        self.rested_s = if resting { self.rested_s + interval_s } else { 0.0 };
        self.rested_s > DELAY_S
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_closed_brake_is_a_spring_up_to_its_torque_and_then_slips() {
        let mut lining = Lining::new(&Brake { torque_nm: 1.0 }, 2.5e-4);
        let k = (TAU * 60.0).powi(2) * 2.5e-4;
        assert_eq!(lining.torque_nm(5.0, 3.0), 0.0);
        lining.set(true, 5.0);
        lining.set(true, 9.0);
        // Rounding of θ − θ_b.
        assert!((lining.torque_nm(5.01, 0.0) - 0.01 * k).abs() < 1e-12);
        assert_eq!((lining.torque_nm(6.0, 0.0), lining.torque_nm(4.0, 0.0)), (1.0, -1.0));
        lining.slip(6.0);
        assert!(lining.torque_nm(6.0 - 1.0 / k, 0.0).abs() < 1e-12, "at rest where it slipped to");
        lining.set(false, 6.0);
        assert_eq!(lining.torque_nm(5.0, 3.0), 0.0);
    }

    #[test]
    fn the_brake_closes_after_a_rest_and_opens_with_the_next_move() {
        let mut watch = Watch::default();
        let closed: Vec<bool> = (0..200).map(|k| watch.closed((50..150).contains(&k), 0.002)).collect();
        // 0.1 s are fifty intervals; rounding of their sum may take one less or more.
        let from = closed.iter().position(|closed| *closed).expect("closes");
        assert!((99..=101).contains(&from), "{from}");
        assert!(closed[from..150].iter().all(|closed| *closed) && closed[150..].iter().all(|closed| !closed));
    }
}
