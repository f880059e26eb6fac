//! Least output error: θ that minimises Σ (y − ŷ)² with ŷ simulated from the inputs alone.
//!
//! ```text
//! ŷ = (B u1 + C u2 [+ constant]) / A,   ε = y − ŷ                      (1)
//! ∂ŷ/∂θ = (1/A) [−ŷ(t−1)…, u1(t−nkb)…, u2(t−nkc)…, 1]                  (2)
//! cov θ = σ² (ΨᵀΨ)⁻¹, Ψ the rows of (2)                                (3)  white output noise, long records
//! ```
//!
//! Both inputs share A. Unstable models are rejected during the descent. The sum may have several minima: the descent
//! starts from Steiglitz–McBride and from refined instrumental variables, and the better result is returned.

use nalgebra::{DMatrix, DVector};

use super::sriv::{reflect, sriv};
use super::steiglitz_mcbride::steiglitz_mcbride;
use crate::Error;
use crate::identify::filters::prefilter;
use crate::identify::gauss_newton::{Minimum, Model, minimise};
use crate::identify::poles::stable;
use crate::identify::result::{Finding, Noise};
use crate::identify::{Estimate, Structure, Terms};
use crate::trace::Trace;

/// Estimates by least output error. If the descent does not converge to a minimum among the stable models, the point of
/// least output error is returned with `converged` false.
///
/// # Errors
/// The errors of [`least_squares`](crate::identify::least_squares).
pub fn output_error(trace: &Trace, structure: Structure) -> Result<Estimate, Error> {
    let model = Simulated { trace, structure };
    let fixed_point = steiglitz_mcbride(trace, structure)?;
    let mut reflected = fixed_point.convergence.reflected;
    let mut starts = vec![fixed_point.theta];
    starts.extend(sriv(trace, structure).map(|estimate| estimate.theta));
    let mut ends = Vec::new();
    for mut start in starts {
        reflected += usize::from(reflect(structure, &mut start));
        ends.extend(minimise(&model, start));
    }
    let lower = |one: &Minimum, other: &Minimum| one.residuals.norm().total_cmp(&other.residuals.norm());
    let Some(Minimum { theta, residuals, cofactor, converged, iterations }) = ends.into_iter().min_by(lower) else {
        return Err(Error::trace(
            &trace.id,
            "no start simulates to finite values; scale the signals or use --method ls",
        ));
    };
    let noise = Noise::Output;
    Ok(Finding { theta, cofactor, residuals, noise, converged, iterations, reflected }.estimate(trace, structure))
}

struct Simulated<'a> {
    trace: &'a Trace,
    structure: Structure,
}

impl Model for Simulated<'_> {
    fn linearise(&self, theta: &DVector<f64>) -> Option<(DVector<f64>, DMatrix<f64>)> {
        let ([a, _, _], _) = self.structure.polynomials(theta.as_slice());
        let data = stable(&a).then(|| prefilter(self.trace, self.structure, theta.as_slice()))?;
        data.output_error.norm_squared().is_finite().then_some((data.output_error, data.simulated)) // (1), (2)
    }
}
