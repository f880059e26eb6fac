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
//! estimated on, and if the structure of the model contains the true system.

pub mod correlation;
pub mod linearised;
pub mod noise;
pub mod response;
pub mod roots;

pub use correlation::{Correlation, Test};
pub use linearised::Errors;
pub use roots::PoleZeroMap;

use linearised::Linearised;

use crate::Error;
use crate::identify::{Estimate, fit_percent, simulate};
use crate::trace::Trace;

/// Standard deviations of the regions of poles and zeros.
pub const REGION_SIGMAS: f64 = 3.0;

/// Validation results of one model on the trace that it was estimated on.
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

/// Validates an estimate on the trace that it was estimated on.
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
        prediction_fit_percent: estimate.prediction_fit_percent,
        autocorrelation,
        cross_correlation,
        simulated,
    })
}
