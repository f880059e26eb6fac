//! Models of traces and of classes: identification, structure, validation, training and evaluation.
//!
//! Traces come as arrays in memory; models are fitted in double precision and *evaluated* by the same code as in the
//! firmware, the core crate in single precision. Nothing here reads a recording: the crate of readers does.

pub mod audit;
pub mod core;
pub mod error;
pub mod evaluate;
pub mod grey_box;
pub mod identify;
pub mod outputs;
pub mod piecewise;
pub mod session;
pub mod settings;
pub mod statistics;
pub mod structure;
pub mod trace;
pub mod train;
pub mod validate;

pub use error::Error;
