//! The state of a solve under way.

use crate::plan::MAX_OUTPUT_TERMS;
use crate::regression::factor::weight::PRIOR;

/// The triangle of the rows of G, target last.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Outputs {
    pub(super) d: [f32; MAX_OUTPUT_TERMS + 1],
    pub(super) r: [f32; MAX_OUTPUT_TERMS * (MAX_OUTPUT_TERMS + 1) / 2],
    /// The row that is being rotated, and its weight.
    pub(super) row: [f32; MAX_OUTPUT_TERMS + 1],
    pub(super) weight: f32,
}

impl Outputs {
    /// Nothing rotated yet.
    const fn new() -> Self {
        Self { d: [PRIOR; 5], r: [0.0; 10], row: [0.0; 5], weight: 0.0 }
    }
}

/// What the next step does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) enum Stage {
    /// Check that column k is excited.
    Excitation,
    /// Load row k of G, and rotate pivot i − 1.
    Rotation,
    /// Check the instruments of output k.
    Strength,
    /// Move row k of T to its place.
    Placement,
    /// Row i of (2), descending.
    Parameters,
    /// Row k of the outputs' own columns, then σ².
    Residual,
    /// Parameter k in its unit.
    Units,
    /// Row i of R v = e(k), descending.
    Column,
    /// Row i of the products (3).
    Products,
    /// Nothing is left.
    Done,
}

/// A solve under way.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Solution {
    pub(super) rotated: Outputs,
    /// Σ d e² over all rows, then σ² of the scaled rows, times the spread of their mass.
    pub(super) variance: f32,
    /// det² G divided by the squares of its row norms.
    pub(super) strength: f32,
    /// The variance divided by d(k).
    pub(super) weight: f32,
    pub(super) stage: Stage,
    pub(super) k: usize,
    pub(super) i: usize,
}

impl Solution {
    /// Nothing solved yet.
    #[must_use]
    pub const fn new() -> Self {
        let rotated = Outputs::new();
        Self { rotated, variance: 0.0, strength: 1.0, weight: 0.0, stage: Stage::Excitation, k: 0, i: 0 }
    }
}

impl Default for Solution {
    fn default() -> Self {
        Self::new()
    }
}
