//! The means of the bins, for both directions of motion, and the noise about them.

use core::f32::consts::TAU;

use super::line::RotorLine;
use super::table::{RotorTable, split};
use crate::regression::factor::kernels::{numbered, pairs};
use crate::signal::Angle;

/// Passes over which the noise is averaged: √(2/4096) = 2 % error of s².
const NOISE_PASSES: u16 = 4096;
/// Part of a turn between two passes beyond which their correlation is not measured.
const FAR: usize = 4;
/// Largest correlation of two passes in (6): beyond it the spectrum is not resolved.
const LARGEST_CORRELATION: f32 = 0.99;

/// What a map takes, and what it forgets.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RotorSettings {
    /// Slowest motion that is used: about three standard deviations of the velocity's noise, so that the direction is
    /// certain.
    pub slowest_rad_s: f32,
    /// N of (2): after so many passes of a bin its mean forgets exponentially. 65535 is a mean over all passes.
    pub memory: u16,
}

/// One pass of a bin.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Pass {
    bin: usize,
    direction: usize,
    sum: f32,
    samples: u16,
}

/// The noise of passes, for (6).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Noise {
    /// s².
    power: f32,
    /// Mean product of two passes.
    product: f32,
    /// Mean number of bins between them.
    step: f32,
    passes: u16,
    pairs: u16,
    /// Bin, direction and deviation of the last pass; no bin of the map if there is none.
    last: (usize, usize, f32),
}

/// A table that is being learned, of `BINS` bins a turn: at least eight for each period of the highest order.
///
/// ```
/// use bearing_watch::Angle;
/// use bearing_watch::shaft::{RotorMap, RotorSettings};
///
/// let settings = RotorSettings { slowest_rad_s: 0.5, memory: u16::MAX };
/// let mut map = RotorMap::<64>::new();
/// // Three turns forward, three backward: Coulomb friction of 0.2 A, cogging of 0.1 A at order 6.
/// for velocity in [10.0_f32, -10.0] {
///     for k in 0..3 * 640 {
///         let angle = Angle::from_radians(velocity.signum() * k as f32 * core::f32::consts::TAU / 640.0);
///         map.push(&settings, angle, velocity.signum() * 0.2 + 0.1 * angle.times(6).sin_cos().cos, velocity);
///     }
/// }
/// let line = map.line(6).ok_or("a bin has not been passed")?;
/// assert!((line.amplitude_a() - 0.1).abs() < 1e-3);
/// # Ok::<(), &str>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RotorMap<const BINS: usize> {
    /// m of (2), forward and backward.
    means: [[f32; BINS]; 2],
    /// n of (2), at most N.
    passes: [[u16; BINS]; 2],
    open: Pass,
    noise: Noise,
    skipped: u32,
}

impl<const BINS: usize> RotorMap<BINS> {
    /// Nothing learned.
    #[must_use]
    pub const fn new() -> Self {
        const { assert!(BINS >= 8 && BINS <= 16384, "a map has from 8 to 16384 bins") };
        Self {
            means: [[0.0; BINS]; 2],
            passes: [[0; BINS]; 2],
            open: Pass { bin: 0, direction: 0, sum: 0.0, samples: 0 },
            noise: Noise { power: 0.0, product: 0.0, step: 0.0, passes: 0, pairs: 0, last: (usize::MAX, 0, 0.0) },
            skipped: 0,
        }
    }

    /// Takes the residual of a sample with the mechanical angle at that instant. A residual that is not finite and a
    /// sample of too slow a motion are skipped and counted.
    #[inline]
    pub fn push(&mut self, settings: &RotorSettings, angle: Angle, residual_a: f32, velocity_rad_s: f32) {
        // False for NaN as well.
        let is_good = residual_a.abs() < f32::INFINITY && velocity_rad_s.abs() >= settings.slowest_rad_s;
        if !is_good {
            self.skipped = self.skipped.saturating_add(1);
            return;
        }
        let (bin, _) = split(u64::from(angle.bits()).wrapping_mul(BINS as u64));
        let direction = usize::from(velocity_rad_s < 0.0);
        let open = &self.open;
        if bin != open.bin || direction != open.direction || open.samples == u16::MAX {
            self.close(settings.memory);
            self.open = Pass { bin, direction, sum: 0.0, samples: 0 };
        }
        self.open.sum += residual_a;
        self.open.samples = self.open.samples.saturating_add(1);
    }

    /// (1), (2).
    #[inline(never)]
    fn close(&mut self, memory: u16) {
        let Pass { bin, direction, sum, samples } = self.open;
        let mean = self.means.get_mut(direction).and_then(|list| list.get_mut(bin));
        let passes = self.passes.get_mut(direction).and_then(|list| list.get_mut(bin));
        let (Some(mean), Some(passes), true) = (mean, passes, samples > 0) else { return };
        let before = f32::from(*passes);
        let deviation = sum / f32::from(samples) - *mean;
        *passes = passes.saturating_add(1).min(memory.max(1));
        *mean += deviation / f32::from(*passes);
        if before > 0.0 {
            // The variance of a value about the mean of n others is (n + 1)/n of s².
            let deviation = deviation * libm::sqrtf(before / (before + 1.0));
            self.noise.add::<BINS>((bin, direction, deviation));
        }
    }

    /// The number of bins that the rotor has not passed in both directions.
    #[must_use]
    pub fn missing(&self) -> usize {
        let [forward, backward] = &self.passes;
        pairs(forward, backward).fold(0, |count: usize, (one, other)| {
            // A count would be checked for overflow in a build with such checks.
            count.wrapping_add(usize::from(*one == 0 || *other == 0))
        })
    }

    /// The number of samples that were skipped.
    #[must_use]
    pub const fn skipped(&self) -> u32 {
        self.skipped
    }

    /// The table (3); `None` while a bin is missing.
    #[must_use]
    pub fn table(&self) -> Option<RotorTable<BINS>> {
        if self.missing() > 0 {
            return None;
        }
        let mut values = [0.0; BINS];
        let [forward, backward] = &self.means;
        for (value, (one, other)) in pairs(&mut values, pairs(forward, backward)) {
            *value = 0.5 * (one + other);
        }
        Some(RotorTable::of(values))
    }

    /// The line (4) of an order from 1 to below half the number of bins; `None` while a bin is missing.
    #[must_use]
    pub fn line(&self, order: u16) -> Option<RotorLine> {
        let is_resolved = order > 0 && usize::from(order).saturating_mul(2) < BINS;
        if !is_resolved {
            return None;
        }
        let values = self.table()?.current_a;
        let (mut cosine, mut sine) = (0.0, 0.0);
        for (bin, value) in numbered(values) {
            let phase = middle::<BINS>(bin).times(u32::from(order)).sin_cos();
            cosine += value * phase.cos;
            sine += value * phase.sin;
        }
        let [forward, backward] = &self.passes;
        let one_over = |passes: &u16| 1.0 / f32::from((*passes).max(1));
        let weight = pairs(forward, backward).fold(0.0, |sum, (one, other)| sum + one_over(one) + one_over(other));
        let bins = BINS as f32;
        let half_width = 0.5 * TAU * f32::from(order) / bins;
        let sinc = Angle::from_radians(half_width).sin_cos().sin / half_width;
        let scale = 2.0 / (bins * sinc); // (4)
        let variance = self.noise.density(TAU * f32::from(order) / bins) * weight * 0.5; // (5)
        Some(RotorLine {
            order,
            cosine_a: cosine * scale,
            sine_a: sine * scale,
            deviation_a: libm::sqrtf(variance) / (bins * sinc),
        })
    }
}

impl<const BINS: usize> Default for RotorMap<BINS> {
    fn default() -> Self {
        Self::new()
    }
}

/// The angle in the middle of a bin.
fn middle<const BINS: usize>(bin: usize) -> Angle {
    let counts = ((bin as u64).wrapping_mul(2).wrapping_add(1) << 31).checked_div(BINS as u64);
    Angle::from_bits(counts.and_then(|counts| u32::try_from(counts).ok()).unwrap_or(0))
}

impl Noise {
    /// Takes the deviation of a pass, with its bin and direction.
    fn add<const BINS: usize>(&mut self, now: (usize, usize, f32)) {
        let (bin, direction, deviation) = now;
        self.passes = self.passes.saturating_add(1).min(NOISE_PASSES);
        self.power += (deviation * deviation - self.power) / f32::from(self.passes);
        let (from, before, last) = core::mem::replace(&mut self.last, now);
        let passed = if direction == 0 { bin.wrapping_sub(from) } else { from.wrapping_sub(bin) };
        // Past the zero angle the difference is negative.
        let passed = if passed > BINS { passed.wrapping_add(BINS) } else { passed };
        if before == direction && from < BINS && passed > 0 && passed < BINS / FAR {
            self.pairs = self.pairs.saturating_add(1).min(NOISE_PASSES);
            let count = f32::from(self.pairs);
            self.product += (deviation * last - self.product) / count;
            self.step += (passed as f32 - self.step) / count;
        }
    }

    /// (6); `phase_rad` is that of the order from bin to bin.
    fn density(&self, phase_rad: f32) -> f32 {
        let ratio = if self.power > 0.0 { self.product / self.power } else { 0.0 };
        let correlation = ratio.clamp(-LARGEST_CORRELATION, LARGEST_CORRELATION);
        let square = correlation * correlation;
        let cosine = Angle::from_radians(phase_rad * self.step).sin_cos().cos;
        self.power * (1.0 - square) / (1.0 - 2.0 * correlation * cosine + square)
    }
}
