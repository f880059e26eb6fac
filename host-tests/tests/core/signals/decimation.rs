//! Decimation by half-band stages whose taps are those of the least maximum error, and by 20 with a last odd factor.

use std::f64::consts::TAU;

use bearing_watch::drive::{FirDecimator, HalfBandDecimator, HalfBandTaps};
use model::trace::prepare;
use nalgebra::{DMatrix, DVector};

const RATE_HZ: f64 = 20_000.0;

fn tone(frequency_hz: f64, seconds: f64) -> Vec<f64> {
    (0..(seconds * RATE_HZ) as usize).map(|n| (TAU * frequency_hz * n as f64 / RATE_HZ + 0.3).sin()).collect()
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

/// Designs the filter with the least maximum error in the pass band.
///
/// `pairs` is the number of pairs of equal taps, outermost first; `pass_band` is a fraction of the filter's own
/// sampling rate, below 0.25. The stop band begins at 0.5 − `pass_band`. The gain for constants is one.
fn half_band(pairs: usize, pass_band: f64) -> Vec<f64> {
    const FREQUENCIES: usize = 400;
    // Response without the middle tap, which must be ½ in the pass band: Σ 2 c(k) cos(2π f (2k + 1)).
    let frequency = |row: usize| pass_band * row as f64 / (FREQUENCIES - 1) as f64;
    let cosines = DMatrix::from_fn(FREQUENCIES, pairs, |row, k| {
        2.0 * (std::f64::consts::TAU * frequency(row) * (2 * k + 1) as f64).cos()
    });
    let taps = minimax(&cosines, &DVector::from_element(FREQUENCIES, 0.5));
    let to_one = 0.25 / taps.sum();
    taps.iter().rev().map(|tap| tap * to_one).collect()
}

/// Designs a symmetric filter of 2 `pairs` + 1 taps for decimation by `factor` before decimation by 2 or more, with the
/// least maximum error.
///
/// It passes 0 … 0.2 of its output rate and stops what aliases into this band; between these bands, where later filters
/// stop, nothing is asked. The gain for constants is one.
fn before_half_bands(factor: usize, pairs: usize) -> Vec<f64> {
    const FREQUENCIES: usize = 200;
    let band = 0.2 / factor as f64;
    let grid = |from: f64, to: f64| (0..FREQUENCIES).map(move |k| from + (to - from) * k as f64 / 199.0);
    let images = (1..=factor / 2).map(|image| image as f64 / factor as f64);
    let stopped = images.flat_map(|image| grid(image - band, (image + band).min(0.5)));
    let frequencies: Vec<f64> = grid(0.0, band).chain(stopped).collect();
    let responses = DMatrix::from_fn(frequencies.len(), pairs + 1, |row, k| {
        let both = if k == 0 { 1.0 } else { 2.0 };
        both * (std::f64::consts::TAU * frequencies[row] * k as f64).cos()
    });
    let wanted = DVector::from_fn(frequencies.len(), |row, _| if row < FREQUENCIES { 1.0 } else { 0.0 });
    let taps = minimax(&responses, &wanted);
    let to_one = 1.0 / (taps[0] + 2.0 * taps.rows(1, pairs).sum());
    let half = taps.iter().map(|tap| tap * to_one);
    half.clone().rev().chain(half.skip(1)).collect()
}

/// Returns the coefficients x for which the largest element of |`columns` x − `wanted`| is about the least, by least
/// squares whose weights increase where the error is large (Lawson's method).
fn minimax(columns: &DMatrix<f64>, wanted: &DVector<f64>) -> DVector<f64> {
    const ROUNDS: usize = 200;
    let (rows, unknowns) = columns.shape();
    let mut weights = DVector::from_element(rows, 1.0 / rows as f64);
    let mut x = DVector::zeros(unknowns);
    for _ in 0..ROUNDS {
        let roots = weights.map(f64::sqrt);
        let weighted = DMatrix::from_fn(rows, unknowns, |row, k| roots[row] * columns[(row, k)]);
        let (q, r) = weighted.qr().unpack();
        let target = q.transpose() * roots.component_mul(wanted);
        x = r.solve_upper_triangular(&target).unwrap_or(x);
        weights.component_mul_assign(&(columns * &x - wanted).abs());
        weights /= weights.sum();
    }
    x
}

#[test]
fn one_pair_passes_constants_and_three_are_equally_wrong_at_every_peak() {
    assert_eq!(half_band(1, 0.01), [0.25]);
    let taps = half_band(3, 0.1);
    let error = |f: f64| {
        let angle = |k: usize| std::f64::consts::TAU * f * (5 - 2 * k) as f64;
        taps.iter().enumerate().map(|(k, tap)| 2.0 * tap * angle(k).cos()).sum::<f64>() - 0.5
    };
    let errors: Vec<f64> = (0..=1000).map(|k| error(1e-4 * f64::from(k))).collect();
    let (least, most) = errors.iter().fold((0.0_f64, 0.0_f64), |(a, b), e| (a.min(*e), b.max(*e)));
    // 62 dB; the condition of gain one for constants shifts one side of the ripple to zero.
    assert!(most - least < 2.0 * 7.4e-4 && most - least > 5e-4, "{least} {most}");
}

/// Largest errors in the pass band and in the stop bands.
fn errors(factor: usize, pairs: usize) -> [f64; 2] {
    let taps = before_half_bands(factor, pairs);
    let (mut passed, mut stopped) = (0.0_f64, 0.0_f64);
    for f in (0..=5000).map(|k| 1e-4 * f64::from(k)) {
        let phase = |n: usize| std::f64::consts::TAU * f * (n as f64 - pairs as f64);
        let gain: f64 = taps.iter().enumerate().map(|(n, tap)| tap * phase(n).cos()).sum();
        let outputs = f * factor as f64;
        match (outputs - outputs.round()).abs() <= 0.2 {
            true if outputs.round() == 0.0 => passed = passed.max((gain - 1.0).abs()),
            true => stopped = stopped.max(gain.abs()),
            false => {}
        }
    }
    [passed, stopped]
}

#[test]
fn these_numbers_of_taps_stop_80_db_and_fewer_do_not() {
    for (factor, pairs) in [(3, 11), (5, 17)] {
        let [passed, stopped] = errors(factor, pairs);
        println!("by {factor}: {passed:.2e} {stopped:.2e}");
        assert!((3e-5..1e-4).contains(&stopped) && passed < 2.1e-4, "by {factor}: {passed} {stopped}");
        assert!(errors(factor, pairs - 1)[1] > 1e-4, "by {factor}");
        println!("{:?}", before_half_bands(factor, pairs).iter().map(|x| *x as f32).collect::<Vec<_>>());
    }
}
