//! A closed segment → its [`Report`], at once or in steps.

use super::segment::Segment;
use super::verdict;
use crate::decide::{Classification, Decision};
use crate::known_answers::arithmetic_test;
use crate::model::Model;
use crate::plan::{Array, Cells, Plan, Presence};
use crate::reason::Reason;
use crate::regression::estimate::RegressionSolve;
use crate::report::{Report, Verdict};
use crate::shaft::ShaftSolve;
use crate::signal::average;

impl<P: Plan> Segment<P> {
    /// The report, in the place of the caller's: a copy would take stack. The sums are overwritten.
    #[inline(never)]
    pub(super) fn solve(&mut self, model: &Model<P>, report: &mut Report<P>) {
        SegmentSolver::new(model.plan()).run(model, self, report);
        verdict::log(model, report);
    }

    /// The report; the sums are overwritten.
    pub(super) fn report(&mut self, model: &Model<P>) -> Report<P> {
        let mut report = Report::empty(model.plan());
        self.solve(model, &mut report);
        report
    }
}

/// More steps than the largest model has: 254 rows and columns, and as many orders.
const MAX_STEPS: u32 = 1 << 11;

/// What the next step does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
enum Step {
    Trust,
    Regression,
    Shaft,
    Classification,
    Verdict(Result<(), Reason>),
    Done,
}

/// The state of a solve apart from its segment and its report, which are not moved.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct SegmentSolver<P: Plan> {
    regression: Array<P::Regressed, RegressionSolve<P>>,
    shaft: Array<P::Watched, ShaftSolve>,
    classification: Classification<P>,
    next: Step,
}

impl<P: Plan> SegmentSolver<P> {
    // Out of line, so that what it moves takes no stack during the solve.
    #[inline(never)]
    pub(super) fn new(plan: P) -> Self {
        let layout = plan.layout();
        Self {
            regression: P::Regressed::part(layout.regressed() == 1, || RegressionSolve::new(plan)),
            shaft: P::Watched::part(layout.watched() == 1, ShaftSolve::new),
            classification: Classification::new(plan),
            next: Step::Trust,
        }
    }

    /// Does all that is left.
    pub(super) fn run(&mut self, model: &Model<P>, segment: &mut Segment<P>, report: &mut Report<P>) {
        for _ in 0..MAX_STEPS {
            if self.advance(model, segment, report) {
                break;
            }
        }
    }

    /// Does the next step; whether the report is complete.
    #[inline(never)]
    pub(super) fn advance(&mut self, model: &Model<P>, segment: &mut Segment<P>, report: &mut Report<P>) -> bool {
        match self.next {
            Step::Trust => self.next = if start(model, segment, report) { Step::Regression } else { Step::Done },
            Step::Regression => {
                if self.regress(model, segment, report) {
                    self.next = Step::Shaft;
                }
            }
            Step::Shaft => {
                if self.watch(model, segment, report) {
                    // Known at compile time: a plan without a shaft carries no code for it.
                    let layout = model.plan().layout().shaft;
                    let solved = layout.is_some_and(|layout| segment.stuck(layout.mask()).is_none());
                    let contradicts = solved && verdict::contradicts(model, segment, report);
                    self.next = if contradicts { Step::Done } else { Step::Classification };
                }
            }
            Step::Classification => {
                if let Some(result) = self.classify(model, report) {
                    self.next = Step::Verdict(result);
                }
            }
            Step::Verdict(result) => {
                let friction = self.sizes(model, report);
                verdict::judge(model, segment, report, (result, friction));
                self.next = Step::Done;
            }
            Step::Done => {}
        }
        self.next == Step::Done
    }

    /// Does the next step of the regression; whether there is none left.
    #[inline(always)]
    fn regress(&mut self, model: &Model<P>, segment: &mut Segment<P>, report: &mut Report<P>) -> bool {
        let (plan, constants) = (model.plan(), model.constants());
        let stuck = plan.layout().regression.and_then(|layout| segment.stuck(layout.mask()));
        let parts = (self.regression.part_mut(), segment.regression.part_mut());
        let given = (constants.regression.part(), report.estimate.part_mut());
        let ((Some(solve), Some(sums)), (Some(regression), Some(estimate))) = (parts, given) else { return true };
        if stuck.is_some() {
            estimate.reason = stuck;
            return true;
        }
        solve.advance(plan, regression, sums, estimate)
    }

    /// Does the next step of the shaft; whether there is none left.
    #[inline(always)]
    fn watch(&mut self, model: &Model<P>, segment: &mut Segment<P>, report: &mut Report<P>) -> bool {
        let (plan, constants) = (model.plan(), model.constants());
        let stuck = plan.layout().shaft.and_then(|layout| segment.stuck(layout.mask()));
        let parts = (self.shaft.part_mut(), segment.shaft.part_mut());
        let given = (constants.shaft.part(), report.shaft.part_mut());
        let ((Some(solve), Some(sums)), (Some(shaft), Some(estimate))) = (parts, given) else { return true };
        if stuck.is_some() {
            (estimate.friction_reason, estimate.orders_reason) = (stuck, stuck);
            return true;
        }
        solve.advance(plan, shaft, sums, estimate)
    }

    /// Does the next step of the classification; its result with the last one.
    #[inline(always)]
    fn classify(&mut self, model: &Model<P>, report: &mut Report<P>) -> Option<Result<(), Reason>> {
        let (plan, constants) = (model.plan(), model.constants());
        let shaft = report.shaft.part().zip(constants.balance());
        let estimates = (report.estimate.part(), shaft, report.averages.cells());
        let decision = report.decision.get_or_insert_with(|| Decision { model: model.id(), ..Decision::empty(plan) });
        self.classification.step(plan, &constants.classifier, estimates, decision)
    }

    /// The smallest defects that the segment shows; whether one of friction is acceptable.
    #[inline(always)]
    fn sizes(&self, model: &Model<P>, report: &mut Report<P>) -> bool {
        let constants = model.constants();
        let shaft = report.shaft.part().zip(constants.balance());
        let estimates = (report.estimate.part(), shaft, report.averages.cells());
        let (_, variances) = self.classification.coordinates();
        constants.classifier.smallest(estimates, variances, report.smallest.cells_mut())
    }
}

/// Starts the report; `false` if nothing is concluded from the segment, whatever is in it.
#[inline(never)]
fn start<P: Plan>(model: &Model<P>, segment: &Segment<P>, report: &mut Report<P>) -> bool {
    (report.counts, report.rows, report.model) = (segment.counts, segment.rows, model.id());
    // The main loop may have other settings of the processor than the interrupt.
    let failed = segment.failed.or_else(|| arithmetic_test().err()).map(Reason::Arithmetic);
    let reason = if segment.model == model.id() { failed } else { Some(Reason::OtherModel) };
    if let Some(reason) = reason {
        report.verdict = Verdict::Undetermined(reason);
        return false;
    }
    report.averages = segment.averages.clone();
    average::mark_stuck::<P>(&mut report.averages, segment.counts.stuck);
    true
}
