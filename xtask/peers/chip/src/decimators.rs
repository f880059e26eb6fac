//! Three channels decimated by 8, 80 dB of attenuation, band kept up to 0.8 of the new Nyquist frequency.

use core::f64::consts::{PI, TAU};
use core::hint::black_box;

use bearing_watch::drive::{FirDecimator, HalfBandDecimator, HalfBandTaps};

use crate::count::Counter;
use crate::decimation::{Spread, spread};

const CHANNELS: usize = 3;
const FACTOR: usize = 8;
/// Kaiser's formula for these bands; outputs come at whole multiples of the factor.
const TAPS: usize = 201;
/// Periods a sample of the test signal, within the band kept.
const FREQUENCY: f64 = 0.02;
/// Samples before the error is looked at.
const SETTLING: usize = 400;
const SAMPLES: usize = 1200;

type HalfBand = HalfBandDecimator<CHANNELS, 2, 4, 13>;

pub fn run(counter: &mut Counter) {
    let taps = kaiser();
    let mut half_band = HalfBand::new();
    let late = HalfBand::DELAY + HalfBand::LATENCY;
    race(counter, "bearing-watch", size_of::<HalfBand>(), late, |x| half_band.push(black_box(&HalfBandTaps::SHARP), x));

    type Fir = FirDecimator<CHANNELS, TAPS, FACTOR, { TAPS.div_ceil(FACTOR) }>;
    let mut fir = Fir::new();
    race(counter, "bearing-watch FirDecimator", size_of::<Fir>(), TAPS / 2, |x| fir.push(black_box(&taps), x));

    // Its output leaves out the block's later samples, FACTOR − 1 of them.
    let (mut theirs, late) = (Cmsis::new(), TAPS / 2 + FACTOR - 1);
    let name = "CMSIS-DSP 1.10.3 arm_fir_decimate_f32";
    race(counter, name, size_of::<Cmsis>(), late, |x| theirs.push(black_box(&taps), x));
}

/// Counts the samples of some outputs, then lets a sine through: the error is what the output differs from the
/// same sine `late` samples ago.
fn race(
    counter: &mut Counter,
    who: &str,
    bytes: usize,
    late: usize,
    mut push: impl FnMut([f32; CHANNELS]) -> Option<[f32; CHANNELS]>,
) {
    let Spread { mean, worst } = spread(counter, FACTOR, || {
        black_box(push(black_box([0.5; CHANNELS])));
    });
    let mut error = 0.0_f64;
    for n in 0..SAMPLES {
        let output = push([sine(n), -sine(n), 0.5 * sine(n)]);
        if let Some(output) = output
            && n >= SETTLING
        {
            let now = sine(n - late);
            for (y, x) in output.into_iter().zip([now, -now, 0.5 * now]) {
                let off = f64::from((y - x).abs());
                error = if error.is_nan() || off <= error { error } else { off };
            }
        }
    }
    for (what, instructions) in [("mean", mean), ("worst", worst)] {
        say!(
            r#"{{"work":"decimation by 8, 3 channels, {what} sample","who":"{who}","instructions":{instructions},"bytes":{bytes},"error":"{error:.1e}"}}"#
        );
    }
}

fn sine(n: usize) -> f32 {
    libm::sin(TAU * FREQUENCY * n as f64) as f32
}

/// Low-pass with Kaiser's window, from 0.8 to 1.2 of the new Nyquist frequency.
fn kaiser() -> [f32; TAPS] {
    const CUTOFF: f64 = 0.5 / FACTOR as f64;
    let beta = 0.1102 * (80.0 - 8.7);
    let half = (TAPS / 2) as f64;
    let taps: [f64; TAPS] = core::array::from_fn(|j| {
        let k = j as f64 - half;
        let sinc = if k == 0.0 { 2.0 * CUTOFF } else { libm::sin(TAU * CUTOFF * k) / (PI * k) };
        sinc * bessel_i0(beta * libm::sqrt(1.0 - k * k / (half * half)))
    });
    let sum: f64 = taps.iter().sum();
    taps.map(|tap| (tap / sum) as f32)
}

/// Modified Bessel function I₀ by its power series.
fn bessel_i0(x: f64) -> f64 {
    let mut term = 1.0;
    (1..40).fold(1.0, |sum, k| {
        term *= x * x / f64::from(4 * k * k);
        sum + term
    })
}

/// What a user of CMSIS-DSP does: a block of samples a channel, then one call a channel.
struct Cmsis {
    blocks: [[f32; FACTOR]; CHANNELS],
    history: [[f32; TAPS + FACTOR - 1]; CHANNELS],
    filled: usize,
}

unsafe extern "C" {
    fn cmsis_decimate(taps: *const f32, count: u16, history: *mut f32, factor: u8, block: *const f32) -> f32;
}

impl Cmsis {
    fn new() -> Self {
        let history = [[0.0; TAPS + FACTOR - 1]; CHANNELS];
        Self { blocks: [[0.0; FACTOR]; CHANNELS], history, filled: 0 }
    }

    fn push(&mut self, taps: &[f32; TAPS], x: [f32; CHANNELS]) -> Option<[f32; CHANNELS]> {
        for (block, x) in self.blocks.iter_mut().zip(x) {
            block[self.filled] = x;
        }
        self.filled = (self.filled + 1) % FACTOR;
        if self.filled > 0 {
            return None;
        }
        let mut output = [0.0; CHANNELS];
        for ((block, history), y) in self.blocks.iter().zip(&mut self.history).zip(&mut output) {
            let (taps, history) = (taps.as_ptr(), history.as_mut_ptr());
            // SAFETY: TAPS taps, TAPS + FACTOR − 1 cells of history, FACTOR samples, as the function asks.
            *y = unsafe { cmsis_decimate(taps, TAPS as u16, history, FACTOR as u8, block.as_ptr()) };
        }
        Some(output)
    }
}
