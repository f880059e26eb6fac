//! Decimation by the two filters of the core: instructions a sample, and bits.

use core::hint::black_box;

use bearing_watch::drive::{FirDecimator, HalfBandDecimator, HalfBandTaps};

use super::count::Counter;
use super::numbers::Numbers;

const CHANNELS: usize = 3;

type HalfBand<const EARLY: usize> = HalfBandDecimator<CHANNELS, EARLY, 4, 13>;

/// Instructions of the samples of a few outputs.
#[derive(Clone, Copy, Debug)]
pub struct Spread {
    /// Averaged.
    pub mean: u32,
    /// The longest.
    pub worst: u32,
}

/// Counts one by one the samples of eight outputs.
pub fn spread(counter: &mut Counter, factor: usize, mut push: impl FnMut()) -> Spread {
    let (mut sum, mut samples, mut worst) = (0, 0, 0);
    for _ in 0..8 * factor {
        let one = counter.instructions_per_call(1, |_| push());
        (sum, samples, worst) = (sum + one, samples + 1, worst.max(one));
    }
    Spread { mean: (sum + samples / 2) / samples.max(1), worst }
}

/// Three channels by 8 and by 16, and the long filter of the same bands (Kaiser window, 25.1 taps a unit of the
/// factor); `report` gets name, factor, instructions and bytes of state.
pub fn measure(counter: &mut Counter, report: impl Fn(&str, usize, u32, usize)) {
    half_band::<2>(counter, &report);
    half_band::<3>(counter, &report);
    fir::<201, 8, 26>(counter, &report);
    fir::<402, 16, 26>(counter, &report);
}

fn half_band<const EARLY: usize>(counter: &mut Counter, report: impl Fn(&str, usize, u32, usize)) {
    let (mut decimator, factor) = (HalfBand::<EARLY>::new(), HalfBand::<EARLY>::FACTOR);
    let taps = black_box(&HalfBandTaps::SHARP);
    let Spread { mean, worst } = spread(counter, factor, || {
        black_box(decimator.push(taps, black_box([0.5; CHANNELS])));
    });
    report("half-band decimation, 3 channels, mean sample", factor, mean, size_of_val(&decimator));
    report("half-band decimation, 3 channels, worst sample", factor, worst, size_of_val(&decimator));
}

fn fir<const TAPS: usize, const FACTOR: usize, const SLOTS: usize>(
    counter: &mut Counter,
    report: impl Fn(&str, usize, u32, usize),
) {
    let taps: [f32; TAPS] = Numbers(1).array();
    let mut decimator = FirDecimator::<CHANNELS, TAPS, FACTOR, SLOTS>::new();
    let Spread { mean, worst } = spread(counter, FACTOR, || {
        black_box(decimator.push(black_box(&taps), black_box([0.5; CHANNELS])));
    });
    report("FIR decimation, 3 channels, mean sample", FACTOR, mean, size_of_val(&decimator));
    report("FIR decimation, 3 channels, worst sample", FACTOR, worst, size_of_val(&decimator));
}

/// Hands every output of both filters to `add`, for a hash: equal on host and target.
pub fn bits(mut add: impl FnMut(&[f32])) {
    let mut numbers = Numbers(13);
    let taps: [f32; 43] = numbers.array();
    let (mut one, mut eight) = (HalfBand::<0>::new(), HalfBand::<2>::new());
    let mut fir = FirDecimator::<CHANNELS, 43, 5, 9>::new();
    for _ in 0..3000 {
        let sample: [f32; CHANNELS] = numbers.array();
        let outputs =
            [one.push(&HalfBandTaps::SHARP, sample), eight.push(&HalfBandTaps::SHARP, sample), fir.push(&taps, sample)];
        outputs.iter().flatten().for_each(|output| add(output));
    }
}
