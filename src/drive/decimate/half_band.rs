//! A chain of half-band filters: decimation by a power of two with few multiplications, nearly the same number per
//! sample.
//!
//! ```text
//! y(k) = ½ x(2k − 2K + 1) + Σ h(j) [x(2k − 2j) + x(2k − 4K + 2 + 2j)],   j = 0 … K−1              (3)
//! delay of a stage 2K − 1 of its samples;  of the chain  D = (2K₁ − 1)(F/2 − 1) + (2K₂ − 1) F/2 samples    (4)
//! ```
//!
//! K pairs of equal taps, outermost first; of the other taps only the middle one is not zero. The `EARLY` stages of K₁
//! = `SHORT` pairs may have wide transition bands, since only the last stage, of K₂ = `LONG` pairs, determines the band
//! edge. F = 2^(EARLY+1). The response of a stage is odd-symmetric about its new Nyquist frequency, where it is −6 dB:
//! the deviation from one in the pass band equals that from zero in the stop band. Components between 1 and 1.2 of that
//! frequency alias to between 0.8 and 1: use the band up to 0.8.
//!
//! **Schedule.** Sample n (from 1) runs the one stage whose number is the number of trailing zero bits of n + 1: the
//! first stage in every second sample, the next in every fourth, and so on. The last stage has two time slots and does
//! half of its work in each. An output is therefore returned
//!
//! ```text
//! latency = F/2 − 1 samples after the newest sample that it depends on                              (5)
//! ```
//!
//! The total delay is D + latency samples, the same for every frequency: 121 + 3 samples for factor 8, 249 + 7 for 16.
//!
//! Stages store partial sums instead of past samples (transposed form): a sample that is not finite makes only those
//! outputs not finite whose taps include it. Cost per sample: 2K₁ + 1 or at most K₂ + 1 multiply-adds per channel;
//! `cargo xtask measure` prints the instructions. State: 8·CH·(K₁ + 1) bytes per early stage, 8·CH·(K₂ + 1) for the
//! last, and 8 more on the microcontroller.

use super::stage::{Stage, Waiting};

/// Coefficients (3) of a [`HalfBandDecimator`], outermost first; the middle tap of ½ is not included.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct HalfBandTaps<const SHORT: usize, const LONG: usize> {
    /// Taps of every stage except the last.
    pub early: [f32; SHORT],
    /// Taps of the last stage.
    pub last: [f32; LONG],
}

/// Attenuation 83 dB, pass band to 0.1 of the sampling rate of the stage.
const GENTLE: [f32; 4] = [-0.002_474_437, 0.016_966_78, -0.067_683_52, 0.303_191_18];

impl HalfBandTaps<4, 13> {
    /// Components that alias into 0 … 0.4 of the output rate are attenuated by at least 80 dB; components in this band
    /// pass within 0.003 dB; gain one for constants. Computed by `half_band` of `host-tests`.
    pub const SHARP: Self = Self {
        early: GENTLE,
        last: [
            0.000_110_948_116,
            -0.000_343_425_14,
            0.000_834_977_4,
            -0.001_734_886_9,
            0.003_246_281_8,
            -0.005_632_845_7,
            0.009_245_296,
            -0.014_589_696,
            0.022_508_077,
            -0.034_698_285,
            0.055_516_187,
            -0.101_020_69,
            0.316_558_06,
        ],
    };
}

impl HalfBandTaps<4, 4> {
    /// Taps for use before another decimator by 2 or more: components that alias into 0 … 0.2 of the output rate are
    /// attenuated by at least 80 dB.
    pub const GENTLE: Self = Self { early: GENTLE, last: GENTLE };
}

/// Causal decimation of `CH` channels by 2^(`EARLY` + 1), with the computation distributed over the samples.
///
/// The first output is returned when every tap has been multiplied by a sample.
///
/// ```
/// use bearing_watch::drive::{HalfBandDecimator, HalfBandTaps};
/// // 20 kHz → 2.5 kHz: two early stages and the last.
/// let mut decimator = HalfBandDecimator::<1, 2, 4, 13>::new();
/// let outputs = (0..800).filter_map(|n| decimator.push(&HalfBandTaps::SHARP, [n as f32]));
/// // A ramp comes out as a ramp: every eighth sample, `delay` late.
/// let first = HalfBandDecimator::<1, 2, 4, 13>::TAPS.next_multiple_of(8) - 1;
/// for (k, y) in outputs.enumerate() {
///     let n = (first + 8 * k) as f32;
///     assert!((y[0] - (n - HalfBandDecimator::<1, 2, 4, 13>::DELAY as f32)).abs() < 1e-3);
/// }
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct HalfBandDecimator<const CH: usize, const EARLY: usize, const SHORT: usize, const LONG: usize> {
    early: [Stage<CH, SHORT>; EARLY],
    last: Stage<CH, LONG>,
    /// n + 1; its number of trailing zero bits selects the stage.
    turn: u32,
    /// Number of outputs until every tap has been multiplied by a sample.
    filling: usize,
}

impl<const CH: usize, const EARLY: usize, const SHORT: usize, const LONG: usize>
    HalfBandDecimator<CH, EARLY, SHORT, LONG>
{
    /// Number of samples per output.
    pub const FACTOR: usize = 2 << EARLY;
    /// Delay (4) of the filters, in samples: from the centre of the taps to the newest sample in them.
    pub const DELAY: usize = (2 * SHORT - 1) * (Self::FACTOR / 2 - 1) + (2 * LONG - 1) * (Self::FACTOR / 2);
    /// Number of samples (5) between the newest one that an output depends on and the call that returns the output.
    pub const LATENCY: usize = Self::FACTOR / 2 - 1;
    /// Number of samples that an output depends on.
    pub const TAPS: usize = 2 * Self::DELAY + 1;

    /// Creates the filters without samples.
    #[must_use]
    pub const fn new() -> Self {
        const { assert!(EARLY < 16 && SHORT > 0 && LONG > 0 && SHORT < 1000 && LONG < 1000, "stages and taps") };
        // An output is due at sample F/2 − 1 and every F samples from there; with one stage that would be sample zero.
        let filling = Self::TAPS.div_ceil(Self::FACTOR) - (EARLY == 0) as usize;
        Self { early: [Stage::NEW; EARLY], last: Stage::NEW, turn: 1, filling }
    }

    /// Adds a sample; every [`Self::FACTOR`]-th call returns an output once the filters are filled.
    #[inline]
    pub fn push(&mut self, taps: &HalfBandTaps<SHORT, LONG>, sample: [f32; CH]) -> Option<[f32; CH]> {
        self.turn = self.turn.wrapping_add(1);
        let whose = self.turn.trailing_zeros() as usize;
        self.waiting(0).put(whose != 0, sample);
        if let Some(stage) = self.early.get_mut(whose) {
            let carry = stage.later_half(&taps.early);
            let output = stage.sooner_half(&taps.early, carry);
            // The slots of this stage are 2^(whose + 1) samples apart; in the odd ones it computes the first output of
            // a pair.
            let is_first = (self.turn >> (whose + 1)) & 1 == 1;
            self.waiting(whose + 1).put(is_first, output);
            None
        } else if whose == EARLY {
            let carry = self.last.carry(&taps.last);
            let output = self.last.sooner_half(&taps.last, carry);
            let full = self.filling == 0;
            self.filling = self.filling.saturating_sub(1);
            full.then_some(output)
        } else {
            let _in_time_for_the_next_output = self.last.later_half(&taps.last);
            None
        }
    }

    /// Input samples of a stage, counted from the input of the chain.
    #[inline]
    fn waiting(&mut self, stage: usize) -> &mut Waiting<CH> {
        self.early.get_mut(stage).map_or(&mut self.last.waiting, |stage| &mut stage.waiting)
    }

    /// Discards all samples.
    pub fn reset(&mut self) {
        *self = Self::new();
    }
}

impl<const CH: usize, const EARLY: usize, const SHORT: usize, const LONG: usize> Default
    for HalfBandDecimator<CH, EARLY, SHORT, LONG>
{
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    type Sharp<const CH: usize, const EARLY: usize> = HalfBandDecimator<CH, EARLY, 4, 13>;
    const SHARP: HalfBandTaps<4, 13> = HalfBandTaps::SHARP;

    /// All taps of one stage, including zeros and the middle one.
    fn stage(outer: &[f32]) -> Vec<f64> {
        let half = outer.iter().flat_map(|tap| [f64::from(*tap), 0.0]).collect::<Vec<_>>();
        let half = &half[..half.len() - 1];
        half.iter().copied().chain([0.5]).chain(half.iter().rev().copied()).collect()
    }

    /// All taps of the chain at the input rate.
    fn chain(early: usize) -> Vec<f64> {
        (0..=early).fold(Vec::from([1.0]), |chain, k| {
            let next = stage(if k < early { &SHARP.early } else { &SHARP.last });
            let mut product = std::vec![0.0; chain.len() + (next.len() - 1) * (1 << k)];
            for (i, a) in chain.iter().enumerate() {
                next.iter().enumerate().for_each(|(j, b)| product[i + (j << k)] += a * b);
            }
            product
        })
    }

    fn check<const EARLY: usize>(x: impl Fn(usize) -> f32) {
        let taps = chain(EARLY);
        let (factor, latency) = (Sharp::<2, EARLY>::FACTOR, Sharp::<2, EARLY>::LATENCY);
        assert_eq!(taps.len(), Sharp::<2, EARLY>::TAPS);
        let mut decimator = Sharp::<2, EARLY>::new();
        for n in 0..3 * taps.len() {
            let output = decimator.push(&SHARP, [x(n), -x(n)]);
            let newest = n.wrapping_sub(latency);
            let due = n >= latency && newest % factor == factor - 1 && newest + 1 >= taps.len();
            assert_eq!(output.is_some(), due, "factor {factor}, sample {n}");
            if let Some([a, b]) = output {
                let sum: f64 = taps.iter().enumerate().map(|(j, tap)| tap * f64::from(x(newest - j))).sum();
                // Sum of a few dozen single-precision terms below one.
                assert!((f64::from(a) - sum).abs() < 5e-7 && a == -b, "factor {factor}, sample {n}: {a} {sum}");
            }
        }
    }

    #[test]
    fn chain_is_the_convolution_of_its_stages() {
        let rough = |n: usize| ((n * n * 7 + n) % 101) as f32 / 101.0 - 0.5;
        check::<0>(rough);
        check::<1>(rough);
        check::<2>(rough);
        check::<3>(rough);
    }

    #[test]
    fn delay_by_8_and_by_16() {
        assert_eq!((Sharp::<1, 2>::FACTOR, Sharp::<1, 2>::DELAY, Sharp::<1, 2>::LATENCY), (8, 121, 3));
        assert_eq!((Sharp::<1, 3>::FACTOR, Sharp::<1, 3>::DELAY, Sharp::<1, 3>::LATENCY), (16, 249, 7));
    }

    #[test]
    fn impulse_gives_the_taps() {
        check::<1>(|n| if n == 110 { 1.0 } else { 0.0 });
        check::<2>(|n| if n == 301 { 1.0 } else { 0.0 });
    }

    #[test]
    fn folded_bands_are_eighty_decibels_down_and_the_pass_band_is_flat() {
        for early in 0..4 {
            let (taps, factor) = (chain(early), 2 << early);
            let centre = (taps.len() / 2) as f64;
            let gain = |f: f64| {
                let cosine = |j: usize| (std::f64::consts::TAU * f * (j as f64 - centre)).cos();
                taps.iter().enumerate().map(|(j, tap)| tap * cosine(j)).sum::<f64>()
            };
            for k in 0..=100 {
                let kept = 0.004 * f64::from(k) / f64::from(factor); // to 0.8 of the new Nyquist
                assert!((gain(kept) - 1.0).abs() < 3e-4, "{kept}: {}", gain(kept));
                for fold in 1..=factor / 2 {
                    let image = f64::from(fold) / f64::from(factor);
                    assert!(gain(image - kept).abs() < 1e-4 && gain(image + kept).abs() < 1e-4, "{fold} {kept}");
                }
            }
            assert!((gain(0.0) - 1.0).abs() < 1e-6, "constants");
        }
    }

    #[test]
    fn each_sample_is_the_turn_of_exactly_one_stage() {
        let mut decimator = Sharp::<1, 3>::new();
        for n in 0..2000 {
            let before = decimator.clone();
            let _ = decimator.push(&SHARP, [1.0 + n as f32]);
            let sums = |stage: &Stage<1, 4>| (stage.sooner, stage.later);
            let early = before.early.iter().zip(&decimator.early).filter(|(a, b)| sums(a) != sums(b)).count();
            let last = usize::from(before.last.sooner != decimator.last.sooner)
                + usize::from(before.last.later != decimator.last.later);
            assert!(early + last == 1 || n < 200, "sample {n}: {early} early stages, {last} halves of the last");
        }
    }

    #[test]
    fn nan_spoils_the_outputs_that_its_taps_reach_and_reset_forgets() {
        const AT: usize = 400;
        let taps = chain(2);
        let mut decimator = Sharp::<1, 2>::new();
        for n in 0..1200 {
            let x = if n == AT { f32::NAN } else { 1.0 };
            if let Some([y]) = decimator.push(&SHARP, [x]) {
                let met = (n - Sharp::<1, 2>::LATENCY).checked_sub(AT).and_then(|j| taps.get(j));
                assert_eq!(y.is_nan(), met.is_some_and(|tap| *tap != 0.0), "sample {n}");
            }
        }
        decimator.reset();
        assert_eq!(decimator, HalfBandDecimator::default());
    }
}
