//! Third wing: [`Estimate`] → [`Decision`].
//!
//! [`Classifier`] holds the trained constants of the wing: which features, their projection, the discriminant, and how
//! far from healthy is novel. [`Evidence`] gathers the decisions of many segments into an alarm.

pub mod discriminant;
pub mod evidence;
pub mod features;
pub mod novelty;
pub mod projection;
pub mod trend;

pub use discriminant::{Decision, Discriminant, Kind};
pub use evidence::{Alarm, Cause, Evidence, EvidencePlan};
pub use features::{Features, SHAFT_FEATURES};
pub use novelty::Novelty;
pub use projection::Projection;
pub use trend::Trend;

use crate::estimate::{Estimate, Reason, ShaftEstimate};

/// Trained constants from estimate to decision: `F` features, `Z` projected coordinates, `C` classes, all
/// capacities.
///
/// Places beyond those in use hold neutral values (zero rows, zero weights, a likelihood of zero), so that a wider
/// capacity gives the same bits.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Classifier<const F: usize, const Z: usize, const C: usize> {
    /// Which numbers of the estimate are used.
    pub features: Features<F>,
    /// Their affine map to `Z` coordinates.
    pub projection: Projection<F, Z>,
    /// Class densities, priors and costs.
    pub discriminant: Discriminant<Z, C>,
    /// The healthy class by itself.
    pub novelty: Novelty<Z>,
}

/// What a decision comes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Finding {
    /// The class of least expected cost.
    Class(u8),
    /// Healthy is the cheapest name, but too far from healthy to be called so.
    Novel,
    /// Even the cheapest name is too likely wrong.
    Ambiguous,
}

impl<const F: usize, const Z: usize, const C: usize> Classifier<F, Z, C> {
    /// Classifies one estimate, with that of the shaft where features of it are asked for.
    ///
    /// # Errors
    /// [`Reason::NotFinite`] where a likelihood is not a number; where the shaft's estimate says nothing but is asked for, its
    /// reason, and [`Reason::TooFewRows`] where there is none.
    pub fn classify<const M: usize, const P: usize, const K: usize>(
        &self,
        estimate: &Estimate<M, P>,
        shaft: Option<&ShaftEstimate<K>>,
    ) -> Result<Decision<C>, Reason> {
        let z = self.projection.project(&self.features.extract(estimate, shaft)?);
        self.decide(&z).ok_or(Reason::NotFinite)
    }

    /// Decides at projected coordinates; nothing where no likelihood is finite.
    #[must_use]
    pub fn decide(&self, z: &[f32; Z]) -> Option<Decision<C>> {
        let mut decision = self.discriminant.decide(z)?;
        (decision.distance, decision.surprise) = self.novelty.judge(z);
        Some(decision)
    }

    /// Holds a decision against the limits. An unknown or smaller defect is not called healthy; that comes before
    /// ambiguity, so that the false-alarm rate is the set one.
    #[must_use]
    pub fn finding(&self, decision: &Decision<C>) -> Finding {
        if decision.class == self.novelty.class && decision.surprise >= self.novelty.limit {
            Finding::Novel
        } else if decision.least_cost() > self.discriminant.reject_cost {
            Finding::Ambiguous
        } else {
            Finding::Class(decision.class)
        }
    }
}
