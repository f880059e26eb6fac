//! A Gaussian density whose coordinates have errors or are missing.
//!
//! Enters: z, and the variance v of the error of each coordinate, infinite if the coordinate is missing. Leaves: d² and
//! ln p(z) over the k available coordinates.
//!
//! ```text
//! Σ = Rᵀ D R                                                             (1)  R unit upper triangle, D diagonal
//! Σ + diag(v) = R'ᵀ D' R'                                                (2)
//! row i:  D'_i = D_i + v_i,  r'_i = r_i D_i/D'_i;  then the rows below take r_i with weight w = D_i v_i/D'_i:
//!         d = D_j + w x_j²,  s = w x_j/d,  w ← w D_j/d,  D_j ← d,  x ← x − x_j r_j,  r_j ← r_j + s x        (3)
//! R'ᵀ y = z − μ,   d² = Σ y_i²/D'_i                                      (4)
//! ln p = −½ (k ln 2π + Σ ln D'_i + d²)                                   (5)
//! ```
//!
//! The model stores (1): of each row `D_i` and then `r_i`, Z (Z + 1)/2 numbers. (3) is the rotation of
//! Gentleman (1973), as in the regression. It adds variances only: every D' is at least D, so no pivot can become zero
//! or negative, and with v = 0 the stored numbers remain. For `v_i` → ∞ it becomes `D'_i` = ∞, `r'_i` = 0 and w =
//! `D_i`, which is the density of the other coordinates; a sum (5) leaves out the infinite pivot.
//!
//! Cost: Z logarithms and Z (Z − 1)/2 multiply-adds a density without errors; each error adds at most Z² of them.

use super::rising::Scores;
use crate::logarithm::ln;
use crate::plan::{Array, Cells, Plan};
use crate::regression::factor::kernels::rotate_pivot_small;
use crate::regression::factor::pairs;
use crate::unroll::no_unroll;

const LN_2PI: f32 = 1.837_877_1;

/// The factor (2).
#[derive(Clone, Debug)]
pub(crate) struct Density<P: Plan> {
    factor: Array<P::Density, f32>,
    /// Σ ln D' of the available rows.
    log_determinant: f32,
    /// Number of available coordinates, and of all.
    available: usize,
    coordinates: usize,
}

impl<P: Plan> Density<P> {
    /// Of a factor (1) and the variances of so many coordinates; those without a variance have no error.
    #[inline(never)]
    pub(crate) fn of(factor: &[f32], variances: &[f32], coordinates: usize) -> Self {
        let length = crate::regression::factor::lower(coordinates, 0);
        let mut density = Self { factor: Cells::filled(length, 1.0), log_determinant: 0.0, available: 0, coordinates };
        pairs(no_unroll(density.factor.cells_mut()), factor).for_each(|(cell, x)| *cell = *x);
        let mut x: Array<P::Coordinates, f32> = Cells::filled(coordinates, 0.0);
        let mut rows = density.factor.cells_mut();
        for k in 0..no_unroll(coordinates) {
            let below = x.cells_mut().get_mut(k.wrapping_add(1)..).unwrap_or_default();
            let Some((row, later)) = rows.split_at_mut_checked(below.len().wrapping_add(1)) else { break };
            let [pivot, row @ ..] = row else { break };
            let variance = variances.get(k).copied().unwrap_or(0.0);
            if variance > 0.0 {
                let weight = widen(pivot, row, variance, below);
                take(later, below, weight);
            }
            if *pivot < f32::INFINITY {
                density.log_determinant += ln(*pivot);
                density.available = density.available.saturating_add(1);
            }
            rows = later;
        }
        density
    }

    /// Number of available coordinates.
    pub(crate) const fn available(&self) -> usize {
        self.available
    }

    /// d² of (4).
    #[inline(never)]
    pub(crate) fn squared_distance(&self, mean: &[f32], z: &[f32]) -> f32 {
        let mut sum = 0.0;
        self.solve(mean, z, |y, pivot, _| sum += y * (y / pivot));
        sum
    }

    /// d² of (4), and the values that are judged one by one ([`super::rising`]).
    #[inline(never)]
    pub(crate) fn scores(&self, mean: &[f32], z: &[f32], freedom: f32, judged: &mut [f32]) -> Scores {
        let (mut scores, all) = (Scores::default(), z.len());
        self.solve(mean, z, |y, pivot, after| {
            let k = all.wrapping_sub(after).wrapping_sub(1);
            scores.add(y, pivot, [k, all], freedom, judged);
        });
        scores
    }

    /// Solves (4) for each y in turn, which `take` gets with D' and the number of coordinates after it.
    #[inline(always)]
    pub(crate) fn solve(&self, mean: &[f32], z: &[f32], mut take: impl FnMut(f32, f32, usize)) {
        let centred = |k: usize| z.get(k).copied().unwrap_or(0.0) - mean.get(k).copied().unwrap_or(0.0);
        let mut left: Array<P::Coordinates, f32> = Cells::from_fn(z.len(), centred);
        let (mut left, mut rest) = (left.cells_mut(), self.factor.cells());
        while let [y, later @ ..] = left {
            let Some((row, below)) = rest.split_at_checked(later.len().saturating_add(1)) else { break };
            let [pivot, row @ ..] = row else { break };
            pairs(&mut *later, row).for_each(|(x, r)| *x -= *y * *r);
            take(*y, *pivot, later.len());
            (left, rest) = (later, below);
        }
    }

    /// D' of each coordinate, infinite where it is missing.
    pub(crate) fn pivots(&self) -> impl Iterator<Item = f32> {
        pivots(self.factor.cells(), self.coordinates)
    }

    /// (5) from (4).
    pub(crate) fn log_density(&self, squared: f32) -> f32 {
        -0.5 * (self.available as f32 * LN_2PI + self.log_determinant + squared)
    }
}

/// D of each of so many coordinates, of a factor (1).
pub(crate) fn pivots(factor: &[f32], coordinates: usize) -> impl Iterator<Item = f32> {
    let (mut rest, mut length) = (factor, coordinates);
    core::iter::from_fn(move || {
        let (row, below) = rest.split_at_checked(length)?;
        (rest, length) = (below, length.checked_sub(1)?);
        row.first().copied()
    })
}

/// The row's own part of (3): widens the pivot and reduces what is right of it, which x then has as it was; returns w.
fn widen(pivot: &mut f32, row: &mut [f32], variance: f32, x: &mut [f32]) -> f32 {
    let wide = *pivot + variance;
    let (kept, share) = if wide < f32::INFINITY { (*pivot / wide, variance / wide) } else { (0.0, 1.0) };
    for (x, r) in pairs(x, row) {
        *x = *r;
        *r *= kept;
    }
    let weight = *pivot * share;
    *pivot = wide;
    weight
}

/// Rotates x of weight w into the rows of a factor.
fn take(mut rows: &mut [f32], mut x: &mut [f32], mut weight: f32) {
    while let [first, later @ ..] = x {
        let Some((row, below)) = rows.split_at_mut_checked(later.len().wrapping_add(1)) else { break };
        let [pivot, row @ ..] = row else { break };
        rotate_pivot_small(pivot, row, *first, later, &mut weight);
        (rows, x) = (below, later);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::RunTime;

    /// Σ = [4 2; 2 3]: D = (4, 2), r = 0.5.
    const FACTOR: [f32; 3] = [4.0, 0.5, 2.0];
    const Z: [f32; 2] = [3.0, -1.0];
    const MEAN: [f32; 2] = [1.0, 1.0];

    /// d², ln p, number of available coordinates.
    fn judged(variances: &[f32]) -> (f32, f32, usize) {
        let density = Density::<RunTime>::of(&FACTOR, variances, 2);
        let squared = density.squared_distance(&MEAN, &Z);
        (squared, density.log_density(squared), density.available())
    }

    fn near((squared, log, available): (f32, f32, usize), expected: (f32, f32, usize)) {
        // A few roundings of numbers near ten.
        assert!((squared - expected.0).abs() < 3e-6 * expected.0.max(1.0), "{squared} for {expected:?}");
        assert!((log - expected.1).abs() < 3e-6 * expected.1.abs().max(1.0), "{log} for {expected:?}");
        assert_eq!(available, expected.2);
    }

    #[test]
    fn pivots_are_the_first_elements_of_the_rows() {
        let pivots =
            |variances: &[f32]| Density::<RunTime>::of(&FACTOR, variances, 2).pivots().collect::<std::vec::Vec<_>>();
        assert_eq!(pivots(&[]), [4.0, 2.0]);
        // The second coordinate given the first one, whose error is infinite, has its own variance.
        assert_eq!(pivots(&[f32::INFINITY, 0.5]), [f32::INFINITY, 3.5]);
    }

    #[test]
    fn exact_coordinates_by_hand() {
        // z − μ = (2, −2); Σ⁻¹ = [3 −2; −2 4]/8: d² = (12 + 16 + 16)/8 = 5.5.
        let expected = (5.5, -LN_2PI - 0.5 * 8.0_f32.ln() - 2.75, 2);
        near(judged(&[]), expected);
        near(judged(&[0.0, 0.0]), expected);
    }

    #[test]
    fn variances_widen_the_covariance() {
        // Σ + diag(1, 0.5) = [5 2; 2 3.5], of determinant 13.5: adjugate [3.5 −2; −2 5], so
        // d² = (4·3.5 + 2·4·2 + 4·5)/13.5.
        let expected = (4.0 * 3.5 + 2.0 * 4.0 * 2.0 + 4.0 * 5.0) / 13.5;
        near(judged(&[1.0, 0.5]), (expected, -LN_2PI - 0.5 * 13.5_f32.ln() - 0.5 * expected, 2));
    }

    #[test]
    fn a_missing_coordinate_leaves_the_density_of_the_other() {
        let one = |variance: f32| (4.0 / variance, -0.5 * (LN_2PI + variance.ln() + 4.0 / variance), 1);
        near(judged(&[f32::INFINITY, 0.0]), one(3.0));
        near(judged(&[0.0, f32::INFINITY]), one(4.0));
        near(judged(&[f32::INFINITY, 0.5]), one(3.5));
        near(judged(&[f32::INFINITY; 2]), (0.0, 0.0, 0));
    }

    #[test]
    fn the_order_of_coordinates_does_not_matter_and_large_variances_tend_to_missing() {
        // The same Σ with its coordinates exchanged: D = (3, 4 − 4/3), r = 2/3.
        let other = Density::<RunTime>::of(&[3.0, 2.0 / 3.0, 8.0 / 3.0], &[0.5, 1.0], 2);
        let squared = other.squared_distance(&[1.0, 1.0], &[-1.0, 3.0]);
        near((squared, other.log_density(squared), 2), judged(&[1.0, 0.5]));
        let missing = Density::<RunTime>::of(&FACTOR, &[f32::INFINITY, 0.0], 2).squared_distance(&MEAN, &Z);
        for variance in [1e7, 1e20, f32::MAX] {
            let large = Density::<RunTime>::of(&FACTOR, &[variance, 0.0], 2).squared_distance(&MEAN, &Z);
            assert!((large - missing).abs() < 3e-6, "{variance}: {large} {missing}");
        }
    }
}
