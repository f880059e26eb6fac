//! Coordinates of which only larger values than usual are a defect, as in the core, in double precision.
//!
//! ```text
//! u_i = y_i/√(1 + d²_{i−1}/ν),   s_u = −ln(1 − (1 − P(U ≥ max u_i))^K)     (1)  y_i: score given those before it
//! s   = S − ln(1 + S),   S = s_d + s_u                                   (2)  s_d: of the distance of the others
//! ```
//!
//! U² has the law of the distance in one coordinate. It follows from the scores `y_i` of the healthy segments
//! themselves, those of all rising coordinates together, less the degrees of freedom of the regression on the others.
//! If the rate is that of the next run, it is the mean of the laws of gates of one coordinate each.

use std::f64::consts::LN_2;

use bearing_watch::model::{self, KNOTS};
use nalgebra::{DMatrix, DVector};

use super::knots::knots;
use super::law::{DistanceLaw, equivalent};
use crate::train::moments;

/// The rising coordinates of a gate, its last ones; fields as in [`bearing_watch::model::Rising`].
#[derive(Clone, Debug)]
pub struct Rising {
    /// Their number.
    pub count: usize,
    /// ν.
    pub freedom: f64,
    /// The law of u².
    pub law: DistanceLaw,
    /// The law of the distance of the others, if there are any.
    pub others: Option<DistanceLaw>,
}

impl Rising {
    /// Returns (2); `None` if the covariance is singular.
    pub(super) fn surprise(
        &self,
        healthy: (&DVector<f64>, &DMatrix<f64>),
        (value, variance): (&DVector<f64>, &DVector<f64>),
    ) -> Option<f64> {
        let scores = moments::conditional_scores(healthy, value, variance)?;
        let first = value.len() - self.count;
        let (mut squared, mut of_others, mut largest, mut count) = (0.0, None, f64::NEG_INFINITY, 0);
        for (place, (k, y)) in scores.iter().enumerate() {
            if *k >= first {
                largest = largest.max(y / (1.0 + squared / self.freedom).sqrt());
                count += 1;
            }
            squared += y * y;
            if *k < first
                && let Some(law) = &self.others
            {
                of_others = Some(law.surprise(equivalent(squared, place + 1, first)));
            }
        }
        let of_rising = (count > 0).then(|| self.of_largest(largest, count));
        Some(match (of_others, of_rising) {
            (Some(a), Some(b)) => a + b - (a + b).ln_1p(),
            (a, b) => a.or(b).unwrap_or(0.0),
        })
    }

    /// Returns s_u.
    fn of_largest(&self, u: f64, count: i32) -> f64 {
        let half = (-self.law.surprise(u * u) - LN_2).exp();
        let p = if u < 0.0 { 1.0 - half } else { half };
        -(-(f64::from(count) * (-p).ln_1p()).exp_m1()).ln()
    }

    /// Returns the core's form for a gate with this limit.
    #[must_use]
    pub fn core(&self, limit: f64) -> model::Rising {
        let curve = |law: &DistanceLaw| knots(law, limit).map(|knot| knot.map(|x| x as f32));
        let others = self.others.as_ref().map_or([[0.0; 2]; KNOTS], curve);
        model::Rising { count: self.count as u8, freedom: self.freedom as f32, knots: curve(&self.law), others }
    }
}
