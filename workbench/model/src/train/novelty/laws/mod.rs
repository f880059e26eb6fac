//! Distributions of distances and scores of healthy segments, and their form in the core.

pub(crate) mod excess;
pub(crate) mod knots;
pub mod law;
pub mod rising;
pub mod score;
pub mod spread;
