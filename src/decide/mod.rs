//! Third wing: [`Estimate`] → [`Decision`].
//!
//! [`Classifier`] holds the trained constants of the wing: which features, their projection, and the discriminant.

pub mod discriminant;
pub mod features;
pub mod projection;

pub use discriminant::{Decision, Discriminant, Kind};
pub use features::{Features, SHAFT_FEATURES};
pub use projection::Projection;

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
        let features = self.features.extract(estimate, shaft)?;
        self.discriminant.decide(&self.projection.project(&features)).ok_or(Reason::NotFinite)
    }
}
