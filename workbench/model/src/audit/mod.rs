//! What recordings are worth, before anything is trained: times, columns, pairs of columns, equal traces, and the
//! smallest line of an order that would stand out.

pub mod angle;
pub mod bits;
mod clipped;
mod codes;
pub mod column;
pub mod friction;
pub mod held;
pub mod orders;
pub mod pairs;
mod phases;
pub mod scale;
pub mod sessions;
pub mod step;
pub mod sums;
pub mod times;
