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

impl<P: Plan> Classifier<P> {
    /// The sizes (2) and (3) of the rising coordinates, in their order, of a segment whose coordinates have errors of
    /// these variances. The first cell is not used.
    #[inline(never)]
    pub(crate) fn smallest(&self, estimates: Estimates<'_, P>, variances: &[f32], sizes: &mut [f32]) {
        let density = Density::<P>::of(self.novelty.factor.cells(), variances, variances.len());
        let first = variances.len().saturating_sub(self.rising());
        let mut before = 0.0;
        for (k, pivot) in numbered(density.pivots()) {
            let rise = k.wrapping_sub(first).wrapping_add(1);
            if k >= first
                && let Some((size, rise)) = sizes.get_mut(rise).zip(self.novelty.rises.cells().get(rise))
            {
                let shift = rise.reach * libm::sqrtf(pivot * (1.0 + before / self.novelty.freedom)); // (1)
                *size = if pivot < f32::INFINITY { self.size(k, shift, estimates) } else { f32::INFINITY };
            }
            before += if pivot < f32::INFINITY { 1.0 } else { 0.0 };
        }
    }

    /// Number of rising coordinates, which are the last ones.
    pub(super) fn rising(&self) -> usize {
        self.novelty.laws.cells().len().saturating_sub(1)
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

    /// Whether coordinate k rises, and its errors have a variance by which the smallest defect is beyond the acceptable
    /// one ([`Novelty::acceptable`](super::Novelty::acceptable)): it says nothing of this segment.
    pub(super) fn is_blind(&self, k: usize, coordinates: usize, variance: f32) -> bool {
        let novelty = &self.novelty;
        if k < coordinates.saturating_sub(self.rising()) || novelty.class.is_none() {
            return false;
        }
        let pivot = pivots(novelty.factor.cells(), coordinates).nth(k).unwrap_or(f32::INFINITY);
        variance > (novelty.acceptable * novelty.acceptable - 1.0) * pivot
    }

    /// The place of the only feature of coordinate k.
    pub(super) fn feature_of(&self, k: usize) -> Option<(usize, Feature)> {
        let (place, _) = self.projection.only(k)?;
        self.features.cells().get(place).map(|feature| (place, *feature))
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
