//! The distance of a segment from the healthy class, whatever other class it resembles, and the gates of all classes.
//!
//! Enters: z, projected coordinates with the variances v of their errors. Leaves: distance and surprise, and whether a
//! segment is beyond the gate of another class.
//!
//! ```text
//! d² = (z − m)ᵀ (S + diag(v))⁻¹ (z − m)                                  (1)  over the k available coordinates
//! s  = −ln P(d² at least this large | healthy)                           (2)  nats
//! novel if s ≥ −ln α                                                     (3)  s of [`super::rising`], if some rise
//! (d²_Z/Z)^⅓ = 1 − c_Z + √c_Z u,   u = ((d²_k/k)^⅓ − 1 + c_k)/√c_k,   c_n = 2/(9n)       (4)  if k < Z
//! beyond class j if s(d_j²/3²) ≥ −ln α,   d_j² as (1) of mean and covariance of the class                (5)
//! ```
//!
//! Posteriors compare the classes with each other: a segment far from all of them, as of a faulty sensor, gets the
//! class with the widest covariance, with a posterior of nearly 1. By (5) it is no segment of that class. The limit of
//! the distance is three times that of the healthy class, in standard deviations of the class: the law (2) of healthy
//! segments holds for another class only roughly, and a defect grows and differs from drive to drive. Without a healthy
//! class there is no law, and nothing is novel.
//!
//! m and S are mean and covariance of the healthy training segments. (2) is known for all Z coordinates; with k of
//! them, (4) gives the d² that is as improbable. u is nearly normal (Wilson and Hilferty 1931): for chi-square
//! distributions and up to 8 coordinates the surprise by (4) is within 0.04 nats up to 4.6 nats, 0.1 nats low at 6.9,
//! 0.35 at 9.2 and 1 at 13.8. With Gaussian features and n healthy segments of p coordinates, d² of a further segment
//! follows p(n²−1)/(n(n−p)) F(p, n−p) (Hotelling 1931). Then (3) has the false-alarm rate α on average over training
//! sets; the workbench uses a heavier tail if the training segments show one. (2) is stored as knots with straight
//! lines between them. The surprise of a healthy segment has mean 1 nat; a surprise of 4.6 nats has probability 0.01.
//! Cost: Z(Z+3)/2 multiply-adds, one square root, a search among the knots, and (3) of [`super::density`].

use super::density::Density;
use super::direction::Directions;
use super::law::{KNOTS, Law, equivalent, surprise};
use super::rising::{self, Fall, Most, Rarest, Rise, Scores};
use crate::plan::{Array, Cells, ClassifierLengths};

/// The distribution of the healthy class.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Novelty<P: ClassifierLengths> {
    /// Index of the healthy class; `None` if none is known, and then nothing is novel.
    pub class: Option<u8>,
    /// m.
    pub mean: Array<P::Coordinates, f32>,
    /// D and R of S = Rᵀ D R, as in [`Discriminant::factors`](crate::decide::Discriminant::factors).
    pub factor: Array<P::Density, f32>,
    /// The law (2) of d².
    pub knots: Law,
    /// With K rising coordinates the law of d² of the others, not used without others, and then that of the square of
    /// each rising one.
    pub laws: Array<P::Laws, Law>,
    /// Of each rising coordinate, in the order of the laws; the first one is not used.
    pub rises: Array<P::Laws, Rise>,
    /// Degrees of freedom of m and S; not used without rising coordinates.
    pub freedom: f32,
    /// The smallest defect that a segment shows may be so many times the usual one; with larger ones it is not called
    /// healthy.
    pub acceptable: f32,
    /// −ln α of (3), nats; infinite if distances are computed but nothing is called novel.
    pub limit: f32,
    /// The directions of defects, and the law of healthy runs in each.
    pub directions: Directions<P>,
}

/// Limit of the distance from another class over the limit for the healthy class, each in standard deviations of its
/// class: defects differ more between drives, and grow.
const WIDER: f32 = 3.0;

/// How far a segment is from the healthy class.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Departure {
    /// √(1).
    pub distance: f32,
    /// (2).
    pub distance_surprise: f32,
    /// The surprise that (3) compares: with rising coordinates that of the rarest value.
    pub surprise: f32,
    /// The coordinate that departs most.
    pub most: Option<Most>,
    /// The rarest fall of a rising coordinate.
    pub fall: Fall,
}

impl<P: ClassifierLengths> Novelty<P> {
    /// Without a healthy class: every distance and surprise is zero.
    #[must_use]
    pub fn none(plan: P) -> Self {
        let layout = plan.layout();
        Self {
            class: None,
            mean: Cells::filled(layout.coordinates as usize, 0.0),
            factor: Cells::filled(layout.density(), 0.0),
            knots: [[0.0; 2]; KNOTS],
            laws: Cells::filled(layout.laws(), [[0.0; 2]; KNOTS]),
            rises: Cells::filled(layout.laws(), Rise::NONE),
            freedom: 1.0,
            acceptable: f32::INFINITY,
            limit: f32::INFINITY,
            directions: Directions::none(plan),
        }
    }

    /// The departure of the coordinates z, whose errors have these variances: infinite for a missing coordinate, 0 for
    /// coordinates without a variance.
    #[must_use]
    pub fn judge(&self, z: &[f32], variances: &[f32]) -> Departure {
        if self.class.is_none() {
            return Departure::default();
        }
        let density = Density::<P>::of(self.factor.cells(), variances, z.len());
        let laws = self.laws.cells();
        let mut judged: Array<P::Laws, f32> = Cells::filled(laws.len(), rising::MISSING);
        let scores = density.scores(self.mean.cells(), z, self.freedom, judged.cells_mut());
        let departure = self.departure(&scores, z.len());
        if laws.is_empty() {
            return departure;
        }
        let Rarest { surprise, most, fall } =
            rising::rarest(laws, self.rises.cells(), judged.cells(), &scores, z.len());
        Departure { surprise, most, fall, ..departure }
    }

    /// Whether a segment at this squared distance (1) from a class, over the available ones of all coordinates, is
    /// beyond the gate of the class (5); never for the healthy class, whose gate is (3), and without one.
    #[inline(never)]
    #[must_use]
    pub fn excludes(&self, class: u8, squared: f32, [available, all]: [usize; 2]) -> bool {
        let nearer = squared / (WIDER * WIDER);
        match self.class {
            None => false,
            Some(healthy) if healthy == class => false,
            Some(_) => self.surprise(equivalent(nearer, available, all)) >= self.limit,
        }
    }

    /// (2) of d² by straight lines between the knots, outside them along the nearest line, within 0 and 40 nats. NaN
    /// gives NaN.
    #[must_use]
    pub fn surprise(&self, squared: f32) -> f32 {
        surprise(&self.knots, squared)
    }

    /// Distance and surprise of (1) over the available ones of all coordinates.
    fn departure(&self, scores: &Scores, all: usize) -> Departure {
        let squared = equivalent(scores.squared, scores.available, all);
        let (surprise, most) = (self.surprise(squared), scores.farthest());
        Departure { distance: libm::sqrtf(squared), distance_surprise: surprise, surprise, most, fall: Fall::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decide::MAX_SURPRISE;
    use crate::plan::{Layout, Memory, Method, Plan as _, RunTime, Structure, testing};
    use std::vec;

    fn plan() -> RunTime {
        let plain = testing::regression(Structure::new(1, 1, 0, 1, 0), Method::LeastSquares, Memory::Segment);
        RunTime::of(Layout { coordinates: 2, ..plain }).unwrap()
    }

    fn curve() -> Novelty<RunTime> {
        let (mean, factor) = (vec![1.0, -1.0], vec![4.0, -0.5, 0.25]);
        let mut novelty = Novelty { class: Some(0), mean, factor, ..Novelty::none(plan()) };
        for (k, knot) in (0_u16..).zip(&mut novelty.knots) {
            *knot = [f32::from(k * k), f32::from(k)];
        }
        novelty
    }

    #[test]
    fn distance_by_hand() {
        // S = [4 −2; −2 1.25]: R⁻ᵀ (2, 0.25) = (2, 1.25), so d² = 1 + 6.25 = 7.25,
        // between the knots (4, 2) and (9, 3).
        let Departure { distance, distance_surprise, surprise, .. } = curve().judge(&[3.0, -0.75], &[]);
        assert!((distance * distance - 7.25).abs() < 1e-6);
        assert!((surprise - 2.65).abs() < 1e-6 && surprise == distance_surprise);
        // With errors of variance 1 and 0.75, S = [5 −2; −2 2] of determinant 6: d² = (2·4 + 2·2·0.5 + 5·0.0625)/6.
        let Departure { distance, .. } = curve().judge(&[3.0, -0.75], &[1.0, 0.75]);
        assert!((distance * distance - 10.3125 / 6.0).abs() < 1e-6, "{distance}");
    }

    #[test]
    fn a_missing_coordinate_leaves_the_other() {
        // The first alone: d² = 2²/4 = 1. u = (1 − 1 + 2/9)/√(2/9) = 0.471405; (1 − 1/9 + u/3)³ = 1.144523.
        let Departure { distance, .. } = curve().judge(&[3.0, 9.0], &[0.0, f32::INFINITY]);
        assert!((distance * distance - 2.289_046).abs() < 1e-5, "{}", distance * distance);
        assert_eq!(curve().judge(&[3.0, 9.0], &[f32::INFINITY; 2]), Departure::default());
        assert!((0.0..0.1).contains(&equivalent(0.0, 1, 2)) && equivalent(0.0, 2, 1) == 0.0);
        assert!(equivalent(f32::NAN, 1, 2).is_nan() && equivalent(f32::INFINITY, 1, 2).is_infinite());
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
    fn the_gate_of_another_class_is_three_times_as_far() {
        // The surprise is 2 at a distance of 2.
        let gated = Novelty { limit: 2.0, ..curve() };
        assert!(gated.excludes(1, 36.1, [2, 2]) && !gated.excludes(1, 35.9, [2, 2]));
        assert!(!gated.excludes(0, 1e9, [2, 2]), "the healthy class");
        assert!(!Novelty { class: None, ..gated.clone() }.excludes(1, 1e9, [2, 2]), "no law");
        assert!(!Novelty { limit: f32::INFINITY, ..gated.clone() }.excludes(1, 1e9, [2, 2]), "no limit");
        // One coordinate as improbable as 4 over both (4): u = ((4/2)^⅓ − 1 + 1/9)·3 = 1.113097, so that the ninth of
        // its square is (1 − 2/9 + √(2/9) u)³ = 2.2097.
        assert!(gated.excludes(1, 9.0 * 2.215, [1, 2]) && !gated.excludes(1, 9.0 * 2.205, [1, 2]));
        assert!(!gated.excludes(1, f32::NAN, [2, 2]));
    }

    #[test]
    fn without_a_healthy_class_distances_are_zero() {
        assert_eq!(Novelty::none(plan()).judge(&[1e9, f32::NAN], &[]), Departure::default());
    }
}
