//! The factor of a segment → parameters, covariance, residual variance.
//!
//! Enters: a [`Problem`], the factor with its scales. Leaves: a [`Solved`], or the reason why there is no solution. By
//! instrumental variables the module `instruments` first makes the factor that of (1); the rest is least squares.
//!
//! ```text
//! R θ = r,   σ² = Σ dᵢ eᵢ² / (N − n)                                                                  (2)
//! R v = e(k):   cov θ(i, j) = Σₖ σ² s(i) v(i) s(j) v(j) / d(k)                                        (3)
//! ```
//!
//! e is the residual of a row of the factor, s the scale that converts a parameter to its unit. [`Solution::new`]
//! solves (2), about n²/2 multiply-adds; each call of [`Solution::add_column`] adds a column v of (3), at most n² of
//! them. A solve is needed once in seconds, so the code is loops over slices, shared by every size.

mod instruments;

use super::problem::{Problem, SolveError, Solved, lower};
use super::slices::{add, minus, put, times};
use super::weight::PRIOR;

/// A solve whose parameters are known, and whose covariance is added column by column.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Solution {
    /// σ² of the scaled rows, times the spread of their mass.
    variance: f32,
    /// The next column.
    column: usize,
}

impl Solution {
    /// Nothing solved yet.
    pub const NONE: Self = Self { variance: 0.0, column: 0 };

    /// Solves (2). Without `INSTRUMENTS` there is no code for them, and the problem must have no outputs.
    ///
    /// # Errors
    /// A [`SolveError`]; what is in the results then has no meaning.
    #[inline(never)]
    pub fn new<const INSTRUMENTS: bool>(
        problem: &mut Problem<'_>,
        solved: &mut Solved<'_>,
    ) -> Result<Self, SolveError> {
        let n = problem.parameters();
        // Written so that NaN is too few.
        let enough = problem.mass.rows > n as f32;
        if !enough {
            return Err(SolveError::TooFewRows);
        }
        // The columns that must be independent are those of the instruments, the first n.
        if let Some(k) = (0..n).find(|k| !problem.excites(*k)) {
            return Err(SolveError::NotExcited(problem.index(k)));
        }
        // By least squares nothing is between the columns of inputs and target.
        if INSTRUMENTS && problem.outputs > 0 {
            instruments::compose(problem)?;
        }
        for i in (0..n).rev() {
            let (row, known) = (problem.row(i), solved.work.get(i.wrapping_add(1)..n).unwrap_or(&[]));
            let target = row.get(known.len()).copied().unwrap_or(0.0);
            let value = minus(target, row, known);
            put(solved.work, i, value);
        }
        let mut solution = Self::NONE;
        solution.take_residual::<INSTRUMENTS>(problem, solved);
        // Scaled problem: (y s_y) = (φ s) θ', so θ = θ' s/s_y.
        let common = problem.common();
        for k in 0..n {
            let index = if INSTRUMENTS { problem.index(k) } else { k };
            let theta = solved.work.get(k).copied().unwrap_or(0.0);
            let base = problem.base.get(index).copied().unwrap_or(0.0);
            put(solved.delta, index, base + theta * problem.scale_of(index) * common);
        }
        Ok(solution)
    }

    /// σ², also in the unit of the estimate. The first n rows are solved exactly.
    #[inline(never)]
    fn take_residual<const INSTRUMENTS: bool>(&mut self, problem: &Problem<'_>, solved: &mut Solved<'_>) {
        let Problem { mass, gain, outputs, .. } = *problem;
        let mut sum = problem.d.get(problem.columns().wrapping_sub(1)).copied().unwrap_or(0.0);
        if INSTRUMENTS {
            (0..outputs).for_each(|k| sum += problem.square(k, solved.work));
        }
        let variance = sum / (mass.rows - mass.spread * problem.parameters() as f32);
        // The variance carries s_y². Scales are powers of two.
        let target = problem.common();
        // One factor after the other: the square of a scale could leave the range of f32.
        *solved.variance = variance * target * target / gain / gain;
        self.variance = variance * mass.spread;
    }

    /// Adds the next column of R⁻¹ to the covariance, which starts at zero; whether it was the last.
    #[inline(never)]
    pub fn add_column<const INSTRUMENTS: bool>(&mut self, problem: &Problem<'_>, solved: &mut Solved<'_>) -> bool {
        let (n, k, common) = (problem.parameters(), self.column, problem.common());
        let next = k.wrapping_add(1);
        let weight = self.variance / problem.d.get(k).copied().unwrap_or(PRIOR);
        put(solved.work, k, 1.0);
        for i in (0..k).rev() {
            let known = solved.work.get(i.wrapping_add(1)..next).unwrap_or(&[]);
            let value = minus(0.0, problem.row(i), known);
            put(solved.work, i, value);
        }
        let inputs = if INSTRUMENTS { problem.inputs } else { n };
        let column = solved.work.get_mut(..next).unwrap_or_default();
        let (near, far) = column.split_at_mut(inputs.min(column.len()));
        times(near, problem.scale.get(n.wrapping_sub(inputs)..).unwrap_or(&[]), common);
        if INSTRUMENTS {
            times(far, problem.scale, common);
        }
        for i in 0..next {
            add_products::<INSTRUMENTS>(problem, solved, i, weight);
        }
        self.column = next;
        next >= n
    }
}

/// Adds the products of row i of a column to the covariance.
#[inline(never)]
fn add_products<const INSTRUMENTS: bool>(problem: &Problem<'_>, solved: &mut Solved<'_>, i: usize, weight: f32) {
    let Problem { inputs, outputs, .. } = *problem;
    let (work, cells) = (&*solved.work, &mut *solved.covariance);
    let weighted = work.get(i).copied().unwrap_or(0.0) * weight;
    // The parameters of inputs are after those of outputs in the estimate, and before them in the factor.
    if i < inputs || !INSTRUMENTS {
        let row = lower(outputs.wrapping_add(i), outputs);
        add(cells.get_mut(row..).unwrap_or_default(), work.get(..i.wrapping_add(1)).unwrap_or(&[]), weighted);
        return;
    }
    let output = i.wrapping_sub(inputs);
    // Down a column of the triangle, whose rows grow.
    let (mut index, mut step) = (lower(outputs, output), outputs);
    for v in work.get(..inputs).unwrap_or(&[]) {
        let Some(cell) = cells.get_mut(index) else { break };
        *cell += weighted * v;
        step = step.wrapping_add(1);
        index = index.wrapping_add(step);
    }
    let outputs = work.get(inputs..i.wrapping_add(1)).unwrap_or(&[]);
    add(cells.get_mut(lower(output, 0)..).unwrap_or_default(), outputs, weighted);
}

#[cfg(test)]
mod tests;
