//! Models: bytes, ranges, plans.

mod file;
pub mod plans;
mod ranges;
mod shaft;
