//! Coordinates of which only larger values than usual show a defect, such as the scores of bearing orders.
//!
//! Enters: the coordinates' scores given those before them ([`super::density`]). Leaves: the surprise of the rarest of
//! the distance of the other coordinates and each rising one.
//!
//! ```text
//! d²_i = y_1²/D'_1 + … + y_i²/D'_i,     y, D' of all Z coordinates, the K rising ones last       (1)
//! p_0  = P(d²_{Z−K} at least this large)
//! u_i  = y_i/√(D'_i (1 + d²_{i−1}/ν)),   p_i = P(U_i ≥ u_i),   i > Z − K                         (2)
//! s    = −ln(1 − (1 − min p)^M),   M: number of available values p                               (3)  Tippett 1931
//! ```
//!
//! A distance in Z coordinates contains the noise of coordinates that a defect does not change, and does not
//! distinguish the two directions of each. For a probability of 1 %, an order by itself must be 2.3 standard deviations
//! too strong, but 3.9 in a distance in five coordinates; by (3), one of three rising coordinates beside a distance
//! needs 2.8. (2) is the score of a coordinate given those before it, independent of their distance if all are normal;
//! mean and covariance are estimated with ν degrees of freedom, which its second factor and the laws of d² and u
//! account for. Each u has a law of its own, whose knots are −ln 2 P(U ≥ u) over u², u ≥ 0. Values below the mean are
//! never rare: for u < 0 the probability is 1 − P(U ≥ |u|). For independent values (3) is exact; if they are correlated
//! and their laws are known, the rate is lower than the set one.

use core::f32::consts::LN_2;

use super::law::{Law, equivalent, surprise};
use crate::logarithm::ln;
use crate::regression::factor::pairs;

/// A value that is not available.
pub(crate) const MISSING: f32 = f32::NEG_INFINITY;

/// Squared distances and numbers of available coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Scores {
    /// d² of all coordinates, and the number of available ones.
    pub squared: f32,
    pub available: usize,
    /// The number of available ones before the rising coordinates.
    pub others: usize,
}

impl Scores {
    /// Takes y and D' of the next coordinate, which `after` others follow; one with an infinite D' is not available.
    /// `judged` gets d² of the others and u of each rising coordinate.
    pub(crate) fn add(&mut self, y: f32, pivot: f32, after: usize, freedom: f32, judged: &mut [f32]) {
        let rising = judged.get_mut(1..).unwrap_or_default();
        let is_missing = pivot >= f32::INFINITY;
        let cell = rising.len().checked_sub(after.wrapping_add(1)).and_then(|place| rising.get_mut(place));
        let rises = cell.is_some();
        if let Some(cell) = cell {
            let u = y / libm::sqrtf(pivot * (1.0 + self.squared / freedom)); // (2)
            *cell = if is_missing { MISSING } else { u };
        }
        if is_missing {
            return;
        }
        self.squared += y * (y / pivot);
        self.available = self.available.saturating_add(1);
        if !rises {
            self.others = self.available;
            if let Some(of_others) = judged.first_mut() {
                *of_others = self.squared;
            }
        }
    }
}

/// s of (3), of d² of the others and then u of each rising coordinate, which are overwritten: so many of the others are
/// available, of so many coordinates in all.
#[inline(never)]
pub(crate) fn rarest(laws: &[Law], judged: &mut [f32], [others, coordinates]: [usize; 2]) -> f32 {
    let all_others = coordinates.saturating_sub(laws.len().saturating_sub(1));
    for (k, (law, value)) in pairs(0..usize::MAX, pairs(laws, &mut *judged)) {
        if *value != MISSING {
            *value = if k == 0 { surprise(law, equivalent(*value, others, all_others)) } else { far(law, *value) };
        }
    }
    let (p, count) = smallest(judged);
    together(p, count)
}

/// −ln P(U ≥ |u|), negative for a negative u.
fn far(law: &Law, u: f32) -> f32 {
    let far = surprise(law, u * u) + LN_2;
    if u < 0.0 { -far } else { far }
}

/// min p and M.
#[inline(never)]
fn smallest(judged: &[f32]) -> (f32, f32) {
    let [of_others, rising @ ..] = judged else { return (1.0, 0.0) };
    // Of values below the mean, the one nearest to it has the smallest P(U ≥ u).
    let (mut rarest, mut count) = (MISSING, 0.0);
    for s in rising.iter().filter(|s| **s != MISSING) {
        count += 1.0;
        rarest = if *s > rarest || s.is_nan() { *s } else { rarest };
    }
    let near = libm::expf(-rarest.abs());
    let p = if rarest < 0.0 { 1.0 - near } else { near };
    if *of_others == MISSING {
        return (p, count);
    }
    let of_others = libm::expf(-*of_others);
    (if of_others > p || p.is_nan() { p } else { of_others }, count + 1.0)
}

/// (3).
#[inline(never)]
fn together(p: f32, count: f32) -> f32 {
    if count * p < RARE {
        if count > 0.0 { -ln(p * count) } else { 0.0 }
    } else if p >= 1.0 {
        // A NaN is not.
        0.0
    } else {
        -ln(1.0 - libm::expf(count * ln(1.0 - p)))
    }
}

/// Below this probability p, the difference of 1 − (1 − p)^M and M p is negligible.
const RARE: f32 = 1e-3;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decide::KNOTS;
    use std::vec;
    use std::vec::Vec;

    /// Surprise d²/2 of the others, u² and then 2 u² of the rising ones.
    fn laws(count: usize) -> Vec<Law> {
        let line = |slope: f32| core::array::from_fn(|k| [k as f32, slope * k as f32]);
        (0..=count).map(|k| line(0.5 * 2.0_f32.powi(k as i32))).collect()
    }

    /// The surprise of (y, D') of two others and then of rising ones, with ν = 10.
    fn judged(values: &[[f32; 2]]) -> f32 {
        let laws = laws(values.len() - 2);
        let (mut judged, mut scores) = (vec![MISSING; laws.len()], Scores::default());
        for (k, [y, pivot]) in values.iter().enumerate() {
            scores.add(*y, *pivot, values.len() - 1 - k, 10.0, &mut judged);
        }
        rarest(&laws, &mut judged, [scores.others, values.len()])
    }

    fn near(surprise: f32, expected: f64) {
        // Half of `RARE`.
        assert!((f64::from(surprise) - expected).abs() < 5e-4, "{surprise} for {expected}");
    }

    /// (3) of the smallest of so many probabilities.
    fn of(p: f64, count: i32) -> f64 {
        -(1.0 - (1.0 - p).powi(count)).ln()
    }

    const MISS: [f32; 2] = [3.0, f32::INFINITY];

    #[test]
    fn the_rarer_of_distance_and_coordinate_counts() {
        assert_eq!(laws(1)[1].len(), KNOTS);
        // d² = 4/4 + 9/3 = 4: p₀ = e⁻². u² = 16/2/(1 + 4/10) = 40/7.
        near(judged(&[[2.0, 4.0], [3.0, 3.0], [4.0, 2.0]]), of(0.5 * (-40.0_f64 / 7.0).exp(), 2));
        // A coordinate that falls leaves the distance, whatever its size.
        near(judged(&[[2.0, 4.0], [3.0, 3.0], [-4.0, 2.0]]), of((-2.0_f64).exp(), 2));
        // Without the rising one, without the others, and without any.
        near(judged(&[[2.0, 4.0], [3.0, 3.0], MISS]), 2.0);
        near(judged(&[MISS, MISS, [4.0, 2.0]]), 8.0 + std::f64::consts::LN_2);
        near(judged(&[MISS; 3]), 0.0);
        let sum = judged(&[[2.0, 4.0], [f32::NAN, 3.0], [4.0, 2.0]]);
        assert!(sum.is_nan(), "{sum}");
    }

    #[test]
    fn each_coordinate_has_a_law_of_its_own() {
        // No distance; u² = 1 with the surprise 1, and 4/(1 + 1/10) with twice as much.
        let [none, other] = [[0.0, 1.0]; 2];
        near(judged(&[none, other, [1.0, 1.0], [2.0, 1.0]]), of(0.5 * (-80.0_f64 / 11.0).exp(), 3));
        // So small that a sum of probabilities is enough.
        near(judged(&[none, other, [3.0, 1.0], [-1.0, 1.0]]), 9.0 + 2.0_f64.ln() - 3.0_f64.ln());
        // A coordinate that is missing does not count.
        near(judged(&[none, other, [1.0, 1.0], MISS]), of(0.5 * (-1.0_f64).exp(), 2));
        near(judged(&[none, other, MISS, [-1.0, 1.0]]), of(1.0 - 0.5 * (-2.0_f64).exp(), 2));
    }

    #[test]
    fn far_values_stay_finite() {
        let far = judged(&[[1e18, 1.0], [0.0, 1.0], [1e18, 1e-3]]);
        assert!(far > 30.0 && far.is_finite(), "{far}");
        let near_zero = judged(&[[0.0, 1.0], [0.0, 1.0], [-1e18, 1e-3]]);
        assert!((0.0..1e-6).contains(&near_zero), "{near_zero}");
    }
}
