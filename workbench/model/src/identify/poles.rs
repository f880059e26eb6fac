//! Poles of a model: where they are, whether they are stable, and their reflection into the unit circle.
//!
//! The Schur–Cohn recursion tests first whether all are inside; eigenvalues are computed only if a reflection
//! coefficient is close to one or larger.

use nalgebra::{Complex, DMatrix, Schur};

/// Distance of a reflection coefficient from one within which rounding could change the decision.
const SURE: f64 = 1e-9;

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

/// Schur–Cohn test: whether every reflection coefficient of `1 + a₁ z⁻¹ + …` is below one by more than `SURE`.
pub(super) fn surely_stable(a: &[f64]) -> bool {
    let mut held = [0.0; 32];
    let Some(now) = held.get_mut(..a.len()) else { return false };
    now.copy_from_slice(a);
    for order in (1..=a.len()).rev() {
        let k = now[order - 1];
        let rest = 1.0 - k * k;
        if !(k.abs() < 1.0 - SURE && rest > 0.0) {
            return false;
        }
        let below = order - 1;
        for i in 0..below.div_ceil(2) {
            let (low, high) = (now[i], now[below - 1 - i]);
            now[i] = (low - k * high) / rest;
            now[below - 1 - i] = (high - k * low) / rest;
        }
    }
    true
}

/// Whether `1 + a₁ z⁻¹ + …` has no root outside the unit circle.
pub(super) fn stable(a: &[f64]) -> bool {
    // The computed position of a double pole on the circle has an error of this size.
    surely_stable(&a[1..]) || poles(a).iter().all(|pole| pole.norm() <= 1.0 + 1e-6)
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
    fn stability_is_that_of_the_poles() {
        // Poles 0.9 and −0.8; 0.9e^{±j}; 1.1 and 0.5; 1 and 0.5.
        assert!(surely_stable(&[-0.1, -0.72]));
        assert!(surely_stable(&[-1.8 * 1.0_f64.cos(), 0.81]));
        assert!(!surely_stable(&[-1.6, 0.55]));
        assert!(!surely_stable(&[-1.5, 0.5]), "on the circle the eigenvalues decide");
    }

    #[test]
    fn a_model_that_grows_slowly_is_not_stable() {
        // Poles 1.005; 1; 1 twice, whose computed position is off by 1e-8.
        assert!(!stable(&[1.0, -1.005]) && stable(&[1.0, -1.0]) && stable(&[1.0, -2.0, 1.0]));
    }
}
