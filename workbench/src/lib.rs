//! The host half of `bearing-watch`: simulated rigs, identification, training, evaluation, reports.
//!
//! Traces are identified in double precision; models are *evaluated* by running the very code that firmware runs,
//! the core crate in single precision.

pub mod campaign;
pub mod commands;
pub mod demo;
pub mod embedded;
pub mod error;
pub mod evaluate;
pub mod export;
pub mod features;
pub mod grey_box;
pub mod identify;
pub mod literal;
pub mod pages;
pub mod piecewise;
pub mod report;
pub mod rig;
pub mod structure;
pub mod tables;
pub mod trace;
pub mod train;
pub mod validate;

pub use error::Error;
