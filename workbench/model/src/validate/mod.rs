//! Validation of an estimate on a trace.
//!
//! ```text
//! Trace, Estimate ─► linearised ─► correlation ─► whiteness, independence, feedback: counts and verdicts
//!                         noise ──┘
//!        Estimate ─► roots ─► poles and zeros with 3σ regions, near-cancellations
//!        Estimate ─► response ─► step and frequency response with bounds
//! ```
//!
//! A valid model must pass the **independence** test: if residuals correlate with past inputs, the model lacks part of
//! the dynamics. **Whiteness** must hold for least squares, which is biased otherwise; instrumental variables and
//! output error allow coloured residuals. Correlation with *future* inputs (negative lags; also lag 0 if the input acts
//! at least one sample later) indicates feedback from the output to the input, not a wrong model, so it is counted
//! separately.
//!
//! All bounds and regions follow from the covariance of the estimator. They are valid on the trace that the model was
//! estimated on, or with [`Errors::Given`] on another one, and if the structure of the model contains the true system.

pub mod correlation;
pub mod linearised;
pub mod noise;
pub mod response;
pub mod roots;
mod whiteness;

pub use correlation::{Correlation, Test};
pub use linearised::Errors;
pub use roots::PoleZeroMap;
pub use whiteness::is_white;

use linearised::Linearised;

use crate::Error;
use crate::identify::{Estimate, fit_percent, simulate};
use crate::trace::Trace;

/// Standard deviations of the regions of poles and zeros.
pub const REGION_SIGMAS: f64 = 3.0;

/// Validation results of one model on a trace.
#[derive(Clone, Debug)]
pub struct Validation {
    /// The type of residuals.
    pub errors: Errors,
    /// Their autocorrelation over 1 … lags.
    pub autocorrelation: Correlation,
    /// Their cross-correlation with u1 and u2 over −lags … lags.
    pub cross_correlation: [Correlation; 2],
    /// Test of the autocorrelation.
    pub whiteness: Test,
    /// Test of both cross-correlations for lags 1 … `lags`, and at lag 0 if the input acts without delay.
    pub independence: Test,
    /// Test of both cross-correlations for the other lags.
    pub feedback: Test,
    /// Poles and zeros with 3σ regions.
    pub map: PoleZeroMap,
    /// Output of the model from the inputs alone.
    pub simulated: Vec<f64>,
    /// Eq. 3.2 of `simulated`.
    pub simulation_fit_percent: f64,
    /// Eq. 3.2 of the one-step predictions from *measured* past outputs: usually higher, and not a test of a model.
    pub prediction_fit_percent: f64,
}

/// Eq. 3.2 of the one-step prediction with these errors.
fn fit_of_errors(measured: &[f64], errors: &[f64]) -> f64 {
    let predicted: Vec<f64> = measured.iter().zip(errors).map(|(y, e)| y - e).collect();
    fit_percent(measured, &predicted)
}

/// Validates an estimate on the trace that it was estimated on, or with [`Errors::Given`] on another one.
///
/// # Errors
/// A trace too short for the lags, or signals that do not determine the parameters.
pub fn validate(trace: &Trace, estimate: &Estimate, errors: Errors, lags: usize) -> Result<Validation, Error> {
    let (samples, structure) = (trace.y.len(), estimate.structure);
    let needed = structure.depth() + structure.parameters() + 4 * lags.max(1);
    if lags == 0 || samples <= needed {
        let problem = format!(
            "{samples} samples are too few for a residual test over {lags} lags; use --lags N, N from 1 to a quarter of the samples"
        );
        return Err(Error::trace(&trace.id, problem));
    }
    let linear = Linearised::new(trace, estimate, errors)?;
    let autocorrelation = correlation::auto(&linear, lags);
    let cross_correlation =
        [&trace.u1, &trace.u2].map(|input| correlation::cross(&linear, input, structure.offset, lags));
    let span = lags as i64;
    let [of_u1, of_u2] = &cross_correlation;
    // Sampled feedback may carry the residual of the same sample into an input that acts one or more samples later.
    let starts = [structure.nkb, structure.nkc].map(|delay| i64::from(delay.min(1)));
    let simulated = simulate(trace, structure, estimate.theta.as_slice());
    Ok(Validation {
        errors,
        whiteness: correlation::test(&[(&autocorrelation, 1..=span)]),
        independence: correlation::test(&[(of_u1, starts[0]..=span), (of_u2, starts[1]..=span)]),
        feedback: correlation::test(&[(of_u1, -span..=starts[0] - 1), (of_u2, -span..=starts[1] - 1)]),
        map: PoleZeroMap::new(estimate, REGION_SIGMAS),
        simulation_fit_percent: fit_percent(&trace.y, &simulated),
        prediction_fit_percent: match errors {
            Errors::Given => fit_of_errors(&trace.y[linear.first..], linear.residuals.as_slice()),
            _ => estimate.prediction_fit_percent,
        },
        autocorrelation,
        cross_correlation,
        simulated,
    })
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;
    use crate::identify::{Structure, least_squares};

    /// y = 1.2 y(t−1) − 0.5 y(t−2) + `gain` u(t−1) + e with a slow input.
    fn system(seed: u64, samples: usize, gain: f64) -> Trace {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut draw = || -> f64 { StandardNormal.sample(&mut rng) };
        let (mut y, mut u) = (vec![0.0; 2], vec![0.0; 2]);
        for t in 2..samples {
            u.push(0.9 * u[t - 1] + draw());
            y.push(1.2 * y[t - 1] - 0.5 * y[t - 2] + gain * u[t - 1] + draw());
        }
        Trace { id: "system".into(), u2: u.clone(), u1: u, y, ..Trace::default() }
    }

    /// A model of a short trace passes the test on a long one of the same system, with the uncertainty of its
    /// parameters; without it, and on another system, it does not.
    #[test]
    fn a_given_model_is_tested_with_its_own_uncertainty() {
        let structure = Structure::new(2, 1, 0, 1, 1);
        let (mut passed, mut without, mut other) = (0, 0, 0);
        for seed in 0..24 {
            let estimate = least_squares(&system(seed, 150, 1.0), structure).expect("regular");
            let given = Estimate::given(structure, estimate.theta.clone(), estimate.covariance.clone());
            let exact = Estimate { covariance: DMatrix::zeros(3, 3), ..given.clone() };
            let later = system(100 + seed, 2000, 1.0);
            let pass = |trace: &Trace, model: &Estimate| {
                let found = validate(trace, model, Errors::Given, 15).expect("long enough");
                usize::from(found.independence.passed())
            };
            passed += pass(&later, &given);
            without += pass(&later, &exact);
            other += pass(&system(200 + seed, 2000, 1.5), &given);
        }
        // At 1 %, more than 2 of 24 fail with the probability 0.2 %; linearisation and the normal law cost little.
        assert!(passed >= 22, "{passed}");
        assert!(without < 14 && other < 3, "{without} {other}");
    }
}
