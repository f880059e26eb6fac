//! When samples are taken, and how many make a segment.

use crate::signal::Park;

/// Longest block mean: plain sums of more samples lose digits.
pub const MAX_BLOCK_MEAN: u16 = 1000;
/// Largest number of samples of a segment, after averaging.
pub const MAX_SEGMENT_SAMPLES: u32 = 1_000_000;

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

impl Sampling {
    /// Duration of a segment, s; 0 if the sampling interval is unknown.
    #[must_use]
    pub fn segment_s(&self) -> f32 {
        self.interval_s * f32::from(self.block_mean) * self.segment_samples as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_segment_of_block_means_lasts_as_long_as_all_its_samples() {
        let sampling = Sampling { interval_s: 0.01, park: None, block_mean: 2, segment_samples: 500 };
        assert_eq!(sampling.segment_s(), 10.0);
        assert_eq!(Sampling { interval_s: 0.0, ..sampling }.segment_s(), 0.0);
    }
}
