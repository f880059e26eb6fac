//! A hash of results: equal on host and target means equal bits.

use bearing_watch::Estimate;

/// FNV-1a over the bits of results.
pub struct Hash(u32);

impl Hash {
    /// Of nothing yet.
    pub const fn new() -> Self {
        Self(0x811c_9dc5)
    }

    /// Adds the bits of numbers.
    pub fn add(&mut self, values: &[f32]) {
        for byte in values.iter().flat_map(|x| x.to_bits().to_le_bytes()) {
            self.0 = (self.0 ^ u32::from(byte)).wrapping_mul(0x0100_0193);
        }
    }

    /// Adds all numbers of an estimate in use.
    pub fn add_estimate<const M: usize, const P: usize>(&mut self, estimate: &Estimate<M, P>) {
        let n = estimate.parameters();
        self.add(estimate.delta.get(..n).unwrap_or_default());
        self.add(estimate.covariance.get(..n * (n + 1) / 2).unwrap_or_default());
        self.add(&[estimate.variance, f32::from_bits(estimate.rows)]);
    }

    /// The hash.
    pub const fn bits(&self) -> u32 {
        self.0
    }
}
