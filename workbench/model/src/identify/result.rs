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

#[cfg(test)]
pub(super) mod tests {
    use rand::SeedableRng as _;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution as _, StandardNormal};

    use super::*;
    use crate::identify::{Method, Options, estimate_with};

    /// y = 0.8 y(t−1) + 0.5 u1(t−1) + 0.3 u2(t−1) + constant + noise with a pole at 0.7.
    pub(in crate::identify) fn trace(rows: usize, constant: f64) -> Trace {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let mut draw = || -> f64 { StandardNormal.sample(&mut rng) };
        let (u1, u2): (Vec<f64>, Vec<f64>) = (0..rows).map(|_| (draw(), draw())).unzip();
        let (mut y, mut noise) = (vec![0.0], 0.0);
        for t in 1..rows {
            noise = 0.7 * noise + 0.1 * draw();
            y.push(0.8 * y[t - 1] + 0.5 * u1[t - 1] + 0.3 * u2[t - 1] + constant + noise);
        }
        Trace { id: "simulated".into(), y, u1, u2, ..Trace::default() }
    }

    #[test]
    fn each_parameter_costs_a_degree_of_freedom() {
        let (trace, structure) = (trace(40, 0.0), Structure::new(1, 1, 1, 1, 1));
        for (method, noise_terms) in [(Method::Ls, 0), (Method::Iv, 0), (Method::Armax, 2)] {
            let options = Options { noise_order: Some(2), ..Options::default() };
            let found = estimate_with(&trace, structure, method, options).expect("excited");
            let squares: f64 = found.residuals.iter().map(|e| e * e).sum();
            let expected = squares / (found.rows - 3 - noise_terms) as f64;
            assert!((found.variance / expected - 1.0).abs() < 1e-12, "{method:?}: {} {expected}", found.variance);
        }
    }

    #[test]
    fn iv4_finds_the_constant_under_coloured_noise() {
        let structure = Structure { offset: true, ..Structure::new(1, 1, 1, 1, 1) };
        let found = estimate_with(&trace(4000, 2.0), structure, Method::Iv4, Options::default()).expect("excited");
        let (constant, deviation) = (found.theta[3], found.deviations()[3]);
        // Four standard deviations.
        assert!(deviation < 0.1 && (constant - 2.0).abs() < 4.0 * deviation, "{constant} {deviation}");
    }

    #[test]
    fn parameters_that_change_the_output_by_more_than_it_varies_are_named() {
        let signal = |size: f64| vec![size, -size, size, -size];
        let trace = Trace { y: signal(1.0), u1: signal(2.0), u2: signal(0.5), ..Trace::default() };
        let structure = Structure::new(1, 1, 1, 1, 1);
        let named = |deviations: [f64; 3]| {
            let covariance = DMatrix::from_diagonal(&DVector::from_column_slice(&deviations.map(|sd| sd * sd)));
            Estimate::given(structure, DVector::zeros(3), covariance).undetermined(&trace)
        };
        // sd times size, above and below 1.
        assert_eq!(named([1.1, 0.6, 2.2]), ["a1", "b1", "c1"]);
        assert_eq!(named([0.9, 0.4, 1.8]), Vec::<String>::new());
    }

    #[test]
    fn a_step_of_half_a_deviation_is_not_negligible() {
        let vector = |x: f64| DVector::from_element(1, x);
        assert!(!negligible(&vector(0.5), &vector(1.0), &vector(1.0)));
        assert!(
            negligible(&vector(1e-8), &vector(1.0), &vector(1.0))
                && !negligible(&vector(1e-8), &vector(0.0), &vector(1.0))
        );
        assert!(negligible(&vector(1e-13), &vector(0.0), &vector(1.0)), "rounding");
    }
}
