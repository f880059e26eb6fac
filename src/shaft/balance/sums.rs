//! The sums of the rows of a torque balance in a segment: a triangular factor, into which each row is rotated.
//!
//! The equations are those of [`super::rows`].

use super::rows::{COLUMNS, TERMS, TorqueBalance, WITHOUT_LOAD};
use crate::regression::factor::NEVER;
use crate::regression::factor::kernels::{packed, pairs, rotate_pivot, rotate_pivot_small};
use crate::unroll::no_unroll;

const PACKED: usize = COLUMNS * (COLUMNS - 1) / 2;
/// Mean square of the filtered sign of a shaft that is at rest.
const AT_REST: f32 = 0.04;

/// The sums of the balance, and the row that is being rotated into them. Without a load there are two columns less.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BalanceSums {
    pub(in crate::shaft) d: [f32; COLUMNS],
    pub(in crate::shaft) r: [f32; PACKED],
    row: [f32; COLUMNS],
    weight: f32,
    /// The next pivot of the row; all are done from `COLUMNS` on.
    pivot: usize,
    pub(in crate::shaft) rows: u32,
}

impl BalanceSums {
    /// Holds the prior only.
    pub(in crate::shaft) fn new(balance: &TorqueBalance, load: bool) -> Self {
        let mut sums = Self::EMPTY;
        sums.clear(balance, load);
        sums
    }

    const EMPTY: Self =
        Self { d: [0.0; COLUMNS], r: [0.0; PACKED], row: [0.0; COLUMNS], weight: 0.0, pivot: COLUMNS, rows: 0 };

    /// Keeps the prior only: row k of the factor says that p(k) is nominal, with the weight (σ/prior deviation)².
    #[inline(never)]
    pub(in crate::shaft) fn clear(&mut self, balance: &TorqueBalance, load: bool) {
        *self = Self::EMPTY;
        let target = balance.scale_of(TERMS);
        let mut k = 0_usize;
        for &term in no_unroll(TorqueBalance::terms(load)) {
            let at = |list: &[f32; TERMS]| list.get(term).copied().unwrap_or(1.0);
            let scale = balance.scale_of(term);
            let ratio = balance.deviation * scale / at(&balance.prior);
            if let Some(d) = self.d.get_mut(k) {
                *d = balance.row_spread * ratio * ratio;
            }
            let columns = columns(load);
            if let Some(r) = self.r.get_mut(packed(columns, k, columns.wrapping_sub(1))) {
                *r = at(&balance.nominal) * target / scale;
            }
            k = k.wrapping_add(1);
        }
    }

    /// Takes a row, to be rotated in by [`BalanceSums::rotate`].
    #[inline(always)]
    pub(in crate::shaft) fn start(&mut self, row: [f32; COLUMNS]) {
        (self.row, self.weight, self.pivot) = (row, 1.0, 0);
    }

    /// Rotates in the next pivot; returns whether one was left.
    #[inline(always)]
    pub(in crate::shaft) fn rotate(&mut self, load: bool) -> bool {
        self.rotate_by(load, |d, r, x, later, weight| rotate_pivot::<false>(d, r, x, later, weight, NEVER))
    }

    #[inline(always)]
    fn rotate_by(&mut self, load: bool, pivot: impl Fn(&mut f32, &mut [f32], f32, &mut [f32], &mut f32)) -> bool {
        let (i, columns) = (self.pivot, columns(load));
        if i >= columns {
            return false;
        }
        self.pivot = i.wrapping_add(1);
        let start = packed(columns, i, i.wrapping_add(1));
        let (d, r) = (self.d.get_mut(i), self.r.get_mut(start..));
        let row = self.row.get_mut(i..columns).and_then(<[f32]>::split_first_mut);
        if let (Some(d), Some(r), Some((x, later))) = (d, r, row) {
            pivot(d, r, *x, later, &mut self.weight);
        }
        true
    }

    /// Rotates in the next pivot by small code; returns whether one was left.
    #[inline(never)]
    pub(in crate::shaft) fn rotate_small(&mut self, load: bool) -> bool {
        self.rotate_by(load, rotate_pivot_small)
    }

    /// Sum of squares of the target that the terms and the prior explain, relative to that of the residual.
    #[inline(never)]
    pub(in crate::shaft) fn explained(&self, load: bool) -> f32 {
        let last = columns(load).wrapping_sub(1);
        // r is stored by rows, each one element shorter than the one before: these are the last ones.
        let (mut k, mut index, mut sum) = (0_usize, last, 0.0);
        while k < last {
            let (d, r) = (self.d.get(k).copied(), self.r.get(index.wrapping_sub(1)).copied());
            let r = r.unwrap_or(0.0);
            sum += d.unwrap_or(0.0) * r * r;
            k = no_unroll(k.wrapping_add(1));
            index = index.wrapping_add(last).wrapping_sub(k);
        }
        sum / self.d.get(last).copied().unwrap_or(0.0)
    }

    /// Whether the shaft hardly moved: the mean square of the filtered sign (2) of the velocity over the rows is below
    /// that of a fifth of `ω_r`, which is more than the noise of the velocity leaves of it behind the filter.
    #[inline(never)]
    pub(in crate::shaft) fn is_at_rest(&self, balance: &TorqueBalance, load: bool) -> bool {
        const SIGN: usize = 2;
        let columns = columns(load);
        // The sum of squares of a column by the factor, less the weight of its prior.
        let above = |k: usize| {
            let r = self.r.get(packed(columns, k, SIGN)).copied().unwrap_or(0.0);
            self.d.get(k).copied().unwrap_or(0.0) * r * r
        };
        let scale = balance.scale_of(SIGN);
        let ratio = balance.deviation * scale / balance.prior.get(SIGN).copied().unwrap_or(1.0);
        let of_sign = self.d.get(SIGN).copied().unwrap_or(0.0) - balance.row_spread * ratio * ratio;
        above(0) + above(1) + of_sign < AT_REST * scale * scale * self.rows as f32
    }

    /// Lets p₃ and p₅ change along `by`, the deviation of their change: (7).
    ///
    /// ```text
    /// u = R v,   S_k = 1 + Σ_{j ≥ k} d_j u_j²                                                             (8)
    /// R_k ← R_k − u_k/S_{k+1} Σ_{j > k} d_j u_j R_j,   d_k ← d_k S_{k+1}/S_k                              (9)
    /// ```
    ///
    /// Λ = Rᵀ D R loses ΛvvᵀΛ/S₀ (Sherman and Morrison); (9) factors D − D u uᵀ D/S₀ by rows, from the last one up.
    #[inline(never)]
    pub(super) fn loosen(&mut self, [cos, sin]: [f32; 2]) {
        let (mut below, mut sum) = ([0.0; COLUMNS], 1.0_f32);
        let v = [0.0, 0.0, 0.0, cos, 0.0, sin];
        for k in (0..v.len()).rev() {
            let start = packed(COLUMNS, k, k.wrapping_add(1));
            let row = self.r.get_mut(start..start.wrapping_add(COLUMNS - 1).wrapping_sub(k)).unwrap_or_default();
            let (Some([diagonal, below @ ..]), Some([v_k, later @ ..])) = (below.get_mut(k..), v.get(k..)) else {
                return;
            };
            let u = pairs(&*row, later).fold(*v_k, |u, (r, v)| u + r * v);
            let Some(d) = self.d.get_mut(k) else { return };
            let (weight, part) = (*d * u, u / sum);
            *diagonal = weight;
            for (r, below) in pairs(row, below) {
                let before = *r;
                *r -= part * *below;
                *below += weight * before;
            }
            let above = sum + weight * u;
            *d *= sum / above;
            sum = above;
        }
    }

    /// Scaled parameter k by back substitution; `later` holds those after it.
    #[inline(always)]
    pub(super) fn substitute(&self, columns: usize, k: usize, later: &[f32]) -> f32 {
        let row = self.r.get(packed(columns, k, k.wrapping_add(1))..).unwrap_or(&[]);
        let target = row.get(later.len()).copied().unwrap_or(0.0);
        pairs(row, later).fold(target, |rest, (r, p)| rest - r * p)
    }
}

#[inline(always)]
pub(in crate::shaft) const fn columns(load: bool) -> usize {
    if load { COLUMNS } else { WITHOUT_LOAD.len() + 1 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The products Rᵀ D R of the columns.
    fn products(sums: &BalanceSums) -> [[f64; COLUMNS]; COLUMNS] {
        let r = |k: usize, column: usize| match column {
            _ if column < k => 0.0,
            _ if column == k => 1.0,
            _ => f64::from(sums.r[packed(COLUMNS, k, column)]),
        };
        let sum = |i: usize, j: usize| (0..COLUMNS).map(|k| r(k, i) * f64::from(sums.d[k]) * r(k, j)).sum();
        core::array::from_fn(|i| core::array::from_fn(|j| sum(i, j)))
    }

    #[test]
    fn a_rest_loses_what_is_known_along_the_change_of_the_weight() {
        for by in [[0.7, -0.4], [0.0, 2.0], [3.0, 0.0]] {
            let mut sums = BalanceSums::EMPTY;
            sums.d.iter_mut().zip(1_u8..).for_each(|(d, k)| *d = 0.5 * f32::from(k));
            sums.r.iter_mut().zip(1_u8..).for_each(|(r, k)| *r = 0.5 - 0.3 * f32::from(k % 5));
            let before = products(&sums);
            sums.loosen(by);
            let after = products(&sums);
            let [cos, sin] = by.map(f64::from);
            let along: [f64; COLUMNS] = before.map(|row| cos * row[3] + sin * row[5]);
            let scale = 1.0 + cos * along[3] + sin * along[5];
            for i in 0..COLUMNS {
                for j in 0..COLUMNS {
                    let expected = before[i][j] - along[i] * along[j] / scale;
                    // Some dozen operations of 6e-8 on numbers up to 50.
                    assert!((after[i][j] - expected).abs() < 5e-5, "{by:?} {i} {j}: {} {expected}", after[i][j]);
                }
            }
        }
    }
}
