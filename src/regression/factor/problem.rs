//! What a solve reads, where its results go, and why there is none.
//!
//! A [`Problem`] borrows the factor of a segment; its functions say where a row, a column or a parameter is.

use super::kernels::{packed, pairs};
use super::slices::minus;
use super::weight::{EffectiveRows, PRIOR};

/// A pivot below this part of its column's sum of squares is rounding, not excitation: rounding of exactly dependent
/// columns leaves 1e-13 to 4e-10, a δ-form regression of condition number 2.4e3 has 1.7e-7.
const DEPENDENT: f32 = 1e-9;
/// What a solve reads, and the factor that it overwrites.
#[derive(Debug)]
pub struct Problem<'a> {
    /// Diagonal of the factor.
    pub d: &'a mut [f32],
    /// R of the factor, packed by rows.
    pub r: &'a mut [f32],
    /// Number of parameters whose column is its own instrument.
    pub inputs: usize,
    /// Number of parameters with a separate instrument.
    pub outputs: usize,
    /// Scales of the columns in the order of the estimate, then that of the target.
    pub scale: &'a [f32],
    /// δ-parameters with which the target was predicted; empty for none.
    pub base: &'a [f32],
    /// Weight of the rows.
    pub mass: EffectiveRows,
    /// Steady-state gain |A(1)| of the prefilter.
    pub gain: f32,
}

/// Where the results go; all slices but the covariance have n elements.
#[derive(Debug)]
pub struct Solved<'a> {
    /// δ-parameters.
    pub delta: &'a mut [f32],
    /// Covariance, lower triangle packed by rows.
    pub covariance: &'a mut [f32],
    /// Residual variance in the unit of the output squared.
    pub variance: &'a mut f32,
    /// Room for intermediate results.
    pub work: &'a mut [f32],
}

/// Why there is no solution. Places are those of the estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SolveError {
    /// No more rows than parameters.
    TooFewRows,
    /// The column of this parameter depends on the columns before it, or is zero.
    NotExcited(usize),
    /// The instruments are dependent, or explain hardly more than chance.
    WeakInstruments,
}

impl Problem<'_> {
    #[inline(always)]
    pub(super) const fn parameters(&self) -> usize {
        self.inputs.wrapping_add(self.outputs)
    }

    #[inline(always)]
    pub(super) const fn columns(&self) -> usize {
        self.parameters().wrapping_add(self.outputs).wrapping_add(1)
    }

    /// Place in the estimate of the parameter of column i: outputs come first.
    #[inline(always)]
    pub(crate) const fn index(&self, i: usize) -> usize {
        if i < self.inputs { self.outputs.wrapping_add(i) } else { i.wrapping_sub(self.inputs) }
    }

    /// 1/s of the target.
    #[inline(always)]
    pub(super) fn common(&self) -> f32 {
        1.0 / self.scale_of(self.parameters())
    }

    #[inline(always)]
    pub(super) fn scale_of(&self, index: usize) -> f32 {
        self.scale.get(index).copied().unwrap_or(1.0)
    }

    /// Whether instrument column j is, beyond rounding, independent of the columns before it and not zero.
    #[inline(always)]
    pub(super) fn excites(&self, j: usize) -> bool {
        is_excited((&*self.d, &*self.r), self.columns(), j)
    }

    /// `sum` + Σ d(i) R(i, first + j)² over the j rows from `first` on.
    #[inline(always)]
    pub(super) fn above(&self, first: usize, j: usize, sum: f32) -> f32 {
        above((&*self.d, &*self.r), self.columns(), [first, j], sum)
    }

    /// The triangular factor of n parameters from row i on, right of the diagonal: n − 1 − i elements and the target.
    #[inline(always)]
    pub(super) fn row(&self, i: usize) -> &[f32] {
        let start = packed(self.parameters().wrapping_add(1), i, i.wrapping_add(1));
        self.r.get(start..).unwrap_or(&[])
    }

    /// d e² of row k of the outputs' own columns, e being the residual of the row under θ in the order of columns.
    #[inline(never)]
    pub(super) fn square(&self, k: usize, theta: &[f32]) -> f32 {
        let row = self.parameters().wrapping_add(k);
        let elements = self.r.get(packed(self.columns(), row, row.wrapping_add(1))..).unwrap_or(&[]);
        let Some((parameter, later)) = theta.get(self.inputs.wrapping_add(k)..).and_then(<[f32]>::split_first) else {
            return 0.0;
        };
        let target = elements.get(later.len()).copied().unwrap_or(0.0);
        let e = minus(target - parameter, elements, later);
        self.d.get(row).copied().unwrap_or(0.0) * e * e
    }
}

/// Whether column j of a factor of so many columns is, beyond rounding, independent of those before it and not zero.
#[inline(always)]
pub(super) fn is_excited((d, r): (&[f32], &[f32]), columns: usize, j: usize) -> bool {
    let above = above((d, r), columns, [0, j], 0.0);
    let pivot = d.get(j).copied().unwrap_or(PRIOR);
    // Written so that NaN counts as dependent.
    pivot > DEPENDENT * above && pivot > 4.0 * PRIOR
}

/// `sum` + Σ d(i) R(i, first + j)² over the j rows from `first` on.
#[inline(never)]
fn above((d, r): (&[f32], &[f32]), columns: usize, [first, j]: [usize; 2], mut sum: f32) -> f32 {
    let (mut index, mut step) = (packed(columns, first, first.wrapping_add(j)), columns.wrapping_sub(first));
    for (_, d) in pairs(0..j, d.get(first..).unwrap_or(&[])) {
        step = step.wrapping_sub(1);
        let r = r.get(index).copied().unwrap_or(0.0);
        sum += d * r * r;
        index = index.wrapping_add(step).wrapping_sub(1);
    }
    sum
}

/// Place of element (i, j ≤ i) of a symmetric matrix, lower triangle packed by rows.
#[inline(always)]
#[must_use]
pub const fn lower(i: usize, j: usize) -> usize {
    (i.wrapping_mul(i.wrapping_add(1)) / 2).wrapping_add(j)
}
