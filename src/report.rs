//! The report of a segment, which the detector makes and telemetry sends.

pub use crate::decide::Verdict;
use crate::decide::{Decision, NO_MODEL};
use crate::plan::{Array, Cells, Plan, Presence};
use crate::reason::{Part, Reason};
use crate::regression::estimate::Estimate;
use crate::shaft::ShaftEstimate;
use crate::signal::Counts;
use crate::signal::average::{Average, Averages};

/// The verdict on one segment with all results behind it.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Report<P: Plan> {
    /// The class, or why there is none.
    pub verdict: Verdict,
    /// Likelihoods, posteriors, costs, distance from healthy and missing features; `None` if the verdict is
    /// undetermined.
    pub decision: Option<Decision<P>>,
    /// Samples, rows and channels of the segment that were refused or weighted less.
    pub counts: Counts,
    /// Rows of the regression; in a plan without one, usable samples.
    pub rows: u32,
    pub(crate) estimate: Array<P::Regressed, Estimate<P>>,
    pub(crate) shaft: Array<P::Watched, ShaftEstimate<P>>,
    pub(crate) averages: Averages<P>,
    /// Of each rising coordinate; the first is not used.
    pub(crate) smallest: Array<P::Laws, f32>,
    /// The id of the model.
    pub(crate) model: u32,
}

impl<P: Plan> Report<P> {
    // Out of line, so that what it moves takes no stack during the solve.
    #[inline(never)]
    pub(crate) fn empty(plan: P) -> Self {
        let layout = plan.layout();
        Self {
            verdict: Verdict::Undetermined(Reason::TooFewRows { part: Part::Classifier, rows: 0 }),
            decision: None,
            counts: Counts::default(),
            rows: 0,
            estimate: P::Regressed::part(layout.regressed() == 1, || Estimate::empty(plan)),
            shaft: P::Watched::part(layout.watched() == 1, || ShaftEstimate::empty(plan)),
            averages: crate::signal::average::empty(plan),
            smallest: Cells::filled(layout.laws(), f32::INFINITY),
            model: NO_MODEL,
        }
    }

    /// Withdraws the verdict: a fault was found late ([`Detector::discard`](crate::Detector::discard) returned `true`),
    /// and may have begun in this segment. Do so before the evidence takes it.
    pub fn withdraw(&mut self) {
        (self.verdict, self.decision) = (Verdict::Undetermined(Reason::FoundLate), None);
    }

    /// The decision, or why there is none, for [`Evidence::observe_outcome`](crate::Evidence::observe_outcome).
    ///
    /// # Errors
    /// The reason of an undetermined verdict.
    pub fn outcome(&self) -> Result<&Decision<P>, Reason> {
        match (self.verdict, &self.decision) {
            (Verdict::Undetermined(reason), _) => Err(reason),
            (_, Some(decision)) => Ok(decision),
            // Never: a verdict has a decision.
            (_, None) => Err(Reason::NotFinite(Part::Classifier)),
        }
    }

    /// The estimate of the regression; `None` in a plan without one.
    #[must_use]
    pub fn estimate(&self) -> Option<&Estimate<P>> {
        self.estimate.part()
    }

    /// Friction and bearing orders; `None` in a plan that does not watch the shaft.
    #[must_use]
    pub fn shaft(&self) -> Option<&ShaftEstimate<P>> {
        self.shaft.part()
    }

    /// Averages of the channels that the layout names, in the order of the channels.
    #[must_use]
    pub fn averages(&self) -> &[Average] {
        self.averages.cells()
    }

    /// The smallest defect in each rising coordinate of the model, the last ones, that the gate would have found in
    /// this segment with a probability of 90 %: of friction as a part of the usual one, of a bearing order the
    /// amplitude of its first harmonic, A. Infinite where the segment shows none. Empty if a projection mixes the
    /// features.
    #[must_use]
    pub fn smallest(&self) -> &[f32] {
        self.smallest.cells().get(1..).unwrap_or_default()
    }

    /// What the features come from.
    #[cfg(feature = "telemetry")]
    pub(crate) fn estimates<'a>(
        &'a self,
        balance: Option<&'a crate::shaft::TorqueBalance>,
    ) -> crate::decide::Estimates<'a, P> {
        (self.estimate(), self.shaft().zip(balance), self.averages())
    }
}
