//! Friction beyond the viscous friction of the motor: Stribeck friction, and friction in proportion to the load.
//!
//! ```text
//! T_S(ω) = (Tc + (Ts − Tc) exp(−(ω/ωs)²)) tanh(ω/ω₀)             (1)
//! T_L(ω) = μ |T_load| tanh(ω/ω₀),   μ = 1/η − 1                  (2)
//! ```
//!
//! Tc is the Coulomb friction, Ts the break-away torque, ωs the Stribeck velocity, η the efficiency of what transmits
//! the load, and ω₀ = 1 rad/s the width of the smoothed sign.

use crate::rig::bearing::direction;
use crate::rig::{NoiseSource, RigError, not_negative, positive};

/// Ranges of the Stribeck friction: each constant varies by ± `spread` about its nominal value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stribeck {
    /// Nominal Tc of (1).
    pub coulomb_nm: f64,
    /// Nominal Ts of (1).
    pub break_away_nm: f64,
    /// Nominal ωs of (1).
    pub velocity_rad_s: f64,
    /// Relative variation of each constant.
    pub spread: f64,
}

/// Values of one record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StribeckValues {
    /// Tc of (1).
    pub coulomb_nm: f64,
    /// Ts of (1).
    pub break_away_nm: f64,
    /// ωs of (1).
    pub velocity_rad_s: f64,
}

impl Stribeck {
    /// The ranges of the field.
    pub const FIELD: Self = Self { coulomb_nm: 0.006, break_away_nm: 0.014, velocity_rad_s: 4.0, spread: 0.3 };

    pub(super) fn validate(&self) -> Result<(), RigError> {
        not_negative("field.stribeck.coulomb_nm", self.coulomb_nm)?;
        not_negative("field.stribeck.break_away_nm", self.break_away_nm)?;
        positive("field.stribeck.velocity_rad_s", self.velocity_rad_s)?;
        super::fraction("field.stribeck.spread", self.spread)?;
        Ok(())
    }

    pub(super) fn draw(&self, mut source: NoiseSource) -> StribeckValues {
        let mut vary = |nominal: f64| nominal * source.uniform(1.0 - self.spread, 1.0 + self.spread);
        StribeckValues {
            coulomb_nm: vary(self.coulomb_nm),
            break_away_nm: vary(self.break_away_nm),
            velocity_rad_s: vary(self.velocity_rad_s),
        }
    }
}

impl StribeckValues {
    /// The magnitude of the friction at this velocity: (1) without the smoothed sign.
    #[must_use]
    pub fn magnitude_nm(&self, velocity_rad_s: f64) -> f64 {
        let ratio = velocity_rad_s / self.velocity_rad_s;
        self.coulomb_nm + (self.break_away_nm - self.coulomb_nm) * libm::exp(-ratio * ratio)
    }
}

/// Range of the load-proportional friction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadFriction {
    /// Lower and upper limit of η of (2).
    pub efficiency: [f64; 2],
}

/// Value of one record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadFrictionValues {
    /// μ of (2).
    pub coefficient: f64,
}

impl LoadFriction {
    /// The range of the field.
    pub const FIELD: Self = Self { efficiency: [0.85, 0.95] };

    pub(super) fn validate(&self) -> Result<(), RigError> {
        for efficiency in self.efficiency {
            positive("field.load_friction.efficiency", efficiency)?;
            super::fraction("field.load_friction.efficiency", efficiency)?;
        }
        Ok(())
    }

    pub(super) fn draw(&self, mut source: NoiseSource) -> LoadFrictionValues {
        LoadFrictionValues { coefficient: 1.0 / super::between(&mut source, self.efficiency) - 1.0 }
    }
}

impl LoadFrictionValues {
    /// The torque (2) that opposes positive rotation.
    #[must_use]
    pub fn torque_nm(&self, load_nm: f64, velocity_rad_s: f64) -> f64 {
        self.coefficient * load_nm.abs() * direction(velocity_rad_s)
    }
}
