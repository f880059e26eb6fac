//! The distance of a segment from the healthy class, whatever other class it resembles.
//!
//! Enters: z, projected coordinates. Leaves: distance and surprise.
//!
//! ```text
//! d² = ‖U (z − m)‖²,   UᵀU = S⁻¹                                         (1)
//! s  = −ln P(d² at least this large | healthy)                           (2)  nats
//! novel if s ≥ −ln α                                                     (3)
//! ```
//!
//! m and S are mean and covariance of the healthy training segments, U is lower triangular. With Gaussian features and
//! n healthy segments of p coordinates, d² of a further segment follows p(n²−1)/(n(n−p)) F(p, n−p) (Hotelling 1931).
//! Then (3) has the false-alarm rate α on average over training sets; the workbench uses a heavier tail if the training
//! segments show one. (2) is stored as knots with straight lines between them. The surprise of a healthy segment has
//! mean 1 nat; a surprise of 4.6 nats has probability 0.01. Cost: Z(Z+3)/2 multiply-adds, one square root, a search
//! among the knots.

use super::discriminant::squared_distance;
use crate::plan::{Array, Cells, Plan};

/// Number of knots of the surprise.
pub const KNOTS: usize = 24;
/// Largest surprise, nats: no training set supports smaller probabilities.
pub const MAX_SURPRISE: f32 = 40.0;

/// The distribution of the healthy class.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Novelty<P: Plan> {
    /// Index of the healthy class; `None` if none is known, and then nothing is novel.
    pub class: Option<u8>,
    /// m.
    pub mean: Array<P::Coordinates, f32>,
    /// U, lower triangle packed by rows.
    pub whitening: Array<P::Whitening, f32>,
    /// (d², s) on the curve (2), both increasing from the first, which usually is (0, 0).
    pub knots: [[f32; 2]; KNOTS],
    /// −ln α of (3), nats; infinite if distances are computed but nothing is called novel.
    pub limit: f32,
}

impl<P: Plan> Novelty<P> {
    /// Without a healthy class: every distance and surprise is zero.
    #[must_use]
    pub fn none(plan: P) -> Self {
        let layout = plan.layout();
        Self {
            class: None,
            mean: Cells::filled(layout.coordinates as usize, 0.0),
            whitening: Cells::filled(layout.whitening(), 0.0),
            knots: [[0.0; 2]; KNOTS],
            limit: f32::INFINITY,
        }
    }

    /// Distance √(1) and surprise (2).
    #[must_use]
    pub fn judge(&self, z: &[f32]) -> (f32, f32) {
        if self.class.is_none() {
            return (0.0, 0.0);
        }
        let squared = squared_distance(self.whitening.cells(), self.mean.cells(), z); // (1)
        (libm::sqrtf(squared), self.surprise(squared))
    }

    /// (2) by straight lines between the knots, outside them along the nearest line, within 0 and 40 nats. NaN
    /// gives NaN.
    #[must_use]
    pub fn surprise(&self, squared: f32) -> f32 {
        let [[x0, s0], [x1, s1]] = nearest(&self.knots, squared);
        let surprise = s0 + (squared - x0) * ((s1 - s0) / (x1 - x0));
        if surprise.is_nan() { surprise } else { surprise.clamp(0.0, MAX_SURPRISE) }
    }
}

/// The two knots around a value, or the nearest two.
#[inline(never)]
fn nearest(knots: &[[f32; 2]], squared: f32) -> [[f32; 2]; 2] {
    let mut line = [[0.0; 2]; 2];
    for pair in knots.windows(2) {
        if let [from, to] = pair {
            line = [*from, *to];
            if squared <= to[0] {
                break;
            }
        }
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{Layout, Memory, Method, RunTime, Structure, testing};
    use std::vec;

    fn plan() -> RunTime {
        let plain = testing::regression(Structure::new(1, 1, 0, 1, 0), Method::LeastSquares, Memory::Segment).layout();
        RunTime::of(Layout { coordinates: 2, ..plain }).unwrap()
    }

    fn curve() -> Novelty<RunTime> {
        let (mean, whitening) = (vec![1.0, -1.0], vec![0.5, 0.25, 2.0]);
        let mut novelty = Novelty { class: Some(0), mean, whitening, ..Novelty::none(plan()) };
        for (k, knot) in (0_u16..).zip(&mut novelty.knots) {
            *knot = [f32::from(k * k), f32::from(k)];
        }
        novelty
    }

    #[test]
    fn distance_by_hand() {
        // U (2, 1) = (1, 0.5 + 2) → d² = 7.25, between the knots (4, 2) and (9, 3).
        let (distance, surprise) = curve().judge(&[3.0, 0.0]);
        assert!((distance * distance - 7.25).abs() < 1e-6);
        assert!((surprise - 2.65).abs() < 1e-6);
    }

    #[test]
    fn the_curve_continues_along_its_last_line_to_the_largest_surprise() {
        let curve = curve();
        assert_eq!((curve.surprise(0.0), curve.surprise(4.0), curve.surprise(529.0)), (0.0, 2.0, 23.0));
        // The last line rises by 1 over 529 − 484.
        assert!((curve.surprise(529.0 + 90.0) - 25.0).abs() < 1e-5);
        assert_eq!((curve.surprise(1e30), curve.surprise(f32::INFINITY)), (MAX_SURPRISE, MAX_SURPRISE));
        assert!(curve.surprise(f32::NAN).is_nan());
    }

    #[test]
    fn without_a_healthy_class_distances_are_zero() {
        assert_eq!(Novelty::none(plan()).judge(&[1e9, f32::NAN]), (0.0, 0.0));
    }
}
