//! Instrumental variables: the basic method, and the four-stage one that the source used for every result.
//!
//! Basic (thesis Eq. 2.22): least squares, then in every pass instruments Z with y replaced by the output that the last
//! model simulates, `θ = (ZᵀX)⁻¹ ZᵀY`.
//!
//! Four-stage (thesis §2.1.2, B.1): least squares → IV → AR(n) model L(q) of the residuals `A y − B u1 − C u2` → y, u1,
//! u2 and instruments simulated by the IV model, all filtered by L → IV again.
//!
//! ```text
//! iv4    cov θ = σ² (ZᵀX)⁻¹ ZᵀZ (XᵀZ)⁻¹ on the filtered data        (1)
//! basic  cov θ = s² (ZᵀX)⁻¹ WᵀW (XᵀZ)⁻¹,  w(t) = Σ hₖ z(t+k)        (2)  residual = H(q) white of variance s²
//! ```
//!
//! The basic method's residual is coloured unless the equation error is white, and (1) would then state wrong
//! deviations; (2) is right for any H, here 1/AR of the residuals. Both hold for long records.

use nalgebra::{DMatrix, DVector, Dyn, QR};

use super::filters::{all_pole, fir, regressors};
use super::result::{Finding, Noise, stable};
use super::{Estimate, Structure, least_squares, ls, reflect_unstable, simulate};
use crate::Error;
use crate::trace::Trace;

/// Order of the AR model in (2): long enough for a moving average whose zeros are slow poles.
const COLOUR_ORDER: usize = 25;

/// Estimates by basic instrumental variables; more than three passes change nothing that matters. Where a later pass
/// cannot be solved, the last good one is returned, flagged.
///
/// # Errors
/// As [`least_squares`]; or instruments that do not determine the parameters.
pub fn instrumental_variables(trace: &Trace, structure: Structure, passes: usize) -> Result<Estimate, Error> {
    let first = least_squares(trace, structure)?;
    let t0 = structure.order.depth();
    let signals = Signals::of(trace);
    let (mut theta, mut reflected) = (first.theta, 0);
    let mut last: Option<(ls::Solution, Vec<f64>)> = None;
    let (mut converged, mut iterations) = (true, 0);
    for pass in 1..=passes.max(1) {
        reflected += usize::from(!is_stable(structure, &theta));
        let instruments = simulate(trace, structure, theta.as_slice());
        match signals.solve(structure, t0, &instruments) {
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

/// Estimates by iv4. All sums start at t₀; filters start from zero.
///
/// # Errors
/// As [`least_squares`]; or instruments that do not determine the parameters.
pub fn iv4(trace: &Trace, structure: Structure) -> Result<Estimate, Error> {
    let first = least_squares(trace, structure)?;
    let t0 = structure.order.depth();
    let lost = |column| lost(structure, trace, column);

    let instruments = simulate(trace, structure, first.theta.as_slice());
    let second = Signals::of(trace).solve(structure, t0, &instruments).map_err(lost)?;

    let shaping = autoregression(second.residuals.as_slice(), structure.parameters()).ok_or_else(|| {
        let problem = "the residuals are too few or too regular for a noise model; record more, or use --method ls";
        Error::trace(&trace.id, problem)
    })?;
    let filter = |x: &[f64]| fir(&shaping, x);
    let (y, u1, u2) = (filter(&trace.y), filter(&trace.u1), filter(&trace.u2));
    let instruments = filter(&simulate(trace, structure, second.theta.as_slice()));
    let filtered = Signals { y: &y, u1: &u1, u2: &u2, constant: shaping.iter().sum() };
    let ls::Solution { theta, cofactor, residuals } = filtered.solve(structure, t0, &instruments).map_err(lost)?; // (1)

    let reflected = [&first.theta, &second.theta].into_iter().filter(|theta| !is_stable(structure, theta)).count();
    let noise = Noise::Autoregressive(shaping);
    let finding = Finding { theta, cofactor, residuals, noise, converged: true, iterations: 2, reflected };
    Ok(finding.estimate(trace, structure))
}

/// One pass of the basic method from another model, where it can be solved.
pub(super) fn next_pass(trace: &Trace, structure: Structure, theta: &DVector<f64>) -> Option<DVector<f64>> {
    let instruments = simulate(trace, structure, theta.as_slice());
    let solution = Signals::of(trace).solve(structure, structure.order.depth(), &instruments);
    solution.ok().map(|solution| solution.theta)
}

fn is_stable(structure: Structure, theta: &DVector<f64>) -> bool {
    stable(&structure.polynomials(theta.as_slice()).0[0])
}

struct Signals<'a> {
    y: &'a [f64],
    u1: &'a [f64],
    u2: &'a [f64],
    /// The constant column after filtering.
    constant: f64,
}

impl<'a> Signals<'a> {
    fn of(trace: &'a Trace) -> Self {
        Self { y: &trace.y, u1: &trace.u1, u2: &trace.u2, constant: 1.0 }
    }

    /// IV with Z the regressors of the instruments; the error is the first dependent column of Z.
    fn solve(&self, structure: Structure, t0: usize, instruments: &[f64]) -> Result<ls::Solution, usize> {
        let mut x = regressors(structure, t0, self.y, self.u1, self.u2);
        let mut z = regressors(structure, t0, instruments, self.u1, self.u2);
        if structure.offset {
            let last = structure.parameters() - 1;
            x.column_mut(last).fill(self.constant);
            z.column_mut(last).fill(self.constant);
        }
        solve(&x, z, &DVector::from_column_slice(&self.y[t0..]))
    }
}

/// θ = (ZᵀX)⁻¹ ZᵀY and the cofactor of (1); with Z = QR they are (QᵀX)⁻¹ QᵀY and (QᵀX)⁻¹ (XᵀQ)⁻¹. The error is the
/// first column of Z that depends on those before it.
pub(super) fn solve(x: &DMatrix<f64>, z: DMatrix<f64>, y: &DVector<f64>) -> Result<ls::Solution, usize> {
    let n = x.ncols();
    let (q, rotated_x) = project(x, z)?;
    let mut rotated_y = y.clone();
    q.q_tr_mul(&mut rotated_y);
    let lu = rotated_x.lu();
    let theta = lu.solve(&rotated_y.rows(0, n).into_owned()).ok_or(n - 1)?;
    let inverse = lu.try_inverse().ok_or(n - 1)?;
    if theta.iter().chain(inverse.iter()).any(|p| !p.is_finite()) {
        return Err(n - 1);
    }
    let residuals = y - x * &theta;
    Ok(ls::Solution { cofactor: &inverse * inverse.transpose(), theta, residuals })
}

/// (QᵀX)⁻¹ (XᵀQ)⁻¹ = (ZᵀX)⁻¹ ZᵀZ (XᵀZ)⁻¹, Z = QR.
pub(super) fn sandwich(x: &DMatrix<f64>, z: DMatrix<f64>) -> Option<DMatrix<f64>> {
    let inverse = project(x, z).ok()?.1.try_inverse()?;
    Some(&inverse * inverse.transpose())
}

type Factor = QR<f64, Dyn, Dyn>;

/// Q and QᵀX with Z = QR.
fn project(x: &DMatrix<f64>, z: DMatrix<f64>) -> Result<(Factor, DMatrix<f64>), usize> {
    let n = x.ncols();
    let norms: Vec<f64> = z.column_iter().map(|column| column.norm()).collect();
    let qr = z.qr();
    let r = qr.r();
    let determined = |k: usize| r[(k, k)].abs() >= ls::DEPENDENT * norms[k] && norms[k] > 0.0;
    if let Some(column) = (0..n).find(|&k| !determined(k)) {
        return Err(column);
    }
    let mut rotated = x.clone();
    qr.q_tr_mul(&mut rotated);
    let rotated = rotated.rows(0, n).into_owned();
    Ok((qr, rotated))
}

/// The cofactor of (2) in units of the residual's variance; nothing where the residual is too short to model.
fn coloured_cofactor(x: &DMatrix<f64>, z: DMatrix<f64>, residuals: &DVector<f64>) -> Option<DMatrix<f64>> {
    let rows = residuals.len();
    let order = COLOUR_ORDER.min(rows / 20);
    let shaping = reflect_unstable(&autoregression(residuals.as_slice(), order)?);
    let white = fir(&shaping, residuals.as_slice());
    let white_share = white[order..].iter().map(|e| e * e).sum::<f64>()
        / (rows - order) as f64
        / (residuals.norm_squared() / rows as f64);
    let q = z.qr().q();
    let inverse = (q.transpose() * x).try_inverse()?;
    let mut later = q;
    for mut column in later.column_iter_mut() {
        // Backwards in time: a filter that looks ahead.
        column.as_mut_slice().reverse();
        all_pole(&shaping, column.as_mut_slice());
    }
    let (_, r) = later.qr().unpack();
    let half = inverse * r.transpose();
    Some(&half * half.transpose() * white_share)
}

fn lost(structure: Structure, trace: &Trace, column: usize) -> Error {
    let problem = format!(
        "the instruments do not determine the parameters (first {}); use --method ls, a lower order or a richer command",
        structure.names()[column]
    );
    Error::trace(&trace.id, problem)
}

/// `1 + l₁ q⁻¹ + … + l_n q⁻ⁿ` that whitens `w`, by least squares from its n-th sample on.
fn autoregression(w: &[f64], n: usize) -> Option<Vec<f64>> {
    if w.len() <= 2 * n {
        return None;
    }
    let x = DMatrix::from_fn(w.len() - n, n, |row, column| -w[n + row - 1 - column]);
    let solution = ls::solve(x, DVector::from_column_slice(&w[n..])).ok()?;
    Some([&[1.0], solution.theta.as_slice()].concat())
}
