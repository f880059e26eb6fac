//! How much rows count: the prior, forgetting, and the sum of their weights.
//!
//! The number (1) is that of [`super::triangle`].

/// Nothing is forgotten.
pub const NEVER: Forgetting = Forgetting { lambda: 1.0, floor: 0.0 };
/// Weight of the diagonal before the first row. It is too small to bias data that are scaled to rms ≈ 1.
pub const PRIOR: f32 = 1e-16;

/// Exponential forgetting for endless streams: factor λ < 1 a row, and the floor δ of the diagonal in (1).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Forgetting {
    /// Factor λ a row.
    pub lambda: f32,
    /// Floor δ above zero: 1 % of 1/(1−λ) on data scaled to rms ≈ 1.
    pub floor: f32,
}

/// The weight of the rows in a factor.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct EffectiveRows {
    /// Σλᵏ: the equivalent number of rows of full weight.
    pub rows: f32,
    /// Σλ²ᵏ/Σλᵏ: the factor by which fading changes a covariance.
    pub spread: f32,
}
