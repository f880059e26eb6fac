//! Decimation by any factor with any linear-phase low-pass filter.
//!
//! ```text
//! y(k) = Σ h(j) x(kF − j),   j = 0 … TAPS−1                              (2)
//! ```
//!
//! Delay (TAPS − 1)/2 samples. Instead of computing one long sum every F samples, each sample is added to the at most
//! `SLOTS` outputs that depend on it: at most SLOTS multiplications and additions per channel and sample, evenly
//! distributed; state 4·CH·SLOTS + 8 bytes on the microcontroller. Sums in single precision: 131 taps have an error of
//! about 1e-6 of full scale.

use super::stage::add;
use crate::unroll::unrolled;

/// Causal FIR decimation (2) of `CH` channels by `FACTOR`; `SLOTS` is `TAPS` / `FACTOR`, rounded up.
///
/// The first output is returned when every tap has been multiplied by a sample, so the start-up transient is not
/// output. A sample that is not finite makes only those outputs not finite that depend on it.
///
/// ```
/// // Binomial low-pass, decimation by two; workbench::trace::prepare::anti_alias designs sharper ones.
/// const TAPS: [f32; 3] = [0.25, 0.5, 0.25];
/// let mut fir = bearing_watch::drive::FirDecimator::<1, 3, 2, 2>::new();
/// let out = [1.0, 2.0, 3.0, 4.0].map(|x| fir.push(&TAPS, [x]));
/// assert_eq!(out, [None, None, None, Some([3.0])]); // a ramp, one sample late
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FirDecimator<const CH: usize, const TAPS: usize, const FACTOR: usize, const SLOTS: usize> {
    /// Partial sums of the next outputs, the next output first.
    slots: [[f32; CH]; SLOTS],
    /// Number of samples until the next output.
    remaining: usize,
    /// Number of samples until every tap has been multiplied by a sample.
    filling: usize,
}

impl<const CH: usize, const TAPS: usize, const FACTOR: usize, const SLOTS: usize>
    FirDecimator<CH, TAPS, FACTOR, SLOTS>
{
    /// Creates the filter without samples.
    #[must_use]
    pub const fn new() -> Self {
        const {
            assert!(FACTOR > 0 && TAPS > 0, "a factor and a filter");
            assert!(SLOTS == TAPS.div_ceil(FACTOR), "SLOTS is TAPS / FACTOR, rounded up");
        }
        Self { slots: [[0.0; CH]; SLOTS], remaining: FACTOR - 1, filling: TAPS }
    }

    /// Adds a sample; every `FACTOR`-th call returns an output once the filter is filled.
    #[inline]
    pub fn push(&mut self, taps: &[f32; TAPS], sample: [f32; CH]) -> Option<[f32; CH]> {
        // The output due in `remaining` samples multiplies this sample by tap `remaining`, the next output by the tap
        // FACTOR later.
        // The minimum changes nothing: it shows the compiler that every slot but the last meets a tap.
        let mut met = self.remaining.min(FACTOR - 1);
        if let Some((last, mut slots)) = self.slots.split_last_mut() {
            unrolled!(let [slot, later @ ..] = slots => {
                add(slot, taps.get(met).copied().unwrap_or(0.0), &sample); // (2)
                met = met.wrapping_add(FACTOR);
                slots = later;
            });
            if let Some(tap) = taps.get(met) {
                add(last, *tap, &sample);
            }
        }
        self.filling = self.filling.saturating_sub(1);
        if self.remaining > 0 {
            self.remaining -= 1;
            return None;
        }
        self.remaining = FACTOR - 1;
        let output = self.slots.first().copied().unwrap_or([0.0; CH]);
        let mut slots = &mut self.slots[..];
        unrolled!(let [slot, later @ ..] = slots => {
            *slot = if let [next, ..] = later { *next } else { [0.0; CH] };
            slots = later;
        });
        (self.filling == 0).then_some(output)
    }

    /// Discards all samples.
    pub fn reset(&mut self) {
        *self = Self::new();
    }
}

impl<const CH: usize, const TAPS: usize, const FACTOR: usize, const SLOTS: usize> Default
    for FirDecimator<CH, TAPS, FACTOR, SLOTS>
{
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fir_is_its_convolution_whatever_the_ratio_of_taps_to_factor() {
        fn check<const TAPS: usize, const FACTOR: usize, const SLOTS: usize>() {
            let taps: [f32; TAPS] = core::array::from_fn(|j| 1.0 + j as f32);
            let x = |n: usize| ((n * n) % 7) as f32;
            let mut fir = FirDecimator::<2, TAPS, FACTOR, SLOTS>::new();
            for n in 0..40 {
                let output = fir.push(&taps, [x(n), -x(n)]);
                let due = n % FACTOR == FACTOR - 1 && n + 1 >= TAPS;
                // Sums of small integers are exact.
                let sum: f32 = (0..TAPS).filter(|j| *j <= n).map(|j| taps[j] * x(n - j)).sum();
                assert_eq!(output, due.then_some([sum, -sum]), "{TAPS} taps by {FACTOR}, sample {n}");
            }
        }
        check::<1, 1, 1>();
        check::<5, 1, 5>();
        check::<2, 4, 1>();
        check::<6, 3, 2>();
        check::<7, 3, 3>();
        check::<9, 2, 5>();
    }

    #[test]
    fn fir_forgets_a_nan_and_resets() {
        const TAPS: [f32; 4] = [0.25; 4];
        let mut fir = FirDecimator::<1, 4, 2, 2>::new();
        let fed = |fir: &mut FirDecimator<1, 4, 2, 2>, x: f32| fir.push(&TAPS, [x]).map(|y| y[0]);
        assert_eq!(fed(&mut fir, f32::NAN), None);
        let outputs: std::vec::Vec<f32> = (0..7).filter_map(|_| fed(&mut fir, 2.0)).collect();
        assert!(outputs[0].is_nan() && outputs[1..] == [2.0, 2.0]);
        fir.reset();
        assert_eq!(fir, FirDecimator::default());
    }
}
