//! Torques that depend on the angle of the shaft: cogging, ripple of the torque constant, unbalance.
//!
//! ```text
//! T = Σ c_n sin(nθ + γ_n) + Σ u_n sin(nθ + υ_n) − Kt i Σ k_n sin(nθ + κ_n)       (1)
//! ```
//!
//! with the orders n of [`ORDERS`]; T opposes positive rotation. The phases are uniform over a turn. Each cogging
//! amplitude c_n varies about its nominal value; the amplitudes of unbalance u_n and ripple k_n are fixed.
//!
//! Cost: the sines of all orders are powers of one `exp(jθ)`.

use core::f64::consts::TAU;

use crate::{NoiseSource, PlantState, RigError, fraction, not_negative};

/// Orders of the torques, periods per turn of the shaft.
pub const ORDERS: [u32; 6] = [1, 2, 6, 12, 24, 36];

/// Ranges of the effect; one amplitude for each of [`ORDERS`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Magnetics {
    /// Nominal amplitudes of the cogging torque.
    pub cogging_nm: [f64; 6],
    /// Relative variation of each cogging amplitude.
    pub cogging_spread: f64,
    /// Amplitudes of the ripple, relative to Kt.
    pub torque_constant_ripple: [f64; 6],
    /// Amplitudes of the unbalance.
    pub unbalance_nm: [f64; 6],
}

/// Values of one record: (1) with sines and cosines of zero phase.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MagneticsValues {
    /// Amplitudes of cos nθ and sin nθ of the torque without current.
    pub torque_nm: [[f64; 2]; 6],
    /// Amplitudes of cos nθ and sin nθ of the ripple, relative to Kt.
    pub ripple: [[f64; 2]; 6],
}

impl Magnetics {
    /// The ranges of the field.
    pub const FIELD: Self = Self {
        cogging_nm: [0.0, 0.0, 0.003, 0.006, 0.004, 0.003],
        cogging_spread: 0.3,
        torque_constant_ripple: [0.004, 0.004, 0.01, 0.015, 0.01, 0.006],
        unbalance_nm: [0.006, 0.003, 0.0, 0.0, 0.0, 0.0],
    };

    pub(super) fn validate(&self) -> Result<(), RigError> {
        for k in 0..ORDERS.len() {
            not_negative("field.magnetics.cogging_nm", self.cogging_nm[k])?;
            not_negative("field.magnetics.torque_constant_ripple", self.torque_constant_ripple[k])?;
            not_negative("field.magnetics.unbalance_nm", self.unbalance_nm[k])?;
        }
        fraction("field.magnetics.cogging_spread", self.cogging_spread)?;
        Ok(())
    }

    pub(super) fn draw(&self, mut source: NoiseSource) -> MagneticsValues {
        // a sin(nθ + φ) = a sin φ cos nθ + a cos φ sin nθ.
        let mut wave = |amplitude: f64, spread: f64| {
            let amplitude = amplitude * source.uniform(1.0 - spread, 1.0 + spread);
            let (sin, cos) = libm::sincos(source.uniform(0.0, TAU));
            [amplitude * sin, amplitude * cos]
        };
        let cogging = self.cogging_nm.map(|amplitude| wave(amplitude, self.cogging_spread));
        let ripple = self.torque_constant_ripple.map(|amplitude| wave(amplitude, 0.0));
        let unbalance = self.unbalance_nm.map(|amplitude| wave(amplitude, 0.0));
        let torque_nm = core::array::from_fn(|n| [0, 1].map(|part: usize| cogging[n][part] + unbalance[n][part]));
        MagneticsValues { torque_nm, ripple }
    }
}

impl MagneticsValues {
    /// The torque (1) that opposes positive rotation of a motor with torque constant `kt_nm_per_a`.
    #[must_use]
    pub fn torque_nm(&self, at: &PlantState, kt_nm_per_a: f64) -> f64 {
        let turn = powers(at.angle_rad);
        let sum = |waves: &[[f64; 2]; 6]| -> f64 {
            waves.iter().zip(turn).map(|([a, b], [cos, sin])| a * cos + b * sin).sum()
        };
        sum(&self.torque_nm) - kt_nm_per_a * at.current_a * sum(&self.ripple) // (1)
    }
}

/// Cosine and sine of nθ for each of [`ORDERS`].
fn powers(theta: f64) -> [[f64; 2]; 6] {
    let times = |[a, b]: [f64; 2], [c, d]: [f64; 2]| [a * c - b * d, a * d + b * c];
    let (sin, cos) = libm::sincos(theta);
    let first = [cos, sin];
    let second = times(first, first);
    let sixth = times(times(second, second), second);
    let twelfth = times(sixth, sixth);
    let twenty_fourth = times(twelfth, twelfth);
    [first, second, sixth, twelfth, twenty_fourth, times(twenty_fourth, twelfth)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::tests::{QUIET, run};
    use crate::{Field, FieldValues, Scenario, Stream};

    #[test]
    fn powers_are_the_sines_of_all_orders() {
        for k in 0..1000 {
            let theta = 0.37 * f64::from(k);
            for ([cos, sin], order) in powers(theta).into_iter().zip(ORDERS) {
                let angle = f64::from(order) * theta;
                // The rounding of nθ (up to 1.3e4, so 2e-12) exceeds that of six products.
                assert!((cos - angle.cos()).abs() < 1e-11 && (sin - angle.sin()).abs() < 1e-11, "{order} {theta}");
            }
        }
    }

    /// Amplitude of each order from 0 to 39 over a turn at this current.
    fn spectrum(values: &MagneticsValues, current_a: f64) -> Vec<f64> {
        let torque = |k: u32| {
            let at = PlantState { current_a, velocity_rad_s: 0.0, angle_rad: f64::from(k) * TAU / 100.0 };
            values.torque_nm(&at, 0.05)
        };
        let amplitude = |order: u32| {
            let (mut re, mut im) = (0.0, 0.0);
            for k in 0..100 {
                let (sin, cos) = libm::sincos(f64::from(order * k) * TAU / 100.0);
                (re, im) = (re + torque(k) * cos, im + torque(k) * sin);
            }
            re.hypot(im) / 50.0
        };
        (0..40).map(amplitude).collect()
    }

    #[test]
    fn amplitudes_are_those_of_the_field() {
        for seed in 0..20 {
            let values = Magnetics::FIELD.draw(NoiseSource::new(seed, Stream::Magnetics));
            let idle = spectrum(&values, 0.0);
            for (order, amplitude) in (0..).zip(&idle) {
                let nominal = match order {
                    1 => 0.006..0.006,
                    2 => 0.003..0.003,
                    6 | 36 => 0.0021..0.0039,
                    12 => 0.0042..0.0078,
                    24 => 0.0028..0.0052,
                    _ => 0.0..0.0,
                };
                // Rounding of a sum of 100.
                assert!((nominal.start - 1e-15..=nominal.end + 1e-15).contains(amplitude), "{order} {amplitude}");
            }
            // A large current hides the torque without current (12 mN·m at most): what is left is Kt i k_n.
            let loaded = spectrum(&values, 1e6);
            for (order, ripple) in ORDERS.into_iter().zip(Magnetics::FIELD.torque_constant_ripple) {
                assert!((loaded[order as usize] - 5e4 * ripple).abs() < 0.012, "{order}");
            }
        }
    }

    #[test]
    fn cogging_is_in_the_current_of_a_slow_motor() {
        let field = Field { magnetics: Some(Magnetics::FIELD), ..Field::NONE };
        let scenario = Scenario { field, reference_amplitude_rad_s: 5.0, ..QUIET };
        let values = FieldValues::draw(&scenario, 2).magnetics.expect("on");
        let trace = run(&scenario, 2);
        // Torque balance over six turns of the settled motor.
        let first = 1000;
        let end = (first..4999).find(|&k| trace.angle_rad[k] - trace.angle_rad[first] > 6.0 * TAU).expect("six turns");
        for (n, order) in [(1, 2.0), (2, 6.0)] {
            let (mut re, mut im) = (0.0, 0.0);
            for k in first..end {
                let slope = (trace.velocity_rad_s[k + 1] - trace.velocity_rad_s[k - 1]) / 0.004;
                let torque = 0.05 * trace.current_a[k] - 2.5e-4 * slope - 1e-4 * trace.velocity_rad_s[k];
                let width = 0.5 * (trace.angle_rad[k + 1] - trace.angle_rad[k - 1]) / (6.0 * TAU);
                let (sin, cos) = libm::sincos(order * trace.angle_rad[k]);
                (re, im) = (re + 2.0 * torque * cos * width, im + 2.0 * torque * sin * width);
            }
            let [a, b] = values.torque_nm[n];
            // At order 6 (4.8 Hz) the current lags by 1.6 ms, 2.7°, and the balance turns by as much: 5 % of it; the
            // ripple of a current near 0.05 A is 1e-5 N·m.
            let wrong = (re - a).hypot(im - b);
            assert!(wrong < 0.06 * a.hypot(b) + 2e-5, "{order}: {re} {im} for {a} {b}");
        }
    }
}
