//! Roots of a polynomial with confidence regions, from the covariance of the coefficients.
//!
//! ```text
//! p(z) = p₀ zⁿ + … + p_n,    ∂z/∂p_k = −z^(n−k) / p′(z)                                       (1)
//! cov (Re z, Im z) = J cov(p) Jᵀ,    J = [Re; Im] of (1)                                      (2)
//! region: |Δ| ≤ 3 sd of a real root, 99.7 %;   Δᵀ cov⁻¹ Δ ≤ 9 of a complex one, 1 − e^(−9/2) = 98.9 %   (3)
//! ```
//!
//! The delta method requires well-separated roots: near a double root p′ vanishes, the standard deviation grows with
//! the square root of the coefficient errors, and two real roots may be estimates of a complex pair. A root is marked
//! as not separated if its region reaches half way to another root of its polynomial; its region is then only a rough
//! indication.

use std::f64::consts::TAU;

use nalgebra::{Complex, DMatrix, Matrix2, Vector2};

use crate::identify::{Estimate, poles};

/// A root with its uncertainty.
#[derive(Clone, Debug, PartialEq)]
pub struct Root {
    /// Position in the z-plane.
    pub at: Complex<f64>,
    /// Covariance of (Re, Im); for a real root only the variance of Re is nonzero.
    pub covariance: Matrix2<f64>,
    /// Whether its 3σ region is clear of the other roots, so that the linearisation is valid.
    pub separated: bool,
}

impl Root {
    /// Whether the root is real.
    #[must_use]
    pub fn is_real(&self) -> bool {
        self.at.im == 0.0
    }

    /// Whether the region of `sigmas` standard deviations contains `place`.
    #[must_use]
    pub fn covers(&self, place: Complex<f64>, sigmas: f64) -> bool {
        let offset = Vector2::new(place.re - self.at.re, place.im - self.at.im);
        if self.is_real() {
            return offset.y == 0.0 && offset.x.abs() <= sigmas * self.covariance[(0, 0)].sqrt();
        }
        self.covariance.try_inverse().is_some_and(|inverse| (inverse * offset).dot(&offset) <= sigmas * sigmas)
    }

    /// Distance from the root to the edge of the region along a unit direction.
    fn support(&self, direction: Vector2<f64>, sigmas: f64) -> f64 {
        sigmas * (self.covariance * direction).dot(&direction).max(0.0).sqrt()
    }

    /// Whether the regions overlap: two convex sets are disjoint if some direction separates them.
    #[must_use]
    pub fn overlaps(&self, other: &Self, sigmas: f64) -> bool {
        const DIRECTIONS: u32 = 720;
        let offset = Vector2::new(other.at.re - self.at.re, other.at.im - self.at.im);
        !(0..DIRECTIONS).any(|k| {
            let (sine, cosine) = (TAU * f64::from(k) / f64::from(DIRECTIONS)).sin_cos();
            let along = Vector2::new(cosine, sine);
            offset.dot(&along) > self.support(along, sigmas) + other.support(along, sigmas)
        })
    }

    /// Outline of the region: an ellipse, or the two end points of the interval of a real root.
    #[must_use]
    pub fn outline(&self, sigmas: f64) -> Vec<(f64, f64)> {
        const POINTS: u32 = 64;
        if self.is_real() {
            let half = sigmas * self.covariance[(0, 0)].sqrt();
            return vec![(self.at.re - half, 0.0), (self.at.re + half, 0.0)];
        }
        let eigen = self.covariance.symmetric_eigen();
        let axes = eigen.eigenvectors * Matrix2::from_diagonal(&eigen.eigenvalues.map(|v| sigmas * v.max(0.0).sqrt()));
        let point = |k: u32| {
            let (sine, cosine) = (TAU * f64::from(k) / f64::from(POINTS)).sin_cos();
            let offset = axes * Vector2::new(cosine, sine);
            (self.at.re + offset.x, self.at.im + offset.y)
        };
        (0..POINTS).map(point).collect()
    }
}

/// Roots of `p₀ zⁿ + … + p_n` with the covariance of their regions; empty if p₀ is zero.
#[must_use]
pub fn roots(coefficients: &[f64], covariance: &DMatrix<f64>, sigmas: f64) -> Vec<Root> {
    let Some(&leading) = coefficients.first().filter(|p| p.abs() > 0.0) else { return vec![] };
    let monic: Vec<f64> = coefficients.iter().map(|p| p / leading).collect();
    let n = coefficients.len() - 1;
    let mut found: Vec<Complex<f64>> = poles(&monic);
    for z in &mut found {
        // Computed real eigenvalues of a real matrix may have an imaginary part from rounding.
        if z.im.abs() < 1e-12 * (1.0 + z.re.abs()) {
            z.im = 0.0;
        }
    }
    found.sort_by(|x, y| x.re.total_cmp(&y.re).then(x.im.total_cmp(&y.im)));
    let with_region = |(place, &z): (usize, &Complex<f64>)| {
        let others = found.iter().enumerate().filter(|(other, _)| *other != place).map(|(_, z)| *z);
        let slope = others.clone().fold(Complex::new(leading, 0.0), |slope, other| slope * (z - other));
        let power = |k: usize| if n == k { Complex::new(1.0, 0.0) } else { z.powu(u32::try_from(n - k).unwrap_or(0)) };
        let gradient: Vec<Complex<f64>> = (0..=n).map(|k| -power(k) / slope).collect();
        let jacobian = DMatrix::from_fn(2, n + 1, |row, k| if row == 0 { gradient[k].re } else { gradient[k].im });
        let spread = &jacobian * covariance * jacobian.transpose();
        let mut covariance = Matrix2::new(spread[(0, 0)], spread[(0, 1)], spread[(1, 0)], spread[(1, 1)]);
        if z.im == 0.0 {
            covariance = Matrix2::new(covariance[(0, 0)], 0.0, 0.0, 0.0);
        }
        let nearest = others.map(|other| (z - other).norm()).fold(f64::INFINITY, f64::min);
        let widest = sigmas * covariance.symmetric_eigenvalues().max().max(0.0).sqrt();
        Root { at: z, covariance, separated: widest <= 0.5 * nearest }
    };
    found.iter().enumerate().map(with_region).collect()
}

/// A pole that a zero of one input may cancel: indices into [`PoleZeroMap`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Overlap {
    /// Index into `poles`.
    pub pole: usize,
    /// 0 for u1, 1 for u2.
    pub input: usize,
    /// Index into `zeros[input]`.
    pub zero: usize,
}

/// Poles of A, zeros of B and C, with their regions.
#[derive(Clone, Debug, PartialEq)]
pub struct PoleZeroMap {
    /// Roots of A.
    pub poles: Vec<Root>,
    /// Roots of B and of C, without the roots at zero and infinity caused by the delays.
    pub zeros: [Vec<Root>; 2],
    /// Pairs whose regions overlap.
    pub overlaps: Vec<Overlap>,
    /// Poles that a zero may cancel for every input of the model: A, B and C could each have one term less.
    pub removable: Vec<usize>,
}

impl PoleZeroMap {
    /// The map of an estimate, with regions of `sigmas` standard deviations.
    #[must_use]
    pub fn new(estimate: &Estimate, sigmas: f64) -> Self {
        let order = estimate.structure;
        let (na, nb, nc) = (order.na as usize, order.nb as usize, order.nc as usize);
        let theta = estimate.theta.as_slice();
        let block = |from: usize, n: usize| estimate.covariance.view((from, from), (n, n)).into_owned();
        let mut of_a = DMatrix::zeros(na + 1, na + 1);
        of_a.view_mut((1, 1), (na, na)).copy_from(&block(0, na));
        let monic = [&[1.0], &theta[..na]].concat();
        let poles = roots(&monic, &of_a, sigmas);
        let zeros = [(na, nb), (na + nb, nc)].map(|(from, n)| roots(&theta[from..from + n], &block(from, n), sigmas));
        let mut overlaps = Vec::new();
        for (pole, root) in poles.iter().enumerate() {
            for (input, zeros) in zeros.iter().enumerate() {
                let meeting = zeros.iter().enumerate().filter(|(_, zero)| root.overlaps(zero, sigmas));
                overlaps.extend(meeting.map(|(zero, _)| Overlap { pole, input, zero }));
            }
        }
        let present = [nb > 0, nc > 0];
        let met = |pole: usize, input: usize| overlaps.iter().any(|o| (o.pole, o.input) == (pole, input));
        let everywhere = |pole: &usize| (0..2).all(|input| !present[input] || met(*pole, input));
        let removable = (0..poles.len()).filter(everywhere).filter(|_| present != [false; 2]).collect();
        Self { poles, zeros, overlaps, removable }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DVector;

    use super::*;

    #[test]
    fn regions_of_known_roots() {
        // z² − 1.1 z + 0.3 = (z − 0.5)(z − 0.6): dz/dp₁ = −z/p′, p′(0.5) = −0.1, p′(0.6) = 0.1.
        let covariance = DMatrix::from_diagonal(&DVector::from_vec(vec![0.0, 1e-8, 0.0]));
        let found = roots(&[1.0, -1.1, 0.3], &covariance, 3.0);
        for (root, (at, sd)) in found.iter().zip([(0.5, 5e-4), (0.6, 6e-4)]) {
            assert!((root.at.re - at).abs() < 1e-9 && (root.covariance[(0, 0)].sqrt() - sd).abs() < 1e-9, "{root:?}");
            assert!(root.is_real() && root.separated);
        }
        let wide = roots(&[1.0, -1.1, 0.3], &(covariance * 1e4), 3.0);
        assert!(!wide[0].separated, "3 × 0.05 is more than half of the distance 0.1");
        assert!(roots(&[0.0, 1.0], &DMatrix::zeros(2, 2), 3.0).is_empty(), "no leading term, no roots");
    }

    #[test]
    fn regions_meet_as_their_shapes_say() {
        let ellipse = |re: f64, im: f64, sd_re: f64, sd_im: f64| Root {
            at: Complex::new(re, im),
            covariance: Matrix2::new(sd_re * sd_re, 0.0, 0.0, sd_im * sd_im),
            separated: true,
        };
        let one = ellipse(0.0, 1.0, 0.1, 0.3);
        assert!(one.overlaps(&ellipse(0.59, 1.0, 0.1, 0.1), 3.0) && !one.overlaps(&ellipse(0.61, 1.0, 0.1, 0.1), 3.0));
        // The lower end of the first ellipse is at 0.1; an interval on the real axis does not reach it.
        assert!(!one.overlaps(&ellipse(0.0, 0.0, 0.2, 0.0), 3.0));
        let on_axis = ellipse(1.0, 0.0, 0.1, 0.0);
        assert!(
            on_axis.overlaps(&ellipse(1.5, 0.0, 0.1, 0.0), 3.0) && !on_axis.overlaps(&ellipse(1.7, 0.0, 0.1, 0.0), 3.0)
        );
        assert!(one.covers(Complex::new(0.29, 1.0), 3.0) && !one.covers(Complex::new(0.2, 1.7), 3.0));
    }
}
