//! The classification of a segment in steps of bounded cost.
//!
//! ```text
//! covariates ─► features ─► coordinates ─► factor, by rows ─► likelihoods ─► posteriors, class
//!                                          └ and, of a quadratic discriminant, the factor   │
//!                                            for each class; its gate ◄────────┘           │
//!                                                  distance, surprise ◄─ healthy factor ◄───┘
//! ```

use super::classifier::Classifier;
use super::discriminant::{Deciding, Decision};
use super::features::{Estimates, FeatureValue};
use super::gates::density::Density;
use super::gates::rising;
use crate::plan::{Array, Cells, Kind, Plan};
use crate::reason::{Part, Reason};
use crate::regression::factor::pairs;

/// More steps than the largest model has.
const MAX_STEPS: u32 = 1 << 24;

/// What the next step does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
enum Stage {
    /// Covariate k.
    Covariates,
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
    /// Whether the segment is beyond the gate of class k.
    Gates,
    /// A step of posteriors, costs and class.
    Posteriors,
    /// The next step of the healthy class's factor.
    Healthy,
    /// The squared distance, and the values that are judged one by one.
    Novelty,
    /// Distance and its surprise.
    Distance,
    /// Step k towards the surprise of the rarest value.
    Rising,
}

/// A classification under way, in steps of at most 2 F, Z² or 6 V multiply-adds.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Classification<P: Plan> {
    departures: Array<P::Covariates, FeatureValue>,
    features: Array<P::Features, FeatureValue>,
    coordinates: Array<P::Coordinates, f32>,
    variances: Array<P::Coordinates, f32>,
    density: Density<P>,
    likelihoods: Array<P::Classes, f32>,
    /// Squared distance from class k.
    squared: f32,
    deciding: Deciding,
    /// With rising coordinates, d² of the others and the score of each, and then what follows from them.
    judged: Array<P::Laws, f32>,
    /// Number of others that are available.
    others: usize,
    stage: Stage,
    k: usize,
    /// Whether there is a coordinate that is not missing.
    available: bool,
    /// Why the first covariate or feature is missing.
    reason: Option<Reason>,
}

impl<P: Plan> Classification<P> {
    /// Nothing classified yet.
    #[must_use]
    pub fn new(plan: P) -> Self {
        let layout = plan.layout();
        let coordinates = layout.coordinates as usize;
        Self {
            departures: Cells::filled(layout.covariates as usize, FeatureValue::MISSING),
            features: Cells::filled(layout.features as usize, FeatureValue::MISSING),
            coordinates: Cells::filled(coordinates, 0.0),
            variances: Cells::filled(coordinates, 0.0),
            density: Density::new(plan),
            likelihoods: Cells::filled(layout.classes as usize, 0.0),
            squared: 0.0,
            deciding: Deciding::new(),
            judged: Cells::filled(layout.laws(), rising::MISSING),
            others: 0,
            stage: if layout.covariates > 0 { Stage::Covariates } else { Stage::Features },
            k: 0,
            available: false,
            reason: None,
        }
    }

    /// Does the next step; the result once it is there. Without any coordinate there is none, for the reason why the
    /// first covariate or feature is missing.
    #[inline(never)]
    pub fn step(
        &mut self,
        plan: P,
        classifier: &Classifier<P>,
        estimates: Estimates<'_, P>,
        decision: &mut Decision<P>,
    ) -> Option<Result<(), Reason>> {
        match self.stage {
            // Known at compile time: a plan without covariates carries no code for them.
            Stage::Covariates if plan.layout().covariates > 0 => {
                self.take_covariate(plan, classifier, estimates, decision);
            }
            Stage::Covariates | Stage::Features => self.take_feature(plan, classifier, estimates, decision),
            Stage::Coordinates => {
                if self.project(classifier) {
                    let none = self.reason.unwrap_or(Reason::NotFinite(Part::Classifier));
                    return (!self.available).then_some(Err(none));
                }
            }
            Stage::Load | Stage::Widen | Stage::Likelihoods => self.weigh(plan, classifier),
            Stage::Gates => self.ask_gate(plan, classifier, decision),
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
                let (novelty, z) = (&classifier.novelty, self.coordinates.cells());
                if novelty.class.is_none() {
                    return Some(Ok(()));
                }
                // Known at compile time, as for covariates.
                decision.distance = if plan.layout().rising == 0 {
                    self.density.squared_distance(novelty.mean.cells(), z)
                } else {
                    let scores = novelty.score(&self.density, z, self.judged.cells_mut());
                    self.others = scores.others;
                    scores.squared
                };
                self.stage = Stage::Distance;
            }
            Stage::Distance => {
                let all = self.coordinates.cells().len();
                decision.depart(classifier.novelty.departure(decision.distance, self.density.available(), all));
                if plan.layout().rising == 0 {
                    return Some(Ok(()));
                }
                (self.stage, self.k) = (Stage::Rising, 0);
            }
            // A plan without rising coordinates carries no code for them.
            Stage::Rising if plan.layout().rising > 0 => {
                let (laws, judged) = (classifier.novelty.laws.cells(), self.judged.cells_mut());
                rising::judge(laws, judged, self.k, [self.others, self.coordinates.cells().len()]);
                self.k = self.k.wrapping_add(1);
                if self.k >= rising::steps(judged.len()) {
                    decision.surprise = judged.first().copied().unwrap_or(0.0);
                    return Some(Ok(()));
                }
            }
            Stage::Rising => return Some(Ok(())),
        }
        None
    }

    /// Does all steps, at coordinates less this offset.
    ///
    /// # Errors
    /// As the result of [`Classification::step`].
    pub(crate) fn run(
        &mut self,
        plan: P,
        classifier: &Classifier<P>,
        estimates: Estimates<'_, P>,
        offset: &[f32],
        decision: &mut Decision<P>,
    ) -> Result<(), Reason> {
        let mut moved = false;
        for _ in 0..MAX_STEPS {
            if let Some(result) = self.step(plan, classifier, estimates, decision) {
                return result;
            }
            if !moved && self.stage == Stage::Load {
                moved = true;
                pairs(self.coordinates.cells_mut(), offset).for_each(|(z, own)| *z -= own);
            }
        }
        Err(Reason::NotFinite(Part::Classifier))
    }

    /// The coordinates and the variances of their errors, once they are there.
    pub(crate) fn coordinates(&self) -> (&[f32], &[f32]) {
        (self.coordinates.cells(), self.variances.cells())
    }

    /// Covariate k.
    fn take_covariate(
        &mut self,
        plan: P,
        classifier: &Classifier<P>,
        estimates: Estimates<'_, P>,
        decision: &mut Decision<P>,
    ) {
        let own = self.departures.cells_mut().get_mut(self.k).zip(decision.outside.cells_mut().get_mut(self.k));
        let (Some((cell, outside)), Some(own)) = (own, classifier.covariates.list.cells().get(self.k)) else {
            return self.then(Stage::Features);
        };
        let place = u8::try_from(self.k).unwrap_or(u8::MAX);
        let departure = own.feature.value(plan, estimates).map(|value| own.departure(value));
        *cell = departure.unwrap_or(FeatureValue::MISSING);
        *outside = cell.is_missing();
        if *outside {
            self.reason = self.reason.or(departure.err()).or(Some(Reason::OutOfRange { covariate: place }));
        }
        self.k = self.k.saturating_add(1);
    }

    /// Feature k.
    fn take_feature(
        &mut self,
        plan: P,
        classifier: &Classifier<P>,
        estimates: Estimates<'_, P>,
        decision: &mut Decision<P>,
    ) {
        let own = self.features.cells_mut().get_mut(self.k).zip(decision.missing.cells_mut().get_mut(self.k));
        let (Some((cell, missing)), Some(feature)) = (own, classifier.features.cells().get(self.k)) else {
            return self.then(Stage::Coordinates);
        };
        match feature.value(plan, estimates) {
            Ok(value) => {
                let value = classifier.projection.excess(value, self.k);
                *cell = classifier.covariates.corrected(value, self.k, self.departures.cells());
            }
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
                self.squared = discriminant.squared_distance(&self.density, z, self.k);
                *cell = self.density.log_density(self.squared);
                self.stage = Stage::Gates;
            }
        }
    }

    /// Compares the distance from class k with its gate.
    fn ask_gate(&mut self, plan: P, classifier: &Classifier<P>, decision: &mut Decision<P>) {
        let counts = [self.density.available(), self.coordinates.cells().len()];
        let class = u8::try_from(self.k).unwrap_or(u8::MAX);
        if let Some(cell) = decision.beyond.cells_mut().get_mut(self.k) {
            *cell = classifier.novelty.excludes(class, self.squared, counts);
        }
        self.k = self.k.saturating_add(1);
        let last = self.k >= self.likelihoods.cells().len();
        let next = plan.layout().discriminant == Kind::Quadratic && !last;
        self.stage = if next { Stage::Load } else { Stage::Likelihoods };
    }

    fn then(&mut self, stage: Stage) {
        (self.stage, self.k) = (stage, 0);
    }
}

#[cfg(test)]
mod tests;
