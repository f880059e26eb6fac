//! The factor of a segment → parameters, covariance, residual variance, in steps of bounded cost.
//!
//! Enters: a [`Problem`], the factor with its scales. Leaves: a [`Solved`], or the reason why there is no solution. By
//! instrumental variables the module `instruments` first makes the factor that of (1); the rest is least squares.
//!
//! ```text
//! R θ = r,   σ² = Σ dᵢ eᵢ² / (N − n)                                                                  (2)
//! R v = e(k):   cov θ(i, j) = Σₖ σ² s(i) v(i) s(j) v(j) / d(k)                                        (3)
//! ```
//!
//! e is the residual of a row of the factor, s the scale that converts a parameter to its unit. A step solves one row
//! of (2), or one row of (3) for one k: at most n multiply-adds. A solve is needed once in seconds, so the code is
//! loops over slices, shared by every size. Any division of the steps between calls gives the same bits.

mod instruments;
mod state;

pub use state::Solution;

use super::problem::{Problem, SolveError, Solved, lower};
use super::slices::{add, minus, put, times};
use super::weight::PRIOR;
use state::Stage;

/// Cost of a step without its multiply-adds, and of a multiply-add, instructions.
const STEP: usize = 75;
const MULTIPLY_ADD: usize = 9;
/// Cost of a row besides its multiply-adds, in multiply-adds.
const ROW: usize = 5;
/// Cost of a pivot of the instruments' triangle, in multiply-adds.
const PIVOT: usize = 12;
/// Instructions of the budget for one multiply-add of a step of several rows.
const CHUNK: usize = 24;

impl Solution {
    /// Does steps until they have taken about `budget` instructions; `true` once nothing is left. Without `INSTRUMENTS`
    /// there is no code for them, and the problem must have no outputs.
    ///
    /// # Errors
    /// A [`SolveError`]; what is in the results then has no meaning.
    #[inline(never)]
    pub fn advance<const INSTRUMENTS: bool>(
        &mut self,
        problem: &mut Problem<'_>,
        solved: &mut Solved<'_>,
        budget: usize,
    ) -> Result<bool, SolveError> {
        let n = problem.parameters();
        let (mut spent, mut last) = (0_usize, 0_usize);
        let chunk = (budget / CHUNK).max(1);
        // The next step costs about as much as the last one, and must fit too.
        while spent.wrapping_add(last) < budget && self.stage != Stage::Done {
            let k = self.k;
            let products = match self.stage {
                Stage::Excitation => {
                    // Written so that NaN is too few.
                    let enough = problem.mass.rows > n as f32;
                    if !enough {
                        return Err(SolveError::TooFewRows);
                    }
                    // The columns that must be independent are those of the instruments, the first n.
                    if !problem.excites(k) {
                        return Err(SolveError::NotExcited(problem.place(k)));
                    }
                    let after = if INSTRUMENTS { Stage::Rotation } else { Stage::Parameters };
                    self.then(k.wrapping_add(1) < n, after, if INSTRUMENTS { 0 } else { n });
                    k.wrapping_add(4)
                }
                // By least squares nothing is between the columns of inputs and target.
                Stage::Rotation if INSTRUMENTS && problem.outputs == 0 => {
                    self.then(false, Stage::Parameters, n);
                    0
                }
                Stage::Rotation if INSTRUMENTS => {
                    let mut products = 0_usize;
                    let end = problem.outputs.wrapping_add(2);
                    while self.i < end && products < chunk {
                        self.rotate(problem, k);
                        self.i = self.i.wrapping_add(1);
                        products = products.wrapping_add(PIVOT);
                    }
                    if self.i == end {
                        self.i = 0;
                        self.then(k.wrapping_add(1) < problem.outputs, Stage::Strength, 0);
                    }
                    products
                }
                Stage::Strength if INSTRUMENTS => {
                    if (k == 0 && !self.follow(problem.outputs)) || !self.explain(problem, k) {
                        return Err(SolveError::WeakInstruments);
                    }
                    self.then(k.wrapping_add(1) < problem.outputs, Stage::Placement, 0);
                    k.wrapping_add(6)
                }
                Stage::Placement if INSTRUMENTS => {
                    let mut products = 0_usize;
                    while self.k < n && products < chunk {
                        self.place(problem, self.k);
                        self.k = self.k.wrapping_add(1);
                        products = products.wrapping_add(ROW).wrapping_add(n);
                    }
                    if self.k == n {
                        self.stage = Stage::Parameters;
                    }
                    products
                }
                Stage::Rotation | Stage::Strength | Stage::Placement | Stage::Parameters => {
                    let i = k.wrapping_sub(1);
                    let (row, known) = (problem.row(i), solved.work.get(k..n).unwrap_or(&[]));
                    let target = row.get(known.len()).copied().unwrap_or(0.0);
                    let value = minus(target, row, known);
                    put(solved.work, i, value);
                    (self.stage, self.k) = (Stage::Parameters, i);
                    if i == 0 {
                        // The first n rows are solved exactly.
                        self.variance = problem.d.get(problem.columns().wrapping_sub(1)).copied().unwrap_or(0.0);
                        self.stage = Stage::Residual;
                    }
                    n.wrapping_sub(i)
                }
                Stage::Residual if INSTRUMENTS && k < problem.outputs => {
                    self.variance += problem.square(k, solved.work);
                    self.k = k.wrapping_add(1);
                    6
                }
                Stage::Residual => {
                    self.residual(problem, solved);
                    (self.stage, self.k) = (Stage::Units, 0);
                    4
                }
                Stage::Units => {
                    // Scaled problem: (y s_y) = (φ s) θ', so θ = θ' s/s_y.
                    let (mut products, common) = (0_usize, problem.common());
                    while self.k < n && products < chunk {
                        let k = self.k;
                        let place = if INSTRUMENTS { problem.place(k) } else { k };
                        let theta = solved.work.get(k).copied().unwrap_or(0.0);
                        let base = problem.base.get(place).copied().unwrap_or(0.0);
                        put(solved.delta, place, base + theta * problem.scale_of(place) * common);
                        self.k = k.wrapping_add(1);
                        products = products.wrapping_add(ROW);
                    }
                    if self.k == n {
                        self.start_column(0, problem, solved);
                    }
                    products
                }
                Stage::Column if self.i == 0 => {
                    let (inputs, common) = (if INSTRUMENTS { problem.inputs } else { n }, problem.common());
                    let column = solved.work.get_mut(..k.wrapping_add(1)).unwrap_or_default();
                    let (near, far) = column.split_at_mut(inputs.min(column.len()));
                    times(near, problem.scale.get(n.wrapping_sub(inputs)..).unwrap_or(&[]), common);
                    if INSTRUMENTS {
                        times(far, problem.scale, common);
                    }
                    self.stage = Stage::Products;
                    k.wrapping_mul(2)
                }
                Stage::Column => {
                    let mut products = 0_usize;
                    while self.i > 0 && products < chunk {
                        let (i, next) = (self.i.wrapping_sub(1), self.i);
                        let known = solved.work.get(next..k.wrapping_add(1)).unwrap_or(&[]);
                        let value = minus(0.0, problem.row(i), known);
                        put(solved.work, i, value);
                        self.i = i;
                        products = products.wrapping_add(ROW).wrapping_add(k.wrapping_sub(i));
                    }
                    products
                }
                Stage::Products => {
                    let mut products = 0_usize;
                    while self.i <= k && products < chunk {
                        self.products::<INSTRUMENTS>(problem, solved);
                        self.i = self.i.wrapping_add(1);
                        products = products.wrapping_add(ROW).wrapping_add(self.i);
                    }
                    if self.i > k {
                        self.stage = Stage::Done;
                        if k.wrapping_add(1) < n {
                            self.start_column(k.wrapping_add(1), problem, solved);
                        }
                    }
                    products
                }
                Stage::Done => 0,
            };
            last = STEP.wrapping_add(products.wrapping_mul(MULTIPLY_ADD));
            spent = spent.wrapping_add(last);
        }
        Ok(self.stage == Stage::Done)
    }

    /// Goes on with the next k, or else with `after` from `k`.
    #[inline(always)]
    const fn then(&mut self, next: bool, after: Stage, k: usize) {
        if next {
            self.k = self.k.wrapping_add(1);
        } else {
            (self.stage, self.k) = (after, k);
        }
    }

    /// σ² in the unit of the estimate.
    #[inline(never)]
    fn residual(&mut self, problem: &Problem<'_>, solved: &mut Solved<'_>) {
        let Problem { mass, gain, .. } = *problem;
        let n = problem.parameters();
        let variance = self.variance / (mass.rows - mass.spread * n as f32);
        // The variance carries s_y². Scales are powers of two.
        let target = problem.common();
        // One factor after the other: the square of a scale could leave the range of f32.
        *solved.variance = variance * target * target / gain / gain;
        self.variance = variance * mass.spread;
    }

    /// Starts column k of R⁻¹ in the working room.
    #[inline(always)]
    fn start_column(&mut self, k: usize, problem: &Problem<'_>, solved: &mut Solved<'_>) {
        put(solved.work, k, 1.0);
        self.weight = self.variance / problem.d.get(k).copied().unwrap_or(PRIOR);
        (self.stage, self.k, self.i) = (Stage::Column, k, k);
    }

    /// Adds the products of row i of column k to the covariance.
    #[inline(never)]
    fn products<const INSTRUMENTS: bool>(&self, problem: &Problem<'_>, solved: &mut Solved<'_>) {
        let Problem { inputs, outputs, .. } = *problem;
        let (i, work, cells) = (self.i, &*solved.work, &mut *solved.covariance);
        let weighted = work.get(i).copied().unwrap_or(0.0) * self.weight;
        // The parameters of inputs are after those of outputs in the estimate, and before them in the factor.
        if i < inputs || !INSTRUMENTS {
            let row = lower(outputs.wrapping_add(i), outputs);
            add(cells.get_mut(row..).unwrap_or_default(), work.get(..i.wrapping_add(1)).unwrap_or(&[]), weighted);
            return;
        }
        let own = i.wrapping_sub(inputs);
        // Down a column of the triangle, whose rows grow.
        let (mut place, mut step) = (lower(outputs, own), outputs);
        for v in work.get(..inputs).unwrap_or(&[]) {
            let Some(cell) = cells.get_mut(place) else { break };
            *cell += weighted * v;
            step = step.wrapping_add(1);
            place = place.wrapping_add(step);
        }
        let outputs = work.get(inputs..i.wrapping_add(1)).unwrap_or(&[]);
        add(cells.get_mut(lower(own, 0)..).unwrap_or_default(), outputs, weighted);
    }
}

#[cfg(test)]
mod tests;
