//! Temperature of winding, magnets and lubricant, and the warm-up within a record.
//!
//! Each record has a temperature `s`, uniform from 0 (cold) to 1 (hot):
//!
//! ```text
//! R ← R (1 + ρ s)                                                (1)
//! Kt = Ke ← Kt (1 − δ s)                                         (2)
//! B ← B exp(ln b₀ + s (ln b₁ − ln b₀)) exp(σ g),   g ~ N(0, 1)   (3)
//! Tc, uniform and independent of s                               (4)
//! ```
//!
//! Within the record, with `w(t) = 1 − exp(−t/τ)`, R is multiplied by `1 + r w(t)` and B by `1 − b w(t)`   (5).

use crate::rig::{NoiseSource, RigError, not_negative, positive};

/// Ranges of the effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Temperature {
    /// ρ of (1), the rise of the resistance from cold to hot.
    pub resistance_rise: f64,
    /// δ of (2), the loss of flux from cold to hot.
    pub flux_loss: f64,
    /// b₀ of (3), the factor of the viscous friction when cold.
    pub viscous_cold: f64,
    /// b₁ of (3), the factor of the viscous friction when hot.
    pub viscous_hot: f64,
    /// σ of (3), the scatter of the viscous friction, as standard deviation of its logarithm.
    pub viscous_scatter: f64,
    /// Upper limit of Tc (4); the lower limit is 0.
    pub coulomb_nm: f64,
    /// Upper limit of b of (5); the lower limit is 0.
    pub warm_up_viscous: f64,
    /// Upper limit of r of (5); the lower limit is 0.
    pub warm_up_resistance: f64,
    /// τ of (5).
    pub warm_up_s: f64,
}

/// Values of one record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TemperatureValues {
    /// s, from 0 (cold) to 1 (hot).
    pub state: f64,
    /// Factor of R at the start of the record (1).
    pub resistance: f64,
    /// Factor of Kt and Ke (2).
    pub flux: f64,
    /// Factor of B at the start of the record (3).
    pub viscous: f64,
    /// Added Coulomb friction (4).
    pub coulomb_nm: f64,
    /// b of (5).
    pub warm_up_viscous: f64,
    /// r of (5).
    pub warm_up_resistance: f64,
    /// τ of (5).
    pub warm_up_s: f64,
}

impl Temperature {
    /// The ranges of the field.
    pub const FIELD: Self = Self {
        resistance_rise: 0.4,
        flux_loss: 0.05,
        viscous_cold: 2.5,
        viscous_hot: 0.4,
        viscous_scatter: 0.2,
        coulomb_nm: 0.02,
        warm_up_viscous: 0.25,
        warm_up_resistance: 0.06,
        warm_up_s: 6.0,
    };

    pub(super) fn validate(&self) -> Result<(), RigError> {
        not_negative("field.temperature.resistance_rise", self.resistance_rise)?;
        not_negative("field.temperature.flux_loss", self.flux_loss)?;
        positive("field.temperature.viscous_cold", self.viscous_cold)?;
        positive("field.temperature.viscous_hot", self.viscous_hot)?;
        not_negative("field.temperature.viscous_scatter", self.viscous_scatter)?;
        not_negative("field.temperature.coulomb_nm", self.coulomb_nm)?;
        not_negative("field.temperature.warm_up_viscous", self.warm_up_viscous)?;
        not_negative("field.temperature.warm_up_resistance", self.warm_up_resistance)?;
        positive("field.temperature.warm_up_s", self.warm_up_s)?;
        Ok(())
    }

    pub(super) fn draw(&self, mut source: NoiseSource) -> TemperatureValues {
        let state = source.uniform(0.0, 1.0);
        let [cold, hot] = [self.viscous_cold, self.viscous_hot].map(libm::log);
        let scatter = self.viscous_scatter * source.gaussian();
        TemperatureValues {
            state,
            resistance: 1.0 + self.resistance_rise * state, // (1)
            flux: 1.0 - self.flux_loss * state,             // (2)
            viscous: libm::exp(cold + state * (hot - cold) + scatter), // (3)
            coulomb_nm: source.uniform(0.0, self.coulomb_nm), // (4)
            warm_up_viscous: source.uniform(0.0, self.warm_up_viscous),
            warm_up_resistance: source.uniform(0.0, self.warm_up_resistance),
            warm_up_s: self.warm_up_s,
        }
    }
}

impl TemperatureValues {
    /// Factor of R at time `t_s`, relative to the start of the record (5).
    #[must_use]
    pub fn resistance_at(&self, t_s: f64) -> f64 {
        1.0 + self.warm_up_resistance * self.warmth(t_s)
    }

    /// Factor of B at time `t_s`, relative to the start of the record (5).
    #[must_use]
    pub fn viscous_at(&self, t_s: f64) -> f64 {
        1.0 - self.warm_up_viscous * self.warmth(t_s)
    }

    fn warmth(&self, t_s: f64) -> f64 {
        1.0 - libm::exp(-t_s / self.warm_up_s)
    }
}
