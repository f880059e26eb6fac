//! The factor of a segment → parameters, covariance, residual variance, in steps of bounded cost.
//!
//! By least squares the factor is that of the regression. By instrumental variables the columns of the segment are
//! `[U | x̂ | y | target]`, and with T the rows of U and x̂ and the columns of U, y and target
//!
//! ```text
//! T = [ R_uu  R_uy  r_u ; 0  G  r_x ],   weights D        T θ = r  ⇔  (ZᵀX) θ = Zᵀ y                  (1)
//! ```
//!
//! The rows of G are rotated into a small triangle. With it in their place T is triangular and the rest is least squares:
//! Tᵀ D T = (XᵀZ)(ZᵀZ)⁻¹(ZᵀX).
//!
//! ```text
//! R θ = r,   σ² = Σ dᵢ eᵢ² / (N − n)                                                                  (2)
//! R v = e(k):   cov θ(i, j) = Σₖ σ² s(i) v(i) s(j) v(j) / d(k)                                        (3)
//! ```
//!
//! e is the residual of a row of the factor, s the scale that converts a parameter to its unit. A step solves one row of
//! (2), or one row of (3) for one k: at most n multiply-adds. A solve is needed once in seconds, so the code is loops over
//! slices, shared by every size. Any division of the steps between calls gives the same bits.

use super::kernels::{packed, rotate_loop};
use super::memory::Mass;
use super::triangle::{NEVER, PRIOR};
use crate::plan::MAX_OUTPUT_TERMS;

/// A pivot below this part of its column's sum of squares is rounding, not excitation: rounding of exactly dependent
/// columns leaves 1e-13 to 4e-10, a δ-form regression of condition number 2.4e3 has 1.7e-7.
const DEPENDENT: f32 = 1e-9;
/// det² G divided by the squares of its row norms, below which instruments are weak: a determinant of 1e-5.
const WEAK: f32 = 1e-10;
/// First-stage F below which instruments count as weak (Staiger and Stock's rule). Prefiltered rows and coloured noise are
/// not independent, so chance reaches it more often than the F distribution says.
const CHANCE: f32 = 10.0;

/// What a solve reads.
#[derive(Clone, Copy, Debug)]
pub struct Problem<'a> {
    /// Diagonal of the factor.
    pub d: &'a [f32],
    /// R of the factor, packed by rows.
    pub r: &'a [f32],
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

/// The rotated rows of G, target last.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Outputs {
    d: [f32; MAX_OUTPUT_TERMS + 1],
    r: [f32; MAX_OUTPUT_TERMS * (MAX_OUTPUT_TERMS + 1) / 2],
}

/// What the next step does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
enum Stage {
    /// Check that column k is excited.
    Excitation,
    /// Rotate row k of G.
    Rotation,
    /// Check the instruments.
    Strength,
    /// Row k of (2), descending.
    Parameters,
    /// σ² and the parameters in their units.
    Residual,
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
    /// σ² of the scaled rows, times the spread of their mass.
    variance: f32,
    /// det² G divided by the squares of its row norms.
    strength: f32,
    stage: Stage,
    k: usize,
    i: usize,
}

impl Default for Solution {
    fn default() -> Self {
        Self::new()
    }
}

impl Solution {
    /// Nothing solved yet.
    #[must_use]
    pub const fn new() -> Self {
        let rotated = Outputs { d: [PRIOR; 5], r: [0.0; 10] };
        Self { rotated, variance: 0.0, strength: 1.0, stage: Stage::Excitation, k: 0, i: 0 }
    }

    /// Does steps until they have taken about `budget` multiply-adds; `true` once nothing is left. Without `INSTRUMENTS` there
    /// is no code for them, and the problem must have no outputs.
    ///
    /// # Errors
    /// A [`SolveError`]; what is in the results then has no meaning.
    #[inline(never)]
    pub fn advance<const INSTRUMENTS: bool>(
        &mut self,
        problem: &Problem<'_>,
        solved: &mut Solved<'_>,
        budget: usize,
    ) -> Result<bool, SolveError> {
        let mut spent = 0_usize;
        while spent < budget {
            if self.stage == Stage::Done {
                return Ok(true);
            }
            spent = spent.saturating_add(self.step::<INSTRUMENTS>(problem, solved)?).saturating_add(OVERHEAD);
        }
        Ok(self.stage == Stage::Done)
    }

    /// One step; returns its number of multiply-adds.
    #[inline(always)]
    fn step<const INSTRUMENTS: bool>(
        &mut self,
        problem: &Problem<'_>,
        solved: &mut Solved<'_>,
    ) -> Result<usize, SolveError> {
        let n = problem.parameters();
        let k = self.k;
        match self.stage {
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
                self.then(k.saturating_add(1), n, Stage::Excitation, Stage::Rotation, 0);
                Ok(2 * k)
            }
            Stage::Rotation if INSTRUMENTS && k < problem.outputs => {
                self.rotate(problem, k);
                self.k = k.saturating_add(1);
                Ok(4 * problem.outputs)
            }
            Stage::Rotation => {
                self.stage = Stage::Strength;
                Ok(0)
            }
            Stage::Strength => {
                if INSTRUMENTS && problem.outputs > 0 && !self.are_strong(problem) {
                    return Err(SolveError::WeakInstruments);
                }
                (self.stage, self.k) = (Stage::Parameters, n);
                Ok(4 * problem.outputs)
            }
            Stage::Parameters => {
                let i = k.saturating_sub(1);
                let (near, far, target) = self.row(problem, i);
                let value = minus_both(target, near, far, solved.work.get(k..).unwrap_or(&[]));
                put(solved.work, i, value);
                (self.stage, self.k) = if i == 0 { (Stage::Residual, 0) } else { (Stage::Parameters, i) };
                Ok(n.saturating_sub(i))
            }
            Stage::Residual => {
                self.residual::<INSTRUMENTS>(problem, solved);
                self.start_column(0, solved);
                Ok(n + 2 * problem.outputs)
            }
            Stage::Column if self.i == 0 => {
                let common = problem.common();
                for (i, v) in solved.work.iter_mut().enumerate().take(k.saturating_add(1)) {
                    *v *= problem.scale.get(problem.place(i)).map_or(1.0, |scale| scale * common);
                }
                self.stage = Stage::Products;
                Ok(k.saturating_add(1))
            }
            Stage::Column => {
                let i = self.i.saturating_sub(1);
                let (near, far, _) = self.row(problem, i);
                let value = minus_both(0.0, near, far, solved.work.get(self.i..k.saturating_add(1)).unwrap_or(&[]));
                put(solved.work, i, value);
                self.i = i;
                Ok(k.saturating_sub(i))
            }
            Stage::Products => {
                self.products(problem, solved);
                let next = self.i.saturating_add(1);
                if next <= k {
                    self.i = next;
                } else if k.saturating_add(1) < n {
                    self.start_column(k.saturating_add(1), solved);
                } else {
                    self.stage = Stage::Done;
                }
                Ok(next)
            }
            Stage::Done => Ok(0),
        }
    }

    /// Goes on with the next `k`, or after the last with the next stage.
    fn then(&mut self, next: usize, end: usize, same: Stage, after: Stage, from: usize) {
        (self.stage, self.k) = if next < end { (same, next) } else { (after, from) };
    }

    /// Rotates row `i` of G, and divides the strength by the square of its norm.
    #[inline(never)]
    fn rotate(&mut self, problem: &Problem<'_>, i: usize) {
        let Problem { inputs, outputs, .. } = *problem;
        let mut row = [0.0; MAX_OUTPUT_TERMS + 1];
        let start = packed(problem.columns(), inputs.saturating_add(i), problem.parameters());
        let from = problem.r.get(start..).unwrap_or(&[]);
        let Some(row) = row.get_mut(..outputs.saturating_add(1)) else { return };
        row.iter_mut().zip(from).for_each(|(cell, r)| *cell = *r);
        let norm = row.iter().take(outputs).fold(0.0, |sum, x| sum + x * x);
        let weight = problem.d.get(inputs.saturating_add(i)).copied().unwrap_or(PRIOR);
        self.strength /= weight * norm;
        if let Some(d) = self.rotated.d.get_mut(..row.len()) {
            rotate_loop::<false>(d, &mut self.rotated.r, row, weight, NEVER);
        }
    }

    /// Whether the instruments follow the output: det² G divided by the squares of its row norms is not too small (it is 1
    /// for orthogonal rows), and they explain more of each output column than chance would, F > 10.
    fn are_strong(&mut self, problem: &Problem<'_>) -> bool {
        let Problem { outputs, mass, .. } = *problem;
        let (n, columns) = (problem.parameters(), problem.columns());
        self.rotated.d.iter().take(outputs).for_each(|d| self.strength *= d);
        let own = |i: usize| problem.d.get(n.saturating_add(i)).copied().unwrap_or(0.0);
        // Written so that NaN is weak.
        let mut strong = self.strength > WEAK;
        for j in 0..outputs {
            let mut unexplained = own(j);
            for i in 0..j {
                let place = packed(columns, n.saturating_add(i), n.saturating_add(j));
                let r = problem.r.get(place).copied().unwrap_or(0.0);
                unexplained += own(i) * r * r;
            }
            let explained = self.rotated.d.get(j).copied().unwrap_or(0.0);
            strong &= explained * mass.rows > CHANCE * unexplained && explained > 4.0 * PRIOR;
        }
        strong
    }

    /// σ² and the parameters in the order and the units of the estimate.
    #[inline(never)]
    fn residual<const INSTRUMENTS: bool>(&mut self, problem: &Problem<'_>, solved: &mut Solved<'_>) {
        let Problem { mass, gain, .. } = *problem;
        let n = problem.parameters();
        let squares = problem.residual_sum::<INSTRUMENTS>(solved.work);
        let variance = squares / (mass.rows - mass.spread * n as f32);
        // Scaled problem: (y s_y) = (φ s) θ', so θ = θ' s/s_y, and the variance carries s_y². Scales are powers of two.
        let target = problem.common();
        // One factor after the other: the square of a scale could leave the range of f32.
        *solved.variance = variance * target * target / gain / gain;
        for (i, theta) in solved.work.iter().enumerate() {
            let place = problem.place(i);
            let scale = problem.scale.get(place).copied().unwrap_or(1.0);
            let base = problem.base.get(place).copied().unwrap_or(0.0);
            put(solved.delta, place, base + theta * scale * target);
        }
        self.variance = variance * mass.spread;
    }

    /// Starts column k of R⁻¹ in the working room.
    fn start_column(&mut self, k: usize, solved: &mut Solved<'_>) {
        put(solved.work, k, 1.0);
        (self.stage, self.k, self.i) = (Stage::Column, k, k);
    }

    /// Adds the products of row i of column k to the covariance.
    #[inline(never)]
    fn products(&self, problem: &Problem<'_>, solved: &mut Solved<'_>) {
        let (i, k) = (self.i, self.k);
        let own = solved.work.get(i).copied().unwrap_or(0.0);
        let weighted = own * (self.variance / self.diagonal(problem, k));
        let place = problem.place(i);
        for (j, v) in solved.work.iter().enumerate().take(i.saturating_add(1)) {
            let other = problem.place(j);
            let cell = if place >= other { lower(place, other) } else { lower(other, place) };
            if let Some(cell) = solved.covariance.get_mut(cell) {
                *cell += weighted * v;
            }
        }
    }

    /// Row i of the triangular factor right of the diagonal in two slices, and its target.
    #[inline(never)]
    fn row<'r>(&'r self, problem: &Problem<'r>, i: usize) -> (&'r [f32], &'r [f32], f32) {
        let Problem { inputs, outputs, r, .. } = *problem;
        let next = i.saturating_add(1);
        let (near, far, length) = if i < inputs {
            // The columns of the instruments lie between those of inputs and outputs.
            let start = packed(problem.columns(), i, next);
            let near = inputs.saturating_sub(next);
            let (own, rest) = r.get(start..).unwrap_or(&[]).split_at_checked(near).unwrap_or((&[], &[]));
            (own, rest.get(outputs..).unwrap_or(&[]), outputs)
        } else {
            let row = i.wrapping_sub(inputs);
            let start = packed(outputs.saturating_add(1), row, row.wrapping_add(1));
            let own: &[f32] = &[];
            (own, self.rotated.r.get(start..).unwrap_or(&[]), outputs.saturating_sub(row.saturating_add(1)))
        };
        let target = far.get(length).copied().unwrap_or(0.0);
        (near, far.get(..length).unwrap_or(&[]), target)
    }

    fn diagonal(&self, problem: &Problem<'_>, i: usize) -> f32 {
        let Problem { inputs, d, .. } = *problem;
        let cell = if i < inputs { d.get(i) } else { self.rotated.d.get(i.wrapping_sub(inputs)) };
        cell.copied().unwrap_or(PRIOR)
    }
}

/// What a step costs besides its multiply-adds, in multiply-adds.
const OVERHEAD: usize = 5;

impl Problem<'_> {
    #[inline(always)]
    const fn parameters(&self) -> usize {
        self.inputs.saturating_add(self.outputs)
    }

    #[inline(always)]
    const fn columns(&self) -> usize {
        self.parameters().saturating_add(self.outputs).saturating_add(1)
    }

    /// Place in the estimate of the parameter of column i: outputs come first.
    #[inline(always)]
    const fn place(&self, i: usize) -> usize {
        if i < self.inputs { self.outputs.saturating_add(i) } else { i.wrapping_sub(self.inputs) }
    }

    /// 1/s of the target.
    fn common(&self) -> f32 {
        1.0 / self.scale.get(self.parameters()).copied().unwrap_or(1.0)
    }

    /// Whether instrument column j is, beyond rounding, independent of the columns before it and not zero, by
    /// Σ_{i<j} d(i) R(i, j)².
    fn excites(&self, j: usize) -> bool {
        let (mut above, mut place) = (0.0, j.wrapping_sub(1));
        for (i, d) in self.d.iter().enumerate().take(j) {
            let r = self.r.get(place).copied().unwrap_or(0.0);
            above += d * r * r;
            place = place.wrapping_add(self.columns()).wrapping_sub(i).wrapping_sub(2);
        }
        let own = self.d.get(j).copied().unwrap_or(PRIOR);
        // Written so that NaN counts as dependent.
        own > DEPENDENT * above && own > 4.0 * PRIOR
    }

    /// Σ d e² over all rows of the segment's factor, e being the residual of a row under θ in the order of columns.
    #[inline(always)]
    fn residual_sum<const INSTRUMENTS: bool>(&self, theta: &[f32]) -> f32 {
        let (columns, n) = (self.columns(), self.parameters());
        let mut squares = self.d.get(columns.wrapping_sub(1)).copied().unwrap_or(0.0);
        if !INSTRUMENTS {
            return squares;
        }
        // The first n rows are solved exactly; the rows of the outputs' own columns follow.
        let outputs = theta.get(self.inputs..).unwrap_or(&[]);
        for i in 0..self.outputs {
            let row = n.saturating_add(i);
            let start = packed(columns, row, row.wrapping_add(1));
            let elements = self.r.get(start..).unwrap_or(&[]);
            let length = self.outputs.saturating_sub(i.saturating_add(1));
            let e = elements.get(length).copied().unwrap_or(0.0) - outputs.get(i).copied().unwrap_or(0.0);
            let e = minus(e, elements, outputs.get(i.saturating_add(1)..).unwrap_or(&[]));
            squares += self.d.get(row).copied().unwrap_or(0.0) * e * e;
        }
        squares
    }
}

/// `start − Σ r(j) x(j)`.
// Out of line: the compiler unrolls the loop, and one such loop is enough.
#[inline(never)]
fn minus(start: f32, r: &[f32], x: &[f32]) -> f32 {
    r.iter().zip(x).fold(start, |value, (r, x)| value - r * x)
}

/// [`minus`] where the elements come in two slices.
#[inline(always)]
fn minus_both(start: f32, near: &[f32], far: &[f32], x: &[f32]) -> f32 {
    minus(minus(start, near, x), far, x.get(near.len()..).unwrap_or(&[]))
}

#[inline(never)]
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

    fn run(problem: &Problem<'_>, budget: usize) -> Result<([f32; 2], [f32; 3], f32), SolveError> {
        let (mut delta, mut covariance, mut variance, mut work) = ([0.0; 2], [0.0; 3], 0.0, [0.0; 2]);
        let mut solution = Solution::new();
        let solved =
            &mut Solved { delta: &mut delta, covariance: &mut covariance, variance: &mut variance, work: &mut work };
        while !solution.advance::<true>(problem, solved, budget)? {}
        Ok((delta, covariance, variance))
    }

    const fn problem<'a>(d: &'a [f32], r: &'a [f32], rows: f32) -> Problem<'a> {
        let mass = Mass { rows, spread: 1.0 };
        Problem { d, r, inputs: 2, outputs: 0, scale: &[1.0, 1.0, 1.0], base: &[], mass, gain: 1.0 }
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
        for budget in [2, 7, 1000] {
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
        let scaled = Problem { scale: &[2.0, 0.5, 4.0], ..problem(d, r, 3.0) };
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
        let instrumental = Problem { inputs: 1, outputs: 1, ..problem(d, r, 50.0) };
        let (theta, _, variance) = run(&instrumental, 1).unwrap();
        assert!((theta[0] - 2.0).abs() < 1e-5 && (theta[1] + 1.0).abs() < 1e-5 && variance < 1e-9, "{theta:?}");
        // An output that its instrument does not explain.
        let mut unrelated = Triangle::<[f32; 4], [f32; 6]>::new(4);
        for (k, [u, z, _]) in rows.into_iter().cycle().take(40).enumerate() {
            let y = if k % 2 == 0 { 1.0 } else { -1.0 };
            unrelated.update(&[u, z, y, y], 1.0);
        }
        let (d, r) = unrelated.parts();
        let weak = Problem { d, r, mass: Mass { rows: 40.0, spread: 1.0 }, ..instrumental };
        assert_eq!(run(&weak, 1), Err(SolveError::WeakInstruments));
    }
}
