//! Coefficients of half-band filters for [`bearing_watch::drive::HalfBandDecimator`].

use nalgebra::{DMatrix, DVector};

use crate::trace::minimax::minimax;

/// Designs the filter with the least maximum error in the pass band.
///
/// `pairs` is the number of pairs of equal taps, outermost first; `pass_band` is a fraction of the filter's own
/// sampling rate, below 0.25. The stop band begins at 0.5 − `pass_band`. The gain for constants is one.
#[must_use]
pub fn design(pairs: usize, pass_band: f64) -> Vec<f64> {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_pair_passes_constants_and_three_are_equally_wrong_at_every_peak() {
        assert_eq!(design(1, 0.01), [0.25]);
        let taps = design(3, 0.1);
        let error = |f: f64| {
            let angle = |k: usize| std::f64::consts::TAU * f * (5 - 2 * k) as f64;
            taps.iter().enumerate().map(|(k, tap)| 2.0 * tap * angle(k).cos()).sum::<f64>() - 0.5
        };
        let errors: Vec<f64> = (0..=1000).map(|k| error(1e-4 * f64::from(k))).collect();
        let (least, most) = errors.iter().fold((0.0_f64, 0.0_f64), |(a, b), e| (a.min(*e), b.max(*e)));
        // 62 dB; the condition of gain one for constants shifts one side of the ripple to zero.
        assert!(most - least < 2.0 * 7.4e-4 && most - least > 5e-4, "{least} {most}");
    }
}
