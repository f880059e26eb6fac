//! Random numbers, and the current measurement.
//!
//! One `u64` seed feeds several [`Stream`]s; each is a separate `ChaCha` stream of the same key. Streams never share
//! draws: if one noise level changes or one source is omitted, the other sources do not change.
//!
//! Load fluctuation, an AR(1) process at the sampling interval with stationary standard deviation σ:
//!
//! ```text
//! f(0) = σ g(0),   f(k) = p f(k−1) + σ √(1 − p²) g(k),   g ~ N(0, 1)      (1)
//! ```
//!
//! Current measurement: a second-order Butterworth low-pass, two integrators updated one after the other
//! (semi-implicit Euler) at the inner step `h`, `w = 2π·140 Hz`:
//!
//! ```text
//! s ← s + h (w² (i − y) − √2 w s),   y ← y + h s                          (2)
//! ```
//!
//! The gain at `w` is −3 dB except for terms of order `w h` (0.09 at 100 µs).
//!
//! Gaussian draws use the ziggurat algorithm of `rand_distr`. Its rare draws from the tails use the logarithm of the
//! platform, so they may differ in the last bit between platforms.

use core::f64::consts::{SQRT_2, TAU};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// Cut-off of the current measurement.
pub const CURRENT_FILTER_HZ: f64 = 140.0;

/// Purpose of a stream of random numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stream {
    /// Shaft angle at the start.
    StartAngle,
    /// Fluctuation of the load torque.
    LoadFluctuation,
    /// Noise of the current measurement.
    CurrentNoise,
    /// Noise of the velocity measurement.
    VelocityNoise,
    /// Operating conditions of a trace.
    Conditions,
    /// Temperature of the drive.
    Temperature,
    /// Stribeck friction.
    Stribeck,
    /// Friction in proportion to the load.
    LoadFriction,
    /// Cogging, torque ripple and unbalance.
    Magnetics,
    /// Errors of the angle sensor.
    Resolver,
    /// Gain and offset of the load sensor.
    LoadSensor,
    /// Noise of the load sensor.
    LoadSensorNoise,
    /// Compliance and backlash.
    Mechanics,
    /// Inertia of the payload.
    Payload,
    /// Current measurement and dead time.
    CurrentChain,
    /// Slip of the balls and width of the pulses.
    Slip,
    /// Fluctuation of the slip.
    SlipJitter,
    /// Kind of the duty and its steps.
    Duty,
    /// Missing samples.
    Missing,
    /// Jitter of the sampling instants.
    SampleJitter,
    /// Constants of one drive.
    Unit,
    /// Constants of one day.
    Session,
    /// Noise of the temperature sensor.
    TemperatureSensor,
    /// Noise of the position measurement.
    PositionNoise,
    /// Noise of the angle measurement.
    ResolverNoise,
    /// Position of an axis at the start.
    Axis,
    /// Payload of an axis.
    AxisPayload,
    /// Friction and ripple of a gear.
    Gear,
    /// Moves and rests of a machine.
    Cycle,
}

impl Stream {
    /// The numbers are fixed, so that a new stream does not change the existing ones.
    const fn number(self) -> u64 {
        match self {
            Self::StartAngle => 1,
            Self::LoadFluctuation => 2,
            Self::CurrentNoise => 3,
            Self::VelocityNoise => 4,
            Self::Conditions => 5,
            Self::Temperature => 6,
            Self::Stribeck => 7,
            Self::LoadFriction => 8,
            Self::Magnetics => 9,
            Self::Resolver => 10,
            Self::LoadSensor => 11,
            Self::LoadSensorNoise => 12,
            Self::Mechanics => 13,
            Self::Payload => 14,
            Self::CurrentChain => 15,
            Self::Slip => 16,
            Self::SlipJitter => 17,
            Self::Duty => 18,
            Self::Missing => 19,
            Self::SampleJitter => 20,
            Self::Unit => 21,
            Self::Session => 22,
            Self::TemperatureSensor => 23,
            Self::PositionNoise => 24,
            Self::ResolverNoise => 25,
            Self::Axis => 26,
            Self::AxisPayload => 27,
            Self::Gear => 28,
            Self::Cycle => 29,
        }
    }
}

/// One stream of random numbers with a seed.
#[derive(Debug, Clone)]
pub struct NoiseSource {
    rng: ChaCha8Rng,
}

impl NoiseSource {
    /// The stream for one purpose under one seed.
    #[must_use]
    pub fn new(seed: u64, stream: Stream) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(stream.number());
        Self { rng }
    }

    /// The stream for one purpose under a key of three numbers; no key has the draws of another.
    #[must_use]
    pub fn keyed(key: [u32; 3], stream: Stream) -> Self {
        let mut bytes = *b"............drive of a rig, keys";
        for (place, number) in bytes.chunks_exact_mut(4).zip(key) {
            place.copy_from_slice(&number.to_le_bytes());
        }
        let mut rng = ChaCha8Rng::from_seed(bytes);
        rng.set_stream(stream.number());
        Self { rng }
    }

    /// A draw from N(0, 1).
    pub fn gaussian(&mut self) -> f64 {
        self.rng.sample(StandardNormal)
    }

    /// A draw from the uniform distribution over `[from, to)`.
    pub fn uniform(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.rng.random::<f64>()
    }
}

/// The load fluctuation, equation (1).
#[derive(Debug, Clone)]
pub struct LoadFluctuation {
    source: NoiseSource,
    pole: f64,
    drive_nm: f64,
    value_nm: f64,
}

impl LoadFluctuation {
    /// A stationary process with standard deviation `rms_nm` and pole `pole`, |pole| < 1.
    #[must_use]
    pub fn new(mut source: NoiseSource, rms_nm: f64, pole: f64) -> Self {
        let value_nm = rms_nm * source.gaussian();
        Self { source, pole, drive_nm: rms_nm * (1.0 - pole * pole).sqrt(), value_nm }
    }

    /// Returns the current value and advances the process by one sample.
    pub fn draw(&mut self) -> f64 {
        let now = self.value_nm;
        self.value_nm = self.pole * now + self.drive_nm * self.source.gaussian(); // (1)
        now
    }
}

/// The low-pass of the current measurement (2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurrentFilter {
    step_s: f64,
    slope: f64,
    output_a: f64,
}

impl CurrentFilter {
    /// A filter at rest, updated every `step_s`; stable for `w h < 1.03`, i.e. `step_s` below 1.1 ms.
    #[must_use]
    pub const fn new(step_s: f64) -> Self {
        Self { step_s, slope: 0.0, output_a: 0.0 }
    }

    /// Filters one current sample and returns the filtered current.
    pub fn update(&mut self, current_a: f64) -> f64 {
        let w = TAU * CURRENT_FILTER_HZ;
        let bend = w * w * (current_a - self.output_a) - SQRT_2 * w * self.slope;
        self.slope += self.step_s * bend; // (2)
        self.output_a += self.step_s * self.slope;
        self.output_a
    }

    /// Changes the interval between updates.
    pub(crate) const fn set_step(&mut self, step_s: f64) {
        self.step_s = step_s;
    }

    /// Sets the output to a current that has been constant for a long time.
    pub const fn settle(&mut self, current_a: f64) {
        self.slope = 0.0;
        self.output_a = current_a;
    }

    /// The filtered current.
    #[must_use]
    pub const fn output_a(&self) -> f64 {
        self.output_a
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn amplitude_after_filter(frequency_hz: f64) -> f64 {
        let h = 1e-4;
        let mut filter = CurrentFilter::new(h);
        let mut peak = 0.0_f64;
        for k in 0..20_000 {
            let y = filter.update(libm::sin(TAU * frequency_hz * h * f64::from(k)));
            if k > 10_000 {
                peak = peak.max(y.abs());
            }
        }
        peak
    }

    #[test]
    fn filter_passes_slow_currents_and_halves_power_at_its_cutoff() {
        // 5 Hz: |H| = 1 − ½(5/140)⁴ ≈ 1 − 1e-6; a wrong gain would differ clearly.
        assert!((amplitude_after_filter(5.0) - 1.0).abs() < 1e-3);
        // −3 dB except for terms of order w h = 0.09 (semi-implicit Euler), with limits on both sides.
        let at_cutoff = amplitude_after_filter(140.0);
        assert!((0.70..0.78).contains(&at_cutoff), "{at_cutoff}");
        // Two poles: a quarter at twice the cut-off; one pole would have a half.
        let above = amplitude_after_filter(280.0);
        assert!((0.22..0.28).contains(&above), "{above}");
    }

    #[test]
    fn streams_of_one_seed_differ_and_repeat() {
        let first = |seed, stream| NoiseSource::new(seed, stream).gaussian();
        assert_ne!(first(1, Stream::CurrentNoise), first(1, Stream::VelocityNoise));
        assert_ne!(first(1, Stream::CurrentNoise), first(2, Stream::CurrentNoise));
        assert_eq!(first(1, Stream::CurrentNoise), first(1, Stream::CurrentNoise));
    }

    #[test]
    fn fluctuation_keeps_its_rms_whatever_its_pole() {
        for pole in [-0.5, 0.0, 0.9] {
            let mut fluctuation = LoadFluctuation::new(NoiseSource::new(8, Stream::LoadFluctuation), 0.06, pole);
            let square: f64 = (0..20_000).map(|_| fluctuation.draw().powi(2)).sum::<f64>() / 20_000.0;
            // Four standard deviations of the rms; one is √((1 + p²)/(1 − p²)/2n) = 1.5 % at p = 0.9.
            assert!((square.sqrt() / 0.06 - 1.0).abs() < 0.062, "{pole}: {}", square.sqrt());
        }
    }

    #[test]
    fn uniform_stays_within_its_bounds() {
        let mut source = NoiseSource::new(3, Stream::Conditions);
        let draws: Vec<f64> = (0..1000).map(|_| source.uniform(0.6, 1.5)).collect();
        assert!(draws.iter().all(|x| (0.6..1.5).contains(x)));
        // The extremes of 1000 draws lie within 0.01 of the bounds with a probability of 1 − 2e-5.
        assert!(draws.iter().any(|x| *x < 0.61) && draws.iter().any(|x| *x > 1.49));
    }
}
