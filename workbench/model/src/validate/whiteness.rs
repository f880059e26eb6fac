//! A quick test of residuals for colour.

use statrs::distribution::{ChiSquared, ContinuousCDF as _};

/// Largest lag.
const LAGS: usize = 25;
/// Probability that white residuals are called coloured.
const RATE: f64 = 1e-3;

/// Whether residuals are white by the test of Ljung and Box over 25 lags, which calls white ones coloured once in a
/// thousand; true for fewer than 100 residuals.
#[must_use]
pub fn is_white(residuals: &[f64]) -> bool {
    let n = residuals.len();
    let power: f64 = residuals.iter().map(|e| e * e).sum();
    let Ok(law) = ChiSquared::new(LAGS as f64) else { return true };
    if n < 4 * LAGS || power <= 0.0 {
        return true;
    }
    let share = |lag: usize| {
        let sum: f64 = residuals[lag..].iter().zip(residuals).map(|(later, e)| later * e).sum();
        (sum / power).powi(2) / (n - lag) as f64
    };
    let statistic = (n * (n + 2)) as f64 * (1..=LAGS).map(share).sum::<f64>();
    statistic <= law.inverse_cdf(1.0 - RATE)
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    #[test]
    fn white_passes_and_slightly_coloured_fails() {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let (mut white, mut coloured) = (0, 0);
        for _ in 0..200 {
            let e: Vec<f64> = (0..1001).map(|_| StandardNormal.sample(&mut rng)).collect();
            white += usize::from(is_white(&e));
            let v: Vec<f64> = e.windows(2).map(|pair| pair[1] + 0.3 * pair[0]).collect();
            coloured += usize::from(!is_white(&v));
        }
        // One in a thousand: more than two of 200 has the probability 0.1 %. Correlation 0.28 at lag 1 is 9 deviations.
        assert!(white >= 198 && coloured == 200, "{white} {coloured}");
    }
}
