//! Whether all poles of a model of up to four output terms lie inside the unit circle, told from its δ-form.
//!
//! ```text
//! z = (1 + w)/(1 − w) takes the unit circle's inside to Re w < 0;  A(z) (1 − w)ⁿ becomes
//! p(w) = 2w (1 + w)ⁿ⁻¹ − t₀ (1 + w)ⁿ⁻¹ (1 − w) − Σ_{k=1}^{n−1} t_k 2w (1 + w)ⁿ⁻¹⁻ᵏ (1 − w)ᵏ           (1)
//! ```
//!
//! The Routh–Hurwitz conditions of p are Jury's of A. In this form nothing cancels near z = 1: the constant of p is
//! −t₀ = 1 + Σa itself, where Jury's table would take the difference of numbers near one.

/// Whether the model with these t₀ … t_{n−1} is stable; `false` for more than four and for NaN.
#[must_use]
#[inline(always)]
pub const fn is_stable(t: &[f32]) -> bool {
    // The coefficients of (1), the constant first.
    match *t {
        [] => true,
        [t0] => -t0 > 0.0 && 2.0 + t0 > 0.0,
        [t0, t1] => -t0 > 0.0 && 1.0 - t1 > 0.0 && 2.0 + t0 + 2.0 * t1 > 0.0,
        [t0, t1, t2] => {
            let c0 = -t0;
            let c1 = 2.0 - t0 - 2.0 * (t1 + t2);
            let c2 = 4.0 + t0 + 4.0 * t2;
            let c3 = 2.0 + t0 + 2.0 * (t1 - t2);
            c0 > 0.0 && c1 > 0.0 && c2 > 0.0 && c3 > 0.0 && c1 * c2 > c0 * c3
        }
        [t0, t1, t2, t3] => {
            let c0 = -t0;
            let c1 = 2.0 * (1.0 - t0 - t1 - t2 - t3);
            let c2 = 2.0 * (3.0 - t1 + t2 + 3.0 * t3);
            let c3 = 2.0 * (3.0 + t0 + t1 + t2 - 3.0 * t3);
            let c4 = 2.0 + t0 + 2.0 * (t1 - t2 + t3);
            let positive = c0 > 0.0 && c1 > 0.0 && c2 > 0.0 && c3 > 0.0 && c4 > 0.0;
            positive && c3 * (c1 * c2 - c0 * c3) > c4 * c1 * c1
        }
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    /// t of the polynomial with these poles, real or in conjugate pairs (radius, angle).
    fn delta(real: &[f64], pairs: &[(f64, f64)]) -> Vec<f32> {
        let mut a = std::vec![1.0_f64];
        let mut times = |factor: &[f64]| {
            let mut product = std::vec![0.0; a.len() + factor.len() - 1];
            for (i, x) in a.iter().enumerate() {
                factor.iter().enumerate().for_each(|(j, f)| product[i + j] += x * f);
            }
            a = product;
        };
        real.iter().for_each(|pole| times(&[1.0, -pole]));
        pairs.iter().for_each(|(r, angle)| times(&[1.0, -2.0 * r * angle.cos(), r * r]));
        (0..a.len() - 1).map(|k| if k == 0 { -a.iter().sum::<f64>() } else { a[k + 1..].iter().sum() } as f32).collect()
    }

    #[test]
    fn poles_on_either_side_of_the_circle() {
        for r in [0.2, 0.9, 0.999, 0.9999, 1.0001, 1.001, 1.1, 3.0] {
            let stable = r < 1.0;
            for other in [-0.95, -0.3, 0.0, 0.5, 0.999] {
                for sign in [1.0, -1.0] {
                    assert_eq!(is_stable(&delta(&[sign * r], &[])), stable, "{r}");
                    assert_eq!(is_stable(&delta(&[sign * r, other], &[])), stable, "{r} {other}");
                    assert_eq!(is_stable(&delta(&[sign * r, other, 0.7], &[])), stable, "{r} {other} 0.7");
                    assert_eq!(is_stable(&delta(&[sign * r, other, -0.2, 0.4], &[])), stable, "{r} {other} four");
                }
                for angle in [0.3, 1.0, 2.0, 3.0] {
                    assert_eq!(is_stable(&delta(&[], &[(r, angle)])), stable, "{r} {angle}");
                    assert_eq!(is_stable(&delta(&[other], &[(r, angle)])), stable, "{r} {angle} {other}");
                    assert_eq!(is_stable(&delta(&[other, 0.1], &[(r, angle)])), stable, "{r} {angle} {other} four");
                    assert_eq!(is_stable(&delta(&[], &[(r, angle), (0.8, 1.5)])), stable, "two pairs {r} {angle}");
                }
            }
        }
    }

    #[test]
    fn nan_and_too_many_terms_are_not_stable() {
        assert!(!is_stable(&[f32::NAN]) && !is_stable(&[-0.1, f32::NAN]) && !is_stable(&[-0.1; 5]));
        assert!(is_stable(&[]));
    }
}
