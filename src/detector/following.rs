//! What a monitor does about slow changes of the healthy drive: nothing, or it follows them by a baseline.

use super::verdict;
use crate::alarm::Baseline;
use crate::alarm::baseline::BaselineConstants;
use crate::decide::Decision;
use crate::model::Model;
use crate::plan::{Array, Cells, Plan};
use crate::reason::Reason;
use crate::report::Report;

/// How a [`Monitor`](crate::Monitor) takes slow changes: `()` if it does not, and [`Following`].
///
/// It is a type, so that the first has neither memory nor instructions for a baseline.
pub trait Surroundings<P: Plan>: Sealed {
    /// Decides a report anew, relative to the baseline, and lets the baseline follow.
    #[doc(hidden)]
    fn follow(&mut self, _model: &Model<P>, _report: &mut Report<P>) {}

    /// Takes back what the last report has moved.
    #[doc(hidden)]
    fn undo(&mut self) {}

    /// The baseline, if it has one.
    #[doc(hidden)]
    fn baseline(&self) -> Option<&Baseline<P>> {
        None
    }

    /// The same, to be restored.
    #[doc(hidden)]
    fn baseline_mut(&mut self) -> Option<&mut Baseline<P>> {
        None
    }
}

/// Nothing else is how to take slow changes.
pub trait Sealed {}

impl Sealed for () {}

impl<P: Plan> Surroundings<P> for () {}

/// A baseline that follows slow changes of the healthy drive.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Following<P: Plan> {
    /// None without a healthy class in the model.
    baseline: Option<Baseline<P>>,
    /// Its offset, and whether it was at its bound, before the last report moved it.
    before: (Array<P::Coordinates, f32>, bool),
}

impl<P: Plan> Following<P> {
    pub(super) fn new(model: &Model<P>, constants: Option<BaselineConstants>) -> Self {
        let offset = Cells::filled(model.plan().layout().coordinates as usize, 0.0);
        Self { baseline: constants.and_then(|constants| Baseline::new(model, constants)), before: (offset, false) }
    }
}

impl<P: Plan> Sealed for Following<P> {}

impl<P: Plan> Surroundings<P> for Following<P> {
    fn follow(&mut self, model: &Model<P>, report: &mut Report<P>) {
        let Some(baseline) = &mut self.baseline else { return };
        let (offset, at_bound) = &mut self.before;
        offset.cells_mut().iter_mut().zip(baseline.offset()).for_each(|(cell, x)| *cell = *x);
        *at_bound = baseline.at_bound();
        baseline.follow(model, report);
    }

    fn undo(&mut self) {
        if let Some(baseline) = &mut self.baseline {
            baseline.restore(self.before.0.cells(), self.before.1);
        }
    }

    fn baseline(&self) -> Option<&Baseline<P>> {
        self.baseline.as_ref()
    }

    fn baseline_mut(&mut self) -> Option<&mut Baseline<P>> {
        self.baseline.as_mut()
    }
}

impl<P: Plan> Baseline<P> {
    /// Without any offset yet; `None` if a constant is out of range, or the model has no healthy class.
    #[must_use]
    pub fn new(model: &Model<P>, constants: BaselineConstants) -> Option<Self> {
        let novelty = &model.constants().classifier.novelty;
        novelty
            .class
            .and_then(|_| Self::without_offset(model.plan(), novelty, constants))
            .map(|baseline| baseline.of_model(model.mark()))
    }

    /// Decides the segment of a report anew, relative to this baseline, and follows slow changes. A report without a
    /// decision remains; one of another model, or by the baseline of another one, gets the reason
    /// [`Reason::OtherModel`].
    pub fn follow(&mut self, model: &Model<P>, report: &mut Report<P>) {
        let (plan, constants) = (model.plan(), model.constants());
        if report.decision.is_none() {
            return;
        }
        if self.model() != model.mark() || report.model != model.mark() {
            return verdict::conclude(model, report, Err(Reason::OtherModel));
        }
        let mut decision = Decision { model: model.mark(), ..Decision::empty(plan) };
        let result = self.decide(plan, &constants.classifier, report.estimates(constants.balance()), &mut decision);
        report.decision = Some(decision);
        verdict::conclude(model, report, result);
    }
}
