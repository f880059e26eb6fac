//! The classification of a segment.
//!
//! ```text
//! covariates ─► features ─► coordinates ─► density of each class ─► posteriors, class; gate of each class
//!                                       └─► healthy density ─► distance, surprise
//! ```

use super::classifier::Classifier;
use super::discriminant::Decision;
use super::features::{Estimates, FeatureValue};
use crate::plan::{Array, Cells, Plan};
use crate::reason::{Part, Reason};
use crate::regression::factor::{numbered, pairs};

/// A classification in steps.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Classification<P: Plan> {
    coordinates: Array<P::Coordinates, f32>,
    /// Of the coordinates' errors; infinite for one that is missing.
    variances: Array<P::Coordinates, f32>,
    next: Step,
}

/// What the next step does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
enum Step {
    /// Covariates, features and coordinates.
    Project,
    /// Densities, posteriors, costs, class, and the gates of the classes.
    Compare,
    /// Distance from the healthy class, and surprise.
    Depart,
}

impl<P: Plan> Classification<P> {
    /// Nothing classified yet.
    #[must_use]
    pub fn new(plan: P) -> Self {
        let coordinates = plan.layout().coordinates as usize;
        Self {
            coordinates: Cells::filled(coordinates, 0.0),
            variances: Cells::filled(coordinates, 0.0),
            next: Step::Project,
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
        let (outcome, next) = match self.next {
            Step::Project => (self.project(plan, classifier, estimates, decision), Step::Compare),
            Step::Compare => (self.compare(plan, classifier, decision), Step::Depart),
            Step::Depart => {
                self.depart(classifier, decision);
                return Some(Ok(()));
            }
        };
        self.next = next;
        outcome.err().map(Err)
    }

    /// The coordinates and the variances of their errors, once they are there.
    pub(crate) fn coordinates(&self) -> (&[f32], &[f32]) {
        (self.coordinates.cells(), self.variances.cells())
    }

    /// Covariates, features and coordinates.
    #[inline(never)]
    fn project(
        &mut self,
        plan: P,
        classifier: &Classifier<P>,
        estimates: Estimates<'_, P>,
        decision: &mut Decision<P>,
    ) -> Result<(), Reason> {
        let layout = plan.layout();
        let mut departures: Array<P::Covariates, FeatureValue> =
            Cells::filled(layout.covariates as usize, FeatureValue::MISSING);
        // Known at compile time: a plan without covariates carries no code for them.
        let of_covariates = if layout.covariates > 0 {
            covariates(plan, classifier, estimates, decision, departures.cells_mut())
        } else {
            None
        };
        let mut features: Array<P::Features, FeatureValue> =
            Cells::filled(layout.features as usize, FeatureValue::MISSING);
        let mut reason = of_covariates;
        let cells = features.cells_mut().iter_mut().zip(decision.missing.cells_mut());
        for (k, ((cell, missing), feature)) in numbered(cells.zip(classifier.features.cells())) {
            let value = feature.value(plan, estimates);
            *cell = corrected(classifier, value, k, departures.cells());
            reason = reason.or(value.err());
            *missing = cell.is_missing();
        }
        let mut available = false;
        let features = features.cells();
        let cells = self.coordinates.cells_mut().iter_mut().zip(self.variances.cells_mut());
        for (k, (cell, variance)) in numbered(cells) {
            let z = classifier.projection.coordinate(features, k);
            (*cell, *variance) = (z.value, z.variance);
            available |= !z.is_missing();
        }
        let directions = classifier.novelty.directions.list.cells();
        for (value, direction) in decision.directed.cells_mut().iter_mut().zip(directions) {
            *value = direction.value(self.coordinates.cells(), self.variances.cells());
        }
        if available { Ok(()) } else { Err(reason.unwrap_or(Reason::NotFinite(Part::Classifier))) }
    }

    /// Log-likelihoods, posteriors and class, and whether the segment is beyond the gate of each class.
    #[inline(never)]
    fn compare(&self, plan: P, classifier: &Classifier<P>, decision: &mut Decision<P>) -> Result<(), Reason> {
        let (z, variances) = self.coordinates();
        let mut likelihoods: Array<P::Classes, f32> = Cells::filled(plan.layout().classes as usize, 0.0);
        let cells = likelihoods.cells_mut().iter_mut().zip(decision.beyond.cells_mut());
        classifier.compare(plan, z, variances, cells);
        let decided = classifier.discriminant.decide(likelihoods.cells(), decision);
        if decided { Ok(()) } else { Err(Reason::NotFinite(Part::Classifier)) }
    }

    /// Distance from the healthy class and surprise; without such a class they remain zero.
    // Out of line: the other steps would have its frame on the stack.
    #[inline(never)]
    fn depart(&self, classifier: &Classifier<P>, decision: &mut Decision<P>) {
        let (z, variances) = self.coordinates();
        if classifier.novelty.class.is_some() {
            decision.depart(classifier.novelty.judge(z, variances));
        }
    }
}

/// The k-th feature as the classifier takes it, less what the covariates explain.
fn corrected<P: Plan>(
    classifier: &Classifier<P>,
    value: Result<FeatureValue, Reason>,
    k: usize,
    departures: &[FeatureValue],
) -> FeatureValue {
    match value {
        Ok(value) => classifier.covariates.corrected(classifier.projection.excess(value, k), k, departures),
        Err(_) => FeatureValue::MISSING,
    }
}

/// The departures of the covariates; why the first one has none.
#[inline(never)]
fn covariates<P: Plan>(
    plan: P,
    classifier: &Classifier<P>,
    estimates: Estimates<'_, P>,
    decision: &mut Decision<P>,
    departures: &mut [FeatureValue],
) -> Option<Reason> {
    let mut reason = None;
    let cells = pairs(departures, decision.outside.cells_mut());
    for (index, ((cell, outside), covariate)) in pairs(0..u8::MAX, pairs(cells, classifier.covariates.list.cells())) {
        let departure = covariate.feature.value(plan, estimates).map(|value| covariate.departure(value));
        *cell = departure.unwrap_or(FeatureValue::MISSING);
        *outside = cell.is_missing();
        if *outside {
            reason = reason.or(departure.err()).or(Some(Reason::OutOfRange { covariate: index }));
        }
    }
    reason
}

#[cfg(test)]
mod tests;
