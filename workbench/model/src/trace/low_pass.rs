//! Coefficients of short low-pass filters for [`bearing_watch::drive::FirDecimator`] before half-band filters.

use nalgebra::{DMatrix, DVector};

use crate::trace::minimax::minimax;

/// Designs a symmetric filter of 2 `pairs` + 1 taps for decimation by `factor` before decimation by 2 or more, with the
/// least maximum error.
///
/// It passes 0 … 0.2 of its output rate and stops what aliases into this band; between these bands, where later filters
/// stop, nothing is asked. The gain for constants is one.
#[must_use]
pub fn before_half_bands(factor: usize, pairs: usize) -> Vec<f64> {
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

#[cfg(test)]
mod tests {
    use super::*;

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
}
