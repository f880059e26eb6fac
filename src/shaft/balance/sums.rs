//! The sums of the rows of a torque balance in a segment: a triangular factor, into which each row is rotated.
//!
//! The equations are those of [`super::rows`].

use super::rows::{COLUMNS, TERMS, TorqueBalance};
use super::terms::Terms;
use crate::reason::FrictionTerm;
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
    pub(in crate::shaft) fn new(balance: &TorqueBalance, terms: Terms) -> Self {
        let mut sums = Self::EMPTY;
        sums.clear(balance, terms);
        sums
    }

    const EMPTY: Self =
        Self { d: [0.0; COLUMNS], r: [0.0; PACKED], row: [0.0; COLUMNS], weight: 0.0, pivot: COLUMNS, rows: 0 };

    /// Keeps the prior only: row k of the factor says that p(k) is nominal, with the weight (σ/prior deviation)².
    #[inline(never)]
    pub(in crate::shaft) fn clear(&mut self, balance: &TorqueBalance, terms: Terms) {
        *self = Self::EMPTY;
        let target = balance.scale_of(TERMS);
        let mut k = 0_usize;
        for &term in no_unroll(terms.list()) {
            let at = |list: &[f32; TERMS]| list.get(term).copied().unwrap_or(1.0);
            let scale = balance.scale_of(term);
            let ratio = balance.deviation * scale / at(&balance.prior);
            if let Some(d) = self.d.get_mut(k) {
                *d = balance.row_spread * ratio * ratio;
            }
            let columns = terms.columns();
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
    pub(in crate::shaft) fn rotate(&mut self, terms: Terms) -> bool {
        self.rotate_by(terms, |d, r, x, later, weight| rotate_pivot::<false>(d, r, x, later, weight, NEVER))
    }

    #[inline(always)]
    fn rotate_by(&mut self, terms: Terms, pivot: impl Fn(&mut f32, &mut [f32], f32, &mut [f32], &mut f32)) -> bool {
        let (i, columns) = (self.pivot, terms.columns());
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
    pub(in crate::shaft) fn rotate_small(&mut self, terms: Terms) -> bool {
        self.rotate_by(terms, rotate_pivot_small)
    }

    /// Sum of squares of the target that the terms and the prior explain, relative to that of the residual.
    #[inline(never)]
    pub(in crate::shaft) fn explained(&self, terms: Terms) -> f32 {
        let last = terms.columns().wrapping_sub(1);
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
    pub(in crate::shaft) fn is_at_rest(&self, balance: &TorqueBalance, terms: Terms) -> bool {
        const SIGN: usize = FrictionTerm::Coulomb as usize;
        let (columns, [_, _, sign, ..]) = (terms.columns(), terms.always());
        // The sum of squares of a column by the factor, less the weight of its prior.
        let above = |k: usize| {
            let r = self.r.get(packed(columns, k, sign)).copied().unwrap_or(0.0);
            self.d.get(k).copied().unwrap_or(0.0) * r * r
        };
        let of_weight = if sign > SIGN { above(2) + above(3) } else { 0.0 };
        let scale = balance.scale_of(SIGN);
        let ratio = balance.deviation * scale / balance.prior.get(SIGN).copied().unwrap_or(1.0);
        let own = self.d.get(sign).copied().unwrap_or(0.0) - balance.row_spread * ratio * ratio;
        above(0) + above(1) + of_weight + own < AT_REST * scale * scale * self.rows as f32
    }

    /// Lets the weight change along `by`, the deviation of the change of both its parameters: (7), where the first two
    /// rows of the factor hold what is known of the weight given the other terms.
    #[inline(never)]
    pub(super) fn loosen(&mut self, by: [f32; 2]) {
        let ([d0, d1, ..], [r01, ..]) = (&mut self.d, &self.r);
        let u = [by[0] + r01 * by[1], by[1]];
        let kept = 1.0 / (1.0 + *d1 * u[1] * u[1]);
        let rho = -u[0] * u[1] * *d1 * kept;
        *d0 /= 1.0 + *d0 * u[0] * u[0] * kept;
        *d1 *= kept;
        // Row 1 starts one column later; its own diagonal is 1.
        if let Some((first, second)) = self.r.split_at_mut_checked(COLUMNS - 1)
            && let Some((own, rest)) = first.split_first_mut()
        {
            *own += rho;
            pairs(rest, &*second).for_each(|(own, later)| *own += rho * later);
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Λ⁻¹ of (7) by the first two rows of the factor, and what the weight is where the other terms and i are 1.
    fn of_weight(sums: &BalanceSums) -> ([f32; 3], [f32; 2]) {
        let ([d0, d1, ..], [r, ..]) = (sums.d, sums.r);
        let inverse = [1.0 / d0 + r * r / d1, -r / d1, 1.0 / d1];
        let sum = |row: &[f32]| row.iter().sum::<f32>();
        let second = sum(&sums.r[COLUMNS - 1..2 * COLUMNS - 3]);
        (inverse, [sum(&sums.r[1..COLUMNS - 1]) - r * second, second])
    }

    #[test]
    fn a_rest_adds_to_the_variance_of_the_weight_and_moves_nothing() {
        for by in [[0.7, -0.4], [0.0, 2.0], [3.0, 0.0]] {
            let mut sums = BalanceSums::EMPTY;
            (sums.d[0], sums.d[1]) = (4.0, 9.0);
            sums.r.iter_mut().take(2 * COLUMNS - 3).zip(1_u8..).for_each(|(r, k)| *r = 0.5 - 0.3 * f32::from(k % 5));
            let (before, at) = of_weight(&sums);
            sums.loosen(by);
            let (after, still_at) = of_weight(&sums);
            let added = [by[0] * by[0], by[0] * by[1], by[1] * by[1]];
            // A dozen operations of 6e-8 on numbers up to 10.
            for k in 0..3 {
                assert!((after[k] - before[k] - added[k]).abs() < 1e-5, "{by:?}: {before:?} {after:?}");
            }
            assert!((0..2).all(|k| (still_at[k] - at[k]).abs() < 1e-5), "{by:?}: {at:?} {still_at:?}");
        }
    }
}
