//! Mean and standard deviation over repetitions.

/// Mean and standard deviation (N − 1); the standard deviation is zero for a single value.
#[must_use]
pub fn mean_sd(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n.max(1.0);
    let squares: f64 = values.iter().map(|x| (x - mean).powi(2)).sum();
    (mean, (squares / (n - 1.0).max(1.0)).sqrt())
}

/// Mean and standard deviation of rates, in percent.
#[must_use]
pub fn mean_sd_percent(rates: &[f64]) -> (f64, f64) {
    let (mean, sd) = mean_sd(rates);
    (100.0 * mean, 100.0 * sd)
}
