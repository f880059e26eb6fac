//! The trained constants of the classifier, and what a decision means by them.

use super::covariates::Covariates;
use super::discriminant::{Decision, Discriminant};
use super::features::Feature;
use super::gates::Novelty;
use super::projection::Projection;
use super::verdict::Verdict;
use crate::plan::{Array, Cells, ClassifierLengths, Kind};

/// The trained constants of the classifier.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Classifier<P: ClassifierLengths> {
    /// The features.
    pub features: Array<P::Features, Feature>,
    /// What explains a part of the features.
    pub covariates: Covariates<P>,
    /// Their affine map to coordinates.
    pub projection: Projection<P>,
    /// Class densities, priors and costs.
    pub discriminant: Discriminant<P>,
    /// The distribution of the healthy class.
    pub novelty: Novelty<P>,
}

impl<P: ClassifierLengths> Classifier<P> {
    /// Decides from log-likelihoods and a surprise, for instance of several segments together; `None` if no likelihood
    /// is finite.
    #[must_use]
    pub fn decide(&self, plan: P, log_likelihoods: &[f32], surprise: f32) -> Option<Decision<P>> {
        let mut decision = Decision::empty(plan);
        (decision.distance_surprise, decision.surprise) = (surprise, surprise);
        self.discriminant.decide(log_likelihoods, &mut decision).then_some(decision)
    }

    /// Decides at projected coordinates whose errors have these variances: infinite for a missing coordinate, 0 for
    /// coordinates without a variance. `None` if no likelihood is finite.
    #[must_use]
    pub fn decide_at(&self, plan: P, coordinates: &[f32], variances: &[f32]) -> Option<Decision<P>> {
        let classes = plan.layout().classes as usize;
        let mut likelihoods: Array<P::Classes, f32> = Cells::filled(classes, 0.0);
        let mut beyond: Array<P::Classes, bool> = Cells::filled(classes, false);
        let cells = likelihoods.cells_mut().iter_mut().zip(beyond.cells_mut());
        self.compare(plan, coordinates, variances, cells);
        let mut decision = self.decide(plan, likelihoods.cells(), 0.0)?;
        decision.beyond = beyond;
        decision.depart(self.novelty.judge(coordinates, variances));
        Some(decision)
    }

    /// The cells of each class get its log-likelihood at coordinates whose errors have these variances, and whether
    /// they are beyond its gate. The classes of a linear discriminant share the factor.
    // In line, so that the lengths of the slices are known where they are those of arrays.
    #[inline(always)]
    pub(super) fn compare<'a>(
        &self,
        plan: P,
        z: &[f32],
        variances: &[f32],
        cells: impl Iterator<Item = (&'a mut f32, &'a mut bool)>,
    ) {
        let (kind, discriminant) = (plan.layout().discriminant, &self.discriminant);
        let mut density = discriminant.density(kind, z.len(), variances, 0);
        for (class, (likelihood, beyond)) in (0..u8::MAX).zip(cells) {
            if kind == Kind::Quadratic && class > 0 {
                density = discriminant.density(kind, z.len(), variances, class as usize);
            }
            let squared = discriminant.squared_distance(&density, z, class as usize);
            *likelihood = density.log_density(squared);
            *beyond = self.novelty.excludes(class, squared, [density.available(), z.len()]);
        }
    }

    /// Compares a decision with the limits. Novelty is checked before ambiguity, so that the false-alarm rate is the
    /// set rate.
    #[inline]
    #[must_use]
    pub fn verdict(&self, decision: &Decision<P>) -> Verdict {
        let unhealthy = decision.surprise >= self.novelty.limit;
        // Costs may decide for a class that the segment is far from, if it is near another one.
        let mut class = 0_u8;
        let far_from_all = decision.beyond().iter().all(|beyond| {
            let far = *beyond || (unhealthy && Some(class) == self.novelty.class);
            class = class.wrapping_add(1);
            far
        });
        if far_from_all || (unhealthy && Some(decision.class) == self.novelty.class) {
            Verdict::Novel
        } else if decision.least_cost() > self.discriminant.reject_cost {
            Verdict::Ambiguous
        } else {
            Verdict::Class(decision.class)
        }
    }
}
