//! The law of a squared distance as knots, and what a distance over few coordinates is worth over all.
//!
//! The number (4) is that of [`super::novelty`].

use crate::logarithm::ln;

/// Number of knots of the surprise.
pub const KNOTS: usize = 24;
/// A law: (x, −ln P(X ≥ x)), both increasing from the first knot, which usually is (0, 0).
pub type Law = [[f32; 2]; KNOTS];
/// Largest surprise, nats: no training set supports smaller probabilities.
pub const MAX_SURPRISE: f32 = 40.0;

/// Surprise on a curve of knots, as [`Novelty::surprise`](super::Novelty::surprise).
#[inline(never)]
pub(crate) fn surprise(knots: &[[f32; 2]], squared: f32) -> f32 {
    let [[x0, s0], [x1, s1]] = nearest(knots, squared);
    let surprise = s0 + (squared - x0) * ((s1 - s0) / (x1 - x0));
    if surprise.is_nan() { surprise } else { surprise.clamp(0.0, MAX_SURPRISE) }
}

/// (4); without coordinates 0.
#[inline(never)]
pub(crate) fn equivalent(squared: f32, available: usize, all: usize) -> f32 {
    if available == all || available == 0 {
        return squared;
    }
    let to = all as f32;
    let other = 2.0 / (9.0 * to);
    let root = 1.0 - other + libm::sqrtf(other) * normal(squared, available);
    // A NaN stays, since it is not less than zero.
    if root < 0.0 { 0.0 } else { to * root * root * root }
}

/// u of (4).
#[inline(never)]
fn normal(squared: f32, available: usize) -> f32 {
    let count = available as f32;
    let variance = 2.0 / (9.0 * count);
    let mean = squared / count;
    let root = if mean > f32::MIN_POSITIVE { libm::expf(ln(mean) / 3.0) } else { mean };
    (root - 1.0 + variance) / libm::sqrtf(variance)
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
