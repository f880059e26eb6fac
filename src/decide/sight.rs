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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decide::{Covariates, Discriminant, Novelty, Projection, Rise};
    use crate::plan::{Kind, Layout, Memory, Method, RunTime, ShaftLayout, Signal, Structure, testing};
    use crate::reason::FrictionTerm;
    use crate::shaft::state::tests::balance;
    use crate::shaft::{OrderStrength, Parameter, ShaftEstimate};
    use std::vec;
    use std::vec::Vec;

    fn plan() -> RunTime {
        let plain = testing::regression(Structure::new(1, 1, 0, 1, 0), Method::LeastSquares, Memory::Segment);
        let signal = Signal::channel;
        let (velocity, load) = (Some(signal(1)), None);
        let shaft = ShaftLayout { current: signal(0), velocity, load, orders: 1, harmonics: 3, decimation: 1 };
        let layout = Layout { shaft: Some(shaft), features: 4, coordinates: 4, rising: 4, classes: 1, ..plain };
        RunTime::of(Layout { discriminant: Kind::Linear, ..layout }).unwrap()
    }

    /// Independent coordinates of variance 0.04 with a reach of 4, the first two features exchanged in them.
    fn classifier() -> Classifier<RunTime> {
        let term = FrictionTerm::Drag;
        let exchanged = vec![0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        let diagonal = vec![0.04, 0.0, 0.0, 0.0, 0.04, 0.0, 0.0, 0.04, 0.0, 0.04];
        let novelty = Novelty {
            class: Some(0),
            mean: vec![0.5, 0.0, 0.0, 0.0],
            factor: diagonal.clone(),
            rises: vec![Rise { fall: 1.0, reach: 4.0 }; 5],
            freedom: 1e9,
            acceptable: 2.0,
            ..Novelty::none(plan())
        };
        Classifier {
            features: vec![
                Feature::LogFriction(term),
                Feature::Friction(term),
                Feature::OrderScore(0),
                Feature::FrictionScore(term),
            ],
            covariates: Covariates { list: vec![], map: vec![] },
            projection: Projection { matrix: exchanged, mean: vec![0.0, 1.5, 0.0, 0.0], usual: vec![0.0; 4] },
            discriminant: Discriminant {
                means: vec![0.0; 4],
                factors: diagonal,
                log_prior: vec![0.0],
                costs: vec![0.0],
                reject_cost: f32::INFINITY,
            },
            novelty,
        }
    }

    fn smallest(variances: [f32; 4], classifier: &Classifier<RunTime>) -> (Vec<f32>, bool) {
        let mut shaft = ShaftEstimate::empty(plan());
        (shaft.friction_reason, shaft.orders_reason) = (None, None);
        shaft.friction.drag = Parameter { value: 3.0, deviation: 0.1, score: 10.0 };
        shaft.orders = vec![OrderStrength { smallest: 0.25, ..OrderStrength::default() }];
        let mut sizes = vec![f32::INFINITY; 5];
        let friction = classifier.smallest((None, Some((&shaft, &balance())), &[]), &variances, &mut sizes);
        (sizes[1..].to_vec(), friction)
    }

    fn near(found: &[f32], expected: [f32; 4]) {
        for (found, expected) in found.iter().zip(expected) {
            let same = found.is_infinite() && expected.is_infinite();
            assert!(same || (found - expected).abs() < 1e-5 * expected, "{found} for {expected}");
        }
    }

    #[test]
    fn sizes_by_hand() {
        // A shift of 4 · 0.2 of the mean 1.5 + 0.5; e^0.8 − 1; the order's own; 0.8 deviations of 0.1 of nominal 2.
        let log = 0.8_f32.exp() - 1.0;
        near(&smallest([0.0; 4], &classifier()).0, [0.4, log, 0.25, 0.04]);
        // Three times the variance more doubles the shift; an order has no error of its own.
        let log = 1.6_f32.exp() - 1.0;
        near(&smallest([0.12, 0.12, 0.0, 0.12], &classifier()).0, [0.8, log, 0.25, 0.08]);
        near(&smallest([f32::INFINITY; 4], &classifier()).0, [f32::INFINITY; 4]);
        // Few degrees of freedom widen the shift of a coordinate by those before it.
        let few = Classifier { novelty: Novelty { freedom: 1.0, ..classifier().novelty }, ..classifier() };
        let (sizes, _) = smallest([0.0; 4], &few);
        assert!((sizes[3] - 0.04 * 2.0).abs() < 1e-6, "{sizes:?}");
    }

    #[test]
    fn friction_is_acceptable_at_twice_the_usual_size_or_a_tenth() {
        let friction = |variance: f32| smallest([variance; 4], &classifier()).1;
        // The score of a small deviation stays below a tenth of the nominal value.
        assert!(friction(0.119) && friction(0.2) && !friction(0.3));
    }

    #[test]
    fn a_projection_that_mixes_features_knows_no_size() {
        let mut mixed = classifier();
        mixed.projection.matrix.fill(0.5);
        let (sizes, friction) = smallest([0.0; 4], &mixed);
        assert!(sizes.iter().all(|size| size.is_infinite()) && friction, "{sizes:?}");
    }
}
