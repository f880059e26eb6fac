//! The payload: its inertia, the compliance and the backlash between motor and load.
//!
//! The payload changes the total inertia J. With a compliance, a part of J sits behind a spring with a dead zone, and
//! the load acts on it:
//!
//! ```text
//! J₁ dω₁/dt = (torques of the motor) − T_k                               (1)
//! J₂ dω₂/dt = T_k − T_load,   dθ₂/dt = ω₂                                (2)
//! T_k = k (φ − clamp(φ, −g/2, g/2)) + c (ω₁ − ω₂),   φ = θ₁ − θ₂         (3)
//! J₁ + J₂ = J,   k = (2πf)² J₁J₂/J,   c = 2ζ (2πf) J₁J₂/J                (4)
//! ```
//!
//! c acts only outside the dead zone. f is the resonance of the two inertias without motor and without backlash. The
//! states of (2) are integrated by the midpoint rule of the motor.

use core::f64::consts::TAU;

use crate::rig::{NoiseSource, PlantState, RigError, Stage, not_negative, positive};

/// Ranges of the effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mechanics {
    /// Relative variation of the total inertia.
    pub payload: f64,
    /// J₂/J.
    pub load_share: f64,
    /// Lower and upper limit of f of (4).
    pub resonance_hz: [f64; 2],
    /// ζ of (4).
    pub damping_ratio: f64,
    /// Lower and upper limit of g of (3).
    pub backlash_deg: [f64; 2],
}

/// Values of one record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MechanicsValues {
    /// Factor of the total inertia.
    pub payload: f64,
    /// J₂/J.
    pub load_share: f64,
    /// f of (4).
    pub resonance_hz: f64,
    /// ζ of (4).
    pub damping_ratio: f64,
    /// g of (3).
    pub backlash_rad: f64,
}

impl Mechanics {
    /// The ranges of the field.
    pub const FIELD: Self = Self {
        payload: 0.2,
        load_share: 0.4,
        resonance_hz: [30.0, 80.0],
        damping_ratio: 0.05,
        backlash_deg: [0.1, 0.3],
    };

    pub(super) fn validate(&self) -> Result<(), RigError> {
        super::fraction("field.mechanics.payload", self.payload)?;
        positive("field.mechanics.load_share", self.load_share)?;
        super::within("field.mechanics.load_share", self.load_share, [0.0, 0.95])?;
        for limit in self.resonance_hz {
            positive("field.mechanics.resonance_hz", limit)?;
        }
        not_negative("field.mechanics.damping_ratio", self.damping_ratio)?;
        for limit in self.backlash_deg {
            not_negative("field.mechanics.backlash_deg", limit)?;
        }
        Ok(())
    }

    /// Draws the payload from `job` and the constants of the transmission from `built`.
    pub(super) fn draw(&self, mut job: NoiseSource, mut built: NoiseSource) -> MechanicsValues {
        MechanicsValues {
            payload: 1.0 + job.uniform(-self.payload, self.payload),
            load_share: self.load_share,
            resonance_hz: super::between(&mut built, self.resonance_hz),
            damping_ratio: self.damping_ratio,
            backlash_rad: super::between(&mut built, self.backlash_deg).to_radians(),
        }
    }
}

/// The inertia behind the compliance.
#[derive(Debug, Clone, Copy)]
pub(super) struct LoadSide {
    inertia_kg_m2: f64,
    stiffness_nm_per_rad: f64,
    damping_nm_s_per_rad: f64,
    half_gap_rad: f64,
    angle_rad: f64,
    velocity_rad_s: f64,
    middle: [f64; 2],
}

impl LoadSide {
    /// The load side of a drive with total inertia `j_kg_m2`, at rest relative to the motor and amid its backlash.
    pub(super) fn new(values: &MechanicsValues, j_kg_m2: f64, motor: &PlantState) -> Self {
        let share = values.load_share;
        let (reduced, w) = (j_kg_m2 * share * (1.0 - share), TAU * values.resonance_hz);
        let (angle_rad, velocity_rad_s) = (motor.angle_rad, motor.velocity_rad_s);
        Self {
            inertia_kg_m2: j_kg_m2 * share,
            stiffness_nm_per_rad: w * w * reduced, // (4)
            damping_nm_s_per_rad: 2.0 * values.damping_ratio * w * reduced,
            half_gap_rad: 0.5 * values.backlash_rad,
            angle_rad,
            velocity_rad_s,
            middle: [angle_rad, velocity_rad_s],
        }
    }

    /// One stage of a step of `step_s`: returns T_k at this stage, and integrates (2) to the middle or to the end of
    /// the step. `load_nm` returns the torque on the load side at a velocity.
    pub(super) fn stage(&mut self, stage: Stage, motor: &PlantState, step_s: f64, load_nm: impl Fn(f64) -> f64) -> f64 {
        let [angle, velocity] = match stage {
            Stage::Start => [self.angle_rad, self.velocity_rad_s],
            Stage::Middle => self.middle,
        };
        let coupling = self.coupling_nm(motor.angle_rad - angle, motor.velocity_rad_s - velocity);
        let acceleration = (coupling - load_nm(velocity)) / self.inertia_kg_m2; // (2)
        match stage {
            Stage::Start => {
                let half = 0.5 * step_s;
                self.middle = [angle + half * velocity, velocity + half * acceleration];
            }
            Stage::Middle => {
                self.angle_rad += step_s * velocity;
                self.velocity_rad_s += step_s * acceleration;
            }
        }
        coupling
    }

    /// T_k (3).
    fn coupling_nm(&self, twist_rad: f64, slip_rad_s: f64) -> f64 {
        let strain = twist_rad - twist_rad.clamp(-self.half_gap_rad, self.half_gap_rad);
        // Without backlash the spring is always in contact.
        let contact = strain != 0.0 || self.half_gap_rad == 0.0;
        let damping = if contact { self.damping_nm_s_per_rad * slip_rad_s } else { 0.0 };
        self.stiffness_nm_per_rad * strain + damping
    }
}
