//! Simplified refined instrumental variables (Young), optimal for white output noise.
//!
//! In each pass y, u1, u2 and the output simulated by the previous model are filtered by 1/A of that model; IV on the
//! filtered signals yields the next model.
//!
//! ```text
//! Φ: rows of the filtered y, Ψ: rows of the filtered simulated output
//! step  d = (ΨᵀΦ)⁻¹ Ψᵀ (y − ŷ),   θ ← θ + μ d                (1)
//! cov θ = σ² (ΨᵀΦ)⁻¹ ΨᵀΨ (ΦᵀΨ)⁻¹                             (2)  white output noise, long records
//! ```
//!
//! Ψ is the gradient of ŷ, so at convergence Ψᵀ(y − ŷ) = 0: the estimate is a stationary point of the output error. The
//! step size follows from this: μ is halved until the model is stable and the output error does not increase. If no μ
//! satisfies both, the iteration stops at the last valid iterate and reports whether it converged.

use nalgebra::DVector;

use super::steiglitz_mcbride::steiglitz_mcbride;
use super::{iv, ls};
use crate::Error;
use crate::identify::filters::{Prefiltered, prefilter};
use crate::identify::poles::stable;
use crate::identify::result::{Finding, Noise, negligible};
use crate::identify::{Estimate, Structure, Terms, reflect_unstable};
use crate::trace::Trace;

const PASSES: usize = 100;
/// Maximum number of halvings of μ in one pass.
const HALVINGS: i32 = 30;

/// Estimates by SRIV, starting from least squares or from one pass of IV, whichever has the smaller output error; if
/// this does not converge, it starts again from Steiglitz–McBride.
///
/// # Errors
/// The errors of [`least_squares`](crate::identify::least_squares).
pub fn sriv(trace: &Trace, structure: Structure) -> Result<Estimate, Error> {
    let first = ls::parameters(trace, structure)?;
    let second = iv::next_pass(trace, structure, &first);
    let mut reflected = 0;
    let mut prepared = |mut theta: DVector<f64>| {
        reflected += usize::from(reflect(structure, &mut theta));
        let data = prefilter(trace, structure, theta.as_slice());
        Iterate { theta, data, iterations: 0, converged: false }
    };
    let mut start = prepared(first);
    // If the instruments fail here, least squares remains the starting point.
    if let Some(second) = second.map(&mut prepared).filter(|second| second.loss() < start.loss()) {
        start = second;
    }
    let mut end = refine(trace, structure, start);
    if !end.converged {
        let other = refine(trace, structure, prepared(steiglitz_mcbride(trace, structure)?.theta));
        if other.converged || other.loss() < end.loss() {
            end = other;
        }
    }
    let Iterate { theta, data, iterations, converged } = end;
    let Prefiltered { measured, simulated, target, output_error: residuals, .. } = data;
    let solution = iv::solve_matrices(&measured, &simulated, structure.na.into(), &target);
    let cofactor = solution.map_or_else(|_| ls::unknown(theta.len()), |solution| solution.cofactor); // (2)
    let noise = Noise::Output;
    Ok(Finding { theta, cofactor, residuals, noise, converged, iterations, reflected }.estimate(trace, structure))
}

struct Iterate {
    theta: DVector<f64>,
    data: Prefiltered,
    iterations: usize,
    converged: bool,
}

impl Iterate {
    fn loss(&self) -> f64 {
        loss(&self.data)
    }
}

/// Repeats passes from a stable start until they converge or no step reduces the output error.
fn refine(trace: &Trace, structure: Structure, mut now: Iterate) -> Iterate {
    let (mut share, mut before) = (1.0, DVector::zeros(now.theta.len()));
    let na = structure.na.into();
    while !now.converged && now.iterations < PASSES {
        let Iterate { theta, data, .. } = &now;
        let Ok(pass) = iv::solve_matrices(&data.measured, &data.simulated, na, &data.target) else { break };
        let step = &pass.theta - theta; // (1)
        let variance = now.loss() / data.output_error.len() as f64;
        let deviations = pass.cofactor.diagonal().map(|q| (q * variance).sqrt());
        let converged = negligible(&step, &deviations, theta);
        let scaled = step.component_div(&deviations);
        // Passes that overshoot alternate in sign; without this reduction of the step they may oscillate without end.
        share = if scaled.dot(&before) < 0.0 { 0.5 * share } else { f64::min(1.0, 1.5 * share) };
        before = scaled;
        // Rounding alone may increase the output error by this fraction.
        let limit = now.loss() * (1.0 + 1e-12);
        let tried = (0..HALVINGS).find_map(|halving| {
            let theta = theta + &step * (share * 0.5_f64.powi(halving));
            let inside = stable(&structure.polynomials(theta.as_slice()).0[0]);
            let data = inside.then(|| prefilter(trace, structure, theta.as_slice()))?;
            (loss(&data) <= limit).then_some((theta, data))
        });
        now.converged = converged;
        let Some((theta, data)) = tried else { break };
        now = Iterate { theta, data, iterations: now.iterations + 1, converged };
    }
    now
}

fn loss(data: &Prefiltered) -> f64 {
    let loss = data.output_error.norm_squared();
    if loss.is_finite() { loss } else { f64::INFINITY }
}

/// Reflects unstable poles of a starting point into the unit circle; returns whether there were any.
pub(crate) fn reflect(structure: Structure, theta: &mut DVector<f64>) -> bool {
    let ([a, _, _], _) = structure.polynomials(theta.as_slice());
    let mirrored = reflect_unstable(&a);
    theta.iter_mut().zip(&mirrored[1..]).for_each(|(theta, a)| *theta = *a);
    mirrored != a
}
