//! The rows of the instruments → the triangle T of a solve by instrumental variables, or weak instruments.
//!
//! The columns of the segment are `[U | x̂ | y | target]`, and with T the rows of U and x̂ and the columns of U, y and
//! target
//!
//! ```text
//! T = [ R_uu  R_uy  r_u ; 0  G  r_x ],   weights D        T θ = r  ⇔  (ZᵀX) θ = Zᵀ y                  (1)
//! ```
//!
//! The rows of G are rotated into a small triangle. With it in their place T is triangular, takes the place of the
//! first n rows of the factor, and the rest is least squares: Tᵀ D T = (XᵀZ)(ZᵀZ)⁻¹(ZᵀX).

use super::state::{Outputs, Solution};
use crate::regression::factor::kernels::{packed, pairs, rotate_pivot_small};
use crate::regression::factor::problem::Problem;
use crate::regression::factor::slices::{copy, put, to_front};
use crate::regression::factor::weight::PRIOR;

/// det² G divided by the squares of its row norms, below which instruments are weak: a determinant of 1e-5.
const WEAK: f32 = 1e-10;
/// First-stage F below which instruments count as weak (Staiger and Stock's rule). Prefiltered rows and coloured noise
/// are not independent, so chance reaches it more often than the F distribution says.
const CHANCE: f32 = 10.0;

impl Solution {
    /// Loads row `k` of G and divides the strength by the square of its norm; after that, rotates pivot i − 1.
    #[inline(never)]
    pub(super) fn rotate(&mut self, problem: &Problem<'_>, k: usize) {
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

    /// Whether the instruments follow the output: det² G divided by the squares of its row norms is not too small (it
    /// is 1 for orthogonal rows).
    pub(super) fn follow(&mut self, outputs: usize) -> bool {
        self.strength = pairs(0..outputs, &self.rotated.d).fold(self.strength, |strength, (_, d)| strength * d);
        // Written so that NaN is weak.
        self.strength > WEAK
    }

    /// Whether the instruments explain more of output column j than chance would, F > 10.
    #[inline(never)]
    pub(super) fn explain(&self, problem: &Problem<'_>, j: usize) -> bool {
        let n = problem.parameters();
        let own = problem.d.get(n.wrapping_add(j)).copied().unwrap_or(0.0);
        let explained = self.rotated.d.get(j).copied().unwrap_or(0.0);
        explained * problem.mass.rows > CHANCE * problem.above(n, j, own) && explained > 4.0 * PRIOR
    }

    /// Moves row `i` of T to its place among the first n rows of the factor: the columns of the instruments lie between
    /// those of inputs and outputs. No row that is still needed is overwritten, since rows only move to the front.
    #[inline(never)]
    pub(super) fn place(&self, problem: &mut Problem<'_>, i: usize) {
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
}
