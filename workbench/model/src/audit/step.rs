//! The step of a sensor: the smallest difference of its values.

use crate::statistics::mean_sd;

/// The smallest difference of two values, which is that of the sensor's counts.
#[must_use]
pub fn step(x: &[f64]) -> f64 {
    let mut sorted: Vec<f64> = x.iter().copied().filter(|x| x.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    least_difference(&sorted, mean_sd(&sorted).1)
}

/// The smallest difference of sorted values above the rounding of values with this deviation.
pub(super) fn least_difference(sorted: &[f64], deviation: f64) -> f64 {
    let differences = sorted.windows(2).map(|pair| pair[1] - pair[0]);
    differences.filter(|step| *step > 1e-12 * deviation).fold(f64::INFINITY, f64::min)
}
