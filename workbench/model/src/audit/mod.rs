//! What recordings are worth, before anything is trained: times, columns, pairs of columns, equal traces, and the
//! smallest line of an order that would stand out.

pub mod angle;
mod columns;
pub mod friction;
pub mod orders;
pub mod pairs;
mod phases;
pub mod scale;
pub mod sessions;
pub mod sums;
pub mod times;

pub use columns::{bits, column, held, signs};
