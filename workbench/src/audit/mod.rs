//! What recordings are worth, before anything is trained: times, columns, pairs of columns, equal traces, and the
//! smallest line of an order that would stand out.

pub mod column;
pub mod orders;
pub mod pairs;
pub mod times;

/// Mean and standard deviation.
pub(crate) fn moments(x: &[f64]) -> (f64, f64) {
    let n = x.len().max(1) as f64;
    let mean = x.iter().sum::<f64>() / n;
    (mean, (x.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n).sqrt())
}

/// Median; NaN of nothing.
pub(crate) fn median(x: &[f64]) -> f64 {
    let mut sorted = x.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
}
