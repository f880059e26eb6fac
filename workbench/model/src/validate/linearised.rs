//! The linear map from noise to residuals, given how the residuals depend on the parameters.
//!
//! Near the true θ₀, with v the noise, which equals the residuals at θ₀,
//!
//! ```text
//! ε = v − S (θ − θ₀)          S: sensitivity, rows × parameters                              (1)
//! θ − θ₀ = Kᵀ v               K: gain of the estimator, KᵀS = I                              (2)
//! uᵀ ε = wᵀ v,    w = u − K Sᵀ u      for any signal u, for example a delayed input            (3)
//! ```
//!
//! | residuals | S | K |
//! |---|---|---|
//! | equation errors of least squares | regressors X | X (XᵀX)⁻¹ |
//! | equation errors of iv4 | X | L*Z (X_LᵀZ)⁻¹, instruments Z, regressors X_L filtered by L, L* = L in reversed time |
//! | prediction errors of armax | 1/D-filtered X and delayed ε, because the terms of D are estimated too | S (SᵀS)⁻¹ |
//! | simulation errors (oe; sriv, sm asymptotically) | 1/A-filtered regressors Ψ of the simulated output | Ψ (ΨᵀΨ)⁻¹ |
//!
//! A model that was given has its deviation θ − θ₀ from another trace, with the covariance P, independent of v:
//!
//! ```text
//! uᵀ ε = uᵀ v − uᵀ X (θ − θ₀),   var of the last term uᵀ X P Xᵀ u                            (4)
//! ```
//!
//! By (3), estimated parameters narrow the bounds of some lags: for least squares w is zero if u is itself a regressor.

use nalgebra::{DMatrix, DVector};

use super::noise::Noise;
use crate::Error;
use crate::identify::filters::all_pole;
use crate::identify::{Estimate, Method, Noise as NoiseModel, Structure, Terms, reflect_unstable, simulate};
use crate::trace::Trace;

/// The type of residuals, and the estimator of the parameters; see the table of this module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Errors {
    /// A y − B u1 − C u2 − constant, parameters by least squares: one-step prediction errors.
    LeastSquares,
    /// The same errors, parameters by iv4; they may be coloured.
    Instruments,
    /// y minus the simulated output, parameters by an output-error method; they may be coloured.
    Simulation,
    /// (A y − B u1 − C u2 − constant)/D with the noise polynomial D of armax: one-step prediction errors.
    Prediction,
    /// A y − B u1 − C u2 − constant of a model from another trace: no parameter was estimated on this one.
    Given,
}

impl Errors {
    /// The residuals that a method minimises.
    #[must_use]
    pub const fn of(method: Method) -> Self {
        match method {
            Method::Ls => Self::LeastSquares,
            Method::Iv | Method::IvCommand | Method::Iv4 => Self::Instruments,
            Method::Armax => Self::Prediction,
            Method::Sriv | Method::Sm | Method::Oe => Self::Simulation,
        }
    }
}

/// Residuals with S and K of (1) and (2).
#[derive(Clone, Debug)]
pub struct Linearised {
    /// First row t₀ in the trace.
    pub first: usize,
    /// ε from t₀.
    pub residuals: DVector<f64>,
    sensitivity: DMatrix<f64>,
    gain: DMatrix<f64>,
    /// Of a model from another trace: P^½ Xᵀ, P the covariance of its parameters.
    spread: Option<DMatrix<f64>>,
}

impl Linearised {
    /// Linearises at the estimate.
    ///
    /// # Errors
    /// Signals that do not determine the parameters.
    pub fn new(trace: &Trace, estimate: &Estimate, errors: Errors) -> Result<Self, Error> {
        let (structure, theta) = (estimate.structure, estimate.theta.as_slice());
        let first = structure.depth();
        let simulated = simulate(trace, structure, theta);
        let x = regressors(structure, &trace.y, &trace.u1, &trace.u2, 1.0);
        let of_equation = DVector::from_column_slice(&trace.y) - &x * &estimate.theta;
        let from_first = |m: &DMatrix<f64>| m.rows(first, m.nrows() - first).into_owned();
        let rows = trace.y.len() - first;
        let equation = of_equation.rows(first, rows).into_owned();
        let mut spread = None;
        let (residuals, sensitivity, gain) = match errors {
            Errors::Given => {
                let x = from_first(&x);
                let eigen = estimate.covariance.clone().symmetric_eigen();
                let roots = eigen.eigenvalues.map(|value| value.max(0.0).sqrt());
                spread = Some(DMatrix::from_diagonal(&roots) * eigen.eigenvectors.transpose() * x.transpose());
                (equation, DMatrix::zeros(rows, 0), Some(DMatrix::zeros(rows, 0)))
            }
            Errors::LeastSquares => {
                let x = from_first(&x);
                let gain = pseudo_inverse(&x);
                (equation, x, gain)
            }
            Errors::Instruments => {
                let noise = Noise::of_order(equation.as_slice(), structure.parameters());
                let filtered = |signal: &[f64]| noise.whiten(signal);
                let (u1, u2) = (filtered(&trace.u1), filtered(&trace.u2));
                let constant: f64 = noise.taps().iter().sum();
                let rows_of =
                    |output: &[f64]| from_first(&regressors(structure, &filtered(output), &u1, &u2, constant));
                let gain = instrumental(&rows_of(&trace.y), rows_of(&simulated), &noise);
                (equation, from_first(&x), gain)
            }
            Errors::Prediction => {
                let (residuals, slopes) = prediction_slopes(from_first(&x), equation, &estimate.noise);
                let gain = pseudo_inverse(&slopes);
                (residuals, slopes, gain)
            }
            Errors::Simulation => {
                let slopes = from_first(&output_slopes(trace, structure, theta, &simulated));
                let gain = pseudo_inverse(&slopes);
                let errors = trace.y[first..].iter().zip(&simulated[first..]).map(|(y, s)| y - s);
                (DVector::from_iterator(rows, errors), slopes, gain)
            }
        };
        let gain = gain.filter(|gain| gain.iter().all(|g| g.is_finite())).ok_or_else(|| {
            let problem = "the signals do not determine the parameters; reduce the order or record a richer command";
            Error::trace(&trace.id, problem)
        })?;
        Ok(Self { first, residuals, sensitivity, gain, spread })
    }

    /// w of (3).
    #[must_use]
    pub fn weight(&self, signal: &DVector<f64>) -> DVector<f64> {
        signal - &self.gain * self.sensitivity.tr_mul(signal)
    }

    /// The last term of (4) as a sum of independent sources of variance 1; empty if parameters are estimated here.
    #[must_use]
    pub fn spread(&self, signal: &DVector<f64>) -> DVector<f64> {
        self.spread.as_ref().map_or_else(|| DVector::zeros(0), |spread| spread * signal)
    }

    /// Number of estimated parameters.
    #[must_use]
    pub fn parameters(&self) -> usize {
        self.gain.ncols()
    }
}

/// X (XᵀX)⁻¹ = Q R⁻ᵀ.
fn pseudo_inverse(x: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let qr = x.clone().qr();
    let n = x.ncols();
    let inverse = qr.r().solve_upper_triangular(&DMatrix::identity(n, n))?;
    Some(qr.q() * inverse.transpose())
}

/// L*Q (QᵀX)⁻ᵀ with Z = QR.
fn instrumental(x: &DMatrix<f64>, z: DMatrix<f64>, noise: &Noise) -> Option<DMatrix<f64>> {
    let q = z.qr().q();
    let inverse = q.tr_mul(x).try_inverse()?;
    let mut backwards = q;
    for mut column in backwards.column_iter_mut() {
        let filtered = noise.whiten_backwards(column.as_slice());
        column.copy_from_slice(&filtered);
    }
    Some(backwards * inverse.transpose())
}

/// Rows of −y(t−1)…, u1(t−nkb)…, u2(t−nkc)…, constant from t = 0, with zeros before the record.
fn regressors(structure: Structure, y: &[f64], u1: &[f64], u2: &[f64], constant: f64) -> DMatrix<f64> {
    let Structure { na, nb, nc, nkb, nkc, .. } = structure;
    let (na, nb, nc) = (na as usize, nb as usize, nc as usize);
    DMatrix::from_fn(y.len(), structure.parameters(), |t, column| {
        let before = |x: &[f64], age: usize| t.checked_sub(age).map_or(0.0, |place| x[place]);
        if column < na {
            -before(y, 1 + column)
        } else if column < na + nb {
            before(u1, nkb as usize + column - na)
        } else if column < na + nb + nc {
            before(u2, nkc as usize + column - na - nb)
        } else {
            constant
        }
    })
}

/// ε = (equation error)/D from t₀, with zeros before t₀ as in armax, and −∂ε/∂(θ, d): the regressors and ε(t−1)…,
/// filtered by 1/D.
fn prediction_slopes(x: DMatrix<f64>, equation: DVector<f64>, noise: &NoiseModel) -> (DVector<f64>, DMatrix<f64>) {
    let white = [1.0];
    let d = match noise {
        NoiseModel::MovingAverage { terms, .. } => terms.as_slice(),
        _ => &white,
    };
    let mut residuals = equation;
    all_pole(d, residuals.as_mut_slice());
    let (n, terms) = (x.ncols(), d.len() - 1);
    let delayed = |t: usize, age: usize| t.checked_sub(age).map_or(0.0, |place| residuals[place]);
    let mut slopes = x.resize_horizontally(n + terms, 0.0);
    for k in 0..terms {
        (0..residuals.len()).for_each(|t| slopes[(t, n + k)] = delayed(t, k + 1));
    }
    slopes.column_iter_mut().for_each(|mut column| all_pole(d, column.as_mut_slice()));
    (residuals, slopes)
}

/// ∂ŷ/∂θ: the regressors of the simulated output, filtered by 1/A from the start of the simulation.
fn output_slopes(trace: &Trace, structure: Structure, theta: &[f64], simulated: &[f64]) -> DMatrix<f64> {
    let ([a, _, _], _) = structure.polynomials(theta);
    let a = reflect_unstable(&a);
    let known = if structure.offset { structure.depth() } else { 0 };
    let mut slopes = regressors(structure, simulated, &trace.u1, &trace.u2, 1.0);
    slopes.rows_mut(0, known).fill(0.0);
    slopes.column_iter_mut().for_each(|mut column| all_pole(&a, column.as_mut_slice()));
    slopes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::{Method, estimate};

    fn trace() -> Trace {
        let u1: Vec<f64> = (0..60).map(|t| f64::from(t * t % 17) - 8.0).collect();
        let u2: Vec<f64> = (0..60).map(|t| f64::from(t * t * t % 23) - 11.0).collect();
        let mut y = vec![0.0; 60];
        for t in 1..60 {
            let noise = f64::from(u8::try_from(t * 7 % 11).expect("small")) - 5.0;
            y[t] = 0.6 * y[t - 1] + u1[t - 1] + 0.3 * u2[t - 1] + 0.5 * noise;
        }
        Trace { id: "hand".into(), interval_s: None, irregular_steps: 0, y, u1, u2, motion: None, ..Trace::default() }
    }

    #[test]
    fn gain_inverts_sensitivity_and_fitted_signals_vanish() {
        let trace = trace();
        let structure = Structure::new(1, 1, 1, 1, 1).with_offset();
        let estimate = estimate(&trace, structure, Method::Ls).expect("well posed");
        for errors in [Errors::LeastSquares, Errors::Simulation] {
            let linear = Linearised::new(&trace, &estimate, errors).expect("well posed");
            let unit = linear.gain.tr_mul(&linear.sensitivity);
            assert!((unit - DMatrix::identity(4, 4)).norm() < 1e-9, "{errors:?}"); // rounding of a 60 × 4 system
        }
        let linear = Linearised::new(&trace, &estimate, Errors::LeastSquares).expect("well posed");
        let regressor = DVector::from_column_slice(&trace.u1[..59]);
        assert!(linear.weight(&regressor).norm() < 1e-9 * regressor.norm());
    }

    #[test]
    fn slopes_of_the_simulated_output_are_its_differences() {
        let trace = trace();
        let structure = Structure::new(1, 1, 1, 1, 1).with_offset();
        let theta = [-0.6, 1.0, 0.3, 0.2];
        let base = simulate(&trace, structure, &theta);
        let slopes = output_slopes(&trace, structure, &theta, &base);
        for k in 0..4 {
            let mut moved = theta;
            moved[k] += 1e-6;
            let other = simulate(&trace, structure, &moved);
            for t in 0..60 {
                let difference = (other[t] - base[t]) / 1e-6;
                // The curvature and the cancellation of the difference quotient are of this size.
                assert!((difference - slopes[(t, k)]).abs() < 1e-3, "parameter {k}, sample {t}");
            }
        }
    }
}
