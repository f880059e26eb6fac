//! ARMAX: `A y = B u1 + C u2 [+ constant] + D ε` (thesis Eq. 2.6, B.2; the printed residual omits y(t)).
//!
//! Least squares → residuals e → least squares on `[φ, e(t−1) … e(t−nd)]` → repeat as long as the prediction error
//! decreases; then Gauss–Newton on the prediction error.
//!
//! ```text
//! ε = (A y − B u1 − C u2 − constant) / D                               (1)  zero before t₀
//! −∂ε/∂θ = (1/D) [−y(t−1)…, u1(t−nkb)…, u2(t−nkc)…, 1, ε(t−1)…]        (2)
//! cov θ = σ² (ΨᵀΨ)⁻¹, Ψ the rows of (2)                                (3)  long records
//! ```
//!
//! The roots of D are kept inside the unit circle. A may be unstable, since the predictor is stable if D is.

use nalgebra::{DMatrix, DVector};

use super::ls;
use crate::Error;
use crate::identify::filters::{all_pole, regressors};
use crate::identify::gauss_newton::{Minimum, Model, minimise};
use crate::identify::poles::stable;
use crate::identify::result::{Finding, Noise};
use crate::identify::{Estimate, Structure, least_squares, reflect_unstable};
use crate::trace::Trace;

/// Maximum number of passes of multi-stage least squares; they only compute the starting point.
const PASSES: usize = 10;

/// Estimates by ARMAX with `noise_order` terms in D; the default is na, but at least one. If the descent does not
/// converge to a minimum, the point of least prediction error is returned with `converged` false.
///
/// # Errors
/// The errors of [`least_squares`]; also too few rows for the terms of D.
pub fn armax(trace: &Trace, structure: Structure, noise_order: Option<usize>) -> Result<Estimate, Error> {
    let nd = noise_order.unwrap_or(structure.na as usize).max(usize::from(noise_order.is_none()));
    let first = least_squares(trace, structure)?;
    let n = structure.parameters();
    if first.rows <= n + 2 * nd {
        let problem =
            format!("{} rows for {n} parameters and {nd} noise terms; record more or use --method ls", first.rows);
        return Err(Error::trace(&trace.id, problem));
    }
    let t0 = structure.depth();
    let model = Predictor {
        rows: regressors(structure, t0, &trace.y, &trace.u1, &trace.u2),
        target: DVector::from_column_slice(&trace.y[t0..]),
    };
    let (start, reflected) = model.multi_stage(&first, nd);
    let Some(Minimum { theta, residuals, cofactor, converged, iterations }) = minimise(&model, start) else {
        return Err(Error::trace(&trace.id, "the prediction overflows; scale the signals or use --method ls"));
    };
    let terms = [&[1.0], &theta.as_slice()[n..]].concat();
    let noise = Noise::MovingAverage { terms, deviations: (n..n + nd).map(|k| cofactor[(k, k)].sqrt()).collect() };
    let (theta, cofactor) = (theta.rows(0, n).into_owned(), cofactor.view((0, 0), (n, n)).into_owned());
    Ok(Finding { theta, cofactor, residuals, noise, converged, iterations, reflected }.estimate(trace, structure))
}

/// Regression whose residual is filtered by 1/D; its parameters are θ and d₁….
struct Predictor {
    rows: DMatrix<f64>,
    target: DVector<f64>,
}

impl Predictor {
    /// The best pass of multi-stage least squares, and the number of passes in which D had roots outside the unit
    /// circle.
    fn multi_stage(&self, first: &Estimate, nd: usize) -> (DVector<f64>, usize) {
        let n = self.rows.ncols();
        let mut best = first.theta.clone().resize_vertically(n + nd, 0.0);
        let mut noise = DVector::from_column_slice(&first.residuals);
        let mut least = noise.norm_squared();
        let mut reflected = 0;
        for _ in 0..PASSES {
            let mut rows = self.rows.clone().resize_horizontally(n + nd, 0.0);
            fill_lags(&mut rows, n, &noise);
            let Some(pass) = ls::solve(&rows, &self.target) else { break };
            let mut theta = pass.theta;
            let d = reflect_unstable(&shaping(&theta, n));
            reflected += usize::from(d[1..] != theta.as_slice()[n..]);
            theta.as_mut_slice()[n..].copy_from_slice(&d[1..]);
            noise = self.residuals(&theta);
            let loss = noise.norm_squared();
            if loss.is_nan() || loss >= least * (1.0 - 1e-4) {
                break;
            }
            (best, least) = (theta, loss);
        }
        (best, reflected)
    }

    /// ε by (1).
    fn residuals(&self, theta: &DVector<f64>) -> DVector<f64> {
        let n = self.rows.ncols();
        let mut residuals = &self.target - &self.rows * theta.rows(0, n);
        all_pole(&shaping(theta, n), residuals.as_mut_slice());
        residuals
    }
}

impl Model for Predictor {
    fn linearise(&self, theta: &DVector<f64>) -> Option<(DVector<f64>, DMatrix<f64>)> {
        let n = self.rows.ncols();
        let d = shaping(theta, n);
        let residuals = stable(&d).then(|| self.residuals(theta))?;
        let mut gradient = self.rows.clone().resize_horizontally(theta.len(), 0.0);
        fill_lags(&mut gradient, n, &residuals);
        gradient.column_iter_mut().for_each(|mut column| all_pole(&d, column.as_mut_slice())); // (2)
        residuals.norm_squared().is_finite().then_some((residuals, gradient))
    }
}

/// D from the parameters after the first n.
fn shaping(theta: &DVector<f64>, n: usize) -> Vec<f64> {
    [&[1.0], &theta.as_slice()[n..]].concat()
}

/// Writes ε(t−1), ε(t−2), … into the columns from `first` on.
fn fill_lags(rows: &mut DMatrix<f64>, first: usize, noise: &DVector<f64>) {
    for k in first..rows.ncols() {
        let lag = k - first + 1;
        let mut column = rows.column_mut(k);
        column.rows_mut(lag, noise.len() - lag).copy_from(&noise.rows(0, noise.len() - lag));
    }
}
