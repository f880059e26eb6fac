//! What a segment would have shown: the smallest defect of each rising coordinate that its gate finds.
//!
//! Enters: the spreads of the rising coordinates in a segment, which the gate leaves, and its estimates. Leaves: for each
//! rising coordinate the size of a defect that the gate calls with a probability of 90 %, infinite where the coordinate
//! is missing.
//!
//! ```text
//! δ_i = r_i √V_i,   V_i = D'_i (1 + m_i/ν)                                (1)  shift of the coordinate
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
use super::gates::density::pivots;
use crate::plan::{Cells, Plan};
use crate::regression::factor::numbered;

/// A part of the usual friction that is acceptable whatever is usual: drives of training may be very much alike.
const ACCEPTABLE: f32 = 0.1;

impl<P: Plan> Classifier<P> {
    /// Replaces the spreads V of (1) of the rising coordinates, in the places of their laws, by the sizes (2) and (3).
    /// Returns whether one of friction is acceptable, or none rises.
    #[inline(never)]
    pub(crate) fn smallest(&self, estimates: Estimates<'_, P>, sizes: &mut [f32]) -> bool {
        let (novelty, all) = (&self.novelty, self.novelty.mean.cells().len());
        let laws = novelty.laws.cells().len();
        // Known at compile time: a plan without rising coordinates carries no code for them.
        if laws == 0 {
            return true;
        }
        let most = novelty.acceptable * novelty.acceptable;
        let (mut known, mut acceptable) = (false, false);
        for (k, pivot) in numbered(pivots(novelty.factor.cells(), all)) {
            // The rising coordinates are the last ones, and the first of them has the place 1.
            let place = k.wrapping_add(laws).wrapping_sub(all);
            let Some((size, rise)) = sizes.get_mut(place).zip(novelty.rises.cells().get(place)) else { continue };
            let spread = *size;
            if place == 0 || spread >= f32::INFINITY {
                continue;
            }
            // A projection that mixes features knows no size.
            let Some(only) = self.projection.only(k) else {
                *size = f32::INFINITY;
                continue;
            };
            *size = self.size(k, only, rise.reach * libm::sqrtf(spread), estimates); // (1)
            if self.features.cells().get(only.0).is_some_and(|feature| feature.friction().is_some()) {
                let usual = pivot * (1.0 + k as f32 / novelty.freedom);
                known = true;
                acceptable |= spread <= most * usual || *size <= ACCEPTABLE;
            }
        }
        acceptable || !known
    }

    /// The size of a defect that shifts coordinate k, of one feature with a weight, by so much; infinite if none is known.
    fn size(&self, k: usize, (place, weight): (usize, f32), shift: f32, (_, shaft, _): Estimates<'_, P>) -> f32 {
        let of_feature = (shift / weight).abs();
        let at = |list: &[f32], place: usize| list.get(place).copied().unwrap_or(0.0);
        let size = match (self.features.cells().get(place), shaft) {
            (Some(Feature::OrderScore(place) | Feature::LogOrderAmplitude(place)), Some((shaft, _))) => {
                shaft.orders().get(*place as usize).map_or(f32::INFINITY, |order| order.smallest)
            }
            (Some(Feature::LogFriction(_) | Feature::LogFrictionVariance | Feature::LogVariance), _) => {
                libm::expf(of_feature) - 1.0
            }
            (Some(Feature::FrictionScore(term)), Some((shaft, _))) => {
                shaft.friction.of(*term).map_or(f32::INFINITY, |own| {
                    (of_feature * own.deviation / (own.value - own.score * own.deviation)).abs()
                })
            }
            _ => {
                let mean = at(self.projection.mean.cells(), place) + at(self.novelty.mean.cells(), k) / weight;
                (of_feature / mean).abs()
            }
        };
        // A value that is not a number shows nothing.
        if size < f32::INFINITY { size } else { f32::INFINITY }
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
        let _departure = classifier.novelty.judge_with(&[0.0; 4], &variances, &mut sizes);
        let friction = classifier.smallest((None, Some((&shaft, &balance())), &[]), &mut sizes);
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
    fn sizes_do_not_depend_on_what_the_segment_has() {
        let of = |values: [f32; 4]| {
            let (classifier, mut sizes) = (classifier(), vec![f32::INFINITY; 5]);
            let _departure = classifier.novelty.judge_with(&values, &[0.1; 4], &mut sizes);
            classifier.smallest((None, None, &[]), &mut sizes);
            sizes
        };
        assert!(of([0.0; 4])[1] < 1.0);
        assert_eq!(of([9.0, -3.0, 5.0, 7.0]), of([0.0; 4]));
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
