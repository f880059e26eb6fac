//! How far a segment lies from the healthy class, whatever else it may resemble.
//!
//! Enters: z, projected coordinates. Leaves: distance and surprise.
//!
//! ```text
//! d² = ‖U (z − m)‖²,   UᵀU = S⁻¹                                         (1)
//! s  = −ln P(d² at least this large | healthy)                           (2)  nats
//! novel where s ≥ −ln α                                                  (3)
//! ```
//!
//! m and S are mean and covariance of the healthy training segments, U is lower triangular. With Gaussian features and
//! n healthy segments of p coordinates, d² of a further one follows p(n²−1)/(n(n−p)) F(p, n−p) (Hotelling 1931), so (3)
//! has the false-alarm rate α in the mean over training sets; the workbench takes a heavier tail where the training
//! segments show one. (2) comes as knots with straight lines between. The surprise of a healthy segment has mean 1 nat;
//! 4.6 nats are one in a hundred.
//! Cost: Z(Z+3)/2 multiply-adds, one square root, a walk along the knots.

use super::discriminant::whiten;

/// Knots of the surprise.
pub const KNOTS: usize = 24;
/// The surprise goes no higher, nats: no training set speaks of rarer things.
pub const MAX_SURPRISE: f32 = 40.0;
/// Stands for the healthy class where there is none.
pub const NO_CLASS: u8 = u8::MAX;

/// The healthy class as a region. Places beyond the coordinates in use are zero.
///
/// ```
/// use bearing_watch::decide::Novelty;
/// // Healthy: one coordinate, mean 2, deviation 0.5; the surprise grows by ½ a unit of d².
/// let mut novelty = Novelty { class: 0, mean: [2.0], whitening: [[2.0]], limit: 4.6, ..Novelty::NONE };
/// for (k, knot) in novelty.knots.iter_mut().enumerate() {
///     *knot = [2.0 * k as f32, k as f32];
/// }
/// let (distance, surprise) = novelty.judge(&[4.0]);
/// assert_eq!((distance, surprise), (4.0, 8.0));
/// assert!(surprise >= novelty.limit);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Novelty<const Z: usize> {
    /// Index of the healthy class; [`NO_CLASS`] where none is known, and then nothing is novel.
    pub class: u8,
    /// m.
    pub mean: [f32; Z],
    /// U, by rows.
    pub whitening: [[f32; Z]; Z],
    /// (d², s) on the curve (2), both rising from the first, which is as a rule (0, 0).
    pub knots: [[f32; 2]; KNOTS],
    /// −ln α of (3), nats; infinite where distances are told but nothing is called novel.
    pub limit: f32,
}

impl<const Z: usize> Novelty<Z> {
    /// No healthy class: every distance and surprise is zero.
    pub const NONE: Self = Self {
        class: NO_CLASS,
        mean: [0.0; Z],
        whitening: [[0.0; Z]; Z],
        knots: [[0.0; 2]; KNOTS],
        limit: f32::INFINITY,
    };

    /// Distance √(1) and surprise (2).
    #[must_use]
    pub fn judge(&self, z: &[f32; Z]) -> (f32, f32) {
        if self.class == NO_CLASS {
            return (0.0, 0.0);
        }
        let mut centred = *z;
        for (x, mean) in centred.iter_mut().zip(&self.mean) {
            *x -= mean;
        }
        let squared = whiten(&self.whitening, &centred).iter().fold(0.0, |sum, x| sum + x * x); // (1)
        (libm::sqrtf(squared), self.surprise(squared))
    }

    /// (2) by straight lines between the knots, before the first and beyond the last along the nearest one, within 0 and
    /// [`MAX_SURPRISE`]. Not a number stays so.
    #[must_use]
    pub fn surprise(&self, squared: f32) -> f32 {
        let [[x0, s0], [x1, s1]] = nearest(&self.knots, squared);
        let surprise = s0 + (squared - x0) * ((s1 - s0) / (x1 - x0));
        if surprise.is_nan() { surprise } else { surprise.clamp(0.0, MAX_SURPRISE) }
    }
}

/// The two knots around, or the nearest two. Not inlined, where it would be unrolled: flash is dear.
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

    fn curve() -> Novelty<2> {
        let mut novelty =
            Novelty { class: 0, mean: [1.0, -1.0], whitening: [[0.5, 0.0], [0.25, 2.0]], ..Novelty::NONE };
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
    fn the_curve_goes_on_along_its_last_line_to_the_cap() {
        let curve = curve();
        assert_eq!((curve.surprise(0.0), curve.surprise(4.0), curve.surprise(529.0)), (0.0, 2.0, 23.0));
        // The last line rises by 1 over 529 − 484.
        assert!((curve.surprise(529.0 + 90.0) - 25.0).abs() < 1e-5);
        assert_eq!((curve.surprise(1e30), curve.surprise(f32::INFINITY)), (MAX_SURPRISE, MAX_SURPRISE));
        assert!(curve.surprise(f32::NAN).is_nan());
    }

    #[test]
    fn without_a_healthy_class_nothing_is_said() {
        assert_eq!(Novelty::<2>::NONE.judge(&[1e9, f32::NAN]), (0.0, 0.0));
    }
}
