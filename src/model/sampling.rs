//! When samples are taken, and how many make a segment.

use crate::signal::Park;

/// Longest block mean: plain sums of more samples lose digits.
pub const MAX_BLOCK_MEAN: u16 = 1000;

/// When samples are taken and how many make a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sampling {
    /// Sampling interval, s; 0 if it is unknown.
    pub interval_s: f32,
    /// Sign convention of the quadrature current; `None` if the current is not from a Park transform.
    pub park: Option<Park>,
    /// Number of samples averaged into one before the regression; 1 for none, at most [`MAX_BLOCK_MEAN`].
    pub block_mean: u16,
    /// Number of samples in a segment, after averaging.
    pub segment_samples: u32,
}
