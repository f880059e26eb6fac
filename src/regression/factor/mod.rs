//! Rows of a regression → sums, and their solution.
//!
//! Enters: a [`Row`], target last. Leaves: the solution of a segment, [`Solved`]. [`Triangle`] sums rows, [`Sums`]
//! says for how long they count, [`Solution`] solves.

pub mod kernels;
mod memory;
mod problem;
mod slices;
mod solve;
mod triangle;
mod weight;

pub use kernels::{numbered, pairs};
pub use memory::{MAX_LAMBDA, MAX_SEGMENT_ROWS, Sums, longest};
pub use problem::{Problem, SolveError, Solved, lower};
pub use solve::Solution;
pub use triangle::{Row, Triangle};
pub use weight::{EffectiveRows, Forgetting, NEVER};
