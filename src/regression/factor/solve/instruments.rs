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

use super::SolveError;
use crate::plan::MAX_OUTPUT_TERMS;
use crate::regression::factor::kernels::{packed, pairs, rotate_pivot_small};
use crate::regression::factor::problem::Problem;
use crate::regression::factor::slices::{copy, put, to_front};
use crate::regression::factor::weight::PRIOR;

/// det² G divided by the squares of its row norms, below which instruments are weak: a determinant of 1e-5.
const WEAK: f32 = 1e-10;
/// First-stage F below which instruments count as weak (Staiger and Stock's rule). Prefiltered rows and coloured noise
/// are not independent, so chance reaches it more often than the F distribution says.
const CHANCE: f32 = 10.0;

/// The triangle of the rows of G, target last.
#[derive(Clone, Copy, Debug)]
struct Outputs {
    d: [f32; MAX_OUTPUT_TERMS + 1],
    r: [f32; MAX_OUTPUT_TERMS * (MAX_OUTPUT_TERMS + 1) / 2],
    /// det² G divided by the squares of its row norms.
    strength: f32,
}

/// Puts T in the place of the first n rows of the factor.
///
/// # Errors
/// [`SolveError::WeakInstruments`] if the instruments do not follow the outputs, or hardly more than chance.
// Out of line, so that the triangle of the outputs takes no stack during the rest of the solve.
#[inline(never)]
pub(super) fn compose(problem: &mut Problem<'_>) -> Result<(), SolveError> {
    let mut triangle = Outputs { d: [PRIOR; 5], r: [0.0; 10], strength: 1.0 };
    for k in 0..problem.outputs {
        triangle.rotate(problem, k);
    }
    if !triangle.follows(problem.outputs) || !(0..problem.outputs).all(|j| triangle.explains(problem, j)) {
        return Err(SolveError::WeakInstruments);
    }
    for i in 0..problem.parameters() {
        triangle.place(problem, i);
    }
    Ok(())
}

impl Outputs {
    /// Rotates row `k` of G in, and divides the strength by the square of its norm.
    #[inline(never)]
    fn rotate(&mut self, problem: &Problem<'_>, k: usize) {
        let outputs = problem.outputs;
        let mut cells = [0.0; MAX_OUTPUT_TERMS + 1];
        let Some(row) = cells.get_mut(..=outputs) else { return };
        let of_output = problem.inputs.wrapping_add(k);
        copy(row, problem.r.get(packed(problem.columns(), of_output, problem.parameters())..).unwrap_or(&[]));
        let norm = pairs(0..outputs, &*row).fold(0.0, |sum, (_, x)| sum + x * x);
        let mut weight = problem.d.get(of_output).copied().unwrap_or(PRIOR);
        self.strength /= weight * norm;
        for i in 0..=outputs {
            let right = packed(outputs.wrapping_add(1), i, i.wrapping_add(1));
            let cells = row.get_mut(i..).and_then(<[f32]>::split_first_mut);
            if let (Some(d), Some(r), Some((x, later))) = (self.d.get_mut(i), self.r.get_mut(right..), cells) {
                rotate_pivot_small(d, r, *x, later, &mut weight);
            }
        }
    }

    /// Whether the instruments follow the output: det² G divided by the squares of its row norms is not too small (it
    /// is 1 for orthogonal rows).
    fn follows(&mut self, outputs: usize) -> bool {
        self.strength = pairs(0..outputs, &self.d).fold(self.strength, |strength, (_, d)| strength * d);
        // Written so that NaN is weak.
        self.strength > WEAK
    }

    /// Whether the instruments explain more of output column j than chance would, F > 10.
    #[inline(never)]
    fn explains(&self, problem: &Problem<'_>, j: usize) -> bool {
        let n = problem.parameters();
        let square = problem.d.get(n.wrapping_add(j)).copied().unwrap_or(0.0);
        let explained = self.d.get(j).copied().unwrap_or(0.0);
        explained * problem.mass.rows > CHANCE * problem.above(n, j, square) && explained > 4.0 * PRIOR
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
            copy(cells, self.r.get(from..).unwrap_or(&[]));
            put(problem.d, i, self.d.get(row).copied().unwrap_or(PRIOR));
        }
    }
}
