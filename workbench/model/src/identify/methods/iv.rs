//! Basic instrumental variables (thesis Eq. 2.22): least squares first; then each pass computes `θ = (ZᵀX)⁻¹ ZᵀY` with
//! instruments Z, in which y is replaced by the output that the previous model simulates.
//!
//! ```text
//! cov θ = s² (ZᵀX)⁻¹ WᵀW (XᵀZ)⁻¹,  w(t) = Σ hₖ z(t+k)        (1)  residual = H(q) white of variance s²
//! ```
//!
//! The residual is coloured unless the equation error is white. (1) is valid for any H; here H is 1/AR, with the AR
//! model of the residuals. (1) is asymptotic: it holds for long records.

use nalgebra::{DMatrix, DVector};

use super::instruments::{System, autoregression, rotate};
use super::ls;
use crate::Error;
use crate::identify::filters::{all_pole, regressors};
use crate::identify::kernel::filter::fir;
use crate::identify::poles::stable;
use crate::identify::regression::{Signals, constant, lags, subtract};
use crate::identify::result::{Finding, Noise};
use crate::identify::{Estimate, Structure, Terms, reflect_unstable, simulate};
use crate::trace::Trace;

/// Order of the AR model in (1): sufficient to approximate a moving average whose zeros are slow poles.
const COLOUR_ORDER: usize = 25;

/// Estimates by basic instrumental variables; more than three passes rarely change the result. If a later pass cannot
/// be solved, the result of the last solved pass is returned with `converged` false.
///
/// # Errors
/// The errors of [`least_squares`](crate::identify::least_squares); also instruments that do not determine the
/// parameters.
pub fn instrumental_variables(trace: &Trace, structure: Structure, passes: usize) -> Result<Estimate, Error> {
    let mut theta = ls::parameters(trace, structure)?;
    let mut reflected = 0;
    let t0 = structure.depth();
    let mut last: Option<(ls::Solution, Vec<f64>)> = None;
    let (mut converged, mut iterations) = (true, 0);
    for pass in 1..=passes.max(1) {
        reflected += usize::from(!is_stable(structure, theta.as_slice()));
        let instruments = simulate(trace, structure, theta.as_slice());
        match pass_from(trace, structure, &instruments) {
            Ok(solution) => {
                theta = solution.theta.clone();
                last = Some((solution, instruments));
                iterations = pass;
            }
            Err(column) if last.is_none() => return Err(lost(structure, trace, column)),
            Err(_) => {
                converged = false;
                break;
            }
        }
    }
    let Some((solution, instruments)) = last else { return Err(lost(structure, trace, 0)) };
    let z = regressors(structure, t0, &instruments, &trace.u1, &trace.u2);
    let x = regressors(structure, t0, &trace.y, &trace.u1, &trace.u2);
    let cofactor = coloured_cofactor(&x, z, &solution.residuals).unwrap_or(solution.cofactor);
    let (theta, residuals) = (solution.theta, solution.residuals);
    let noise = Noise::Equation;
    Ok(Finding { theta, cofactor, residuals, noise, converged, iterations, reflected }.estimate(trace, structure))
}

/// One pass of the basic method, starting from another model; `None` if it cannot be solved.
pub(crate) fn next_pass(trace: &Trace, structure: Structure, theta: &DVector<f64>) -> Option<DVector<f64>> {
    let instruments = simulate(trace, structure, theta.as_slice());
    pass_from(trace, structure, &instruments).ok().map(|solution| solution.theta)
}

pub(crate) fn is_stable(structure: Structure, theta: &[f64]) -> bool {
    stable(&structure.polynomials(theta).0[0])
}

/// IV with Z the regressors of the instruments; the error is the first linearly dependent column of Z.
fn pass_from(trace: &Trace, structure: Structure, instruments: &[f64]) -> Result<ls::Solution, usize> {
    let (t0, na) = (structure.depth(), structure.na);
    let constant = constant(structure, 1.0, trace.y.len());
    let columns = Signals::of(trace, &constant).columns(structure);
    let own: Vec<&[f64]> = lags(instruments, t0, 1, na).collect();
    solve(&columns, &own, na.into(), &trace.y[t0..])
}

/// IV if X and Z differ in their first columns, which are `own` in Z; the first `negative` columns have − sign in the
/// model. The error is the first column of Z that depends linearly on the columns before it.
fn solve(x: &[&[f64]], own: &[&[f64]], negative: usize, y: &[f64]) -> Result<ls::Solution, usize> {
    let (measured, shared) = x.split_at(own.len());
    let system = System::new(&rotate(shared, own, measured, y), own.len(), negative > 0)?;
    let (theta, inverse) = system.theta().zip(system.inverse()).ok_or(x.len() - 1)?;
    let mut residuals = y.to_vec();
    subtract(x, negative, theta.as_slice(), &mut residuals);
    let residuals = DVector::from_vec(residuals);
    Ok(ls::Solution { cofactor: &inverse * inverse.transpose(), theta, residuals })
}

/// IV for matrices that differ in their first `own` columns.
pub(crate) fn solve_matrices(
    x: &DMatrix<f64>,
    z: &DMatrix<f64>,
    own: usize,
    y: &DVector<f64>,
) -> Result<ls::Solution, usize> {
    solve(&ls::columns(x), &ls::columns(z)[..own], 0, y.as_slice())
}

/// The cofactor of (1) with these regressors and instruments in units of the variance of the residual; `None` if the
/// residual is too short for an AR model.
pub(crate) fn coloured_cofactor(x: &DMatrix<f64>, z: DMatrix<f64>, residuals: &DVector<f64>) -> Option<DMatrix<f64>> {
    let rows = residuals.len();
    let order = COLOUR_ORDER.min(rows / 20);
    let shaping = reflect_unstable(&autoregression(&[residuals.as_slice()], order)?);
    let mut white = Vec::new();
    fir(&shaping, residuals.as_slice(), &mut white);
    let white_share = white[order..].iter().map(|e| e * e).sum::<f64>()
        / (rows - order) as f64
        / (residuals.norm_squared() / rows as f64);
    let q = z.qr().q();
    let inverse = (q.transpose() * x).try_inverse()?;
    let mut later = q;
    for mut column in later.column_iter_mut() {
        // Filtered in reversed time: a non-causal filter.
        column.as_mut_slice().reverse();
        all_pole(&shaping, column.as_mut_slice());
    }
    let (_, r) = later.qr().unpack();
    let half = inverse * r.transpose();
    Some(&half * half.transpose() * white_share)
}

pub(crate) fn lost(structure: Structure, trace: &Trace, column: usize) -> Error {
    let problem = format!(
        "the instruments do not determine the parameters (first {}); \
         use --method ls, a lower order or a richer command",
        structure.names()[column]
    );
    Error::trace(&trace.id, problem)
}
