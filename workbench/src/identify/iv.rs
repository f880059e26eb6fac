//! The four-stage instrumental-variable method, as the source used it for every result (thesis §2.1.2, B.1).
//!
//! Least squares → instruments simulated by that model, IV → AR(n) model L(q) of the residuals `A y − B u1 − C u2` →
//! y, u1, u2 and instruments simulated by the IV model, all filtered by L → IV again.

use nalgebra::{DMatrix, DVector};

use super::{Estimate, Structure, least_squares, ls, regressors, simulate};
use crate::Error;
use crate::trace::Trace;

/// Estimates by iv4. All sums start at t₀; filters start from zero.
///
/// # Errors
/// As [`least_squares`]; or instruments that do not determine the parameters.
pub fn iv4(trace: &Trace, structure: Structure) -> Result<Estimate, Error> {
    let first = least_squares(trace, structure)?;
    let t0 = structure.first_row(trace)?;
    let lost = || {
        let problem =
            "the instruments do not determine the parameters; use --method ls, a lower order or a richer command";
        Error::trace(&trace.id, problem)
    };

    let instruments = simulate(trace, structure, first.theta.as_slice());
    let signals = Signals { y: &trace.y, u1: &trace.u1, u2: &trace.u2, constant: 1.0 };
    let second = signals.solve(structure, t0, &instruments).ok_or_else(lost)?;

    let noise = residuals(trace, structure, t0, second.theta.as_slice());
    let shaping = autoregression(&noise, structure.parameters()).ok_or_else(|| {
        let problem = "the residuals are too few or too regular for a noise model; record more, or use --method ls";
        Error::trace(&trace.id, problem)
    })?;
    let filter = |x: &[f64]| fir(&shaping, x);
    let (y, u1, u2) = (filter(&trace.y), filter(&trace.u1), filter(&trace.u2));
    let instruments = filter(&simulate(trace, structure, second.theta.as_slice()));
    let filtered = Signals { y: &y, u1: &u1, u2: &u2, constant: shaping.iter().sum() };
    let last = filtered.solve(structure, t0, &instruments).ok_or_else(lost)?;

    Ok(last.estimate(trace, structure))
}

struct Signals<'a> {
    y: &'a [f64],
    u1: &'a [f64],
    u2: &'a [f64],
    /// The constant column after filtering.
    constant: f64,
}

impl Signals<'_> {
    /// θ = (ZᵀX)⁻¹ ZᵀY, cofactor (ZᵀX)⁻¹ ZᵀZ (XᵀZ)⁻¹, with Z the regressors of the instruments; with Z = QR it is (QᵀX)⁻¹ QᵀY.
    fn solve(&self, structure: Structure, t0: usize, instruments: &[f64]) -> Option<ls::Solution> {
        let mut x = regressors(structure, t0, self.y, self.u1, self.u2);
        let mut z = regressors(structure, t0, instruments, self.u1, self.u2);
        if structure.offset {
            let last = structure.parameters() - 1;
            x.column_mut(last).fill(self.constant);
            z.column_mut(last).fill(self.constant);
        }
        let y = DVector::from_column_slice(&self.y[t0..]);
        let q = z.qr().q();
        let system = (q.transpose() * &x).lu();
        let theta = system.solve(&(q.transpose() * &y))?;
        let inverse = system.try_inverse()?;
        let residual_sum = (y - x * &theta).norm_squared();
        theta.iter().all(|p| p.is_finite()).then(|| ls::Solution {
            cofactor: &inverse * inverse.transpose(),
            theta,
            residual_sum,
        })
    }
}

/// `A y − B u1 − C u2 − constant` from t₀ on.
fn residuals(trace: &Trace, structure: Structure, t0: usize, theta: &[f64]) -> Vec<f64> {
    let x = regressors(structure, t0, &trace.y, &trace.u1, &trace.u2);
    let predicted = x * DVector::from_column_slice(theta);
    trace.y[t0..].iter().zip(predicted.iter()).map(|(y, p)| y - p).collect()
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

/// Filters with zeros before the first sample.
fn fir(taps: &[f64], x: &[f64]) -> Vec<f64> {
    let at = |t: usize| taps.iter().enumerate().take(t + 1).map(|(k, tap)| tap * x[t - k]).sum();
    (0..x.len()).map(at).collect()
}
