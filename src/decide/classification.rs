//! The classification of a segment in steps of bounded cost.
//!
//! ```text
//! features ─► coordinates ─► factor, by rows ─► likelihoods ─► posteriors, class ─► factor ─► distance, surprise
//!                            └ of a quadratic discriminant for each class ┘
//! ```

use super::Classifier;
use super::density::Density;
use super::discriminant::{Deciding, Decision};
use super::features::FeatureValue;
use crate::estimate::Estimate;
use crate::plan::{Array, Cells, Kind, Plan};
use crate::reason::{Part, Reason};
use crate::shaft::ShaftEstimate;

/// What the next step does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
enum Stage {
    /// Feature k.
    Features,
    /// Coordinate k.
    Coordinates,
    /// The factor of class k.
    Load,
    /// Its next step.
    Widen,
    /// Log-likelihood of class k.
    Likelihoods,
    /// A step of posteriors, costs and class.
    Posteriors,
    /// The next step of the healthy class's factor.
    Healthy,
    /// Distance and surprise.
    Novelty,
}

/// A classification under way, in steps of at most 2 F or Z² multiply-adds.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Classification<P: Plan> {
    features: Array<P::Features, FeatureValue>,
    coordinates: Array<P::Coordinates, f32>,
    variances: Array<P::Coordinates, f32>,
    density: Density<P>,
    likelihoods: Array<P::Classes, f32>,
    deciding: Deciding,
    stage: Stage,
    k: usize,
    /// Whether there is a coordinate that is not missing.
    available: bool,
    /// Why the first missing feature is missing.
    reason: Option<Reason>,
}

impl<P: Plan> Classification<P> {
    /// Nothing classified yet.
    #[must_use]
    pub fn new(plan: P) -> Self {
        let layout = plan.layout();
        let coordinates = layout.coordinates as usize;
        Self {
            features: Cells::filled(layout.features as usize, FeatureValue::MISSING),
            coordinates: Cells::filled(coordinates, 0.0),
            variances: Cells::filled(coordinates, 0.0),
            density: Density::new(plan),
            likelihoods: Cells::filled(layout.classes as usize, 0.0),
            deciding: Deciding::new(),
            stage: Stage::Features,
            k: 0,
            available: false,
            reason: None,
        }
    }

    /// Does the next step; the result once it is there. Without any coordinate there is none, for the reason why the
    /// first feature is missing.
    #[inline(never)]
    pub fn step(
        &mut self,
        plan: P,
        classifier: &Classifier<P>,
        estimates: (Option<&Estimate<P>>, Option<&ShaftEstimate<P>>),
        decision: &mut Decision<P>,
    ) -> Option<Result<(), Reason>> {
        match self.stage {
            Stage::Features => self.take_feature(plan, classifier, estimates, decision),
            Stage::Coordinates => {
                if self.project(classifier) {
                    let none = self.reason.unwrap_or(Reason::NotFinite(Part::Classifier));
                    return (!self.available).then_some(Err(none));
                }
            }
            Stage::Load | Stage::Widen | Stage::Likelihoods => self.weigh(plan, classifier),
            Stage::Posteriors => {
                let done = self.deciding.step(&classifier.discriminant, self.likelihoods.cells(), decision)?;
                if !done {
                    return Some(Err(Reason::NotFinite(Part::Classifier)));
                }
                self.density.load(classifier.novelty.factor.cells());
                self.stage = Stage::Healthy;
            }
            Stage::Healthy => {
                let known = classifier.novelty.class.is_some();
                if !(known && self.density.step(self.variances.cells())) {
                    self.stage = Stage::Novelty;
                }
            }
            Stage::Novelty => {
                let judged = classifier.novelty.judge_by(&self.density, self.coordinates.cells());
                (decision.distance, decision.surprise) = judged;
                return Some(Ok(()));
            }
        }
        None
    }

    /// Feature k.
    fn take_feature(
        &mut self,
        plan: P,
        classifier: &Classifier<P>,
        (estimate, shaft): (Option<&Estimate<P>>, Option<&ShaftEstimate<P>>),
        decision: &mut Decision<P>,
    ) {
        let own = self.features.cells_mut().get_mut(self.k).zip(decision.missing.cells_mut().get_mut(self.k));
        let (Some((cell, missing)), Some(feature)) = (own, classifier.features.cells().get(self.k)) else {
            return self.then(Stage::Coordinates);
        };
        match feature.value(plan, estimate, shaft) {
            Ok(value) => *cell = classifier.projection.excess(value, self.k),
            Err(reason) => self.reason = self.reason.or(Some(reason)),
        }
        *missing = cell.is_missing();
        self.k = self.k.saturating_add(1);
    }

    /// Coordinate k; returns whether it was the last.
    fn project(&mut self, classifier: &Classifier<P>) -> bool {
        let own = self.coordinates.cells_mut().get_mut(self.k).zip(self.variances.cells_mut().get_mut(self.k));
        let Some((cell, variance)) = own else {
            self.then(Stage::Load);
            return true;
        };
        let z = classifier.projection.coordinate(self.features.cells(), self.k);
        (*cell, *variance) = (z.value, z.variance);
        self.available |= !z.is_missing();
        self.k = self.k.saturating_add(1);
        false
    }

    /// The factor and the log-likelihood of class k. The classes of a linear discriminant share the factor.
    fn weigh(&mut self, plan: P, classifier: &Classifier<P>) {
        let (kind, discriminant) = (plan.layout().discriminant, &classifier.discriminant);
        let z = self.coordinates.cells();
        match self.stage {
            Stage::Load => {
                self.density.load(discriminant.factor(kind, z.len(), self.k));
                self.stage = Stage::Widen;
            }
            Stage::Widen => {
                if !self.density.step(self.variances.cells()) {
                    self.stage = Stage::Likelihoods;
                }
            }
            _ => {
                let Some(cell) = self.likelihoods.cells_mut().get_mut(self.k) else {
                    return self.then(Stage::Posteriors);
                };
                *cell = discriminant.likelihood(&self.density, z, self.k);
                self.k = self.k.saturating_add(1);
                let last = self.k >= self.likelihoods.cells().len();
                if kind == Kind::Quadratic && !last {
                    self.stage = Stage::Load;
                }
            }
        }
    }

    fn then(&mut self, stage: Stage) {
        (self.stage, self.k) = (stage, 0);
    }
}
