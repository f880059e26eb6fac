//! Second-order low-pass that also gives the derivative of its output, without differentiating noise.
//!
//! Enters: a signal x. Leaves: y, x behind a Butterworth low-pass of cut-off `f_c`, and its derivative ẏ.
//!
//! ```text
//! v₁ = (s₁ + g (x − s₂)) D,   D = 1/(1 + g (g + √2)),   v₂ = s₂ + g v₁,   g = tan(π f_c Ts)   (1)
//! s₁ ← 2 v₁ − s₁,   s₂ ← 2 v₂ − s₂;                     y = v₂,   ẏ = (2 g/Ts) v₁              (2)
//!
//! s₁ ← (2 D − 1) s₁ + 2 g D (x − s₂),   s₂ ← s₂ + 2 g v₁,   2 v₁ = s₁ + the s₁ before           (3)
//! ```
//!
//! (3) is (1) and (2) rearranged: y and ẏ follow from the states before and after the sample, and are computed only
//! where they are used.
//!
//! Trapezoidal integrators (Zavalishin, *The Art of VA Filter Design*, §4) make ẏ exactly the bilinear derivative of y.
//! Signals behind the same filter keep every linear equation that holds between them.

use crate::record::record;

record! {
    /// Constants of (1) and (2), shared by all filters of a bank.
    #[derive(Clone, Copy, Debug, PartialEq)]
    #[cfg_attr(feature = "defmt", derive(defmt::Format))]
    pub struct StateVariable: BalanceFilter {
        /// `g = tan(π f_c Ts)`, above 0; below 1 for cut-offs below a quarter of the sampling rate.
        pub gain: f32 in [1e-4, 10.0],
        /// 1/(1 + g (g + √2)).
        pub damping: f32,
        /// 2 g/Ts, 1/s.
        pub rate_per_s: f32,
    }
}

/// State of one filter.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Cell {
    s1: f32,
    s2: f32,
}

impl StateVariable {
    /// From g and the sampling interval.
    #[must_use]
    pub const fn new(gain: f32, interval_s: f32) -> Self {
        let damping = 1.0 / (1.0 + gain * (gain + core::f32::consts::SQRT_2));
        Self { gain, damping, rate_per_s: 2.0 * gain / interval_s }
    }
}

impl Cell {
    /// At rest on a level.
    pub const fn at(level: f32) -> Self {
        Self { s1: 0.0, s2: level }
    }

    /// y and v₁; ẏ is v₁ times [`StateVariable::rate_per_s`].
    #[inline(always)]
    pub fn step(&mut self, bank: &StateVariable, x: f32) -> (f32, f32) {
        let StateVariable { gain, damping, .. } = *bank;
        let (s1, s2) = (self.s1, self.s2);
        self.s1 = (2.0 * damping - 1.0) * s1 + (2.0 * gain * damping) * (x - s2); // (3)
        let twice_v1 = s1 + self.s1;
        self.s2 = s2 + gain * twice_v1;
        (0.5 * (s2 + self.s2), 0.5 * twice_v1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::PI;

    /// Gain of y and of ẏ for a sine of f Hz at 500 Hz, after the transient.
    fn gains(frequency_hz: f64) -> (f64, f64) {
        let bank = StateVariable::new((PI * 8.0 / 500.0).tan() as f32, 0.002);
        let mut cell = Cell::default();
        let (mut low, mut slope) = (0.0_f64, 0.0_f64);
        for k in 0..5000 {
            let x = (2.0 * PI * frequency_hz * f64::from(k) * 0.002).sin() as f32;
            let (y, v) = cell.step(&bank, x);
            if k >= 2500 {
                low = low.max(f64::from(y).abs());
                slope = slope.max(f64::from(v * bank.rate_per_s).abs());
            }
        }
        (low, slope)
    }

    #[test]
    fn butterworth_gain_and_its_derivative() {
        for frequency in [0.5, 4.0, 8.0, 25.0] {
            // Bilinear: frequencies warp to tan(π f Ts).
            let ratio = (PI * frequency / 500.0).tan() / (PI * 8.0_f64 / 500.0).tan();
            let gain = 1.0 / (1.0 + ratio.powi(4)).sqrt();
            let slope = gain * 2.0 * 500.0 * (PI * frequency / 500.0).tan();
            let (y, dy) = gains(frequency);
            // The peak of a sampled sine is met to (π f Ts)²/2 = 1.2 % at 25 Hz.
            assert!((y / gain - 1.0).abs() < 0.015 && (dy / slope - 1.0).abs() < 0.015, "{frequency}: {y} {dy}");
        }
    }

    #[test]
    fn a_level_has_no_slope() {
        let bank = StateVariable::new(0.05, 0.002);
        let mut cell = Cell::at(3.0);
        assert_eq!(cell.step(&bank, 3.0), (3.0, 0.0));
    }
}
