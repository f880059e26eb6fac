//! What a segment would have shown: the smallest defect of each rising coordinate that its gate finds.
//!
//! Enters: the variances of the coordinates' errors in a segment, and its estimates. Leaves: for each rising coordinate
//! the size of a defect that the gate calls with a probability of 90 %, infinite where the coordinate is missing.
//!
//! ```text
//! δ_i = r_i √(D'_i (1 + m_i/ν))                                          (1)  shift of the coordinate
//! friction p:       |δ_i/p̄|;    its logarithm:  e^δ_i − 1;    its score:  |δ_i σ/n|                     (2)
//! order:            the amplitude of [`crate::shaft::orders`], A                                       (3)
//! ```
//!
//! `r_i` is the reach of [`Rise`](super::Rise): the deviations to the limit of the gate, and from there to the value
//! that nine of ten segments exceed. `D'_i` is the variance of the coordinate given those before it, with the errors of
//! this segment, `m_i` the number of those before it, ν the degrees of freedom of the model's covariance, p̄ the healthy
//! mean and n the nominal value: (2) is a part of the usual value. The sizes follow from the motion and the noise of the
//! segment, not from the value that the coordinate has in it.

use super::classifier::Classifier;
use super::features::{Estimates, Feature};
use super::gates::density::{Density, pivots};
use crate::plan::{Cells, Plan};
use crate::regression::factor::{numbered, pairs};

/// A part of the usual friction that is acceptable whatever is usual: drives of training may be very much alike.
const ACCEPTABLE: f32 = 0.1;

impl<P: Plan> Classifier<P> {
    /// The sizes (2) and (3) of the rising coordinates, in their order, of a segment whose coordinates have errors of
    /// these variances. The first cell is not used. Returns whether one of friction is acceptable, or none rises.
    #[inline(never)]
    pub(crate) fn smallest(&self, estimates: Estimates<'_, P>, variances: &[f32], sizes: &mut [f32]) -> bool {
        let (all, novelty) = (variances.len(), &self.novelty);
        let density = Density::<P>::of(novelty.factor.cells(), variances, all);
        let (laws, most) = (novelty.laws.cells().len(), novelty.acceptable * novelty.acceptable);
        let (mut before, mut known, mut acceptable) = (0.0, false, false);
        for (k, (pivot, usual)) in numbered(density.pivots().zip(pivots(novelty.factor.cells(), all))) {
            if pivot >= f32::INFINITY {
                continue;
            }
            // The rising coordinates are the last ones, and the first of them has the place 1.
            let place = k.wrapping_add(laws).wrapping_sub(all);
            if let Some((size, rise)) = sizes.get_mut(place).zip(novelty.rises.cells().get(place))
                && place > 0
            {
                let shift = rise.reach * libm::sqrtf(pivot * (1.0 + before / novelty.freedom)); // (1)
                *size = self.size(k, shift, estimates);
                let friction = self.is_friction(k);
                known |= friction;
                acceptable |= friction && (pivot <= most * usual || *size <= ACCEPTABLE);
            }
            before += 1.0;
        }
        acceptable || !known
    }

    /// Whether coordinate k is a friction.
    fn is_friction(&self, k: usize) -> bool {
        let feature = self.projection.only(k).and_then(|(place, _)| self.features.cells().get(place));
        matches!(feature, Some(Feature::Friction(_) | Feature::FrictionScore(_) | Feature::LogFriction(_)))
    }

    /// The size of a defect that shifts coordinate k by so much; infinite if none is known.
    fn size(&self, k: usize, shift: f32, (_, shaft, _): Estimates<'_, P>) -> f32 {
        let Some((place, weight)) = self.projection.only(k) else { return f32::INFINITY };
        let of_feature = (shift / weight).abs();
        let at = |list: &[f32], place: usize| list.get(place).copied().unwrap_or(0.0);
        let mean = at(self.projection.mean.cells(), place) + at(self.novelty.mean.cells(), k) / weight;
        let size = match (self.features.cells().get(place), shaft) {
            (Some(Feature::OrderScore(place) | Feature::LogOrderAmplitude(place)), Some((shaft, _))) => {
                shaft.orders().get(*place as usize).map_or(f32::INFINITY, |order| order.smallest)
            }
            (Some(Feature::LogFriction(_) | Feature::LogFrictionVariance | Feature::LogVariance), _) => {
                libm::expm1f(of_feature)
            }
            (Some(Feature::FrictionScore(term)), Some((shaft, _))) => {
                shaft.friction.of(*term).map_or(f32::INFINITY, |own| {
                    (of_feature * own.deviation / (own.value - own.score * own.deviation)).abs()
                })
            }
            _ => (of_feature / mean).abs(),
        };
        // A value that is not a number shows nothing.
        if size < f32::INFINITY { size } else { f32::INFINITY }
    }

    /// Whether any of the features for which this holds is among them, and whether one of those has a value.
    pub(crate) fn seen(&self, missing: &[bool], of: impl Fn(Feature) -> Option<bool>) -> [bool; 2] {
        let (mut known, mut seen) = (false, false);
        for (feature, missing) in pairs(self.features.cells(), missing) {
            if let Some(good) = of(*feature) {
                (known, seen) = (true, seen || (good && !*missing));
            }
        }
        [known, seen]
    }
}
