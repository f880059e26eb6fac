//! What single columns are worth: their values, steps, codes, signs and held samples.

pub mod bits;
pub(crate) mod clipped;
pub(crate) mod codes;
pub mod column;
pub mod held;
pub mod signs;
