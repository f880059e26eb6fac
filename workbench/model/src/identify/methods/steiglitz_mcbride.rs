//! The Steiglitz–McBride method, the source's output-error estimator (thesis Eq. 2.10, B.3; the printed program uses a
//! wrong index in its sums).
//!
//! Least squares → y, u1, u2 filtered by 1/A of the last pass → least squares, until the parameters no longer change.
//!
//! ```text
//! Φ: rows of the filtered y, Ψ: rows of the filtered simulated output
//! converged Φᵀ (y − ŷ) = 0                       (1)
//! cov θ = σ² (ΦᵀΨ)⁻¹ ΦᵀΦ (ΨᵀΦ)⁻¹                 (2)  white output noise, long records
//! ```
//!
//! (1) is not a minimum of the output error: on noisy traces the two differ (see
//! [`output_error`](super::output_error)). The least-squares covariance of the last pass would count the noise in Φ as
//! excitation; (2) does not.

use nalgebra::DVector;

use super::{iv, ls};
use crate::Error;
use crate::identify::filters::{Prefiltered, prefilter};
use crate::identify::poles::stable;
use crate::identify::result::{Finding, Noise, negligible};
use crate::identify::{Estimate, Structure, Terms};
use crate::trace::Trace;

/// Maximum number of passes; convergence is linear, at a signal-to-noise ratio of 20 dB about one digit per pass.
const PASSES: usize = 200;
/// Number of passes after which steps are halved, so that a cycle between two models converges.
const PATIENCE: usize = 25;

/// Estimates by Steiglitz–McBride. If the passes do not converge, the pass of least output error is returned with
/// `converged` false.
///
/// # Errors
/// The errors of [`least_squares`](crate::identify::least_squares).
pub fn steiglitz_mcbride(trace: &Trace, structure: Structure) -> Result<Estimate, Error> {
    let mut theta = ls::parameters(trace, structure)?;
    let (mut iterations, mut reflected) = (0, 0);
    let mut best: Option<(f64, DVector<f64>)> = None;
    let mut converged = false;
    while !converged && iterations < PASSES {
        let data = prefilter(trace, structure, theta.as_slice());
        reflected += usize::from(data.reflected);
        let loss = data.output_error.norm_squared();
        if loss.is_finite() && best.as_ref().is_none_or(|(least, _)| loss < *least) {
            best = Some((loss, theta.clone()));
        }
        let Some(pass) = ls::solve(&data.measured, &data.target) else { break };
        let step = &pass.theta - &theta;
        if step.iter().any(|s| !s.is_finite()) {
            break;
        }
        iterations += 1;
        let variance = pass.residuals.norm_squared() / pass.residuals.len() as f64;
        let deviations = pass.cofactor.diagonal().map(|q| (q * variance).sqrt());
        converged = negligible(&step, &deviations, &theta);
        theta += step * if iterations > PATIENCE { 0.5 } else { 1.0 };
    }
    // A fixed point with reflected poles is not a fixed point of the model itself.
    converged &= stable(&structure.polynomials(theta.as_slice()).0[0]);
    if let (false, Some((_, best))) = (converged, best) {
        theta = best;
    }
    let Prefiltered { measured, simulated, target, output_error: residuals, .. } =
        prefilter(trace, structure, theta.as_slice());
    let solution = iv::solve_matrices(&simulated, &measured, structure.na.into(), &target);
    let cofactor = solution.map_or_else(|_| ls::unknown(theta.len()), |solution| solution.cofactor); // (2)
    let noise = Noise::Output;
    Ok(Finding { theta, cofactor, residuals, noise, converged, iterations, reflected }.estimate(trace, structure))
}
