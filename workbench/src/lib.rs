//! The host part of `bearing-watch`: simulated rigs, identification, training, evaluation, reports.
//!
//! Traces are identified in double precision; models are *evaluated* by running the same code as the firmware, the core
//! crate in single precision.

pub mod audit;
pub mod cli;
pub mod core;
mod damaged;
pub mod error;
pub mod evaluate;
pub mod fleet;
pub mod grey_box;
pub mod identify;
pub mod piecewise;
pub mod report;
pub mod rig;
pub mod structure;
pub mod study;
pub mod trace;
pub mod train;
pub mod validate;

pub use error::Error;
