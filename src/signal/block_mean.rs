//! Mean of blocks of samples.
//!
//! ```text
//! m(k) = (1/B) Σ x(kB + i),  i = 0 … B−1                                 (1)
//! ```
//!
//! The shortest anti-alias filter: first zero at the new sampling rate, attenuation of about 13 dB at the first side
//! lobe. Delay (B − 1)/2 samples; state 4·CH + 4 bytes. Plain single-precision sums: a block of 1000 equal samples is
//! accurate to 1e-5. A sample that is not finite makes the mean of its block not finite; the guard of the regressor
//! then skips it.

/// Block mean (1) of `CH` channels.
///
/// ```
/// let mut mean = bearing_watch::drive::BlockMean::new();
/// assert_eq!(mean.push([1.0, 10.0], 2), None);
/// assert_eq!(mean.push([3.0, 30.0], 2), Some([2.0, 20.0]));
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BlockMean<const CH: usize> {
    sum: [f32; CH],
    count: u16,
}

impl<const CH: usize> BlockMean<CH> {
    /// Creates an empty block.
    #[must_use]
    pub const fn new() -> Self {
        Self { sum: [0.0; CH], count: 0 }
    }

    /// Adds a sample; every `block`-th call returns the mean. A block of 0 or 1 returns each sample unchanged.
    #[inline]
    pub fn push(&mut self, sample: [f32; CH], block: u16) -> Option<[f32; CH]> {
        if block <= 1 {
            return Some(sample);
        }
        for (sum, x) in self.sum.iter_mut().zip(sample) {
            *sum += x;
        }
        self.count = self.count.saturating_add(1);
        if self.count < block {
            return None;
        }
        let mean = self.sum.map(|sum| sum / f32::from(self.count));
        *self = Self::new();
        Some(mean)
    }

    /// Whether no sample is in the block.
    pub(crate) const fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Discards an incomplete block.
    pub fn reset(&mut self) {
        *self = Self::new();
    }
}

impl<const CH: usize> Default for BlockMean<CH> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn block_of_one_is_the_signal() {
        let mut mean = BlockMean::new();
        assert_eq!(mean.push([0.1], 1), Some([0.1]));
        assert_eq!(mean.push([0.2], 0), Some([0.2]));
    }

    #[test]
    fn nan_spoils_its_own_block_only() {
        let mut mean = BlockMean::new();
        assert_eq!(mean.push([f32::NAN], 2), None);
        assert!(mean.push([1.0], 2).unwrap()[0].is_nan());
        assert_eq!(mean.push([1.0], 2), None);
        assert_eq!(mean.push([2.0], 2), Some([1.5]));
    }

    #[test]
    fn reset_forgets_the_open_block() {
        let mut mean = BlockMean::new();
        assert_eq!(mean.push([100.0], 2), None);
        mean.reset();
        assert_eq!(mean.push([1.0], 2), None);
        assert_eq!(mean.push([3.0], 2), Some([2.0]));
    }
}
