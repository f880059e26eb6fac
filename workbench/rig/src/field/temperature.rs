//! Temperature of winding, magnets and lubricant, and the warm-up within a record.
//!
//! Each record has a temperature `s`, uniform in a range of 0 (cold) to 1 (hot):
//!
//! ```text
//! R ← R (1 + ρ s)                                                (1)
//! Kt = Ke ← Kt (1 − δ s)                                         (2)
//! B ← B exp(ln b₀ + s (ln b₁ − ln b₀)) exp(σ g),   g ~ N(0, 1)   (3)
//! Tc, uniform and independent of s                               (4)
//! ```
//!
//! A sensor at the lubricant records, with 20 °C cold and 100 °C hot and white noise n of 0.5 °C,
//!
//! ```text
//! T = 20 + 80 (s + ln(1 − b w(t))/ln(b₁/b₀)) + n                 (6)
//! ```
//!
//! so that it follows the viscous friction, but for its scatter, also during the warm-up.
//!
//! Within the record, with `w(t) = 1 − exp(−t/τ)`, R is multiplied by `1 + r w(t)` and B by `1 − b w(t)`   (5).

use crate::{NoiseSource, RigError, fraction, not_negative, positive};

/// Temperature of a cold drive, and of a hot one.
const RANGE_C: [f64; 2] = [20.0, 100.0];
/// Standard deviation of the sensor's noise.
const NOISE_C: f64 = 0.5;

/// Ranges of the effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Temperature {
    /// Range of s: from 0 to 1, or narrower.
    pub state: [f64; 2],
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
    /// ln(b₁/b₀) of (3).
    pub viscous_slope: f64,
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
        state: [0.0, 1.0],
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
        for end in self.state {
            fraction("field.temperature.state", end)?;
        }
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
        let state = source.uniform(self.state[0], self.state[1]);
        let [cold, hot] = [self.viscous_cold, self.viscous_hot].map(libm::log);
        let scatter = self.viscous_scatter * source.gaussian();
        TemperatureValues {
            state,
            resistance: 1.0 + self.resistance_rise * state, // (1)
            flux: 1.0 - self.flux_loss * state,             // (2)
            viscous: libm::exp(cold + state * (hot - cold) + scatter), // (3)
            viscous_slope: hot - cold,
            coulomb_nm: source.uniform(0.0, self.coulomb_nm), // (4)
            warm_up_viscous: source.uniform(0.0, self.warm_up_viscous),
            warm_up_resistance: source.uniform(0.0, self.warm_up_resistance),
            warm_up_s: self.warm_up_s,
        }
    }
}

impl TemperatureValues {
    /// Factor of R at time `t_s`, relative to the start of the record (5).
    pub(crate) fn resistance_at(&self, t_s: f64) -> f64 {
        1.0 + self.warm_up_resistance * self.warmth(t_s)
    }

    /// Factor of B at time `t_s`, relative to the start of the record (5).
    pub(crate) fn viscous_at(&self, t_s: f64) -> f64 {
        1.0 - self.warm_up_viscous * self.warmth(t_s)
    }

    /// Recorded temperature at these times, °C (6).
    pub(crate) fn measured_c(&self, times_s: &[f64], mut source: NoiseSource) -> Vec<f64> {
        let [cold, hot] = RANGE_C;
        let rise = |t_s: f64| {
            if self.viscous_slope == 0.0 { 0.0 } else { libm::log(self.viscous_at(t_s)) / self.viscous_slope }
        };
        let each = |t_s: &f64| cold + (hot - cold) * (self.state + rise(*t_s)) + NOISE_C * source.gaussian();
        times_s.iter().map(each).collect()
    }

    fn warmth(&self, t_s: f64) -> f64 {
        1.0 - libm::exp(-t_s / self.warm_up_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::tests::{QUIET, moments, run};
    use crate::{Field, FieldValues, Scenario, Stream};

    #[test]
    fn factors_follow_the_temperature() {
        let draws: Vec<TemperatureValues> =
            (0..2000).map(|seed| Temperature::FIELD.draw(NoiseSource::new(seed, Stream::Temperature))).collect();
        let scatter: Vec<f64> =
            draws.iter().map(|t| t.viscous.ln() - (2.5_f64.ln() + t.state * (0.4_f64 / 2.5).ln())).collect();
        let (mean, sd) = moments(&scatter);
        // Four standard deviations of mean (0.2/√2000) and of standard deviation (0.2/√4000).
        assert!(mean.abs() < 0.018 && (sd - 0.2).abs() < 0.013, "{mean} {sd}");
        for t in &draws {
            // Rounding only.
            assert!((t.resistance - (1.0 + 0.4 * t.state)).abs() < 1e-15);
            assert!((t.flux - (1.0 - 0.05 * t.state)).abs() < 1e-15);
            assert!((0.0..0.02).contains(&t.coulomb_nm) && (0.0..0.25).contains(&t.warm_up_viscous));
            assert!((0.0..0.06).contains(&t.warm_up_resistance));
        }
        // The Coulomb friction does not depend on the temperature: 4/√2000 for their correlation.
        let (states, torques): (Vec<f64>, Vec<f64>) = draws.iter().map(|t| (t.state, t.coulomb_nm)).unzip();
        let ((ms, ss), (mt, st)) = (moments(&states), moments(&torques));
        let product = states.iter().zip(&torques).map(|(s, t)| (s - ms) * (t - mt)).sum::<f64>() / 2000.0;
        assert!((product / (ss * st)).abs() < 0.09);
    }

    #[test]
    fn the_sensor_follows_the_viscous_friction() {
        let values = Temperature::FIELD.draw(NoiseSource::new(1, Stream::Temperature));
        let times: Vec<f64> = (0..5000).map(|k| 0.002 * f64::from(k)).collect();
        let measured = values.measured_c(&times, NoiseSource::new(1, Stream::TemperatureSensor));
        let error = |(t, c): (&f64, &f64)| {
            // ln B falls by ln(2.5/0.4) over 80 °C; without scatter it is ln 2.5 at 20 °C.
            let log = 2.5_f64.ln() + values.state * (0.4_f64 / 2.5).ln() + values.viscous_at(*t).ln();
            c - (20.0 + 80.0 * (log - 2.5_f64.ln()) / (0.4_f64 / 2.5).ln())
        };
        let (mean, sd) = moments(&times.iter().zip(&measured).map(error).collect::<Vec<_>>());
        // Four standard deviations of mean (0.5/√5000) and of standard deviation (0.5/√10000).
        assert!(mean.abs() < 0.03 && (sd - 0.5).abs() < 0.02, "{mean} {sd}");
    }

    #[test]
    fn warm_up_starts_at_one_and_has_its_time_constant() {
        let values = Temperature::FIELD.draw(NoiseSource::new(1, Stream::Temperature));
        assert_eq!((values.resistance_at(0.0), values.viscous_at(0.0)), (1.0, 1.0));
        let part = 1.0 - (-1.0_f64).exp();
        // Rounding only.
        assert!((values.resistance_at(6.0) - (1.0 + part * values.warm_up_resistance)).abs() < 1e-15);
        assert!((values.viscous_at(6.0) - (1.0 - part * values.warm_up_viscous)).abs() < 1e-15);
    }

    #[test]
    fn at_constant_speed_current_and_voltage_are_those_of_the_warm_motor() {
        let field = Field { temperature: Some(Temperature::FIELD), ..Field::NONE };
        for seed in 0..5 {
            let scenario = Scenario { field, ..QUIET };
            let values = FieldValues::draw(&scenario, seed);
            let (motor, t) = (values.motor(&scenario.motor), values.temperature.expect("on"));
            let trace = run(&scenario, seed);
            let (last, omega) = (4999, trace.velocity_rad_s[4999]);
            let friction = motor.b_nm_s_per_rad * t.viscous_at(9.998) * omega + t.coulomb_nm * omega.tanh();
            let current = friction / motor.kt_nm_per_a;
            // The drift of B and R (at most 1 % a second) changes ω by less than 1e-2 rad/s²: 3e-6 N·m, 5e-5 A.
            assert!((trace.current_a[last] - current).abs() < 1e-4, "{} {current}", trace.current_a[last]);
            let voltage = motor.r_ohm * t.resistance_at(9.998) * current + motor.ke_v_s_per_rad * omega;
            // The same drift of ω over one sample, and the rest of the settling: e⁻¹⁷ of at most 2 V.
            assert!((trace.voltage_v[last] - voltage).abs() < 2e-4, "{} {voltage}", trace.voltage_v[last]);
        }
    }
}
