//! Least squares by normal equations, for long records of few columns.
//!
//! ```text
//! own part   1 − R² of a column on the other columns                                          (1)  1 if orthogonal
//! θ = (XᵀX)⁻¹ Xᵀy                                                                             (2)
//! ```
//!
//! [`regression`] has the covariance for correlated residuals, and the factorisation that takes any columns.

use nalgebra::{DMatrix, DVector};

use super::regression;

/// (XᵀX)⁻¹ of columns that are scaled to unit norm, and their norms before. Products of columns square the condition of
/// X, so the own part (1) of each column has to be well above rounding; X need not be copied for a factorisation, which
/// would take several times the memory of a long record.
pub(crate) struct Inverse {
    of_unit: DMatrix<f64>,
    norms: Vec<f64>,
}

impl Inverse {
    /// (1): the inverse's diagonal is one over it.
    pub(crate) fn own_part(&self, k: usize) -> f64 {
        1.0 / self.of_unit[(k, k)]
    }
}

/// The inverse; `None` of columns that depend on each other.
pub(crate) fn inverse(columns: &[&DVector<f64>]) -> Option<Inverse> {
    let norms: Vec<f64> = columns.iter().map(|column| column.norm()).collect();
    if norms.iter().any(|norm| !(*norm > 0.0 && norm.is_finite())) {
        return None;
    }
    let product = |j: usize, k: usize| columns[j].dot(columns[k]) / (norms[j] * norms[k]);
    let of_unit = DMatrix::from_fn(norms.len(), norms.len(), product).cholesky()?.inverse();
    Some(Inverse { of_unit, norms })
}

/// Least squares.
pub(crate) struct Solution {
    pub theta: DVector<f64>,
    pub covariance: DMatrix<f64>,
    pub inverse: Inverse,
}

/// (2), with the covariance for residuals that are correlated over `lags` rows.
pub(crate) fn solve(columns: &[DVector<f64>], y: &DVector<f64>, lags: usize) -> Option<Solution> {
    let inverse = inverse(&columns.iter().collect::<Vec<_>>())?;
    let n = columns.len();
    let scale = DVector::from_fn(n, |k, _| 1.0 / inverse.norms[k]);
    let whole = DMatrix::from_diagonal(&scale) * &inverse.of_unit * DMatrix::from_diagonal(&scale);
    let theta = &whole * DVector::from_fn(n, |k, _| columns[k].dot(y));
    let mut residuals = y.clone();
    for (column, theta) in columns.iter().zip(theta.iter()) {
        residuals.axpy(-theta, column, 1.0);
    }
    let score = |t: usize, g: &mut DVector<f64>| {
        let row = DVector::from_fn(n, |k, _| columns[k][t] * residuals[t]);
        whole.mul_to(&row, g);
    };
    let covariance = regression::covariance((n, y.len()), score, lags);
    theta.iter().all(|p| p.is_finite()).then_some(Solution { theta, covariance, inverse })
}
