//! Power of a test for the bearing's order: (1) of [`bounds`](super).

use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::energy::{HARMONICS, Spall};

/// (1) at this false-alarm rate.
pub(super) fn order_power(spall: &Spall, severity: f64, rate: f64) -> f64 {
    by_harmonics(spall, rate, |harmonics| (2 * harmonics, spall.energy(severity, harmonics)))
}

/// The largest power of any number of harmonics, whose degrees of freedom and non-centrality `law` returns.
pub(super) fn by_harmonics(spall: &Spall, rate: f64, law: impl Fn(usize) -> (usize, f64)) -> f64 {
    let own = rate / spall.slips;
    // Another slip than the true one may exceed its threshold.
    let chance = 1.0 - (rate - own);
    let power_of = |(freedom, non_centrality)| 1.0 - (1.0 - power(freedom, non_centrality, own)) * chance;
    (1..=HARMONICS).map(|harmonics| power_of(law(harmonics))).fold(0.0, f64::max)
}

/// P(χ²(k, λ) > c), where a central χ² exceeds c at this rate: a Poisson mixture of central ones.
fn power(freedom: usize, non_centrality: f64, rate: f64) -> f64 {
    let law = |k: usize| ChiSquared::new(k as f64).ok();
    let Some(limit) = law(freedom).map(|law| law.inverse_cdf(1.0 - rate)) else { return f64::NAN };
    let half = 0.5 * non_centrality;
    // Beyond ten deviations of the mixture nothing remains.
    let (first, last) = ((half - 10.0 * half.sqrt()).max(0.0) as usize, (half + 10.0 * half.sqrt() + 20.0) as usize);
    if half > 2000.0 {
        return 1.0;
    }
    let weight =
        |n: usize| (n as f64 * half.max(1e-300).ln() - half - statrs::function::gamma::ln_gamma(n as f64 + 1.0)).exp();
    let term = |n: usize| weight(n) * law(freedom + 2 * n).map_or(0.0, |law| law.sf(limit));
    (first..=last).map(term).sum()
}

#[cfg(test)]
mod tests {
    use statrs::distribution::Normal;

    use super::*;

    #[test]
    fn a_power_is_that_of_the_known_law() {
        // Without a signal the set rate; one degree: P(|g + 3| > 2.5758) of a standard normal variable.
        for freedom in [1, 6, 13] {
            assert!((power(freedom, 0.0, 0.01) - 0.01).abs() < 1e-9);
        }
        let normal = Normal::standard();
        let exact = normal.sf(2.575_829 - 3.0) + normal.cdf(-2.575_829 - 3.0);
        assert!((power(1, 9.0, 0.01) - exact).abs() < 1e-6, "{}", power(1, 9.0, 0.01));
        assert!(power(6, 5000.0, 0.01) > 1.0 - 1e-9);
    }
}
