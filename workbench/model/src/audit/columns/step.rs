//! The values of a column that are not missing, and the step of its sensor: the smallest difference of them.

use std::borrow::Cow;

use crate::statistics::mean_sd;

/// The smallest difference of two values, which is that of the sensor's counts.
#[must_use]
pub fn step(x: &[f64]) -> f64 {
    let mut sorted = finite(x).into_owned();
    sorted.sort_by(f64::total_cmp);
    least_difference(&sorted, mean_sd(&sorted).1)
}

/// The values that are not missing.
pub(crate) fn finite(x: &[f64]) -> Cow<'_, [f64]> {
    if x.iter().all(|x| x.is_finite()) {
        Cow::Borrowed(x)
    } else {
        Cow::Owned(x.iter().copied().filter(|x| x.is_finite()).collect())
    }
}

/// The smallest difference of sorted values above the rounding of values with this deviation.
pub(crate) fn least_difference(sorted: &[f64], deviation: f64) -> f64 {
    let differences = sorted.windows(2).map(|pair| pair[1] - pair[0]);
    differences.filter(|step| *step > 1e-12 * deviation).fold(f64::INFINITY, f64::min)
}
