//! Least squares (thesis Eq. 2.17–2.19) by orthogonal triangularisation, without normal equations.
//!
//! ```text
//! [X y] = Q [R q; 0 ·],   R θ = q,   cov θ = σ² (XᵀX)⁻¹ = σ² R⁻¹ R⁻ᵀ
//! ```
//!
//! The columns are read from the signals in blocks of rows ([`crate::identify::kernel::triangle`]); Q is not formed.
//! Cost for n parameters: 2 N n² flops.

use nalgebra::{DMatrix, DVector};

use super::incomplete;
use crate::Error;
use crate::identify::factor::{Dependent, Factor};
use crate::identify::refused::{self, complete_row, first_row, unexcited};
use crate::identify::regression::{Signals, constant, subtract};
use crate::identify::result::{Finding, Noise};
use crate::identify::{Estimate, Structure};
use crate::trace::Trace;

/// Minimises Σ e² over rows t₀ … N−1, without those that a missing sample is in.
///
/// # Errors
/// Fewer rows than parameters, or columns that the signals do not excite.
pub fn least_squares(trace: &Trace, structure: Structure) -> Result<Estimate, Error> {
    if !refused::is_complete(trace) {
        return incomplete::least_squares(trace, structure, first_row(structure, trace)?);
    }
    let constant = constant(structure, 1.0, trace.y.len());
    let signals = Signals::of(trace, &constant);
    let factor = factor(trace, structure, &signals)?;
    let mut residuals = Vec::new();
    signals.residuals(structure, factor.theta.as_slice(), &mut residuals);
    let cofactor = factor.cofactor();
    let Factor { theta, .. } = factor;
    let (residuals, noise) = (DVector::from_vec(residuals), Noise::Equation);
    let finding = Finding { theta, cofactor, residuals, noise, converged: true, iterations: 1, reflected: 0 };
    Ok(finding.estimate(trace, structure))
}

/// Returns only the parameters of [`least_squares`].
pub(crate) fn parameters(trace: &Trace, structure: Structure) -> Result<DVector<f64>, Error> {
    let constant = constant(structure, 1.0, trace.y.len());
    Ok(factor(trace, structure, &Signals::of(trace, &constant))?.theta)
}

fn factor(trace: &Trace, structure: Structure, signals: &Signals) -> Result<Factor, Error> {
    let t0 = complete_row(structure, trace)?;
    let factor = Factor::new(signals.columns(structure), structure.na.into(), &trace.y[t0..]);
    factor.map_err(|Dependent { column, partners }| unexcited(structure, trace, column, &partners))
}

/// Solution of one regression.
pub(crate) struct Solution {
    pub theta: DVector<f64>,
    /// Covariance without σ²: (XᵀX)⁻¹, or the sandwich form of instrumental variables.
    pub cofactor: DMatrix<f64>,
    pub residuals: DVector<f64>,
}

/// Solves min ‖target − Xθ‖; returns `None` if a column depends linearly on the columns before it.
pub(crate) fn solve(x: &DMatrix<f64>, target: &DVector<f64>) -> Option<Solution> {
    let columns = columns(x);
    let mut residuals = target.clone();
    let factor = Factor::new(columns.clone(), 0, target.as_slice()).ok()?;
    subtract(&columns, 0, factor.theta.as_slice(), residuals.as_mut_slice());
    let cofactor = factor.cofactor();
    Some(Solution { theta: factor.theta, cofactor, residuals })
}

/// The columns of a matrix.
pub(crate) fn columns(x: &DMatrix<f64>) -> Vec<&[f64]> {
    x.as_slice().chunks_exact(x.nrows().max(1)).collect()
}

/// The cofactor of parameters that the data do not determine: infinite.
pub(crate) fn unknown(n: usize) -> DMatrix<f64> {
    DMatrix::from_diagonal_element(n, n, f64::INFINITY)
}
