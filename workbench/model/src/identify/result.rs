//! The result of every estimator: parameters with covariance, residuals, two separate fits, convergence.
//!
//! ```text
//! σ² = Σ ε²/(rows − n)                          (1)  thesis Eq. 2.18; n counts the noise terms of ARMAX too
//! simulation fit: ŷ from the inputs alone       (2)  thesis Eq. 3.2, the criterion of "focus = simulation"
//! prediction fit: ŷ = y − ε, one step ahead     (3)  usually higher: a slow output is easy to predict
//! ```
//!
//! ε are the one-step prediction errors of the noise model that the method assumes ([`Noise`]). Other tools report (3)
//! by default; therefore neither of the two is called just "fit" here.

use nalgebra::{DMatrix, DVector};

use super::kernel::sums::dot;
use super::poles::stable;
use super::simulate::{fit_of_error, fit_percent, simulate};
use super::{Structure, Terms};
use crate::trace::Trace;

/// Parameters with their uncertainty and fits.
#[derive(Clone, Debug)]
pub struct Estimate {
    /// Structure of `theta`.
    pub structure: Structure,
    /// a₁…, b₁…, c₁…, constant.
    pub theta: DVector<f64>,
    /// Covariance of `theta` under the noise that the method assumes. For every method it is exact only in the limit of
    /// long records; the page of each estimator has its formula.
    pub covariance: DMatrix<f64>,
    /// Residual variance σ² with N − n degrees of freedom (Eq. 2.18).
    pub variance: f64,
    /// Rows of the regression.
    pub rows: usize,
    /// Eq. 3.2 on the simulated output (2).
    pub fit_percent: f64,
    /// One-step prediction errors ε from t₀, under `noise`.
    pub residuals: Vec<f64>,
    /// Eq. 3.2 of the one-step prediction (3), rows from t₀.
    pub prediction_fit_percent: f64,
    /// The noise model that the method assumes.
    pub noise: Noise,
    /// Whether and how the iteration converged.
    pub convergence: Convergence,
}

/// How white noise ε enters `A y = B u1 + C u2 [+ constant] + …`.
#[derive(Clone, Debug, PartialEq)]
pub enum Noise {
    /// `… + ε`: white equation error (ls, iv).
    Equation,
    /// `… + ε/L`: autoregressive equation error (iv4); coefficients of L, including the leading 1.
    Autoregressive(Vec<f64>),
    /// `… + A ε`: white output noise (sriv, sm, oe). Simulation and prediction are then equal.
    Output,
    /// `… + D ε`: moving-average equation error (armax); coefficients of D, including the leading 1, and the standard
    /// deviations of d₁….
    MovingAverage {
        /// 1, d₁, ….
        terms: Vec<f64>,
        /// Standard deviations of d₁….
        deviations: Vec<f64>,
    },
}

/// How an iteration ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Convergence {
    /// Whether the last step was negligible compared with the standard deviations. For methods with a fixed number of
    /// passes: whether every pass could be solved. If false, `theta` is the last valid iterate.
    pub converged: bool,
    /// Number of passes or steps.
    pub iterations: usize,
    /// Number of passes whose auxiliary model was unstable, so that its poles were reflected into the unit circle.
    pub reflected: usize,
    /// Whether the estimated model itself is stable.
    pub stable: bool,
}

/// Result of an estimator before it is converted to an [`Estimate`].
pub(super) struct Finding {
    pub theta: DVector<f64>,
    /// Covariance without σ².
    pub cofactor: DMatrix<f64>,
    /// ε of the rows from t₀.
    pub residuals: DVector<f64>,
    pub noise: Noise,
    pub converged: bool,
    pub iterations: usize,
    pub reflected: usize,
}

impl Finding {
    /// Adds σ² (1) and the fits (2), (3).
    pub(super) fn estimate(self, trace: &Trace, structure: Structure) -> Estimate {
        let Self { theta, cofactor, residuals, mut noise, converged, iterations, reflected } = self;
        let rows = residuals.len();
        let noise_terms = match &noise {
            Noise::MovingAverage { deviations, .. } => deviations.len(),
            _ => 0,
        };
        let freedom = rows.saturating_sub(structure.parameters() + noise_terms).max(1);
        let residuals: Vec<f64> = residuals.data.into();
        let error = dot(&residuals, &residuals);
        let variance = error / freedom as f64; // (1)
        if let Noise::MovingAverage { deviations, .. } = &mut noise {
            deviations.iter_mut().for_each(|deviation| *deviation *= variance.sqrt());
        }
        let measured = &trace.y[trace.y.len() - rows..];
        let mut estimate = Estimate {
            structure,
            covariance: cofactor * variance,
            variance,
            rows,
            fit_percent: fit_percent(&trace.y, &simulate(trace, structure, theta.as_slice())), // (2)
            prediction_fit_percent: fit_of_error(error, measured),                             // (3)
            residuals,
            noise,
            convergence: Convergence { converged, iterations, reflected, stable: true },
            theta,
        };
        estimate.convergence.stable = estimate.is_stable();
        estimate
    }
}

impl Estimate {
    /// A model given from elsewhere, with its uncertainty; it has no rows, residuals or fits.
    #[must_use]
    pub fn given(structure: Structure, theta: DVector<f64>, covariance: DMatrix<f64>) -> Self {
        let convergence = Convergence { converged: true, iterations: 0, reflected: 0, stable: true };
        let mut estimate = Self {
            structure,
            theta,
            covariance,
            variance: 0.0,
            rows: 0,
            fit_percent: f64::NAN,
            residuals: vec![],
            prediction_fit_percent: f64::NAN,
            noise: Noise::Equation,
            convergence,
        };
        estimate.convergence.stable = estimate.is_stable();
        estimate
    }

    /// Whether every pole lies inside or on the unit circle.
    #[must_use]
    pub fn is_stable(&self) -> bool {
        let ([a, _, _], _) = self.structure.polynomials(self.theta.as_slice());
        stable(&a)
    }

    /// Names of the parameters that the signals hardly determine: a change of the parameter by one standard deviation
    /// changes the predicted output by more than the output itself varies. Rounding of recorded signals can hide an
    /// exact linear dependence, for example of three lags of one sine, from every rank test; this criterion still
    /// detects it.
    #[must_use]
    pub fn undetermined(&self, trace: &Trace) -> Vec<String> {
        let rms = |x: &[f64]| {
            let measured = || x.iter().filter(|x| x.is_finite());
            (measured().map(|x| x * x).sum::<f64>() / measured().count().max(1) as f64).sqrt()
        };
        let Structure { na, nb, nc, .. } = self.structure;
        let signals = [(&trace.y, na), (&trace.u1, nb), (&trace.u2, nc)];
        let sizes = signals.into_iter().flat_map(|(x, terms)| std::iter::repeat_n(rms(x), terms as usize)).chain([1.0]);
        let output = rms(&trace.y);
        let named = self.structure.names().into_iter().zip(self.deviations()).zip(sizes);
        named.filter(|((_, sd), size)| sd * size > output).map(|((name, _), _)| name).collect()
    }

    /// Standard deviations of `theta`.
    #[must_use]
    pub fn deviations(&self) -> Vec<f64> {
        self.covariance.diagonal().iter().map(|v| v.sqrt()).collect()
    }
}

/// Whether a step is small compared with the standard deviations or, if these are zero, compared with rounding.
pub(super) fn negligible(step: &DVector<f64>, deviations: &DVector<f64>, theta: &DVector<f64>) -> bool {
    let rounding = 1e-11 * theta.norm();
    step.iter().zip(deviations).all(|(step, deviation)| step.abs() <= 1e-7 * deviation + rounding)
}
