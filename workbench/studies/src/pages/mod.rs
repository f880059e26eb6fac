//! Pages of the studies.

pub mod campaign;
pub mod demo;
pub mod tables;
