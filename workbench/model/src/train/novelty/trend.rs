//! The trend of healthy runs in their order: (5) and (6) of [`super::runs`].

use nalgebra::DVector;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Probability of a trend in any coordinate if the runs have none.
const SIGNIFICANT: f64 = 0.05;

/// A trend of the healthy runs in their order (5).
#[derive(Clone, Debug, PartialEq)]
pub struct Drift {
    /// Coordinates with a significant trend.
    pub coordinates: Vec<usize>,
    /// Expected distance of the next run from the mean of the training runs, in standard deviations of a segment.
    pub distance: f64,
}

impl Drift {
    /// Returns the number of runs after the last training run in which the drift of `count` runs reaches a distance
    /// (6).
    pub(crate) fn runs_to(&self, distance: f64, count: usize) -> f64 {
        let k = count as f64;
        0.5 * (k + 1.0) * distance * self.distance.hypot(1.0) / self.distance - 0.5 * (k - 1.0)
    }
}

/// Slope of the run means over the runs in one coordinate, in standard deviations of a segment a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slope {
    /// The slope.
    pub value: f64,
    /// Its standard error.
    pub error: f64,
}

/// Coordinates with a significant trend, and δ of (5).
pub(super) type Shift = (Vec<usize>, DVector<f64>);

/// Returns the trend of the run means in each coordinate, and, if any is significant, these coordinates and the
/// expected shift δ of the next run from the mean of all (5).
pub(super) fn trend(means: &[DVector<f64>]) -> (Vec<Slope>, Option<Shift>) {
    let k = means.len() as f64;
    let p = means.first().map_or(0, DVector::len);
    let Ok(law) = StudentsT::new(0.0, 1.0, k - 2.0) else { return (vec![], None) };
    let time = |run: usize| run as f64 - 0.5 * (k - 1.0);
    let squares = k * (k * k - 1.0) / 12.0;
    let slope = means.iter().enumerate().map(|(run, own)| own * time(run)).sum::<DVector<f64>>() / squares;
    let mean = means.iter().sum::<DVector<f64>>() / k;
    let of = |coordinate: usize| {
        let left = |(run, own): (usize, &DVector<f64>)| {
            (own[coordinate] - mean[coordinate] - slope[coordinate] * time(run)).powi(2)
        };
        let variance = means.iter().enumerate().map(left).sum::<f64>() / (k - 2.0) / squares;
        Slope { value: slope[coordinate], error: variance.sqrt() }
    };
    let slopes: Vec<Slope> = (0..p).map(of).collect();
    let significant = |&coordinate: &usize| {
        let Slope { value, error } = slopes[coordinate];
        2.0 * law.sf(value.abs() / error.max(f64::MIN_POSITIVE)) * (p as f64) < SIGNIFICANT
    };
    let coordinates: Vec<usize> = (0..p).filter(significant).collect();
    let found = (!coordinates.is_empty()).then(|| (coordinates, slope * (0.5 * (k + 1.0))));
    (slopes, found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trend_by_hand() {
        // Means 0, 1, 2, 4: slope 1.3, residual variance 0.3/2, t = 1.3/√(0.15/5) = 7.5 > 4.30; δ = 1.3 · 5/2.
        let means = [0.0, 1.0, 2.0, 4.0].map(|x| DVector::from_element(1, x));
        let (slopes, found) = trend(&means);
        let (coordinates, shift) = found.expect("significant");
        assert!(coordinates == [0] && (shift[0] - 3.25).abs() < 1e-12, "{shift}");
        assert!((slopes[0].value - 1.3).abs() < 1e-12 && (slopes[0].error - 0.03_f64.sqrt()).abs() < 1e-12);
        let (slopes, found) = trend(&[0.0, 3.0, 1.0, 4.0].map(|x| DVector::from_element(1, x)));
        assert!(found.is_none() && (slopes[0].value - 1.0).abs() < 1e-12);
        // δ at 2 deviations is 2/√5 from the covariance with δδᵀ: 3 deviations are 3.354 δ, 8.385 runs from the middle.
        let drift = Drift { coordinates, distance: 2.0 };
        assert!((drift.runs_to(3.0, 4) - 6.885).abs() < 1e-3, "{}", drift.runs_to(3.0, 4));
    }
}
