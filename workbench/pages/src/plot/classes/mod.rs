//! Plots of classes: densities, posteriors, reliability, and decisions over a plane.

pub(super) mod densities;
pub(super) mod posteriors;
mod regions;
pub(super) mod reliability;
pub(super) mod scatter;
