//! Decimation offline without phase and in the core with delay: the same filter, the same steady signals.

use std::f64::consts::TAU;

use bearing_watch::drive::FirDecimator;
use model::trace::prepare::anti_alias;
use model::trace::{Preparation, Trace};

const FACTOR: usize = 3;
const TAPS: usize = 131;
const SLOTS: usize = TAPS.div_ceil(FACTOR);

fn taps() -> [f32; TAPS] {
    let taps: Vec<f32> = anti_alias(FACTOR).iter().map(|tap| *tap as f32).collect();
    taps.try_into().expect("the length that the design gives for this factor")
}

fn causal(x: &[f64]) -> Vec<f64> {
    let (taps, mut fir) = (taps(), FirDecimator::<1, TAPS, FACTOR, SLOTS>::new());
    x.iter().filter_map(|x| fir.push(&taps, [*x as f32])).map(|y| f64::from(y[0])).collect()
}

fn offline(x: &[f64]) -> Vec<f64> {
    let y = x.to_vec();
    let trace = Trace {
        id: "x".into(),
        interval_s: None,
        irregular_steps: 0,
        u1: y.clone(),
        u2: y.clone(),
        y,
        motion: None,
        ..Trace::default()
    };
    Preparation { block_mean: 1, decimate: FACTOR }.apply(&trace).expect("long enough").y
}

fn tone(frequency: f64, shift: f64) -> Vec<f64> {
    (0..3000).map(|n| (TAU * frequency * (n as f64 - shift)).sin()).collect()
}

/// Amplitude, and phase against a sine of that frequency, of samples taken every `FACTOR`-th from `first` on.
fn phasor(y: &[f64], frequency: f64, first: f64) -> (f64, f64) {
    let (mut re, mut im) = (0.0, 0.0);
    for (k, y) in y.iter().enumerate() {
        let angle = TAU * frequency * (first + (k * FACTOR) as f64);
        re += y * angle.sin();
        im += y * angle.cos();
    }
    (2.0 * re.hypot(im) / y.len() as f64, im.atan2(re))
}

#[test]
fn a_sine_in_the_pass_band_keeps_its_amplitude_and_comes_half_the_taps_late() {
    let delay = (TAPS - 1) as f64 / 2.0;
    // 900 outputs hold whole periods of these frequencies.
    for frequency in [0.01, 0.04, 0.1] {
        let x = tone(frequency, 0.0);
        let (late, prompt) = (causal(&x), offline(&x));
        // Outputs end at samples 2, 5, …; the first once 131 samples are in, at sample 131.
        assert_eq!(late.len(), (3000 - 131) / FACTOR + 1);
        let first = 131.0;
        let (late_amplitude, late_phase) = phasor(&late[..900], frequency, first);
        let (amplitude, phase) = phasor(&prompt[50..950], frequency, 150.0);
        // The design's ripple is 70 dB down (3e-4) and the same in both; between them single precision.
        assert!((late_amplitude - amplitude).abs() < 1e-5, "{frequency}: {late_amplitude} {amplitude}");
        assert!((amplitude - 1.0).abs() < 1e-3, "{frequency}: {amplitude}");
        assert!(phase.abs() < 1e-6, "offline: no phase, {phase}");
        let turn = (late_phase + TAU * frequency * delay) / TAU;
        assert!((turn - turn.round()).abs() < 1e-5, "{frequency}: {turn} turns off the delay of {delay} samples");
    }
}

#[test]
fn causal_outputs_are_the_offline_ones_of_a_shifted_signal() {
    // The causal output at sample n is the zero-phase one at n − 65; 65 = 131 − 66 and 66 is a multiple of 3.
    let mixed: Vec<f64> = tone(0.03, 0.2).iter().zip(tone(0.21, 0.7)).map(|(a, b)| 5.0 + a + b).collect();
    let (late, prompt) = (causal(&mixed), offline(&mixed));
    for (k, late) in late.iter().enumerate().take(900) {
        let prompt = prompt[22 + k]; // sample 66 + 3k = 131 + 3k − 65
        assert!((late - prompt).abs() < 1e-5, "{k}: {late} {prompt}"); // 131 single-precision terms near 5
    }
}

#[test]
fn what_would_alias_is_sixty_decibels_down() {
    for frequency in [0.168, 0.2, 0.25, 0.33, 0.45] {
        let most = host_tests::peak(causal(&tone(frequency, 0.3)));
        assert!(most < 1e-3, "{frequency}: {most}");
    }
}
