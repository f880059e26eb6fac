//! The angle sensor and the velocity from its differences.
//!
//! ```text
//! θ_m = Q(θ + e₁ sin(θ + φ₁) + e₂ sin(2θ + φ₂) + e₁₂ sin(12θ + φ₁₂))     (1)
//! ω_m = F((θ_m(k) − θ_m(k−1)) / (t(k) − t(k−1)))                         (2)
//! ```
//!
//! Q rounds down to a multiple of a turn divided by a power of two. F is a Butterworth low-pass of second order at the
//! sampling interval (bilinear transform, exact at its cut-off), so that ω_m lags behind ω by half an interval and F's
//! delay. The controller uses ω_m.

use core::f64::consts::{PI, SQRT_2, TAU};

use super::draws::{between, choice};
use crate::{NoiseSource, RigError, not_negative, positive, within};

/// Orders of the error (1).
pub const ERROR_ORDERS: [f64; 3] = [1.0, 2.0, 12.0];

/// Ranges of the effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resolver {
    /// Lower and upper limit of each error amplitude, for each of [`ERROR_ORDERS`].
    pub error_deg: [[f64; 2]; 3],
    /// Smallest and largest number of bits of a turn, both included.
    pub bits: [u32; 2],
    /// Cut-off of F (2).
    pub cutoff_hz: f64,
}

/// Values of one record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResolverValues {
    /// Amplitude and phase of each error.
    pub error_rad: [[f64; 2]; 3],
    /// Number of bits of a turn.
    pub bits: u32,
    /// Cut-off of F (2).
    pub cutoff_hz: f64,
}

impl Resolver {
    /// The ranges of the field.
    pub const FIELD: Self = Self { error_deg: [[0.1, 0.5], [0.1, 0.5], [0.1, 0.25]], bits: [12, 14], cutoff_hz: 60.0 };

    pub(super) fn validate(&self, sample_time_s: f64) -> Result<(), RigError> {
        for error in self.error_deg.as_flattened() {
            not_negative("field.resolver.error_deg", *error)?;
        }
        for bits in self.bits {
            within("field.resolver.bits", f64::from(bits), [1.0, 30.0])?;
        }
        positive("field.resolver.cutoff_hz", self.cutoff_hz)?;
        within("field.resolver.cutoff_hz", self.cutoff_hz, [0.0, 0.49 / sample_time_s])?;
        Ok(())
    }

    pub(super) fn draw(&self, mut source: NoiseSource) -> ResolverValues {
        let mut error = |range| [between(&mut source, range).to_radians(), source.uniform(0.0, TAU)];
        let error_rad = self.error_deg.map(&mut error);
        let [fewest, most] = self.bits;
        let choices = most.saturating_sub(fewest) + 1;
        ResolverValues { error_rad, bits: fewest + choice(&mut source, choices), cutoff_hz: self.cutoff_hz }
    }
}

impl ResolverValues {
    /// The measured angle of a shaft at this angle (1), not wrapped.
    pub(crate) fn measured_rad(&self, angle_rad: f64) -> f64 {
        let waves = ERROR_ORDERS.iter().zip(self.error_rad);
        let error: f64 = waves.map(|(n, [amplitude, phase])| amplitude * libm::sin(n * angle_rad + phase)).sum();
        rounded(angle_rad + error, self.step_rad()) // (1)
    }

    /// The resolution of Q.
    #[must_use]
    pub fn step_rad(&self) -> f64 {
        step_rad(self.bits)
    }
}

/// Q: the next lower multiple of a step.
pub(crate) fn rounded(angle_rad: f64, step_rad: f64) -> f64 {
    (angle_rad / step_rad).floor() * step_rad
}

/// The step of so many bits of a turn.
#[must_use]
pub fn step_rad(bits: u32) -> f64 {
    TAU / f64::from(1_u32 << bits)
}

/// The velocity from differences of the angle (2).
#[derive(Debug, Clone, Copy)]
pub(crate) struct DifferencedVelocity {
    b0: f64,
    a: [f64; 2],
    memory: [f64; 2],
    previous_rad: f64,
    initial_rad_s: f64,
    started: bool,
}

impl DifferencedVelocity {
    /// A filter whose output has been `initial_rad_s` for a long time.
    pub(crate) fn new(cutoff_hz: f64, sample_time_s: f64, initial_rad_s: f64) -> Self {
        let k = libm::tan(PI * cutoff_hz * sample_time_s);
        let scale = 1.0 / (1.0 + SQRT_2 * k + k * k);
        let b0 = k * k * scale;
        let a = [2.0 * (k * k - 1.0) * scale, (1.0 - SQRT_2 * k + k * k) * scale];
        let second = (b0 - a[1]) * initial_rad_s;
        let memory = [second + (2.0 * b0 - a[0]) * initial_rad_s, second];
        Self { b0, a, memory, previous_rad: 0.0, initial_rad_s, started: false }
    }

    /// The velocity after one more measured angle, `interval_s` after the last.
    pub(crate) fn update(&mut self, measured_rad: f64, interval_s: f64) -> f64 {
        let slope = if self.started { (measured_rad - self.previous_rad) / interval_s } else { self.initial_rad_s };
        (self.previous_rad, self.started) = (measured_rad, true);
        let output = self.b0 * slope + self.memory[0];
        self.memory[0] = 2.0 * self.b0 * slope - self.a[0] * output + self.memory[1];
        self.memory[1] = self.b0 * slope - self.a[1] * output;
        output // (2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Stream;

    fn drawn(seed: u64) -> ResolverValues {
        Resolver::FIELD.draw(NoiseSource::new(seed, Stream::Resolver))
    }

    #[test]
    fn error_harmonics_and_resolution_are_those_of_the_field() {
        let mut seen = [false; 3];
        for seed in 0..40 {
            let values = drawn(seed);
            seen[values.bits as usize - 12] = true;
            let step = TAU / f64::from(1 << values.bits);
            assert_eq!(values.step_rad(), step);
            // Angles beside the grid of Q, over one turn.
            let points = 10_007;
            let error = |k: u32| {
                let theta = f64::from(k) * TAU / f64::from(points);
                (theta, values.measured_rad(theta) - theta)
            };
            for (order, [from, to]) in ERROR_ORDERS.into_iter().zip(Resolver::FIELD.error_deg) {
                let (mut re, mut im) = (0.0, 0.0);
                for (theta, error) in (0..points).map(error) {
                    let (sin, cos) = libm::sincos(order * theta);
                    (re, im) = (re + error * cos, im + error * sin);
                }
                let amplitude = 2.0 / f64::from(points) * re.hypot(im);
                // Rounding down is noise of at most step/√12 = 4.4e-4 rad, √(2/10007) of it: four times is 2.5e-5.
                assert!((from.to_radians() - 3e-5..to.to_radians() + 3e-5).contains(&amplitude), "{order} {amplitude}");
            }
        }
        assert_eq!(seen, [true; 3]);
    }

    #[test]
    fn measured_angles_are_multiples_of_the_resolution() {
        let values = ResolverValues { error_rad: [[0.0; 2]; 3], bits: 12, cutoff_hz: 60.0 };
        for k in -1000..1000 {
            let theta = 0.0137 * f64::from(k);
            let counts = values.measured_rad(theta) / values.step_rad();
            // A power of two divides without rounding; multiplication by 2π rounds once.
            assert!((counts - counts.round()).abs() < 1e-11);
            assert!((0.0..=values.step_rad()).contains(&(theta - values.measured_rad(theta))));
        }
    }

    #[test]
    fn velocity_is_the_slope_behind_sixty_hertz() {
        let mut steady = DifferencedVelocity::new(60.0, 0.002, 30.0);
        for k in 0..100 {
            // Settled from the start; rounding of an angle of 6 rad over 2 ms.
            assert!((steady.update(0.06 * f64::from(k), 0.002) - 30.0).abs() < 1e-11);
        }
        for (frequency_hz, gain) in [(5.0, 1.0 / (1.0 + warped(5.0).powi(4)).sqrt()), (60.0, 0.5_f64.sqrt())] {
            let w = TAU * frequency_hz;
            let mut filter = DifferencedVelocity::new(60.0, 0.002, 0.0);
            let outputs: Vec<f64> =
                (0..5000).map(|k| filter.update(libm::sin(w * 0.002 * f64::from(k)) / w, 0.002)).collect();
            let rms = (outputs[2500..].iter().map(|x| x * x).sum::<f64>() / 2500.0).sqrt();
            // The difference over an interval: sin(x)/x with x = ω Ts/2. Whole periods, so only rounding is left.
            let x = 0.5 * w * 0.002;
            assert!((rms - 0.5_f64.sqrt() * gain * x.sin() / x).abs() < 1e-9, "{frequency_hz}: {rms}");
        }
    }

    /// Frequency over the cut-off of 60 Hz after the bilinear transform.
    fn warped(frequency_hz: f64) -> f64 {
        (PI * frequency_hz * 0.002).tan() / (PI * 60.0 * 0.002).tan()
    }

    #[test]
    fn a_longer_interval_is_a_smaller_slope() {
        let mut filter = DifferencedVelocity::new(60.0, 0.002, 10.0);
        let mut angle = 0.0;
        for k in 0..50 {
            let interval = if k % 2 == 0 { 0.0018 } else { 0.0022 };
            angle += 10.0 * interval;
            // Rounding of an angle of 1 rad over 2 ms.
            assert!((filter.update(angle, interval) - 10.0).abs() < 1e-11);
        }
    }
}
