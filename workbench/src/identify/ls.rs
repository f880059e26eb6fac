//! Least squares (thesis Eq. 2.17–2.19) by orthogonal triangularisation; no normal equations.

use nalgebra::{DMatrix, DVector};

use super::filters::regressors;
use super::result::{Finding, Noise};
use super::{Estimate, Structure, unexcited};
use crate::Error;
use crate::trace::Trace;

/// Diagonal of R, relative to its column's norm, below which a column is dependent: double rounding leaves 1e-15.
pub(super) const DEPENDENT: f64 = 1e-11;

/// Minimises Σ e² over rows t₀ … N−1.
///
/// # Errors
/// Fewer rows than parameters, or columns that the signals do not excite.
pub fn least_squares(trace: &Trace, structure: Structure) -> Result<Estimate, Error> {
    let t0 = structure.first_row(trace)?;
    let x = regressors(structure, t0, &trace.y, &trace.u1, &trace.u2);
    let target = DVector::from_column_slice(&trace.y[t0..]);
    let solution = solve(x, target).map_err(|column| {
        let x = regressors(structure, t0, &trace.y, &trace.u1, &trace.u2);
        unexcited(structure, trace, column, &partners(x, column))
    })?;
    let Solution { theta, cofactor, residuals } = solution;
    let noise = Noise::Equation;
    let finding = Finding { theta, cofactor, residuals, noise, converged: true, iterations: 1, reflected: 0 };
    Ok(finding.estimate(trace, structure))
}

/// Parameters of one regression.
pub(super) struct Solution {
    pub theta: DVector<f64>,
    /// Covariance without σ²: (XᵀX)⁻¹, or the sandwich form of instrumental variables.
    pub cofactor: DMatrix<f64>,
    pub residuals: DVector<f64>,
}

/// Solves min ‖target − Xθ‖; the error is the first dependent column.
pub(super) fn solve(mut x: DMatrix<f64>, target: DVector<f64>) -> Result<Solution, usize> {
    let n = x.ncols();
    // Columns of unit norm, so that the diagonal of R measures dependence and not units.
    let norms: Vec<f64> = x.column_iter().map(|column| column.norm()).collect();
    for (mut column, &norm) in x.column_iter_mut().zip(&norms) {
        if norm > 0.0 {
            column /= norm;
        }
    }
    let scaled = x.clone();
    let qr = x.qr();
    let r = qr.r();
    if let Some(dependent) = (0..n).find(|&k| r[(k, k)].abs() < DEPENDENT || norms[k] == 0.0) {
        return Err(dependent);
    }
    let mut rotated = target.clone();
    qr.q_tr_mul(&mut rotated);
    let scaled_theta = r.solve_upper_triangular(&rotated.rows(0, n).into_owned()).ok_or(n - 1)?;
    let residuals = target - scaled * &scaled_theta;
    let inverse_r = r.solve_upper_triangular(&DMatrix::identity(n, n)).ok_or(n - 1)?;
    let mut inverse = &inverse_r * inverse_r.transpose();
    let mut theta = scaled_theta;
    for i in 0..n {
        theta[i] /= norms[i];
        for j in 0..n {
            inverse[(i, j)] /= norms[i] * norms[j];
        }
    }
    Ok(Solution { theta, cofactor: inverse, residuals })
}

/// The earlier columns of which a dependent column is made.
fn partners(x: DMatrix<f64>, dependent: usize) -> Vec<usize> {
    let norms: Vec<f64> = x.column_iter().map(|column| column.norm()).collect();
    let r = x.qr().unpack_r();
    let (before, column) = (r.view((0, 0), (dependent, dependent)), r.view((0, dependent), (dependent, 1)));
    let Some(shares) = before.solve_upper_triangular(&column) else { return vec![] };
    let parts: Vec<f64> = shares.iter().zip(&norms).map(|(share, norm)| (share * norm).abs()).collect();
    // A share of rounding, amplified by near-dependence among the earlier columns, stays below this.
    (0..dependent).filter(|&k| parts[k] > 1e-6 * norms[dependent]).collect()
}

/// The cofactor of parameters that the data do not determine.
pub(super) fn unknown(n: usize) -> DMatrix<f64> {
    DMatrix::from_diagonal_element(n, n, f64::INFINITY)
}
