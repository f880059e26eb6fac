//! Friction beyond the viscous friction of the motor: Stribeck friction, and friction in proportion to the load.
//!
//! ```text
//! T_S(ω) = (Tc + (Ts − Tc) exp(−(ω/ωs)²)) tanh(ω/ω₀)             (1)
//! T_L(ω) = μ |T_load| tanh(ω/ω₀),   μ = 1/η − 1                  (2)
//! ```
//!
//! Tc is the Coulomb friction, Ts the break-away torque, ωs the Stribeck velocity, η the efficiency of what transmits
//! the load, and ω₀ = 1 rad/s the width of the smoothed sign.

use super::draws::between;
use crate::bearing::direction;
use crate::{NoiseSource, RigError, fraction, not_negative, positive};

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
        fraction("field.stribeck.spread", self.spread)?;
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
    pub(crate) fn magnitude_nm(&self, velocity_rad_s: f64) -> f64 {
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
            fraction("field.load_friction.efficiency", efficiency)?;
        }
        Ok(())
    }

    pub(super) fn draw(&self, mut source: NoiseSource) -> LoadFrictionValues {
        LoadFrictionValues { coefficient: 1.0 / between(&mut source, self.efficiency) - 1.0 }
    }
}

impl LoadFrictionValues {
    /// The torque (2) that opposes positive rotation.
    #[must_use]
    pub fn torque_nm(&self, load_nm: f64, velocity_rad_s: f64) -> f64 {
        self.coefficient * load_nm.abs() * direction(velocity_rad_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::tests::{QUIET, run};
    use crate::{Field, FieldValues, Scenario, Stream};

    #[test]
    fn stribeck_falls_from_break_away_to_coulomb() {
        let curve = StribeckValues { coulomb_nm: 0.006, break_away_nm: 0.014, velocity_rad_s: 4.0 };
        // At standstill Ts, at ωs a part 1/e of the difference, at 10 ωs Tc except for e⁻¹⁰⁰; rounding only.
        let at_velocity = 0.006 + 0.008 * (-1.0_f64).exp();
        for (velocity, torque) in [(0.0, 0.014), (4.0, at_velocity), (-4.0, at_velocity), (40.0, 0.006)] {
            assert!((curve.magnitude_nm(velocity) - torque).abs() < 1e-17, "{velocity}");
        }
        for seed in 0..500 {
            let drawn = Stribeck::FIELD.draw(NoiseSource::new(seed, Stream::Stribeck));
            let factors = [drawn.coulomb_nm / 0.006, drawn.break_away_nm / 0.014, drawn.velocity_rad_s / 4.0];
            // The limits are rounded once.
            assert!(factors.iter().all(|factor| (0.7 - 1e-15..1.3 + 1e-15).contains(factor)), "{factors:?}");
        }
    }

    #[test]
    fn at_constant_speed_the_current_overcomes_the_curve() {
        let field = Field { stribeck: Some(Stribeck::FIELD), ..Field::NONE };
        for speed in [2.0, 6.0, 40.0] {
            let scenario = Scenario { field, reference_amplitude_rad_s: speed, ..QUIET };
            let curve = FieldValues::draw(&scenario, 3).stribeck.expect("on");
            let trace = run(&scenario, 3);
            let omega = trace.velocity_rad_s[4999];
            let friction = 1e-4 * omega + curve.magnitude_nm(omega) * omega.tanh();
            // The loop has settled: e⁻¹⁷ of 40 rad/s, 2e-6 rad/s, times (B + Kp Kt/R)/Kt.
            assert!((trace.current_a[4999] - friction / 0.05).abs() < 1e-6, "{speed}");
        }
    }

    #[test]
    fn load_friction_opposes_motion_whatever_the_sign_of_the_load() {
        let friction = LoadFrictionValues { coefficient: 0.1 };
        // tanh 50 is 1.
        for (load, velocity, torque) in [(0.2, 50.0, 0.02), (-0.2, 50.0, 0.02), (0.2, -50.0, -0.02), (0.2, 0.0, 0.0)] {
            assert!((friction.torque_nm(load, velocity) - torque).abs() < 1e-17);
        }
        for seed in 0..500 {
            let drawn = LoadFriction::FIELD.draw(NoiseSource::new(seed, Stream::LoadFriction));
            assert!((1.0 / 0.95 - 1.0 - 1e-15..1.0 / 0.85 - 1.0 + 1e-15).contains(&drawn.coefficient));
        }
    }

    #[test]
    fn at_the_peaks_of_a_slow_load_its_friction_is_in_the_current() {
        let field = Field { load_friction: Some(LoadFriction::FIELD), ..Field::NONE };
        // 0.25 Hz: peaks at 5 s (positive) and 7 s (negative), where the load does not change.
        let scenario = Scenario { field, load_amplitude_nm: 0.15, load_frequency_hz: 0.25, ..QUIET };
        let mu = FieldValues::draw(&scenario, 4).load_friction.expect("on").coefficient;
        let trace = run(&scenario, 4);
        for (sample, load) in [(2500, 0.15), (3500, -0.15)] {
            let slope = (trace.velocity_rad_s[sample + 1] - trace.velocity_rad_s[sample - 1]) / 0.004;
            let known = 2.5e-4 * slope + 1e-4 * trace.velocity_rad_s[sample];
            let friction = 0.05 * trace.current_a[sample] - known - load;
            // The measured current lags by 1.6 ms. The load is at its peak, so this is second order in the load; the
            // acceleration, at most 4 rad/s², changes by 1 % in this time: 1e-5 N·m.
            assert!((friction - mu * 0.15).abs() < 2e-5, "{friction} {}", mu * 0.15);
        }
    }
}
