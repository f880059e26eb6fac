//! A hash of results: equal on host and target means equal bits.

use bearing_watch::plan::Plan;
use bearing_watch::shaft::{OrderStrength, ShaftEstimate};
use bearing_watch::{Estimate, FrictionTerm};

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

    /// Adds all numbers of an estimate.
    pub fn add_estimate<P: Plan>(&mut self, estimate: &Estimate<P>) {
        self.add(estimate.delta());
        self.add(estimate.packed_covariance());
        self.add(&[estimate.variance, f32::from_bits(estimate.rows)]);
    }

    /// Adds all numbers of friction and bearing orders.
    pub fn add_shaft<P: Plan>(&mut self, shaft: &ShaftEstimate<P>) {
        let friction = &shaft.friction;
        for term in FrictionTerm::ALL.into_iter().filter_map(|term| friction.parameter(term)) {
            self.add(&[term.value, term.deviation, term.score]);
        }
        self.add(&[friction.variance, f32::from_bits(friction.rows)]);
        for order in shaft.orders() {
            let OrderStrength { prominence, score, amplitude, deviation, slip, slip_deviation, smallest, .. } = *order;
            self.add(&[prominence, score, amplitude, deviation, slip, slip_deviation, smallest]);
        }
    }

    /// The hash.
    pub const fn bits(&self) -> u32 {
        self.0
    }
}
