//! The false-alarm rate of a single gate, and the number of healthy segments that keeps it near the set rate.
//!
//! The mean rate over training sets is the set one; a single gate, trained on n segments, has the rate
//!
//! ```text
//! P(Σ wᵢ (gᵢ + δᵢ)² > c),   w = 1/λ,   δ = Qᵀm,   S = Q Λ Qᵀ             (1)
//! ```
//!
//! with g standard normal, m ~ N(0, I/n), (n−1) S ~ Wishart(n−1), and c the gate's d². Random draws of m and S
//! (Bartlett 1933) yield the distribution of (1). Each tail is computed by the saddle-point approximation (Kuonen
//! 1999), which has a relative error below 5 %.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{ChiSquared, Distribution, StandardNormal};
use statrs::function::erf::erfc;

use super::law::DistanceLaw;

/// One gate in twenty may exceed the set rate by more than this factor.
pub const BOUND: f64 = 3.0;
/// Upper limit of the search for the number needed.
const MOST: usize = 100_000;

/// Returns the rates of single gates trained on `rows` Gaussian segments, over random training sets, in ascending
/// order.
#[must_use]
pub fn gate_rates(coordinates: usize, rows: usize, rate: f64, draws: usize) -> Vec<f64> {
    let limit = DistanceLaw::gaussian(coordinates, rows).squared_at(-rate.ln());
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut rates: Vec<f64> = (0..draws).map(|_| single(coordinates, rows, limit, &mut random)).collect();
    rates.sort_by(f64::total_cmp);
    rates
}

/// Returns the smallest number of healthy segments for which 95 % of the gates have at most [`BOUND`] times the set
/// rate.
#[must_use]
pub fn rows_needed(coordinates: usize, rate: f64) -> usize {
    /// The numbers that were searched before: each fold of a validation needs the same one.
    static KNOWN: Mutex<BTreeMap<(usize, u64), usize>> = Mutex::new(BTreeMap::new());
    let key = (coordinates, rate.to_bits());
    let known = || KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    let before = known().get(&key).copied();
    before.unwrap_or_else(|| {
        let needed = searched_rows(coordinates, rate);
        known().insert(key, needed);
        needed
    })
}

/// The search of [`rows_needed`].
fn searched_rows(coordinates: usize, rate: f64) -> usize {
    let draws = (4000 / coordinates).clamp(60, 400);
    let bounded = |rows: usize| {
        let rates = gate_rates(coordinates, rows, rate, draws);
        rates[(0.95 * draws as f64) as usize] <= BOUND * rate
    };
    // Searches from above: with very few segments nearly all gates are far out and a few are useless, and the 95 %
    // criterion would accept them.
    let mut enough = 1500 + 20 * coordinates;
    while !bounded(enough) && enough < MOST {
        enough *= 2;
    }
    loop {
        let fewer = enough * 93 / 100;
        if fewer <= coordinates + 1 || !bounded(fewer) {
            return enough;
        }
        enough = fewer;
    }
}

/// Returns (1) for one random training set.
fn single(coordinates: usize, rows: usize, limit: f64, random: &mut ChaCha8Rng) -> f64 {
    let scatter = wishart(coordinates, rows - 1, random);
    let normal = |random: &mut ChaCha8Rng| -> f64 { StandardNormal.sample(random) };
    let mean = DVector::from_fn(coordinates, |_, _| normal(random) / (rows as f64).sqrt());
    let eigen = SymmetricEigen::new(scatter / (rows as f64 - 1.0));
    let shift = eigen.eigenvectors.transpose() * mean;
    let terms: Vec<(f64, f64)> =
        eigen.eigenvalues.iter().zip(shift.iter()).map(|(value, shift)| (1.0 / value, shift * shift)).collect();
    tail(&terms, limit)
}

/// Returns the scatter of so many standard normal vectors, of rank `degrees` at most.
pub(crate) fn wishart(coordinates: usize, degrees: usize, random: &mut ChaCha8Rng) -> DMatrix<f64> {
    if degrees < coordinates {
        let rows = DMatrix::from_fn(coordinates, degrees, |_, _| -> f64 { StandardNormal.sample(random) });
        return &rows * rows.transpose();
    }
    let mut factor = DMatrix::zeros(coordinates, coordinates);
    for i in 0..coordinates {
        factor[(i, i)] = ChiSquared::new((degrees - i) as f64).map_or(0.0, |law| law.sample(random)).sqrt();
        (0..i).for_each(|j| factor[(i, j)] = StandardNormal.sample(random));
    }
    &factor * factor.transpose()
}

/// Returns P(Σ w (g + δ)² > c) for terms (w, δ²).
pub(crate) fn tail(terms: &[(f64, f64)], limit: f64) -> f64 {
    let beyond = |x: f64| 0.5 * erfc(x / std::f64::consts::SQRT_2);
    if let [(w, shift)] = terms {
        let (far, shift) = ((limit / w).sqrt(), shift.sqrt());
        return beyond(far - shift) + beyond(far + shift);
    }
    let largest = terms.iter().map(|(w, _)| *w).fold(0.0, f64::max);
    // Alone, since the search needs no logarithm.
    let slope = |t: f64| {
        let each = |(w, shift): &(f64, f64)| {
            let u = 1.0 - 2.0 * w * t;
            w / u + w * shift / (u * u)
        };
        terms.iter().map(each).sum::<f64>()
    };
    let cumulant = |t: f64| {
        let each = |(w, shift): &(f64, f64)| {
            let u = 1.0 - 2.0 * w * t;
            (-0.5 * u.ln() + w * shift * t / u, 2.0 * w * w / (u * u) + 4.0 * w * w * shift / (u * u * u))
        };
        terms.iter().map(each).fold((0.0, 0.0), |sum, term| (sum.0 + term.0, sum.1 + term.1))
    };
    // The derivative of the cumulant generating function rises from 0 at −∞ to +∞ at 1/(2 w).
    let pole = 0.5 / largest;
    let beyond_mean = limit > slope(0.0);
    let (mut low, mut high) = if beyond_mean { (0.0, pole) } else { (-1e6 * pole, 0.0) };
    for _ in 0..if beyond_mean { 40 } else { 60 } {
        let middle = 0.5 * (low + high);
        if slope(middle) < limit { low = middle } else { high = middle }
    }
    let t = low;
    let (value, curvature) = cumulant(t);
    let r = (2.0 * (t * limit - value)).max(0.0).sqrt().copysign(t);
    if r.abs() < 1e-3 {
        return 0.5;
    }
    let argument = r + (t * curvature.sqrt() / r).ln() / r;
    beyond(argument)
}

#[cfg(test)]
mod tests {
    use super::*;
    use statrs::distribution::{ChiSquared as Exact, ContinuousCDF};

    #[test]
    fn saddle_points_are_near_exact_tails() {
        for (p, limit) in [(1, 6.6), (2, 9.2), (3, 11.3), (6, 22.5), (20, 60.0)] {
            let exact = Exact::new(f64::from(p)).expect("law").sf(limit);
            let got = tail(&vec![(1.0, 0.0); p as usize], limit);
            // The stated 5 %; for one coordinate the tail is exact.
            assert!((got / exact - 1.0).abs() < 0.05, "{p}: {got} for {exact}");
        }
        // One shifted coordinate: the sum of two normal tails.
        let exact = 0.5 * (erfc(2.0 / std::f64::consts::SQRT_2) + erfc(4.0 / std::f64::consts::SQRT_2));
        assert!((tail(&[(2.0, 1.0)], 18.0) / exact - 1.0).abs() < 1e-9);
    }

    #[test]
    fn single_gates_scatter_about_the_set_rate() {
        for (p, rows) in [(1, 30), (3, 30), (6, 100)] {
            let rates = gate_rates(p, rows, 0.01, 2000);
            let mean = rates.iter().sum::<f64>() / 2000.0;
            // 2000 draws whose deviation is about equal to their mean: 3 standard errors are 7 %; the saddle point adds
            // 5 %.
            assert!((mean / 0.01 - 1.0).abs() < 0.12, "{p} {rows}: {mean}");
        }
    }

    #[test]
    fn rarer_alarms_need_more_segments() {
        let needed = [(1, 1e-2), (1, 1e-3), (3, 1e-2), (3, 1e-3)].map(|(p, rate)| rows_needed(p, rate));
        println!("{needed:?}");
        // The second answer is that of the first search.
        assert_eq!(rows_needed(3, 1e-2), searched_rows(3, 1e-2));
        assert!(needed[0] < needed[1] && needed[2] < needed[3], "{needed:?}");
        // One coordinate: ln rate has the standard deviation (z² + 1)/√(2n), z = 2.58; 1.645 of them are ln 3 at n =
        // 65. Fewer suffice, as few segments put the median gate further out.
        assert!((30..65).contains(&needed[0]), "{needed:?}");
    }
}
