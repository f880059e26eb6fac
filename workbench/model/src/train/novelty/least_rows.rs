//! Number of independent segments that a false-alarm rate needs.

use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::law::DistanceLaw;

/// A gate is refused if its d² exceeds that of known mean and covariance by this factor: only the largest defects would
/// reach it.
const FARTHEST: f64 = 10.0;

/// Returns the smallest number of independent segments from which a gate can be trained that is not too far out for its
/// rate.
#[must_use]
pub fn fewest(coordinates: usize, rate: f64) -> usize {
    fewest_near(coordinates, rate, FARTHEST)
}

/// Returns the smallest number of rows from which a gate is near enough by [`is_near`].
pub(super) fn fewest_near(coordinates: usize, rate: f64, factor: f64) -> usize {
    let near = |&rows: &usize| is_near(coordinates, rows, rate, factor);
    (coordinates + 2..).take(1000).find(near).unwrap_or(coordinates + 1000)
}

/// Returns whether the d² of a gate of so many segments exceeds that of known mean and covariance by at most a factor.
pub(super) fn is_near(coordinates: usize, rows: usize, rate: f64, factor: f64) -> bool {
    let known = ChiSquared::new(coordinates as f64).map_or(f64::NAN, |law| law.inverse_cdf(1.0 - rate));
    DistanceLaw::gaussian(coordinates, rows).squared_at(-rate.ln()) <= factor * known
}
