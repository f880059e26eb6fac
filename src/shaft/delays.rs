//! How far the ring of the shaft is read back for each signal, so that all refer to one instant.
//!
//! A plan that takes each second sample reads its signals through a half-band low-pass, 3 samples late:
//!
//! ```text
//! y(k) = (−x(k) + 9 x(k−2) + 16 x(k−3) + 9 x(k−4) − x(k−6))/32                                        (1)
//! H(φ) e^{3jφ} = ½ + (9 cos φ − cos 3φ)/16 = ½ + ¾ c − ¼ c³,   c = cos φ                              (2)
//! ```
//!
//! φ is the phase a sample. (1) is flat at φ = 0 up to the third derivative, ½ at a quarter of the sampling rate, and 0
//! at half of it (Mintzer, *On half-band, third-band and Nth-band FIR filters*, 1982). It passes a tenth of the rate by
//! 0.97.

use crate::plan::{FILTERED_MOMENTS, MOMENTS};
use crate::record::record;

/// Longest lag that can be compensated, samples.
pub const MAX_LAG: f32 = 5.0;
/// Samples in the ring, without and with (1): with an interpolation the longest lag reads back 6 or 13 samples.
pub(super) const RING: u8 = 8;
pub(super) const FILTERED_RING: u8 = 16;
const _: () = assert!(MOMENTS == RING as usize && FILTERED_MOMENTS == (FILTERED_RING + BEFORE) as usize);
/// Samples before the newest that an interpolated value of (1) reads, and how many it reads.
pub(super) const BEFORE: u8 = 7;
pub(super) const TAPS: usize = BEFORE as usize + 1;
/// Samples by which (1) is late.
const LATE: f32 = 3.0;

record! {
    /// Samples by which measured signals lag behind the angle, 0 … [`MAX_LAG`].
    #[derive(Clone, Copy, Debug, Default, PartialEq)]
    #[cfg_attr(feature = "defmt", derive(defmt::Format))]
    pub struct Lags: SignalLag {
        /// Lag of the current.
        pub current: f32 in [0.0, MAX_LAG],
        /// Lag of the velocity; that of differences of the angle is half a sample.
        pub velocity: f32 in [0.0, MAX_LAG],
        /// Lag of the load.
        pub load: f32 in [0.0, MAX_LAG],
    }
}

/// How far the ring is read back for one signal.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Delay {
    pub whole: u8,
    /// The part of a sample beyond the whole ones.
    pub part: f32,
}

impl Delay {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 … 9 in a validated model")]
    fn of(samples: f32) -> Self {
        let whole = (samples as u8).min(FILTERED_RING - 2);
        Self { whole, part: samples - f32::from(whole) }
    }
}

/// The delays of current, velocity and load, and that to the middle of the last interval, to which the residual refers.
/// Two lists, since four [`Delay`]s would take twelve bytes more.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Delays {
    whole: [u8; 4],
    part: [f32; 4],
    /// Samples that a lost one spoils.
    pub spoilt: u8,
}

impl Delays {
    /// Of these lags, for each sample or for each second one behind (1).
    pub fn of(lags: &Lags, halved: bool) -> Self {
        let Lags { current, velocity, load } = *lags;
        let longest = current.max(velocity).max(load);
        // The middle of an interval of one or two samples.
        let angle = Delay::of(longest + if halved { LATE + 1.0 } else { 0.5 });
        let all = [Delay::of(longest - current), Delay::of(longest - velocity), Delay::of(longest - load), angle];
        let (whole, part) = (all.map(|delay| delay.whole), all.map(|delay| delay.part));
        // The first sample of (1) at the start of an interval of two is 5 before the angle.
        let spoilt = angle.whole.saturating_add(if halved { 6 } else { 3 });
        Self { whole, part, spoilt }
    }

    /// Those of current, velocity, load and angle.
    #[inline(always)]
    pub const fn all(&self) -> [Delay; 4] {
        let ([w0, w1, w2, w3], [p0, p1, p2, p3]) = (self.whole, self.part);
        [
            Delay { whole: w0, part: p0 },
            Delay { whole: w1, part: p1 },
            Delay { whole: w2, part: p2 },
            Delay { whole: w3, part: p3 },
        ]
    }
}

/// (1) of the samples from the oldest to the newest, interpolated between the last seven and the first seven: this part
/// of a sample earlier.
#[inline(always)]
pub(super) fn half_band([x7, x6, x5, x4, x3, x2, x1, x0]: [f32; TAPS], part: f32) -> f32 {
    const OUTER: f32 = 1.0 / 32.0;
    let of = |middle: f32, near: f32, far: f32| 0.5 * middle + 9.0 * OUTER * near - OUTER * far;
    let newer = of(x3, x2 + x4, x0 + x6);
    let older = of(x4, x3 + x5, x1 + x7);
    newer + part * (older - newer)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_half_band_filter_has_its_response_and_is_interpolated() {
        for cycles in [0.0_f64, 0.05, 0.1, 0.2, 0.25, 0.4, 0.5] {
            let phase = core::f64::consts::TAU * cycles;
            let c = phase.cos();
            let gain = 0.5 + 0.75 * c - 0.25 * c.powi(3);
            for part in [0.0_f32, 0.3, 0.9] {
                // The sample k is at k − 7, so that the middle of the last seven is 3 samples back.
                let at = |back: f64| (0.4 - phase * back).cos();
                let samples = core::array::from_fn(|k| at(7.0 - k as f64) as f32);
                let whole = gain * at(3.0);
                let expected = whole + f64::from(part) * (gain * at(4.0) - whole);
                let error = f64::from(half_band(samples, part)) - expected;
                // Some eight roundings of numbers up to one.
                assert!(error.abs() < 3e-7, "{cycles} {part}: {error}");
            }
        }
    }

    #[test]
    fn signals_and_angle_refer_to_one_instant() {
        let lags = Lags { current: 1.25, velocity: 0.5, load: 3.0 };
        let samples = |halved| Delays::of(&lags, halved).all().map(|delay| f32::from(delay.whole) + delay.part);
        // Each signal with its lag is 3 samples back; the angle is in the middle of the interval that ends there.
        assert_eq!(samples(false), [1.75, 2.5, 0.0, 3.5]);
        // The half-band filter is 3 samples late itself.
        assert_eq!(samples(true), [1.75, 2.5, 0.0, 7.0]);
    }
}
