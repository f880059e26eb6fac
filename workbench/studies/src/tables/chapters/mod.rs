//! The tables of each chapter of the source.

pub(super) mod chapter3;
pub(super) mod chapter4;
pub mod chapter5;
pub(super) mod distributions;
pub(super) mod pieces;
mod separation;
