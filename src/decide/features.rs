//! Estimate → the feature vector the model asks for.
//!
//! Enters: an [`Estimate`] of n parameters. Leaves: up to `F` numbers picked from
//!
//! ```text
//! [ δ-parameters (n, the constant last),  ln σ² ]                        (1)
//! ```
//!
//! A model trained on a subset of the raw a, b, c lists the δ-parameters those depend on; the projection carries the
//! linear map between the two forms. Nothing is lost near a₁ ≈ −1.9.

use crate::estimate::Estimate;

/// Places in (1) of the features in use, the first `count` of `index`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Features<const F: usize> {
    /// Places in (1); n means ln σ².
    pub index: [u8; F],
    /// How many are used.
    pub count: u8,
}

impl<const F: usize> Features<F> {
    /// Picks the features; places not in use are zero.
    #[must_use]
    pub fn extract<const M: usize, const P: usize>(&self, estimate: &Estimate<M, P>) -> [f32; F] {
        let n = estimate.parameters();
        // A perfect fit has no logarithm; the smallest normal number stands for it.
        let variance = libm::logf(estimate.variance.max(f32::MIN_POSITIVE));
        let mut out = [0.0; F];
        for (cell, &index) in out.iter_mut().zip(&self.index).take(self.count as usize) {
            let index = index as usize;
            *cell = if index == n { variance } else { estimate.delta.get(index).copied().unwrap_or(0.0) };
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::{Counts, Order};

    #[test]
    fn picks_parameters_and_log_variance_in_any_order() {
        let estimate = Estimate::<4, 6> {
            order: Order::new(1, 1, 1, 1, 1),
            offset: false,
            delta: [0.5, 2.0, 3.0, 0.0],
            covariance: [0.0; 6],
            variance: 1.0,
            rows: 10,
            counts: Counts::default(),
            stable: true,
            segment: 0,
        };
        let features = Features { index: [2, 3, 0, 0], count: 3 };
        assert_eq!(features.extract(&estimate), [3.0, 0.0, 0.5, 0.0]);
        let perfect = Estimate { variance: 0.0, ..estimate };
        assert!(features.extract(&perfect)[1].is_finite());
    }
}
