//! Free-run simulation and its fit.

use nalgebra::{Complex, DMatrix, Schur};

use super::Structure;
use super::kernel::free_run::{FreeRun, surely_stable};
use super::kernel::sums::{distance, spread};
use crate::trace::Trace;

/// Output of the model from the inputs alone; unstable poles are reflected into the unit circle. Starts from zero. If a
/// constant term is estimated, zero is not an operating point; the simulation then starts from the first t₀ measured
/// outputs.
#[must_use]
pub fn simulate(trace: &Trace, structure: Structure, theta: &[f64]) -> Vec<f64> {
    let mut output = Vec::new();
    FreeRun::new(structure, theta).simulate(trace, &mut output);
    output
}

/// Thesis Eq. 3.2: 100 (1 − ‖ŷ − y‖/‖y − mean y‖).
#[must_use]
pub fn fit_percent(measured: &[f64], simulated: &[f64]) -> f64 {
    fit_of_error(distance(measured, simulated), measured)
}

/// Eq. 3.2 from the squared norm ‖ŷ − y‖².
pub(super) fn fit_of_error(error: f64, measured: &[f64]) -> f64 {
    100.0 * (1.0 - (error / spread(measured)).sqrt())
}

/// Roots in z of `1 + a₁ z⁻¹ + …`, as eigenvalues of the companion matrix; NaN if `a` contains NaN or infinity.
#[must_use]
pub fn poles(a: &[f64]) -> Vec<Complex<f64>> {
    let n = a.len() - 1;
    if a.iter().any(|a| !a.is_finite()) {
        return vec![Complex::new(f64::NAN, f64::NAN); n];
    }
    // Zero trailing coefficients are roots at zero, for which the eigenvalue iteration may not terminate.
    let zeros = a[1..].iter().rev().take_while(|a| **a == 0.0).count();
    let a = &a[..a.len() - zeros];
    let mut roots = vec![Complex::new(0.0, 0.0); zeros];
    if n > zeros {
        let n = n - zeros;
        let companion = DMatrix::from_fn(n, n, |i, j| match i {
            0 => -a[j + 1],
            _ => f64::from(u8::from(j + 1 == i)),
        });
        match Schur::try_new(companion, f64::EPSILON, EIGENVALUE_SWEEPS * n) {
            Some(schur) => roots.extend(schur.complex_eigenvalues().iter()),
            None => roots.extend(simultaneous_roots(a)),
        }
    }
    roots
}

/// Maximum number of sweeps of the eigenvalue iteration per root; it has no exceptional shifts and can cycle.
const EIGENVALUE_SWEEPS: usize = 60;

/// Roots by Weierstrass' simultaneous iteration, from starting points without symmetry.
fn simultaneous_roots(a: &[f64]) -> Vec<Complex<f64>> {
    let bound = 1.0 + a[1..].iter().fold(0.0_f64, |most, a| most.max(a.abs()));
    let mut roots: Vec<Complex<f64>> =
        (0..a.len() - 1).map(|k| Complex::from_polar(0.5 * bound, 0.4 + 2.39996 * k as f64)).collect();
    for _ in 0..500 {
        for k in 0..roots.len() {
            let value = a.iter().fold(Complex::new(0.0, 0.0), |sum, a| sum * roots[k] + a);
            let others = (0..roots.len()).filter(|&j| j != k).map(|j| roots[k] - roots[j]);
            let step = value / others.fold(Complex::new(1.0, 0.0), |product, gap| product * gap);
            roots[k] -= step;
        }
    }
    roots
}

/// `1 + a₁ z⁻¹ + …` with every pole p outside the unit circle replaced by 1/p̄.
#[must_use]
pub fn reflect_unstable(a: &[f64]) -> Vec<f64> {
    if surely_stable(&a[1..]) {
        return a.to_vec();
    }
    let poles = poles(a);
    if poles.iter().all(|p| p.norm() <= 1.0) || poles.iter().any(|p| !p.re.is_finite() || !p.im.is_finite()) {
        return a.to_vec();
    }
    let mut polynomial = vec![Complex::new(1.0, 0.0)];
    for pole in poles {
        let pole = if pole.norm() > 1.0 { pole.conj().inv() } else { pole };
        polynomial.push(Complex::new(0.0, 0.0));
        for k in (1..polynomial.len()).rev() {
            let shifted = polynomial[k - 1] * pole;
            polynomial[k] -= shifted;
        }
    }
    polynomial.iter().map(|c| c.re).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reflection_mirrors_only_what_is_outside() {
        // Poles 2 and 0.5·(±j): (1 − 2z⁻¹)(1 + 0.25z⁻²) → (1 − 0.5z⁻¹)(1 + 0.25z⁻²)
        let reflected = reflect_unstable(&[1.0, -2.0, 0.25, -0.5]);
        for (got, want) in reflected.iter().zip([1.0, -0.5, 0.25, -0.125]) {
            assert!((got - want).abs() < 1e-12, "{reflected:?}"); // eigenvalues of a 3×3 matrix, to rounding
        }
        let stable = [1.0, -0.5];
        assert_eq!(reflect_unstable(&stable), stable, "stable polynomials pass bit for bit");
    }

    #[test]
    fn poles_of_difficult_polynomials() {
        assert_eq!(poles(&[1.0, 0.0, 0.0, 0.0]), [Complex::new(0.0, 0.0); 3]);
        assert!(poles(&[1.0, f64::NAN, 0.1]).iter().all(|p| p.re.is_nan()));
        // z³ + 0.5: three roots of equal magnitude.
        for roots in [poles(&[1.0, 0.0, 0.0, 0.5]), simultaneous_roots(&[1.0, 0.0, 0.0, 0.5])] {
            assert!(roots.iter().all(|p| (p.powu(3) + 0.5).norm() < 1e-12), "{roots:?}"); // rounding
        }
    }

    #[test]
    fn fit_of_truth_and_of_the_mean() {
        let y = [1.0, 2.0, 3.0];
        assert_eq!(fit_percent(&y, &y), 100.0);
        assert_eq!(fit_percent(&y, &[2.0; 3]), 0.0);
    }
}
