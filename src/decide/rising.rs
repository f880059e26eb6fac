//! Coordinates of which only larger values than usual show a defect, such as the scores of bearing orders.
//!
//! Enters: the distance of the other coordinates, and the scores of the rising ones given those before them
//! ([`super::density`]). Leaves: the surprise of both together.
//!
//! ```text
//! d²_i = y_1²/D'_1 + … + y_i²/D'_i,     y, D' of all coordinates, the K rising ones last     (1)
//! s_d  = −ln P(d²_{Z−K} at least this large)
//! u_i  = y_i/√(D'_i (1 + d²_{i−1}/ν)),   i > Z − K                                           (2)
//! s_u  = −ln(1 − (1 − p)^K),   p = P(U ≥ max u_i)                                            (3)
//! s    = S − ln(1 + S),   S = s_d + s_u                                                      (4)  Fisher 1932
//! ```
//!
//! A distance in Z coordinates contains the noise of those that a defect leaves alone, and of both directions of each:
//! an order that is 2.3 standard deviations too strong is improbable at 1 % by itself, but in the distance in five
//! coordinates it takes 3.9. In (4), 2.9 are enough on average. (2) is the score of a coordinate given those before it,
//! independent of their distance if all are normal; mean and covariance are estimated, which its second factor and the
//! laws of d² and u account for. P(U ≥ u) is half of P(U² ≥ u²), for u < 0 the rest.
//!
//! Without available rising coordinates s is `s_d`, without others `s_u`. Where all features of a record scatter with
//! one common factor, the two surprises depend on each other, and the rate is up to twice the set one.

use core::f32::consts::LN_2;

use super::ln;
use super::novelty::{KNOTS, equivalent, surprise};

/// The rising coordinates and the laws of (1) and (2).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Rising {
    /// K.
    pub count: u8,
    /// ν.
    pub freedom: f32,
    /// (u², −ln P(U² ≥ u²)) of one coordinate, both increasing.
    pub knots: [[f32; 2]; KNOTS],
    /// (d², `s_d`) of the others, both increasing; not used without others.
    pub others: [[f32; 2]; KNOTS],
}

/// Squared distances, and the largest score of the rising coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Scores {
    /// d² of all coordinates, and the number of available ones.
    pub squared: f32,
    pub available: usize,
    /// The same of all but the rising ones.
    pub squared_others: f32,
    pub others: usize,
    /// max u of (2); zero without available ones.
    pub largest: f32,
}

impl Scores {
    /// Adds y²/D' of the next coordinate; one with an infinite D' is not available.
    pub(super) fn add(&mut self, y: f32, pivot: f32, rising: Option<&Rising>) {
        if pivot >= f32::INFINITY {
            return;
        }
        if let Some(rising) = rising {
            let u = y / libm::sqrtf(pivot * (1.0 + self.squared / rising.freedom)); // (2)
            let first = self.available == self.others;
            self.largest = if first || u > self.largest || u.is_nan() { u } else { self.largest };
        }
        self.squared += y * (y / pivot);
        self.available = self.available.saturating_add(1);
        if rising.is_none() {
            (self.squared_others, self.others) = (self.squared, self.available);
        }
    }
}

impl Rising {
    /// No coordinate.
    pub const NONE: Self = Self { count: 0, freedom: 1.0, knots: [[0.0; 2]; KNOTS], others: [[0.0; 2]; KNOTS] };

    /// (4) of scores with rising coordinates, of `coordinates` in all.
    #[inline(never)]
    pub(super) fn surprise(&self, scores: &Scores, coordinates: usize) -> f32 {
        if scores.available == 0 {
            return 0.0;
        }
        let all = coordinates.saturating_sub(self.count as usize);
        let of_others = surprise(&self.others, equivalent(scores.squared_others, scores.others, all));
        let count = scores.available.saturating_sub(scores.others);
        if count == 0 {
            return of_others;
        }
        let of_rising = self.of_largest(scores.largest, count as f32);
        if scores.others == 0 {
            return of_rising;
        }
        let sum = of_others + of_rising;
        sum - ln(1.0 + sum) // (4)
    }

    /// (3).
    #[inline(never)]
    fn of_largest(&self, u: f32, count: f32) -> f32 {
        let one_sided = surprise(&self.knots, u * u) + LN_2;
        let half = libm::expf(-one_sided);
        let p = if u < 0.0 { 1.0 - half } else { half };
        if u >= 0.0 && count * p < RARE {
            return one_sided - ln(count);
        }
        // A NaN stays, since it is not less than zero.
        let s = -ln(1.0 - libm::expf(count * ln(1.0 - p)));
        if s < 0.0 { 0.0 } else { s }
    }
}

/// Below this probability, 1 − (1 − p)^K is K p but for a part of it so small.
const RARE: f32 = 1e-3;

#[cfg(test)]
mod tests {
    use super::*;

    /// Surprise u² of one coordinate, d²/2 of the others.
    fn rising(count: u8) -> Rising {
        let mut rising = Rising { count, freedom: 10.0, ..Rising::NONE };
        for (k, (one, others)) in (0_u8..).zip(rising.knots.iter_mut().zip(&mut rising.others)) {
            (*one, *others) = ([f32::from(k); 2], [2.0 * f32::from(k), f32::from(k)]);
        }
        rising
    }

    /// Scores of (y, D') of two others and then of rising ones.
    fn scores(rising: &Rising, values: &[[f32; 2]]) -> Scores {
        let mut scores = Scores::default();
        for (k, [y, pivot]) in values.iter().enumerate() {
            scores.add(*y, *pivot, (k >= 2).then_some(rising));
        }
        scores
    }

    fn judged(values: &[[f32; 2]]) -> f32 {
        let rising = rising(values.len() as u8 - 2);
        rising.surprise(&scores(&rising, values), values.len())
    }

    fn near(found: f32, expected: f32) {
        assert!((found - expected).abs() < 1e-5, "{found} for {expected}");
    }

    const MISSING: [f32; 2] = [3.0, f32::INFINITY];

    #[test]
    fn one_coordinate_by_hand() {
        // d² = 4/4 + 9/3 = 4: s_d = 2. u² = 16/2/(1 + 4/10) = 40/7, at most 1e-3 in (3).
        let sum: f32 = 2.0 + 40.0 / 7.0 + LN_2;
        near(judged(&[[2.0, 4.0], [3.0, 3.0], [4.0, 2.0]]), sum - (1.0 + sum).ln());
        // A coordinate that falls: p = 1 − e^−(40/7)/2.
        let sum: f32 = 2.0 - (1.0 - 0.5 * (-40.0_f32 / 7.0).exp()).ln();
        near(judged(&[[2.0, 4.0], [3.0, 3.0], [-4.0, 2.0]]), sum - (1.0 + sum).ln());
        // Without the rising one, and without the others.
        near(judged(&[[2.0, 4.0], [3.0, 3.0], MISSING]), 2.0);
        near(judged(&[MISSING, MISSING, [4.0, 2.0]]), 8.0 + LN_2);
        near(judged(&[MISSING; 3]), 0.0);
        let sum = judged(&[[2.0, 4.0], [f32::NAN, 3.0], [4.0, 2.0]]);
        assert!(sum.is_nan(), "{sum}");
    }

    #[test]
    fn the_largest_of_several_counts_once() {
        // No distance; u = 1 and then 2/√(1 + 1/10): p = e^−(40/11)/2.
        let values = [[0.0, 1.0], [0.0, 1.0], [1.0, 1.0], [2.0, 1.0]];
        let p = 0.5 * (-40.0_f64 / 11.0).exp();
        let sum = -(1.0 - (1.0 - p).powi(2)).ln();
        near(judged(&values), (sum - (1.0 + sum).ln()) as f32);
        // The first larger, and both so small that their product is lost.
        let [none, other, ..] = values;
        let sum = 9.0 + LN_2 - 2.0_f32.ln();
        near(judged(&[none, other, [3.0, 1.0], [-1.0, 1.0]]), sum - (1.0 + sum).ln());
        near(judged(&[none, other, [-1.0, 1.0], MISSING]), {
            let sum = -(1.0 - 0.5 * (-1.0_f32).exp()).ln();
            sum - (1.0 + sum).ln()
        });
    }

    #[test]
    fn far_values_stay_finite() {
        let far = judged(&[[1e18, 1.0], [0.0, 1.0], [1e18, 1e-3]]);
        assert!(far > 30.0 && far.is_finite(), "{far}");
        let near_zero = judged(&[[0.0, 1.0], [0.0, 1.0], [-1e18, 1e-3]]);
        assert!((0.0..1e-6).contains(&near_zero), "{near_zero}");
    }
}
