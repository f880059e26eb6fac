//! Coordinates of which larger values than usual are a defect, as in the core, in double precision.
//!
//! ```text
//! u_i = y_i/√(1 + d²_{i−1}/ν),   s = −ln(1 − (1 − min p)^M)                (1)  y_i: score given those before it
//! p: of the distance of the others, and min(P(U_i ≥ u_i), P(U_i ≤ u_i)/φ) of each rising coordinate
//! M: 1 for the others, 1 + φ for each rising coordinate
//! f = u⁺/u⁻,   P(U ≥ u⁺) = P(U ≤ −u⁻) = φ p*;   reach = u* + u₁₀,   P(U ≥ u*) = p*,   P(U ≤ −u₁₀) = 0.1   (2)
//! ```
//!
//! p* is the probability of one value at the limit of all. φ = 0.1 is the part of a fall in the false alarms.
//!
//! The law of U (`super::score`) follows from the scores `y_i` of the healthy segments themselves, less the degrees of
//! freedom of the regression on the others; if runs count, it is symmetric and that of a run's distance. Each
//! coordinate has a law of its own: the friction of a drive has heavier tails than the score of an order.

use std::f64::consts::LN_2;

use bearing_watch::model::{KNOTS, Law, Rise};
use nalgebra::{DMatrix, DVector};

use super::knots::{knots, knots_of};
use super::law::{DistanceLaw, equivalent};
use super::score::ScoreLaw;
use crate::train::distribution::moments;

/// φ, as in the core.
const FALLS: f64 = 0.1;

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
    pub(crate) fn surprise(
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
        let rising = each.len() as f64;
        each.extend(of_others);
        Some(rarest(&each, each.len() as f64 + FALLS * rising))
    }

    /// The surprise that one value needs for a gate with this limit.
    fn own(&self, limit: f64) -> f64 {
        let rising = self.laws.len() as f64;
        let all = (1.0 + FALLS) * rising + if self.others.is_some() { 1.0 } else { 0.0 };
        let p = -(-(-limit).exp()).ln_1p() / all;
        -(-(-p).exp_m1()).ln()
    }

    /// Returns (2) of each rising coordinate for a gate with this limit, behind a placeholder.
    #[must_use]
    pub fn rises(&self, limit: f64) -> Vec<Rise> {
        let own = self.own(limit);
        let each = |law: &ScoreLaw| {
            let (fall, below) = (own - FALLS.ln(), law.mirrored());
            let reach = law.at(own, 0.0) + below.at(10_f64.ln(), 0.0);
            Rise { fall: (law.at(fall, 0.0) / below.at(fall, 0.0)) as f32, reach: reach as f32 }
        };
        std::iter::once(Rise::NONE).chain(self.laws.iter().map(each)).collect()
    }

    /// Returns the core's laws for a gate with this limit.
    #[must_use]
    pub fn core(&self, limit: f64) -> Vec<Law> {
        // The knot at the limit is that of one of all values.
        let own = self.own(limit);
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

/// Returns −ln P(U ≥ u), at most ½ for u ≥ 0; for u < 0 the rarer of the probability that the law leaves to U < |u|, as
/// in the core, and of a fall.
fn one_sided(law: &ScoreLaw, u: f64) -> f64 {
    let far = law.surprise(u.abs()).max(LN_2);
    if u >= 0.0 {
        return far;
    }
    (-(-(-far).exp()).ln_1p()).max(law.mirrored().surprise(-u) + FALLS.ln())
}

/// Returns s of (1) of surprises that count as so many; 0 without any.
fn rarest(surprises: &[f64], count: f64) -> f64 {
    let p = (-surprises.iter().fold(0.0_f64, |most, s| most.max(*s))).exp();
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
        // 1 % of two rising values and the others.
        let of_one = 1.0 - 0.99_f64.powf(1.0 / 3.2);
        for (law, expected) in [(laws[0], -of_one.ln()), (laws[1], -(2.0 * of_one).ln())] {
            // The rounding of single precision.
            assert!(law.iter().any(|[_, s]| (f64::from(*s) - expected).abs() < 1e-5), "{expected}");
        }
        let u = law.at(-of_one.ln(), 0.0);
        assert!((rarest(&[one_sided(&law, u), 0.3, one_sided(&law, -1.0)], 3.2) - limit).abs() < 1e-9);
        assert!(rarest(&[], 0.0).abs() < 1e-15 && rarest(&[0.0], 1.0).abs() < 1e-15);
        // A fall reaches the limit where it is ten times as rare; on both sides the symmetric law is one.
        let fall = law.at(-of_one.ln() + 10_f64.ln(), 0.0);
        assert!((one_sided(&law, -fall) + of_one.ln()).abs() < 1e-9);
        let rise = rising.rises(limit)[1];
        assert!((rise.fall - 1.0).abs() < 1e-6);
        assert!((f64::from(rise.reach) - u - law.at(10_f64.ln(), 0.0)).abs() < 1e-5, "{rise:?}");
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
