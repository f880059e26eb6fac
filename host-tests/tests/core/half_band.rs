//! Decimation by half-band stages, 20 kHz → 1.25 kHz, against direct sums and against its limits; and by 20 with a last
//! odd factor.

use std::f64::consts::TAU;

use bearing_watch::drive::{FirDecimator, HalfBandDecimator, HalfBandTaps};
use model::trace::prepare;

use crate::filter_design::half_band;

const RATE_HZ: f64 = 20_000.0;

type By16 = HalfBandDecimator<1, 3, 4, 13>;

fn by_16(x: &[f64]) -> Vec<f64> {
    let mut decimator = By16::new();
    x.iter().filter_map(|x| decimator.push(&HalfBandTaps::SHARP, [*x as f32])).map(|y| f64::from(y[0])).collect()
}

/// One stage as it is defined: an output for every second sample, zeros before the first.
fn stage(x: &[f64], outer: &[f32]) -> Vec<f64> {
    let pairs = outer.len() as isize;
    let at = |n: isize| usize::try_from(n).map_or(0.0, |n| x[n]);
    let output = |newest: usize| {
        let centre = newest as isize - 2 * pairs + 1;
        let pair = |j: isize| {
            let off = 2 * pairs - 1 - 2 * j;
            f64::from(outer[j as usize]) * (at(centre - off) + at(centre + off))
        };
        0.5 * at(centre) + (0..pairs).map(pair).sum::<f64>()
    };
    (1..x.len()).step_by(2).map(output).collect()
}

fn tone(frequency_hz: f64, seconds: f64) -> Vec<f64> {
    (0..(seconds * RATE_HZ) as usize).map(|n| (TAU * frequency_hz * n as f64 / RATE_HZ + 0.3).sin()).collect()
}

#[test]
fn sixteenth_rate_equals_four_direct_convolutions() {
    let x: Vec<f64> = tone(37.0, 1.0)
        .iter()
        .zip(tone(411.0, 1.0))
        .zip(tone(6100.0, 1.0))
        .map(|((a, b), c)| 0.1 + 0.4 * a + 0.3 * b + 0.2 * c)
        .collect();
    let taps = HalfBandTaps::SHARP;
    let early = (0..3).fold(x.clone(), |x, _| stage(&x, &taps.early));
    let direct = stage(&early, &taps.last);
    let skipped = By16::TAPS.div_ceil(16) - 1; // outputs that reach before the first sample
    let ours = by_16(&x);
    // One second is 1250 outputs; the last may still be under way.
    assert!(ours.len() + skipped == 1250 || ours.len() + skipped == 1249, "{}", ours.len());
    for (k, (ours, direct)) in ours.iter().zip(&direct[skipped..]).enumerate() {
        assert!((ours - direct).abs() < 5e-7, "{k}: {ours} {direct}"); // single precision
    }
}

#[test]
fn tones_of_the_band_pass_late_and_others_are_eighty_decibels_down() {
    for frequency in [3.0, 100.0, 250.0, 499.0] {
        let first = By16::TAPS.next_multiple_of(16) - 1; // the newest sample of the first output
        for (k, y) in by_16(&tone(frequency, 1.0)).iter().enumerate() {
            let at = (first + 16 * k - By16::DELAY) as f64 / RATE_HZ;
            let wanted = (TAU * frequency * at + 0.3).sin();
            assert!((y - wanted).abs() < 3e-4, "{frequency} Hz, {k}: {y} {wanted}");
        }
    }
    // Whatever would land within ±500 Hz: all that is within 500 Hz of a multiple of 1250 Hz.
    for image in (1..=8).map(|k| 1250.0 * f64::from(k)) {
        for off in [-500.0, -333.0, -20.0, 20.0, 333.0, 500.0] {
            if image + off < RATE_HZ / 2.0 {
                let most = host_tests::peak(by_16(&tone(image + off, 1.0)));
                assert!(most < 1.05e-4, "{image} {off}: {most}"); // 80 dB, and rounding
            }
        }
    }
}

#[test]
fn constants_of_the_core_are_the_design() {
    let check = |ours: &[f32], pass_band: f64| {
        for (ours, design) in ours.iter().zip(half_band(ours.len(), pass_band)) {
            assert!((f64::from(*ours) - design).abs() < 1e-7, "{ours} {design}");
        }
    };
    check(&HalfBandTaps::SHARP.early, 0.1);
    check(&HalfBandTaps::SHARP.last, 0.2);
    check(&HalfBandTaps::GENTLE.last, 0.1);
}

/// 20 kHz → 5 kHz by gentle half bands → 1 kHz by a long filter, which alone decides the band.
#[test]
fn an_odd_factor_comes_last() {
    const TAPS: usize = 219;
    let taps: Vec<f32> = prepare::anti_alias(5).iter().map(|tap| *tap as f32).collect();
    let taps: [f32; TAPS] = taps.try_into().expect("the length that the design gives for this factor");
    let by_20 = |x: &[f64]| {
        let mut half_bands = HalfBandDecimator::<1, 1, 4, 4>::new();
        let mut fir = FirDecimator::<1, TAPS, 5, { TAPS.div_ceil(5) }>::new();
        let push = |x: &f64| half_bands.push(&HalfBandTaps::GENTLE, [*x as f32]).and_then(|x| fir.push(&taps, x));
        x.iter().filter_map(push).map(|y| f64::from(y[0])).collect::<Vec<_>>()
    };
    let kept = host_tests::peak(by_20(&tone(390.0, 1.0)));
    assert!((kept - 1.0).abs() < 2e-3, "{kept}");
    for frequency in [501.0, 990.0, 2510.0, 4900.0, 5300.0, 9700.0] {
        let most = host_tests::peak(by_20(&tone(frequency, 1.0)));
        assert!(most < 1e-3, "{frequency}: {most}"); // the long filter's 60 dB
    }
}
