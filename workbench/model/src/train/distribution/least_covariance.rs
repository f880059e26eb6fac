//! The least covariance of a class of few rows with errors.
//!
//! With few rows the restricted likelihood is largest where Σ is nearly singular: the errors of some rows explain their
//! spread, and the others are too few for all directions. Such a class would call most of its new rows novel. So Σ is
//! in every direction at least the standard error of the covariance that was observed:
//!
//! ```text
//! Σ ≥ √(2/(n − C)) S,   S = n/(n − C) Σ_i w_i (f_i − m)(f_i − m)ᵀ / Σ_i w_i,   w_i = min_k s_k/(s_k + v_ik)   (1)
//! ```
//!
//! over the complete rows, with the means m of the rows in S, the variance s_k of feature k alone, and n = (Σ w)²/Σ w².
//! √(2/(n − C)) is the relative standard error of a variance in S. The weights keep a few rows with large errors from
//! widening the class. Without errors S is the sample covariance, which is above its part.
//!
//! Rows are given by their count, mean and scatter ([`Cell`]).

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::covariance::symmetric;

/// The least covariance by (1), of features with these variances alone; `None` of too few complete rows.
pub(crate) fn least(cells: &[Cell], classes: usize, alone: &DVector<f64>) -> Option<DMatrix<f64>> {
    let weight = |cell: &Cell| {
        let parts = alone.iter().zip(cell.variance.iter()).map(|(own, error)| own / (own + error));
        parts.fold(1.0, f64::min)
    };
    let complete = cells.iter().filter(|cell| cell.variance.iter().all(|v| v.is_finite()));
    let weighted: Vec<(f64, &Cell)> = complete.map(|cell| (weight(cell), cell)).collect();
    let sum = |power: i32| weighted.iter().map(|(weight, cell)| cell.count * weight.powi(power)).sum::<f64>();
    let freedom = sum(1).powi(2) / sum(2) - classes as f64;
    let part = (2.0 / freedom).sqrt().min(1.0) / (sum(1) * freedom / (freedom + classes as f64));
    (freedom > 0.0).then(|| within(&weighted, classes) * part)
}

/// A covariance that is at least `least` in every direction, and changed in no direction in which it was; `None` if
/// `least` is singular.
pub(crate) fn raised(covariance: &DMatrix<f64>, least: DMatrix<f64>) -> Option<DMatrix<f64>> {
    let factor = least.cholesky()?.unpack();
    let half = factor.solve_lower_triangular(covariance)?;
    let whitened = symmetric(&factor.solve_lower_triangular(&half.transpose())?);
    let SymmetricEigen { eigenvalues, eigenvectors } = whitened.symmetric_eigen();
    let missing = eigenvalues.map(|value| (1.0 - value).max(0.0));
    let axes = factor * eigenvectors;
    Some(symmetric(&(covariance + &axes * DMatrix::from_diagonal(&missing) * axes.transpose())))
}

/// Rows of one class whose values have the same variances of their errors.
#[derive(Clone, Debug)]
pub struct Cell {
    /// Index of the class.
    pub class: usize,
    /// Number of rows.
    pub count: f64,
    /// Variances of the errors.
    pub variance: DVector<f64>,
    /// Mean of the rows; of missing values any number.
    pub mean: DVector<f64>,
    /// Scatter of the rows about it; of missing values any number.
    pub scatter: DMatrix<f64>,
}

/// Weighted scatter about the weighted means of the classes.
pub(crate) fn within(cells: &[(f64, &Cell)], classes: usize) -> DMatrix<f64> {
    let features = cells.first().map_or(0, |(_, cell)| cell.mean.len());
    let mut scatter = DMatrix::zeros(features, features);
    for class in 0..classes {
        let own = || cells.iter().filter(move |(_, cell)| cell.class == class);
        let sum = own().map(|(weight, cell)| weight * cell.count).sum::<f64>();
        let mean = own().fold(DVector::zeros(features), |mean, (w, cell)| mean + &cell.mean * (w * cell.count / sum));
        for (weight, cell) in own() {
            let away = &cell.mean - &mean;
            scatter.ger(weight * cell.count, &away, &away, 1.0);
            scatter += &cell.scatter * *weight;
        }
    }
    scatter
}

#[cfg(test)]
mod tests {
    use crate::train::distribution::moments::{Observed, cells};

    use super::*;

    #[test]
    fn the_least_covariance_by_hand() {
        let values = [-2.0, 0.0, 2.0].map(|x| DVector::from_element(1, x));
        let (exact, spread) = (DVector::zeros(1), DVector::from_element(1, 4.0));
        let rows: Vec<_> = values.iter().map(|value| Observed { value, variance: &exact, class: 0 }).collect();
        // S = 8/2 = 4, and √(2/2) of it.
        let found = least(&cells(&rows), 1, &spread).expect("rows");
        assert!((found[(0, 0)] - 4.0).abs() < 1e-12, "{found}");
        // 50 times as many: the part is √(2/149) of S = 400/149.
        let rows = rows.repeat(50);
        let found = least(&cells(&rows), 1, &spread).expect("rows");
        assert!((found[(0, 0)] - (2.0_f64 / 149.0).sqrt() * 400.0 / 149.0).abs() < 1e-12, "{found}");
        // A further row with an endless error has no weight, however far it is.
        let (far, error) = (DVector::from_element(1, 1e3), DVector::from_element(1, 1e12));
        let mut rows = rows;
        rows.push(Observed { value: &far, variance: &error, class: 0 });
        let all = cells(&rows);
        let with = least(&all, 1, &spread).expect("rows");
        assert!((with[(0, 0)] / found[(0, 0)] - 1.0).abs() < 0.01, "{with} {found}");
        assert!(least(&cells(&rows[..1]), 1, &spread).is_none());
    }
}
