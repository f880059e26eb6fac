//! The filters of a front end for each factor of decimation.
//!
//! ```text
//! F = P · 2^k    x ─► short low-pass, by P = 3 or 5 ─► k half-band filters, the last one sharp ─► y
//! ```
//!
//! The low-pass has to stop only what aliases into the pass band of the half-band filters behind it, hence its few
//! taps. For each factor the whole chain passes 0 … 0.4 of the output rate within 0.003 dB, and components that alias
//! into this band are attenuated by at least 80 dB.

use super::{FirDecimator, HalfBandDecimator, HalfBandTaps};
use crate::printable::Printable;

/// Low-pass by 3 before half-band filters, by `before_half_bands` of `host-tests`.
const BY_3: [f32; 23] = [
    -0.001_114_763_8,
    -0.001_807_513_8,
    0.000_126_108_08,
    0.007_996_123,
    0.011_917_328,
    -0.000_501_761_2,
    -0.032_410_827,
    -0.047_316_33,
    0.000_998_868_3,
    0.127_559_93,
    0.268_498_75,
    0.332_108_2,
    0.268_498_75,
    0.127_559_93,
    0.000_998_868_3,
    -0.047_316_33,
    -0.032_410_827,
    -0.000_501_761_2,
    0.011_917_328,
    0.007_996_123,
    0.000_126_108_08,
    -0.001_807_513_8,
    -0.001_114_763_8,
];

/// Low-pass by 5 before half-band filters, likewise.
const BY_5: [f32; 35] = [
    -0.001_792_011_9,
    -0.000_620_839_94,
    -0.000_002_624_166_2,
    0.001_584_644_1,
    0.002_209_287,
    0.010_502_976,
    0.004_948_854,
    0.000_067_463_43,
    -0.009_615_242_5,
    -0.015_156_663,
    -0.036_359_042,
    -0.021_856_54,
    -0.000_174_496_18,
    0.040_751_446,
    0.083_248_3,
    0.157_332_36,
    0.184_825_76,
    0.200_212_72,
    0.184_825_76,
    0.157_332_36,
    0.083_248_3,
    0.040_751_446,
    -0.000_174_496_18,
    -0.021_856_54,
    -0.036_359_042,
    -0.015_156_663,
    -0.009_615_242_5,
    0.000_067_463_43,
    0.004_948_854,
    0.010_502_976,
    0.002_209_287,
    0.001_584_644_1,
    -0.000_002_624_166_2,
    -0.000_620_839_94,
    -0.001_792_011_9,
];

/// A chain of filters with fixed taps for `CH` channels.
pub trait Decimate<const CH: usize>: Clone + PartialEq + Printable {
    /// The chain without samples.
    const NEW: Self;
    /// Samples per output.
    const FACTOR: usize;
    /// Samples between the centre of the taps of an output and the newest sample in them.
    const DELAY: usize;
    /// Samples between the newest one that an output depends on and the call that returns it.
    const LATENCY: usize;
    /// The number, from zero and modulo the factor, of the newest sample that an output depends on.
    const NEWEST: usize;

    /// Adds a sample; every [`Self::FACTOR`]-th call returns an output once the filters are filled.
    fn push(&mut self, sample: [f32; CH]) -> Option<[f32; CH]>;
}

/// No decimation: every sample is an output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Unfiltered;

impl<const CH: usize> Decimate<CH> for Unfiltered {
    const NEW: Self = Self;
    const FACTOR: usize = 1;
    const DELAY: usize = 0;
    const LATENCY: usize = 0;
    const NEWEST: usize = 0;

    #[inline(always)]
    fn push(&mut self, sample: [f32; CH]) -> Option<[f32; CH]> {
        Some(sample)
    }
}

/// Half-band filters, the last one sharp.
type HalfBands<const CH: usize, const EARLY: usize> = HalfBandDecimator<CH, EARLY, 4, 13>;

impl<const CH: usize, const EARLY: usize> Decimate<CH> for HalfBands<CH, EARLY> {
    const NEW: Self = Self::new();
    const FACTOR: usize = Self::FACTOR;
    const DELAY: usize = Self::DELAY;
    const LATENCY: usize = Self::LATENCY;
    const NEWEST: usize = Self::FACTOR - 1;

    #[inline(always)]
    fn push(&mut self, sample: [f32; CH]) -> Option<[f32; CH]> {
        Self::push(self, &HalfBandTaps::SHARP, sample)
    }
}

/// A low-pass by `P`, then half-band filters.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Compound<const CH: usize, const TAPS: usize, const P: usize, const SLOTS: usize, const EARLY: usize> {
    low_pass: FirDecimator<CH, TAPS, P, SLOTS>,
    half_bands: HalfBands<CH, EARLY>,
}

macro_rules! compound {
    ($taps:ident, $length:literal, $p:literal, $slots:literal) => {
        impl<const CH: usize, const EARLY: usize> Decimate<CH> for Compound<CH, $length, $p, $slots, EARLY> {
            const NEW: Self = Self { low_pass: FirDecimator::new(), half_bands: HalfBandDecimator::new() };
            const FACTOR: usize = $p * HalfBands::<CH, EARLY>::FACTOR;
            const DELAY: usize = ($length - 1) / 2 + $p * HalfBands::<CH, EARLY>::DELAY;
            const LATENCY: usize = $p * HalfBands::<CH, EARLY>::LATENCY;
            // The first output of the low-pass, which the half-band filters count as zero, has this many samples before
            // it: all but the last of its slots are full.
            const NEWEST: usize = ($p * ($slots - 1) + $p * HalfBands::<CH, EARLY>::FACTOR - 1) % (Self::FACTOR);

            #[inline(always)]
            fn push(&mut self, sample: [f32; CH]) -> Option<[f32; CH]> {
                let passed = self.low_pass.push(&$taps, sample)?;
                self.half_bands.push(&HalfBandTaps::SHARP, passed)
            }
        }
    };
}

compound!(BY_3, 23, 3, 8);
compound!(BY_5, 35, 5, 7);

/// A number of samples that a [`FrontEnd`](crate::drive::FrontEnd) makes one: the type of the numbers for which there
/// are filters, as [`Factor`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct By<const FACTOR: usize>;

/// A factor of decimation for which there are filters: 1, 2, 4, 8, 16, 32, and 3 or 5 times 2 … 16 (3) or 2 … 8 (5).
///
/// [`By`] implements it for each of them.
pub trait Factor: sealed::Sealed {
    /// The filters of `CH` channels.
    type Chain<const CH: usize>: Decimate<CH>;
}

mod sealed {
    pub trait Sealed {}
}

macro_rules! factors {
    ($($factor:literal: $chain:ty;)+) => {$(
        impl sealed::Sealed for By<$factor> {}

        impl Factor for By<$factor> {
            type Chain<const CH: usize> = $chain;
        }
    )+};
}

factors! {
    1: Unfiltered;
    2: HalfBands<CH, 0>;
    4: HalfBands<CH, 1>;
    8: HalfBands<CH, 2>;
    16: HalfBands<CH, 3>;
    32: HalfBands<CH, 4>;
    6: Compound<CH, 23, 3, 8, 0>;
    12: Compound<CH, 23, 3, 8, 1>;
    24: Compound<CH, 23, 3, 8, 2>;
    48: Compound<CH, 23, 3, 8, 3>;
    10: Compound<CH, 35, 5, 7, 0>;
    20: Compound<CH, 35, 5, 7, 1>;
    40: Compound<CH, 35, 5, 7, 2>;
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    /// Outputs for one tone of a frequency in units of the output rate.
    fn tone<const FACTOR: usize>(frequency: f64) -> Vec<(usize, f64)>
    where
        By<FACTOR>: Factor,
    {
        let mut chain = <By<FACTOR> as Factor>::Chain::<1>::NEW;
        let phase = |n: f64| core::f64::consts::TAU * frequency * n / FACTOR as f64;
        let push = |n: usize| chain.push([phase(n as f64).cos() as f32]).map(|y| (n, f64::from(y[0])));
        (0..80 * FACTOR).filter_map(push).collect()
    }

    fn check<const FACTOR: usize>()
    where
        By<FACTOR>: Factor,
    {
        type Chain<const FACTOR: usize> = <By<FACTOR> as Factor>::Chain<1>;
        let (delay, latency) = (Chain::<FACTOR>::DELAY, Chain::<FACTOR>::LATENCY);
        assert_eq!(Chain::<FACTOR>::FACTOR, FACTOR);
        let mut worst = [0.0_f64; 2];
        for frequency in [0.0, 0.013, 0.1, 0.27, 0.4] {
            for (n, y) in tone::<FACTOR>(frequency) {
                assert_eq!((n - latency) % FACTOR, Chain::<FACTOR>::NEWEST, "by {FACTOR}, sample {n}");
                let at = (n - latency - delay) as f64 / FACTOR as f64;
                worst[0] = worst[0].max((y - (core::f64::consts::TAU * frequency * at).cos()).abs());
            }
        }
        for image in 1..=FACTOR / 2 {
            for off in [-0.4, -0.31, 0.07, 0.4] {
                let most = tone::<FACTOR>(image as f64 + off).iter().fold(0.0, |most: f64, (_, y)| most.max(y.abs()));
                worst[1] = worst[1].max(most);
            }
        }
        std::println!(
            "by {FACTOR}: delay {delay} + {latency}, passes within {:.1e}, stops to {:.1e}",
            worst[0],
            worst[1]
        );
        // 0.003 dB and 80 dB, with 5e-6 of rounding.
        assert!(worst[0] < 3.5e-4 && worst[1] < 1.05e-4, "by {FACTOR}: {worst:?}");
        assert!(FACTOR == 1 || (worst[0] > 3e-5 && worst[1] > 3e-5), "by {FACTOR}: too good: {worst:?}");
    }

    #[test]
    fn every_chain_passes_its_band_with_one_delay_and_stops_what_aliases() {
        check::<1>();
        check::<2>();
        check::<4>();
        check::<8>();
        check::<16>();
        check::<32>();
        check::<6>();
        check::<12>();
        check::<24>();
        check::<48>();
        check::<10>();
        check::<20>();
        check::<40>();
    }

    #[test]
    fn taps_are_symmetric_since_every_frequency_has_one_delay() {
        for taps in [&BY_3[..], &BY_5] {
            let mirrored: Vec<f32> = taps.iter().rev().copied().collect();
            assert_eq!(taps, mirrored);
        }
    }
}
