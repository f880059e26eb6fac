//! Rows of a regression → sums, and their solution.
//!
//! [`Triangle`] sums rows, [`Sums`] says for how long they count, [`Solution`] solves.

pub mod kernels;
mod memory;
mod problem;
mod slices;
mod solve;
mod triangle;

pub use kernels::pairs;
pub use memory::{MAX_LAMBDA, MAX_LONG_SEGMENT_ROWS, MAX_SEGMENT_ROWS, Mass, Sums, longest};
pub use problem::{Problem, SolveError, Solved, lower};
pub use solve::Solution;
#[cfg(feature = "internals")]
pub use triangle::PRIOR;
pub use triangle::{Forgetting, NEVER, Triangle};

/// One row of the regression.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row<'a> {
    /// Scaled columns, target last.
    pub cells: &'a [f32],
    /// Weight in 0 … 1: below one for an outlier.
    pub weight: f32,
    /// (Δu1)² + (Δu2)², scaled as the levels are; by instrumental variables of the prefiltered inputs.
    pub motion: f32,
}
