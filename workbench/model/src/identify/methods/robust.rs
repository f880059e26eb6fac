//! Standard deviations of least squares that allow for coloured residuals.
//!
//! ```text
//! cov θ = s² (XᵀX)⁻¹ WᵀW (XᵀX)⁻¹,  w(t) = Σ hₖ x(t+k)        residual = H(q) white of variance s²
//! ```
//!
//! H is the autoregressive model of the residuals, as in [`super::iv`]. Coloured residuals also bias least squares:
//! these standard deviations are about the value to which it converges, not about the true one.

use nalgebra::DVector;

use super::iv::coloured_cofactor;
use crate::Error;
use crate::identify::Estimate;
use crate::identify::filters::regressors;
use crate::identify::refused::complete_row;
use crate::trace::Trace;

/// Replaces the covariance of an estimate by least squares.
///
/// # Errors
/// Too few rows for a model of the residuals, or missing samples.
pub fn robust(trace: &Trace, estimate: Estimate) -> Result<Estimate, Error> {
    let t0 = complete_row(estimate.structure, trace)?;
    let x = regressors(estimate.structure, t0, &trace.y, &trace.u1, &trace.u2);
    let residuals = DVector::from_column_slice(&estimate.residuals);
    let cofactor = coloured_cofactor(&x, x.clone(), &residuals).ok_or_else(|| {
        Error::trace(&trace.id, "too few rows for a model of the residuals' colour; leave out --robust")
    })?;
    Ok(Estimate { covariance: cofactor * estimate.variance, ..estimate })
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;
    use crate::identify::{Structure, least_squares};

    /// y = 2 u with a slow u and slow noise: no bias, but the plain deviation is a fifth of the true one.
    #[test]
    fn deviations_hold_under_coloured_noise() {
        let structure = Structure::new(0, 1, 0, 0, 0);
        let (mut plain, mut allowed) = (0.0, 0.0);
        for seed in 0..40 {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let mut slow = || {
                let mut last = 0.0;
                let mut next = || -> f64 {
                    let white: f64 = StandardNormal.sample(&mut rng);
                    last = 0.9 * last + white;
                    last
                };
                (0..3000).map(|_| next()).collect::<Vec<f64>>()
            };
            let (u1, noise) = (slow(), slow());
            let y = u1.iter().zip(noise).map(|(u, e)| 2.0 * u + e).collect();
            let trace = Trace { id: "x".into(), u2: u1.clone(), u1, y, ..Trace::default() };
            let estimate = least_squares(&trace, structure).expect("regular");
            plain += ((estimate.theta[0] - 2.0) / estimate.deviations()[0]).powi(2) / 40.0;
            let robust = robust(&trace, estimate).expect("enough rows");
            allowed += ((robust.theta[0] - 2.0) / robust.deviations()[0]).powi(2) / 40.0;
        }
        // χ² of 40 draws divided by 40: 0.55 … 1.6 at 1 and 99 %. Theory: the plain one is (1 + 0.81)/(1 − 0.81) = 9.5.
        assert!((0.5..1.75).contains(&allowed) && (5.0..16.0).contains(&plain), "{allowed} {plain}");
    }
}
