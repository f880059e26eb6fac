//! What a segment would have shown: the smallest defect of each rising coordinate that its gate finds.
//!
//! Enters: the variances of the coordinates' errors in a segment, and its estimates. Leaves: for each rising coordinate
//! the size of a defect that the gate calls with a probability of 90 %, infinite where the coordinate is missing.
//!
//! ```text
//! δ_i = r_i √(D'_i (1 + m_i/ν))                                           (1)  shift of the coordinate
//! friction p:  x = min δ_k/y_k  over the rising k with y_k > 0,   R'ᵀ y = W f′                          (2)
//!              f′ of q, ln q and the score of q:  c n,  c n/n_q,  c n/σ_q
//! order:       the amplitude of [`crate::shaft::orders`], A                                            (3)
//! ```
//!
//! `r_i` is the reach of [`Rise`](super::Rise): the deviations to the limit of the gate, and from there to the value
//! that nine of ten segments exceed. `D'_i` is the variance of the coordinate given those before it, with the errors
//! of this segment, `m_i` the number of those before it, ν the degrees of freedom of the model's covariance. A
//! friction that rises by the part x of its nominal value n raises all features that contain it, by c for q = p or the
//! drag: a coordinate of which those before it tell the same shows the less of it. A logarithm rises by ln (1 + x).
//! The sizes follow from the motion and the noise of the segment, not from the value that the coordinate has in it.

use super::classifier::Classifier;
use super::features::{Estimates, Feature};
use super::gates::density::{Density, pivots};
use crate::plan::{Array, Cells, Plan};
use crate::reason::FrictionTerm;
use crate::regression::factor::{numbered, pairs};
use crate::shaft::{ShaftEstimate, TorqueBalance};
use crate::unroll::no_unroll;

/// A part of the usual friction that is acceptable whatever is usual: drives of training may be very much alike.
const ACCEPTABLE: f32 = 0.1;

impl<P: Plan> Classifier<P> {
    /// The sizes (2) and (3) of the rising coordinates, in their order, of a segment whose coordinates have errors of
    /// these variances. The first cell is not used. Returns whether one of friction is acceptable, or none rises.
    #[inline(never)]
    pub(crate) fn smallest(&self, estimates: Estimates<'_, P>, variances: &[f32], sizes: &mut [f32]) -> bool {
        let (novelty, laws) = (&self.novelty, self.novelty.laws.cells().len());
        // Known at compile time: a plan without rising coordinates carries no code for them.
        if laws == 0 {
            return true;
        }
        let density = Density::<P>::of(novelty.factor.cells(), variances, variances.len());
        let mut shifts: Array<P::Laws, f32> = Cells::filled(laws, f32::INFINITY);
        let (most, mut acceptable) = (novelty.acceptable * novelty.acceptable, [false; 2]);
        self.shifts(&density, variances.len(), shifts.cells_mut());
        for (k, pivot) in numbered(pivots(novelty.factor.cells(), variances.len())) {
            let index = self.index(k, variances.len());
            let (Some(size), Some(shift)) = (sizes.get_mut(index), shifts.cells().get(index)) else { continue };
            if index == 0 || *shift >= f32::INFINITY {
                continue;
            }
            let only =
                self.projection.only(k).and_then(|(index, weight)| Some((self.features.cells().get(index)?, weight)));
            let friction = only.and_then(|(feature, _)| feature.friction());
            *size = match (only, friction.zip(estimates.1)) {
                (_, Some((term, shaft))) => self.friction(term, shaft, &density, shifts.cells()),
                (Some((feature, weight)), None) => self.size(k, (*feature, weight), *shift, estimates),
                // A projection that mixes features knows no size.
                (None, _) => f32::INFINITY,
            };
            if friction.is_some() {
                let reach = novelty.rises.cells().get(index).map_or(0.0, |rise| rise.reach);
                let usual = reach * reach * pivot * (1.0 + k as f32 / novelty.freedom);
                let [known, good] = &mut acceptable;
                (*known, *good) = (true, *good || *shift * *shift <= most * usual || *size <= ACCEPTABLE);
            }
        }
        let [known, good] = acceptable;
        good || !known
    }

    /// The index of a coordinate's law. The rising coordinates are the last ones; their indices begin at 1.
    fn index(&self, coordinate: usize, all: usize) -> usize {
        coordinate.wrapping_add(self.novelty.laws.cells().len()).wrapping_sub(all)
    }

    /// δ of (1) of each rising coordinate.
    #[inline(never)]
    fn shifts(&self, density: &Density<P>, all: usize, shifts: &mut [f32]) {
        let mut before = 0.0;
        for (k, pivot) in numbered(density.pivots()) {
            let index = self.index(k, all);
            if let Some((shift, rise)) = shifts.get_mut(index).zip(self.novelty.rises.cells().get(index)) {
                *shift = rise.reach * libm::sqrtf(pivot * (1.0 + before / self.novelty.freedom));
            }
            if pivot < f32::INFINITY {
                before += 1.0;
            }
        }
    }

    /// (2).
    #[inline(never)]
    fn friction(
        &self,
        term: FrictionTerm,
        (shaft, balance): (&ShaftEstimate<P>, &TorqueBalance),
        density: &Density<P>,
        shifts: &[f32],
    ) -> f32 {
        let (nominal, features) = (balance.nominal_of(term), self.features.cells());
        let slope = |feature: Feature| {
            let measured = feature.friction()?;
            let rise = nominal * balance.rises_with(measured, term);
            Some(match feature {
                Feature::LogFriction(_) => rise / balance.nominal_of(measured),
                Feature::FrictionScore(_) => rise / shaft.friction.of(measured)?.deviation,
                _ => rise,
            })
        };
        let mut slopes: Array<P::Features, f32> = Cells::filled(features.len(), 0.0);
        pairs(slopes.cells_mut(), no_unroll(features))
            .for_each(|(cell, feature)| *cell = slope(*feature).unwrap_or(0.0));
        let all = self.novelty.mean.cells().len();
        let row = |k: usize| self.projection.matrix.cells().get(k.wrapping_mul(features.len())..).unwrap_or(&[]);
        let moved = |k: usize| pairs(row(k), slopes.cells()).map(|(weight, slope)| weight * slope).sum();
        let moved: Array<P::Coordinates, f32> = Cells::from_fn(all, moved);
        let mut least = (f32::INFINITY, 0);
        density.solve(&[], moved.cells(), |y, _, after| {
            let k = all.wrapping_sub(after).wrapping_sub(1);
            let size = shifts.get(self.index(k, all)).map_or(f32::INFINITY, |shift| shift / y);
            // Written so that a value that is not a number shows nothing.
            if self.index(k, all) > 0 && size > 0.0 && size < least.0 {
                least = (size, k);
            }
        });
        let (size, k) = least;
        let feature = self.projection.only(k).and_then(|(index, _)| features.get(index));
        if matches!(feature, Some(Feature::LogFriction(_))) { libm::expf(size) - 1.0 } else { size }
    }

    /// The size of a defect that shifts coordinate k, of a feature of no friction with a weight, by so much; infinite
    /// if none is known.
    fn size(&self, k: usize, (feature, weight): (Feature, f32), shift: f32, (_, shaft, _): Estimates<'_, P>) -> f32 {
        let of_feature = (shift / weight).abs();
        let at = |list: &[f32], index: usize| list.get(index).copied().unwrap_or(0.0);
        let size = match (feature, shaft) {
            (Feature::OrderScore(order) | Feature::LogOrderAmplitude(order), Some((shaft, _))) => {
                shaft.orders().get(order as usize).map_or(f32::INFINITY, |order| order.smallest)
            }
            (Feature::LogFrictionVariance | Feature::LogVariance, _) => libm::expf(of_feature) - 1.0,
            _ => {
                let index = self.projection.only(k).map_or(usize::MAX, |(index, _)| index);
                let mean = at(self.projection.mean.cells(), index) + at(self.novelty.mean.cells(), k) / weight;
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
    use crate::plan::{Kind, Layout, Load, Memory, Method, RunTime, ShaftLayout, Signal, Structure, testing};
    use crate::reason::FrictionTerm;
    use crate::shaft::state::tests::balance;
    use crate::shaft::{OrderStrength, Parameter, ShaftEstimate};
    use std::vec;
    use std::vec::Vec;

    fn plan() -> RunTime {
        let plain = testing::regression(Structure::new(1, 1, 0, 1, 0), Method::LeastSquares, Memory::Segment);
        let signal = Signal::channel;
        let (velocity, load) = (Some(signal(1)), Load::Unknown);
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
        shaft.friction.drag = Parameter { value: 3.0, deviation: 0.0065, score: 10.0 };
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

    const MISSING: f32 = f32::INFINITY;

    #[test]
    fn sizes_by_hand() {
        // The nominal drag is 0.1 + 20 · 0.002 = 0.14. A shift of 4 · 0.2 of a score with a deviation of 0.0065; an
        // order has its own size.
        let of_score = 0.8 * 0.0065 / 0.14;
        near(&smallest([0.0; 4], &classifier()).0, [of_score, of_score, 0.25, of_score]);
        // Three times the variance more doubles the shift; an order has no error of its own.
        let doubled = 2.0 * of_score;
        near(&smallest([0.12, 0.12, 0.0, 0.12], &classifier()).0, [doubled, doubled, 0.25, doubled]);
        // Without the score the logarithm shows most: ln (1 + x) = 0.8; and without both the drag, 0.14 x = 0.8.
        let log = 0.8_f32.exp() - 1.0;
        near(&smallest([0.0, 0.0, 0.0, MISSING], &classifier()).0, [log, log, 0.25, MISSING]);
        near(&smallest([0.0, MISSING, 0.0, MISSING], &classifier()).0, [0.8 / 0.14, MISSING, 0.25, MISSING]);
        near(&smallest([MISSING; 4], &classifier()).0, [MISSING; 4]);
        // Few degrees of freedom widen the shift of a coordinate by those before it.
        let few = Classifier { novelty: Novelty { freedom: 1.0, ..classifier().novelty }, ..classifier() };
        near(&smallest([0.0; 4], &few).0, [doubled, doubled, 0.25, doubled]);
    }

    #[test]
    fn a_coordinate_shows_only_what_those_before_it_do_not_tell() {
        let mut told = classifier();
        // The logarithm follows the drag, as both do with a defect: 1/0.14 a unit.
        told.novelty.factor[1] = 1.0 / 0.14;
        near(&smallest([0.0, 0.0, 0.0, MISSING], &told).0, [0.8 / 0.14, 0.8 / 0.14, 0.25, MISSING]);
        // Two thirds are left.
        told.novelty.factor[1] = 1.0 / 0.42;
        let log = 1.2_f32.exp() - 1.0;
        near(&smallest([0.0, 0.0, 0.0, MISSING], &told).0, [log, log, 0.25, MISSING]);
    }

    #[test]
    fn viscous_friction_shows_in_the_drag() {
        let term = FrictionTerm::Viscous;
        let mut other = classifier();
        other.features[1] = Feature::Friction(term);
        // 0.002 of the viscous friction itself are 20 · 0.002 of the drag, whose logarithm rises by 0.04/0.14 of it.
        let of_log = (0.8_f32 * 0.14 / 0.04).exp() - 1.0;
        let (sizes, _) = smallest([0.0, 0.0, 0.0, MISSING], &other);
        assert!((sizes[0] / of_log - 1.0).abs() < 1e-5, "{sizes:?}");
    }

    #[test]
    fn sizes_do_not_depend_on_what_the_segment_has() {
        let of = |value: f32| {
            let mut shaft = ShaftEstimate::empty(plan());
            shaft.friction.drag = Parameter { value, deviation: 0.1, score: value };
            let mut sizes = vec![f32::INFINITY; 5];
            let estimates = (None, Some((&shaft, &balance())), &[][..]);
            classifier().smallest(estimates, &[0.1; 4], &mut sizes);
            sizes
        };
        assert!(of(0.0)[1] < 10.0);
        assert_eq!(of(9.0), of(0.0));
    }

    #[test]
    fn friction_is_acceptable_at_twice_the_usual_size_or_a_tenth() {
        let friction = |variance: f32| smallest([variance; 4], &classifier()).1;
        // The score of a small deviation stays below a tenth of the nominal value.
        assert!(friction(0.119) && friction(0.2) && !friction(0.3));
    }

    #[test]
    fn a_size_is_that_of_the_feature_whatever_its_weight_in_the_coordinate() {
        let of = |feature: Feature, weight: f32| {
            let mut other = classifier();
            other.features[2] = feature;
            (other.projection.matrix[10], other.projection.mean[2]) = (weight, 3.0);
            other.novelty.mean[2] = 2.0 * weight;
            smallest([0.0; 4], &other).0[2]
        };
        let near = |size: f32, expected: f32| assert!((size / expected - 1.0).abs() < 1e-5, "{size} {expected}");
        // A shift of 4 · 0.2 of a coordinate with half of the feature is 1.6, of a healthy mean of 3 + 2.
        for weight in [0.5, -0.5] {
            near(of(Feature::LogFrictionVariance, weight), 1.6_f32.exp() - 1.0);
            near(of(Feature::ChannelRms(0), weight), 1.6 / 5.0);
        }
    }

    #[test]
    fn a_projection_that_mixes_features_knows_no_size() {
        let mut mixed = classifier();
        mixed.projection.matrix.fill(0.5);
        let (sizes, friction) = smallest([0.0; 4], &mixed);
        assert!(sizes.iter().all(|size| size.is_infinite()) && friction, "{sizes:?}");
    }
}
