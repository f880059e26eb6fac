//! Everything that was trained, as plain numbers.

use super::parts::ModelView;
use super::sampling::Sampling;
use crate::alarm::EvidenceConstants;
use crate::decide::Classifier;
use crate::plan::{Array, Cells, Plan};
use crate::regression::Regression;
use crate::shaft::TorqueBalance;
use crate::shaft::state::ShaftConstants;
use crate::signal::{Channel, Label};

/// Everything that was trained, as plain numbers. [`Model::new`](super::Model::new) checks them.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Constants<P: Plan> {
    /// Rate and segment length.
    pub sampling: Sampling,
    /// The channels, in the order of the sample.
    pub channels: Array<P::Channels, Channel>,
    /// The regression: one element, or none.
    pub regression: Array<P::Regressed, Regression<P>>,
    /// The shaft: one element, or none.
    pub shaft: Array<P::Watched, ShaftConstants<P>>,
    /// Features, projection, discriminant and novelty.
    pub classifier: Classifier<P>,
    /// Constants of the alarm over many segments.
    pub evidence: EvidenceConstants,
    /// Class names, none of them empty.
    pub labels: Array<P::Classes, Label>,
}

impl<P: Plan> Constants<P> {
    /// The torque balance of the shaft, if there is one.
    pub(crate) fn balance(&self) -> Option<&TorqueBalance> {
        self.shaft.part().map(|shaft| &shaft.balance)
    }
}

impl<P: Plan> Constants<P> {
    pub(super) fn parts(&self, plan: P) -> ModelView<'_> {
        crate::plan!(@parts viewed, P, self, plan.layout(), P::channels().unwrap_or(&[]))
    }
}
