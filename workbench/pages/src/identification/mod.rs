//! Pages of models of single traces.

pub mod cogging;
pub mod structure;
pub mod validation;
