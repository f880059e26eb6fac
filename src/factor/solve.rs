//! The factor of a segment → parameters, covariance, residual variance, in steps of bounded cost.
//!
//! By least squares the factor is that of the regression. By instrumental variables the columns of the segment are
//! `[U | x̂ | y | target]`, and with T the rows of U and x̂ and the columns of U, y and target
//!
//! ```text
//! T = [ R_uu  R_uy  r_u ; 0  G  r_x ],   weights D        T θ = r  ⇔  (ZᵀX) θ = Zᵀ y                  (1)
//! ```
//!
//! The rows of G are rotated into a small triangle. With it in their place T is triangular, takes the place of the first n
//! rows of the factor, and the rest is least squares: Tᵀ D T = (XᵀZ)(ZᵀZ)⁻¹(ZᵀX).
//!
//! ```text
//! R θ = r,   σ² = Σ dᵢ eᵢ² / (N − n)                                                                  (2)
//! R v = e(k):   cov θ(i, j) = Σₖ σ² s(i) v(i) s(j) v(j) / d(k)                                        (3)
//! ```
//!
//! e is the residual of a row of the factor, s the scale that converts a parameter to its unit. A step solves one row of
//! (2), or one row of (3) for one k: at most n multiply-adds. A solve is needed once in seconds, so the code is loops over
//! slices, shared by every size. Any division of the steps between calls gives the same bits.

use core::cell::Cell;

use super::kernels::{packed, pairs, rotate_pivot_small};
use super::memory::Mass;
use super::triangle::PRIOR;
use crate::plan::MAX_OUTPUT_TERMS;

/// A pivot below this part of its column's sum of squares is rounding, not excitation: rounding of exactly dependent
/// columns leaves 1e-13 to 4e-10, a δ-form regression of condition number 2.4e3 has 1.7e-7.
const DEPENDENT: f32 = 1e-9;
/// det² G divided by the squares of its row norms, below which instruments are weak: a determinant of 1e-5.
const WEAK: f32 = 1e-10;
/// First-stage F below which instruments count as weak (Staiger and Stock's rule). Prefiltered rows and coloured noise are
/// not independent, so chance reaches it more often than the F distribution says.
const CHANCE: f32 = 10.0;

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
    pub mass: Mass,
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

/// The triangle of the rows of G, target last.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Outputs {
    d: [f32; MAX_OUTPUT_TERMS + 1],
    r: [f32; MAX_OUTPUT_TERMS * (MAX_OUTPUT_TERMS + 1) / 2],
    /// The row that is being rotated, and its weight.
    row: [f32; MAX_OUTPUT_TERMS + 1],
    weight: f32,
}

/// What the next step does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
enum Stage {
    /// Check that column k is excited.
    Excitation,
    /// Load row k of G, and rotate pivot i − 1.
    Rotation,
    /// Check the instruments of output k.
    Strength,
    /// Move row k of T to its place.
    Placement,
    /// Row i of (2), descending.
    Parameters,
    /// Row k of the outputs' own columns, then σ².
    Residual,
    /// Parameter k in its unit.
    Units,
    /// Row i of R v = e(k), descending.
    Column,
    /// Row i of the products (3).
    Products,
    /// Nothing is left.
    Done,
}

/// A solve under way.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Solution {
    rotated: Outputs,
    /// Σ d e² over all rows, then σ² of the scaled rows, times the spread of their mass.
    variance: f32,
    /// det² G divided by the squares of its row norms.
    strength: f32,
    /// The variance divided by d(k).
    weight: f32,
    stage: Stage,
    k: usize,
    i: usize,
}

impl Default for Solution {
    fn default() -> Self {
        Self::new()
    }
}

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
    /// Nothing solved yet.
    #[must_use]
    pub const fn new() -> Self {
        let rotated = Outputs { d: [PRIOR; 5], r: [0.0; 10], row: [0.0; 5], weight: 0.0 };
        Self { rotated, variance: 0.0, strength: 1.0, weight: 0.0, stage: Stage::Excitation, k: 0, i: 0 }
    }

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

    /// Loads row `k` of G and divides the strength by the square of its norm; after that, rotates pivot i − 1.
    #[inline(never)]
    fn rotate(&mut self, problem: &Problem<'_>, k: usize) {
        let outputs = problem.outputs;
        let Outputs { d, r, row, weight } = &mut self.rotated;
        let Some(row) = row.get_mut(..=outputs) else { return };
        let Some(i) = self.i.checked_sub(1) else {
            let own = problem.inputs.wrapping_add(k);
            let from = problem.r.get(packed(problem.columns(), own, problem.parameters())..).unwrap_or(&[]);
            copy(row, from);
            let norm = pairs(0..outputs, &*row).fold(0.0, |sum, (_, x)| sum + x * x);
            *weight = problem.d.get(own).copied().unwrap_or(PRIOR);
            self.strength /= *weight * norm;
            return;
        };
        let right = packed(outputs.wrapping_add(1), i, i.wrapping_add(1));
        let cells = row.get_mut(i..).and_then(<[f32]>::split_first_mut);
        if let (Some(d), Some(r), Some((x, later))) = (d.get_mut(i), r.get_mut(right..), cells) {
            rotate_pivot_small(d, r, *x, later, weight);
        }
    }

    /// Whether the instruments follow the output: det² G divided by the squares of its row norms is not too small (it is 1
    /// for orthogonal rows).
    fn follow(&mut self, outputs: usize) -> bool {
        self.strength = pairs(0..outputs, &self.rotated.d).fold(self.strength, |strength, (_, d)| strength * d);
        // Written so that NaN is weak.
        self.strength > WEAK
    }

    /// Whether the instruments explain more of output column j than chance would, F > 10.
    #[inline(never)]
    fn explain(&self, problem: &Problem<'_>, j: usize) -> bool {
        let n = problem.parameters();
        let own = problem.d.get(n.wrapping_add(j)).copied().unwrap_or(0.0);
        let explained = self.rotated.d.get(j).copied().unwrap_or(0.0);
        explained * problem.mass.rows > CHANCE * problem.above(n, j, own) && explained > 4.0 * PRIOR
    }

    /// Moves row `i` of T to its place among the first n rows of the factor: the columns of the instruments lie between
    /// those of inputs and outputs. No row that is still needed is overwritten, since rows only move to the front.
    #[inline(never)]
    fn place(&self, problem: &mut Problem<'_>, i: usize) {
        let Problem { inputs, outputs, .. } = *problem;
        let (n, next) = (problem.parameters(), i.wrapping_add(1));
        let to = packed(n.wrapping_add(1), i, next);
        if i < inputs {
            let (from, near) = (packed(problem.columns(), i, next), inputs.wrapping_sub(next));
            to_front(problem.r, to, from, near);
            let far = from.wrapping_add(near).wrapping_add(outputs);
            to_front(problem.r, to.wrapping_add(near), far, outputs.wrapping_add(1));
        } else {
            let row = i.wrapping_sub(inputs);
            let from = packed(outputs.wrapping_add(1), row, row.wrapping_add(1));
            let cells = problem.r.get_mut(to..to.wrapping_add(n.wrapping_sub(i))).unwrap_or_default();
            copy(cells, self.rotated.r.get(from..).unwrap_or(&[]));
            put(problem.d, i, self.rotated.d.get(row).copied().unwrap_or(PRIOR));
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

impl Problem<'_> {
    #[inline(always)]
    const fn parameters(&self) -> usize {
        self.inputs.wrapping_add(self.outputs)
    }

    #[inline(always)]
    const fn columns(&self) -> usize {
        self.parameters().wrapping_add(self.outputs).wrapping_add(1)
    }

    /// Place in the estimate of the parameter of column i: outputs come first.
    #[inline(always)]
    const fn place(&self, i: usize) -> usize {
        if i < self.inputs { self.outputs.wrapping_add(i) } else { i.wrapping_sub(self.inputs) }
    }

    /// 1/s of the target.
    #[inline(always)]
    fn common(&self) -> f32 {
        1.0 / self.scale_of(self.parameters())
    }

    #[inline(always)]
    fn scale_of(&self, place: usize) -> f32 {
        self.scale.get(place).copied().unwrap_or(1.0)
    }

    /// Whether instrument column j is, beyond rounding, independent of the columns before it and not zero.
    #[inline(always)]
    fn excites(&self, j: usize) -> bool {
        let above = self.above(0, j, 0.0);
        let own = self.d.get(j).copied().unwrap_or(PRIOR);
        // Written so that NaN counts as dependent.
        own > DEPENDENT * above && own > 4.0 * PRIOR
    }

    /// `sum` + Σ d(i) R(i, first + j)² over the j rows from `first` on.
    #[inline(never)]
    fn above(&self, first: usize, j: usize, mut sum: f32) -> f32 {
        let columns = self.columns();
        let (mut place, mut step) = (packed(columns, first, first.wrapping_add(j)), columns.wrapping_sub(first));
        for (_, d) in pairs(0..j, self.d.get(first..).unwrap_or(&[])) {
            step = step.wrapping_sub(1);
            let r = self.r.get(place).copied().unwrap_or(0.0);
            sum += d * r * r;
            place = place.wrapping_add(step).wrapping_sub(1);
        }
        sum
    }

    /// The triangular factor of n parameters from row i on, right of the diagonal: n − 1 − i elements and the target.
    #[inline(always)]
    fn row(&self, i: usize) -> &[f32] {
        let start = packed(self.parameters().wrapping_add(1), i, i.wrapping_add(1));
        self.r.get(start..).unwrap_or(&[])
    }

    /// d e² of row k of the outputs' own columns, e being the residual of the row under θ in the order of columns.
    #[inline(never)]
    fn square(&self, k: usize, theta: &[f32]) -> f32 {
        let row = self.parameters().wrapping_add(k);
        let elements = self.r.get(packed(self.columns(), row, row.wrapping_add(1))..).unwrap_or(&[]);
        let Some((own, later)) = theta.get(self.inputs.wrapping_add(k)..).and_then(<[f32]>::split_first) else {
            return 0.0;
        };
        let target = elements.get(later.len()).copied().unwrap_or(0.0);
        let e = minus(target - own, elements, later);
        self.d.get(row).copied().unwrap_or(0.0) * e * e
    }
}

/// `start − Σ r(j) x(j)`.
#[inline(never)]
fn minus(start: f32, r: &[f32], x: &[f32]) -> f32 {
    r.iter().zip(x).fold(start, |value, (r, x)| value - r * x)
}

/// Multiplies the cells by `common` scale.
#[inline(never)]
fn times(cells: &mut [f32], scale: &[f32], common: f32) {
    pairs(cells, scale).for_each(|(cell, scale)| *cell *= scale * common);
}

/// Adds `weight` x to the cells.
#[inline(never)]
fn add(cells: &mut [f32], x: &[f32], weight: f32) {
    pairs(cells, x).for_each(|(cell, x)| *cell += weight * x);
}

/// Copies cells to a place before them.
#[inline(never)]
fn to_front(cells: &mut [f32], to: usize, from: usize, count: usize) {
    if to == from {
        return;
    }
    let cells = Cell::from_mut(cells).as_slice_of_cells();
    let to = cells.get(to..to.wrapping_add(count)).unwrap_or(&[]);
    pairs(to, cells.get(from..).unwrap_or(&[])).for_each(|(to, from)| to.set(from.get()));
}

#[inline(never)]
fn copy(cells: &mut [f32], from: &[f32]) {
    pairs(cells, from).for_each(|(cell, r)| *cell = *r);
}

#[inline(always)]
fn put(cells: &mut [f32], place: usize, value: f32) {
    if let Some(cell) = cells.get_mut(place) {
        *cell = value;
    }
}

/// Place of element (i, j ≤ i) of a symmetric matrix, lower triangle packed by rows.
#[inline(always)]
#[must_use]
pub const fn lower(i: usize, j: usize) -> usize {
    (i.wrapping_mul(i.wrapping_add(1)) / 2).wrapping_add(j)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::factor::Triangle;

    type Answer = Result<([f32; 2], [f32; 3], f32), SolveError>;

    /// A problem whose factor is kept.
    #[derive(Clone, Copy)]
    struct Case<'a> {
        d: &'a [f32],
        r: &'a [f32],
        inputs: usize,
        outputs: usize,
        scale: &'a [f32],
        mass: Mass,
    }

    fn run(case: &Case<'_>, budget: usize) -> Answer {
        let Case { inputs, outputs, scale, mass, .. } = *case;
        let (d, r) = (&mut case.d.to_vec(), &mut case.r.to_vec());
        let problem = &mut Problem { d, r, inputs, outputs, scale, base: &[], mass, gain: 1.0 };
        let (mut delta, mut covariance, mut variance, mut work) = ([0.0; 2], [0.0; 3], 0.0, [0.0; 2]);
        let mut solution = Solution::new();
        let solved =
            &mut Solved { delta: &mut delta, covariance: &mut covariance, variance: &mut variance, work: &mut work };
        while !solution.advance::<true>(problem, solved, budget)? {}
        Ok((delta, covariance, variance))
    }

    const fn problem<'a>(d: &'a [f32], r: &'a [f32], rows: f32) -> Case<'a> {
        Case { d, r, inputs: 2, outputs: 0, scale: &[1.0, 1.0, 1.0], mass: Mass { rows, spread: 1.0 } }
    }

    #[test]
    fn two_parameters_by_hand() {
        // XᵀX = [2 1; 1 2], XᵀY = [3; 0] → θ = [2, −1], RSS = 9 − 6 = 3 over one degree of freedom, and the covariance
        // 3 [2 −1; −1 2]/3.
        let mut triangle = Triangle::<[f32; 3], [f32; 3]>::new(3);
        for row in [[1.0, 0.0, 3.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]] {
            triangle.update(&row, 1.0);
        }
        let (d, r) = triangle.parts();
        let (theta, covariance, variance) = run(&problem(d, r, 3.0), 1).unwrap();
        let close = |x: f32, y: f32| (x - y).abs() < 1e-5; // roundings of numbers near three
        assert!(close(theta[0], 2.0) && close(theta[1], -1.0) && close(variance, 3.0), "{theta:?} {variance}");
        assert!(close(covariance[0], 2.0) && close(covariance[1], -1.0) && close(covariance[2], 2.0));
        for budget in [100, 400, 10_000] {
            assert_eq!(run(&problem(d, r, 3.0), budget), Ok((theta, covariance, variance)), "{budget}");
        }
    }

    #[test]
    fn scales_convert_parameters_and_covariance() {
        let mut triangle = Triangle::<[f32; 3], [f32; 3]>::new(3);
        for [a, b, y] in [[1.0, 0.0, 3.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]] {
            triangle.update(&[2.0 * a, 0.5 * b, 4.0 * y], 1.0);
        }
        let (d, r) = triangle.parts();
        let scaled = Case { scale: &[2.0, 0.5, 4.0], ..problem(d, r, 3.0) };
        let (theta, covariance, variance) = run(&scaled, 1).unwrap();
        let close = |x: f32, y: f32| (x - y).abs() < 1e-5;
        assert!(close(theta[0], 2.0) && close(theta[1], -1.0) && close(variance, 3.0), "{theta:?} {variance}");
        assert!(close(covariance[0], 2.0) && close(covariance[1], -1.0) && close(covariance[2], 2.0));
    }

    #[test]
    fn few_rows_and_dependent_columns_are_errors() {
        let mut triangle = Triangle::<[f32; 3], [f32; 3]>::new(3);
        assert_eq!(run(&problem(triangle.parts().0, triangle.parts().1, 9.0), 1), Err(SolveError::NotExcited(0)));
        for x in [1.0, -2.0, 0.5, 3.0] {
            triangle.update(&[x, 2.0 * x, x * x], 1.0);
        }
        let (d, r) = triangle.parts();
        assert_eq!(run(&problem(d, r, 4.0), 1), Err(SolveError::NotExcited(1)));
        assert_eq!(run(&problem(d, r, 2.0), 1), Err(SolveError::TooFewRows));
        assert_eq!(run(&problem(d, r, f32::NAN), 1), Err(SolveError::TooFewRows));
    }

    #[test]
    fn instruments_by_hand() {
        // Columns [u | x̂ | y | target] with x̂ = z: θ of y and u from Zᵀ e = 0, here exactly target = 2 y − u.
        let rows = [[1.0, 0.5, 0.7], [-0.5, 1.0, 0.9], [0.25, -1.0, -1.2], [1.0, 1.0, 1.3], [-1.0, 0.5, 0.2]];
        let mut triangle = Triangle::<[f32; 4], [f32; 6]>::new(4);
        for [u, z, y] in rows {
            triangle.update(&[u, z, y, 2.0 * y - u], 1.0);
        }
        let (d, r) = triangle.parts();
        let instrumental = Case { inputs: 1, outputs: 1, ..problem(d, r, 50.0) };
        let (theta, _, variance) = run(&instrumental, 1).unwrap();
        assert!((theta[0] - 2.0).abs() < 1e-5 && (theta[1] + 1.0).abs() < 1e-5 && variance < 1e-9, "{theta:?}");
        // An output that its instrument does not explain.
        let mut unrelated = Triangle::<[f32; 4], [f32; 6]>::new(4);
        for (k, [u, z, _]) in rows.into_iter().cycle().take(40).enumerate() {
            let y = if k % 2 == 0 { 1.0 } else { -1.0 };
            unrelated.update(&[u, z, y, y], 1.0);
        }
        let (d, r) = unrelated.parts();
        let weak = Case { d, r, mass: Mass { rows: 40.0, spread: 1.0 }, ..instrumental };
        assert_eq!(run(&weak, 1), Err(SolveError::WeakInstruments));
    }
}
