//! Damped Gauss–Newton (Levenberg–Marquardt) on a sum of squared residuals, by orthogonal factorisations.
//!
//! ```text
//! ε(θ), J = −∂ε/∂θ:   min ‖ε − J d‖² + λ ‖D d‖²,  D = column norms of J;   θ ← θ + d        (1)
//! cov θ = σ² (JᵀJ)⁻¹                                                                      (2)
//! ```
//!
//! λ starts at zero. J is triangularised once per step; each λ then costs a factorisation of 2n rows.

use nalgebra::{DMatrix, DVector};

use super::kernel::triangle::DEPENDENT;
use super::methods::ls;
use super::result::negligible;

const STEPS: usize = 100;
/// Damping below this value is set to zero.
const LEAST_DAMPING: f64 = 1e-7;
const MOST_DAMPING: f64 = 1e8;

/// Final point of the iteration.
pub(super) struct Minimum {
    pub theta: DVector<f64>,
    pub residuals: DVector<f64>,
    /// (JᵀJ)⁻¹.
    pub cofactor: DMatrix<f64>,
    pub converged: bool,
    pub iterations: usize,
}

/// A model as required by the minimiser.
pub(super) trait Model {
    /// ε and J; `None` if θ is not allowed or the signals overflow.
    fn linearise(&self, theta: &DVector<f64>) -> Option<(DVector<f64>, DMatrix<f64>)>;
}

/// Minimises from `theta`; returns `None` if the model is not allowed at `theta`.
pub(super) fn minimise(model: &impl Model, mut theta: DVector<f64>) -> Option<Minimum> {
    let (mut residuals, jacobian) = model.linearise(&theta)?;
    let mut system = Triangle::new(&residuals, jacobian);
    let (mut damping, mut iterations, mut converged) = (0.0, 0, false);
    while iterations < STEPS {
        let variance = residuals.norm_squared() / residuals.len() as f64;
        if let Some(step) = system.step(0.0) {
            let deviations = system.cofactor().diagonal().map(|q| (q * variance).sqrt());
            // The undamped step estimates the distance to the minimum; the limit is 1e-6 standard deviations.
            converged = negligible(&step, &(deviations * 10.0), &theta);
        }
        // If the model is exact, only rounding errors remain.
        converged |= residuals.norm() <= 1e-12 * system.size(&theta);
        if converged {
            break;
        }
        // Rounding alone may increase the sum by this fraction.
        let limit = residuals.norm_squared() * (1.0 + 1e-12);
        let next = loop {
            let tried = system.step(damping).and_then(|step| {
                let theta = &theta + step;
                let (residuals, jacobian) = model.linearise(&theta)?;
                (residuals.norm_squared() <= limit).then_some((theta, residuals, jacobian))
            });
            if tried.is_some() || damping > MOST_DAMPING {
                break tried;
            }
            damping = (damping * 8.0_f64).max(1e-4);
        };
        let Some((new_theta, new_residuals, jacobian)) = next else { break };
        (theta, residuals) = (new_theta, new_residuals);
        system = Triangle::new(&residuals, jacobian);
        damping = if damping < LEAST_DAMPING { 0.0 } else { damping / 10.0 };
        iterations += 1;
    }
    Some(Minimum { cofactor: system.cofactor(), theta, residuals, converged, iterations })
}

/// J = QR with columns of unit norm, and Qᵀε.
struct Triangle {
    r: DMatrix<f64>,
    rotated: DVector<f64>,
    norms: Vec<f64>,
}

impl Triangle {
    fn new(residuals: &DVector<f64>, mut jacobian: DMatrix<f64>) -> Self {
        let n = jacobian.ncols();
        let norms: Vec<f64> = jacobian.column_iter().map(|column| column.norm().max(f64::MIN_POSITIVE)).collect();
        jacobian.column_iter_mut().zip(&norms).for_each(|(mut column, norm)| column /= *norm);
        let qr = jacobian.qr();
        let mut rotated = residuals.clone();
        qr.q_tr_mul(&mut rotated);
        Self { r: qr.unpack_r(), rotated: rotated.rows(0, n).into_owned(), norms }
    }

    /// d of (1); `None` if J is singular and undamped.
    fn step(&self, damping: f64) -> Option<DVector<f64>> {
        let n = self.norms.len();
        let mut step = if damping == 0.0 {
            if self.is_singular() {
                return None;
            }
            self.r.solve_upper_triangular(&self.rotated)?
        } else {
            let mut stacked = DMatrix::zeros(2 * n, n);
            stacked.rows_mut(0, n).copy_from(&self.r);
            stacked.rows_mut(n, n).fill_diagonal(damping.sqrt());
            let mut target = DVector::zeros(2 * n);
            target.rows_mut(0, n).copy_from(&self.rotated);
            let qr = stacked.qr();
            qr.q_tr_mul(&mut target);
            qr.unpack_r().solve_upper_triangular(&target.rows(0, n).into_owned())?
        };
        step.iter_mut().zip(&self.norms).for_each(|(d, norm)| *d /= norm);
        step.iter().all(|d| d.is_finite()).then_some(step)
    }

    /// Σ |θₖ| ‖Jₖ‖, the magnitude of the summed terms of the model.
    fn size(&self, theta: &DVector<f64>) -> f64 {
        theta.iter().zip(&self.norms).map(|(theta, norm)| theta.abs() * norm).sum()
    }

    fn is_singular(&self) -> bool {
        self.r.diagonal().iter().any(|d| d.is_nan() || d.abs() < DEPENDENT)
    }

    /// (2); infinite if J is singular.
    fn cofactor(&self) -> DMatrix<f64> {
        let n = self.norms.len();
        let inverse = (!self.is_singular()).then(|| self.r.solve_upper_triangular(&DMatrix::identity(n, n))).flatten();
        let Some(mut inverse) = inverse else { return ls::unknown(n) };
        inverse.row_iter_mut().zip(&self.norms).for_each(|(mut row, norm)| row /= *norm);
        &inverse * inverse.transpose()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// y = θ₁ exp(−θ₂ t), θ₂ > 0.
    struct Decay(DVector<f64>);

    impl Model for Decay {
        fn linearise(&self, theta: &DVector<f64>) -> Option<(DVector<f64>, DMatrix<f64>)> {
            let shape = |t: usize| (-theta[1] * t as f64).exp();
            let residuals = DVector::from_fn(self.0.len(), |t, _| self.0[t] - theta[0] * shape(t));
            let jacobian =
                DMatrix::from_fn(
                    self.0.len(),
                    2,
                    |t, k| {
                        if k == 0 { shape(t) } else { -theta[0] * t as f64 * shape(t) }
                    },
                );
            (theta[1] > 0.0).then_some((residuals, jacobian))
        }
    }

    #[test]
    fn finds_an_exact_decay_from_far_away() {
        let truth = DVector::from_fn(30, |t, _| 3.0 * (-0.2 * t as f64).exp());
        let found = minimise(&Decay(truth), DVector::from_column_slice(&[0.3, 2.0])).expect("allowed start");
        assert!(found.converged && (found.theta[0] - 3.0).abs() < 1e-9 && (found.theta[1] - 0.2).abs() < 1e-9);
    }

    #[test]
    fn a_singular_jacobian_has_no_covariance() {
        let found = minimise(&Decay(DVector::zeros(3)), DVector::from_column_slice(&[0.0, 1.0]));
        let found = found.expect("allowed start");
        assert!(found.cofactor[(0, 0)].is_infinite());
        assert!(minimise(&Decay(DVector::zeros(3)), DVector::from_column_slice(&[1.0, -1.0])).is_none());
    }

    /// ε = atan θ, of which an undamped step from 3 ends at −9.5 and the next one beyond 100.
    struct Arctangent;

    impl Model for Arctangent {
        fn linearise(&self, theta: &DVector<f64>) -> Option<(DVector<f64>, DMatrix<f64>)> {
            let jacobian = DMatrix::from_column_slice(2, 1, &[-1.0 / (1.0 + theta[0] * theta[0]), 0.0]);
            Some((DVector::from_column_slice(&[theta[0].atan(), 0.0]), jacobian))
        }
    }

    #[test]
    fn a_step_that_makes_the_error_larger_is_damped() {
        let found = minimise(&Arctangent, DVector::from_element(1, 3.0)).expect("allowed start");
        assert!(found.converged && found.theta[0].abs() < 1e-6, "{} {}", found.theta, found.iterations);
    }
}
