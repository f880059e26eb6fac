//! The detector as a whole: its segments, its parts, covariates, and a processor that computes otherwise.

mod arithmetic;
pub mod covariates;
pub mod parts;
mod streams;
