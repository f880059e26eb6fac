//! Coordinates of which only larger values than usual are a defect, as in the core, in double precision.
//!
//! ```text
//! u_i = y_i/√(1 + d²_{i−1}/ν),   s = −ln(1 − (1 − min p)^M)                (1)  y_i: score given those before it
//! p: of the distance of the others, and P(U_i ≥ u_i) of each rising coordinate, M in all
//! ```
//!
//! The law of U (`super::score`) follows from the scores `y_i` of the healthy segments themselves, less the degrees of
//! freedom of the regression on the others; if runs count, it is symmetric and that of a run's distance. Each
//! coordinate has a law of its own: the friction of a drive has heavier tails than the score of an order.

use std::f64::consts::LN_2;

use bearing_watch::model::{KNOTS, Law};
use nalgebra::{DMatrix, DVector};

use super::knots::{knots, knots_of};
use super::law::{DistanceLaw, equivalent};
use super::score::ScoreLaw;
use crate::train::moments;

/// The rising coordinates of a gate, its last ones.
#[derive(Clone, Debug)]
pub struct Rising {
    /// ν.
    pub freedom: f64,
    /// The law of u of each.
    pub laws: Vec<ScoreLaw>,
    /// The law of the distance of the others, if there are any.
    pub others: Option<DistanceLaw>,
}

impl Rising {
    /// Returns s of (1); `None` if the covariance is singular.
    pub(super) fn surprise(
        &self,
        healthy: (&DVector<f64>, &DMatrix<f64>),
        (value, variance): (&DVector<f64>, &DVector<f64>),
    ) -> Option<f64> {
        let scores = moments::conditional_scores(healthy, value, variance)?;
        let first = value.len() - self.laws.len();
        let (mut squared, mut of_others, mut each) = (0.0, None, Vec::new());
        for (place, (k, y)) in scores.iter().enumerate() {
            if *k >= first {
                each.push(one_sided(&self.laws[*k - first], y / (1.0 + squared / self.freedom).sqrt()));
            }
            squared += y * y;
            if *k < first
                && let Some(law) = &self.others
            {
                of_others = Some(law.surprise(equivalent(squared, place + 1, first)));
            }
        }
        each.extend(of_others);
        Some(rarest(&each))
    }

    /// Returns the core's laws for a gate with this limit.
    #[must_use]
    pub fn core(&self, limit: f64) -> Vec<Law> {
        // The knot at the limit is that of one of all values.
        let own = -(-(-limit).exp()).ln_1p() / (self.laws.len() + usize::from(self.others.is_some())) as f64;
        let own = -(-(-own).exp_m1()).ln();
        let core = |knots: [[f64; 2]; KNOTS]| knots.map(|knot| knot.map(|x| x as f32));
        let others = self.others.as_ref().map_or([[0.0; 2]; KNOTS], |law| core(knots(law, own)));
        // −ln 2 P(U ≥ u) over u², from the u ≥ 0 on at which it is zero.
        let each = |law: &ScoreLaw| {
            let (least, mut u) = ((law.surprise(0.0) - LN_2).max(0.0), 0.0);
            let at = |surprise: f64| {
                u = law.at(surprise + LN_2, u);
                u * u
            };
            core(knots_of(at, least, own - LN_2))
        };
        std::iter::once(others).chain(self.laws.iter().map(each)).collect()
    }
}

/// Returns −ln P(U ≥ u), at most ½ for u ≥ 0; for u < 0 the probability that the law leaves to U < |u|, as in the core.
/// The exact one matters to no gate: no value below the mean is rare.
fn one_sided(law: &ScoreLaw, u: f64) -> f64 {
    let far = law.surprise(u.abs()).max(LN_2);
    if u < 0.0 { -(-(-far).exp()).ln_1p() } else { far }
}

/// Returns s of (1) of surprises; 0 without any.
fn rarest(surprises: &[f64]) -> f64 {
    let p = (-surprises.iter().fold(0.0_f64, |most, s| most.max(*s))).exp();
    let count = surprises.len() as f64;
    if p >= 1.0 { 0.0 } else { -(-(count * (-p).ln_1p()).exp_m1()).ln() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn knots_of_each_law_are_where_the_limit_is_reached() {
        let law = ScoreLaw::symmetric(&DistanceLaw::gaussian(1, 200));
        let rising = Rising { freedom: 199.0, laws: vec![law.clone(); 2], others: Some(DistanceLaw::gaussian(2, 200)) };
        let limit = 100_f64.ln();
        let laws = rising.core(limit);
        // 1 % of three values is 0.33445 % of one.
        let of_one = 1.0 - 0.99_f64.powf(1.0 / 3.0);
        for (law, expected) in [(laws[0], -of_one.ln()), (laws[1], -(2.0 * of_one).ln())] {
            // The rounding of single precision.
            assert!(law.iter().any(|[_, s]| (f64::from(*s) - expected).abs() < 1e-5), "{expected}");
        }
        let u = law.at(-of_one.ln(), 0.0);
        assert!((rarest(&[one_sided(&law, u), 0.3, one_sided(&law, -1.0)]) - limit).abs() < 1e-9);
        assert!(rarest(&[]).abs() < 1e-15 && rarest(&[0.0]).abs() < 1e-15);
    }

    #[test]
    fn knots_of_skewed_laws_are_laws_of_the_core() {
        // Scores of both skews: their mean is not their median.
        let skewed: Vec<f64> = (0..150).map(|k| (f64::from(k) / 50.0 - 1.0).exp() - 1.17).collect();
        let mirrored: Vec<f64> = skewed.iter().map(|y| -y).collect();
        let [far, near] = [skewed, mirrored].map(|scores| ScoreLaw::of(150, &scores));
        assert!(far.surprise(0.0) > LN_2 + 0.05 && near.surprise(0.0) < LN_2 - 0.05, "{}", far.surprise(0.0));
        let rising = Rising { freedom: 149.0, laws: vec![far, near], others: None };
        for limit in [0.4, 100_f64.ln()] {
            for law in &rising.core(limit)[1..] {
                assert!(law.windows(2).all(|two| two[0][0] < two[1][0] && two[0][1] < two[1][1]), "{law:?}");
                assert!(law[0][0] >= 0.0 && law[0][1] >= 0.0, "{law:?}");
            }
        }
    }
}
