//! Estimates → [`Decision`], and decisions of many segments → alarm.
//!
//! Features → projection → discriminant and novelty, once a segment; [`Evidence`] collects decisions.

mod discriminant;
mod evidence;
mod features;
mod novelty;
mod projection;
mod trend;

use discriminant::Deciding;
pub use discriminant::{Decision, Discriminant};
pub use evidence::{Alarm, Cause, Evidence, EvidenceConstants};
pub use features::Feature;
#[cfg(feature = "internals")]
pub use novelty::MAX_SURPRISE;
pub use novelty::{KNOTS, Novelty};
pub use projection::Projection;
#[cfg(feature = "internals")]
pub use trend::MAX_TREND_SEGMENTS;
pub use trend::Trend;

use crate::estimate::Estimate;
use crate::plan::{Array, Cells, Plan};
use crate::reason::{Part, Reason};
use crate::shaft::ShaftEstimate;

/// The trained constants of the classifier.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Classifier<P: Plan> {
    /// The features.
    pub features: Array<P::Features, Feature>,
    /// Their affine map to coordinates.
    pub projection: Projection<P>,
    /// Class densities, priors and costs.
    pub discriminant: Discriminant<P>,
    /// The distribution of the healthy class.
    pub novelty: Novelty<P>,
}

/// What a decision means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Finding {
    /// The class of least expected cost.
    Class(u8),
    /// Healthy has the least expected cost, but the segment is too far from the healthy class.
    Novel,
    /// The least expected cost exceeds the cost of no decision.
    Ambiguous,
}

impl<P: Plan> Classifier<P> {
    /// Decides from log-likelihoods and a surprise, for instance of several segments together; `None` if no likelihood
    /// is finite.
    #[must_use]
    pub fn decide(&self, plan: P, log_likelihoods: &[f32], surprise: f32) -> Option<Decision<P>> {
        let mut decision = Decision::empty(plan);
        decision.surprise = surprise;
        self.discriminant.decide(log_likelihoods, &mut decision).then_some(decision)
    }

    /// Decides at projected coordinates; `None` if no likelihood is finite.
    #[must_use]
    pub fn decide_at(&self, plan: P, coordinates: &[f32]) -> Option<Decision<P>> {
        let layout = plan.layout();
        let classes = layout.classes as usize;
        let likelihood = |class| self.discriminant.log_likelihood(layout.discriminant, coordinates, class);
        let likelihoods = Array::<P::Classes, f32>::from_fn(classes, likelihood);
        let mut decision = self.decide(plan, likelihoods.cells(), 0.0)?;
        (decision.distance, decision.surprise) = self.novelty.judge(coordinates);
        Some(decision)
    }

    /// Compares a decision with the limits. Novelty is checked before ambiguity, so that the false-alarm rate is the
    /// set rate.
    #[must_use]
    pub fn finding(&self, decision: &Decision<P>) -> Finding {
        if Some(decision.class) == self.novelty.class && decision.surprise >= self.novelty.limit {
            Finding::Novel
        } else if decision.least_cost() > self.discriminant.reject_cost {
            Finding::Ambiguous
        } else {
            Finding::Class(decision.class)
        }
    }
}

/// What the next step of a classification does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
enum Stage {
    /// Feature k.
    Features,
    /// Coordinate k.
    Coordinates,
    /// Log-likelihood of class k.
    Likelihoods,
    /// A step of posteriors, costs and class.
    Posteriors,
    /// Distance and surprise.
    Novelty,
}

/// A classification under way, in steps of at most F or Z² multiply-adds.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Classification<P: Plan> {
    features: Array<P::Features, f32>,
    coordinates: Array<P::Coordinates, f32>,
    likelihoods: Array<P::Classes, f32>,
    deciding: Deciding,
    stage: Stage,
    k: usize,
}

impl<P: Plan> Classification<P> {
    /// Nothing classified yet.
    #[must_use]
    pub fn new(plan: P) -> Self {
        let layout = plan.layout();
        Self {
            features: Cells::filled(layout.features as usize, 0.0),
            coordinates: Cells::filled(layout.coordinates as usize, 0.0),
            likelihoods: Cells::filled(layout.classes as usize, 0.0),
            deciding: Deciding::new(),
            stage: Stage::Features,
            k: 0,
        }
    }

    /// Does the next step; the result once it is there.
    #[inline(never)]
    pub fn step(
        &mut self,
        plan: P,
        classifier: &Classifier<P>,
        (estimate, shaft): (Option<&Estimate<P>>, Option<&ShaftEstimate<P>>),
        decision: &mut Decision<P>,
    ) -> Option<Result<(), Reason>> {
        let k = self.k;
        match self.stage {
            Stage::Features => {
                let (Some(cell), Some(feature)) =
                    (self.features.cells_mut().get_mut(k), classifier.features.cells().get(k))
                else {
                    return self.then(Stage::Coordinates);
                };
                match feature.value(plan, estimate, shaft) {
                    Ok(value) => *cell = value,
                    Err(reason) => return Some(Err(reason)),
                }
            }
            Stage::Coordinates => {
                let Some(cell) = self.coordinates.cells_mut().get_mut(k) else { return self.then(Stage::Likelihoods) };
                *cell = classifier.projection.coordinate(self.features.cells(), k);
            }
            Stage::Likelihoods => {
                let Some(cell) = self.likelihoods.cells_mut().get_mut(k) else { return self.then(Stage::Posteriors) };
                let kind = plan.layout().discriminant;
                *cell = classifier.discriminant.log_likelihood(kind, self.coordinates.cells(), k);
            }
            Stage::Posteriors => {
                match self.deciding.step(&classifier.discriminant, self.likelihoods.cells(), decision) {
                    None => return None,
                    Some(true) => return self.then(Stage::Novelty),
                    Some(false) => return Some(Err(Reason::NotFinite(Part::Classifier))),
                }
            }
            Stage::Novelty => {
                (decision.distance, decision.surprise) = classifier.novelty.judge(self.coordinates.cells());
                return Some(Ok(()));
            }
        }
        self.k = k.saturating_add(1);
        None
    }

    fn then<T>(&mut self, stage: Stage) -> Option<T> {
        (self.stage, self.k) = (stage, 0);
        None
    }
}
