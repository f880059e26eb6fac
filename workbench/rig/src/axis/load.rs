//! All torques of an axis at the motor shaft.
//!
//! ```text
//! load side   T_L = T_ext + T_weight(φ) + T_gear(θ, ω, T_ext + T_weight)                         (1)
//! stiff       (J + ΔJ) dω/dt = M − ½ ΔJ′ ω² − T_L                                                (2)
//! ```
//!
//! ΔJ is the inertia of the axis that depends on φ and payload. Motor, bearing and brake act on the motor's side.

use super::super::field::Opposing;
use super::brake::Lining;
use super::gear::GearValues;
use super::{Axis, Gravity, NoiseSource, Travel};

/// The axis of one record in its present state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisLoad {
    travel: Travel,
    /// Angle of the motor at φ = 0.
    origin_rad: f64,
    inertia_kg_m2: f64,
    gravity: Option<Gravity>,
    gear: Option<GearValues>,
    lining: Option<Lining>,
    payload: f64,
}

impl AxisLoad {
    /// An axis at nominal payload with an open brake: `origin_rad` is the motor's angle at φ = 0, `inertia_kg_m2` the
    /// total inertia, and `gear` draws the values of the gear.
    #[must_use]
    pub fn new(axis: &Axis, travel: Travel, [origin_rad, inertia_kg_m2]: [f64; 2], gear: NoiseSource) -> Self {
        Self {
            travel,
            origin_rad,
            inertia_kg_m2,
            gravity: axis.gravity,
            gear: axis.gear.map(|own| own.draw(axis.ratio, gear)),
            lining: axis.brake.map(|brake| Lining::new(&brake, inertia_kg_m2)),
            payload: 1.0,
        }
    }

    /// Sets the payload, 1 nominal.
    pub const fn set_payload(&mut self, payload: f64) {
        self.payload = payload;
    }

    /// The payload.
    #[must_use]
    pub const fn payload(&self) -> f64 {
        self.payload
    }

    /// Opens the brake, or closes it at this angle of the motor.
    pub const fn set_brake(&mut self, closed: bool, angle_rad: f64) {
        if let Some(lining) = &mut self.lining {
            lining.set(closed, angle_rad);
        }
    }

    /// Lets the brake slip, at the end of a step.
    pub(crate) fn settle(&mut self, angle_rad: f64) {
        if let Some(lining) = &mut self.lining {
            lining.slip(angle_rad);
        }
    }

    /// Whether the axis is linear.
    pub(super) const fn is_linear(&self) -> bool {
        self.travel.linear
    }

    /// The angle φ of the axis at an angle of the load side.
    #[must_use]
    pub fn phi(&self, angle_rad: f64) -> f64 {
        (angle_rad - self.origin_rad) / self.travel.motor_rad_per_rad
    }

    /// The weight at the motor.
    #[must_use]
    pub fn weight_nm(&self, angle_rad: f64) -> f64 {
        let phi = self.phi(angle_rad);
        self.gravity.map_or(0.0, |gravity| gravity.torque_nm(&self.travel, phi, self.payload))
    }

    /// What opposes motion at a point of the load side under a load that includes the weight, and ΔJ.
    pub(crate) fn opposing(&self, [angle_rad, velocity_rad_s]: [f64; 2], load_nm: f64) -> Opposing {
        let wheel_rad = angle_rad - self.origin_rad;
        let gear = self.gear.map_or(0.0, |gear| gear.torque_nm(wheel_rad, velocity_rad_s, load_nm));
        let phi = self.phi(angle_rad);
        let [added, slope] = self.gravity.map_or([0.0; 2], |own| own.inertia(&self.travel, phi, self.payload));
        let centrifugal = 0.5 * self.inertia_kg_m2 * slope * velocity_rad_s * velocity_rad_s;
        Opposing { torque_nm: load_nm + gear + centrifugal, added_kg_m2: self.inertia_kg_m2 * added } // (1)
    }

    /// The torque of the brake on the motor.
    pub(crate) fn brake_nm(&self, angle_rad: f64, velocity_rad_s: f64) -> f64 {
        self.lining.map_or(0.0, |lining| lining.torque_nm(angle_rad, velocity_rad_s))
    }
}
