//! A closed segment → its [`Report`], at once or in pieces of bounded cost.

use super::sequence::Sequence;
use crate::alarm::Baseline;
use crate::decide::{Classification, Decision, Finding};
use crate::known_answers::arithmetic_test;
use crate::model::Model;
use crate::plan::{Array, Cells, Plan, Presence};
use crate::reason::{Kernel, Reason};
use crate::regression::estimate::{RegressionSolve, RegressionSums};
use crate::report::{Report, Verdict};
use crate::shaft::{ShaftSolve, ShaftSums};
use crate::signal::Counts;
use crate::signal::average::{self, Averages};

/// Instructions of a piece, about; its last step may exceed them.
pub(super) const PIECE: usize = 140;

/// The sums of a closed segment, separate from the detector.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Segment<P: Plan> {
    pub(super) regression: Array<P::Regressed, RegressionSums<P>>,
    pub(super) shaft: Array<P::Watched, ShaftSums<P>>,
    pub(super) averages: Averages<P>,
    pub(super) counts: Counts,
    /// Rows of the regression, or usable samples in a plan without one.
    pub(super) rows: u32,
    /// Whether it is a whole segment, of which half must be usable.
    pub(super) whole: bool,
    /// What the processor did not compute as the host does when the segment closed.
    pub(super) failed: Option<Kernel>,
    /// The mark of the model.
    pub(super) model: u32,
    /// Its place among the segments of the detector.
    pub(super) sequence: Sequence,
}

/// What the next piece does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
enum Stage {
    Trust,
    Regression,
    Shaft,
    Plausibility,
    Classification,
    Done,
}

/// The solve of a closed segment in pieces.
///
/// Each call of [`Solver::advance`] does a few steps and returns; `cargo xtask measure` prints the instructions of the
/// longest call, of the examples' signals and of any data. Pieces give the same bits as [`Model::conclude`].
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Solver<'m, P: Plan> {
    model: &'m Model<P>,
    segment: Segment<P>,
    report: Report<P>,
    solve: Solve<P>,
}

impl<'m, P: Plan> Solver<'m, P> {
    /// Nothing solved yet.
    #[must_use]
    pub fn new(model: &'m Model<P>, segment: Segment<P>) -> Self {
        let plan = model.plan();
        Self { model, segment, report: Report::empty(plan), solve: Solve::new(plan) }
    }

    /// Does the next piece; returns the report with the last one. Further calls return it again.
    pub fn advance(&mut self) -> Option<&Report<P>> {
        let done = self.solve.advance(self.model, &mut self.segment, &mut self.report, PIECE);
        done.then_some(&self.report)
    }

    /// Does all that is left; returns the report.
    #[must_use]
    pub fn finish(mut self) -> Report<P> {
        self.solve.run(self.model, &mut self.segment, &mut self.report);
        self.report
    }
}

/// The state of a solve apart from its segment and its report, which are not moved.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Solve<P: Plan> {
    regression: Array<P::Regressed, RegressionSolve<P>>,
    shaft: Array<P::Watched, ShaftSolve>,
    classification: Classification<P>,
    stage: Stage,
}

impl<P: Plan> Solve<P> {
    // Out of line, so that what it moves takes no stack during the solve.
    #[inline(never)]
    pub(super) fn new(plan: P) -> Self {
        let layout = plan.layout();
        Self {
            regression: P::Regressed::part(layout.regressed() == 1, || RegressionSolve::new(plan)),
            shaft: P::Watched::part(layout.watched() == 1, ShaftSolve::new),
            classification: Classification::new(plan),
            stage: Stage::Trust,
        }
    }

    /// Does about `budget` instructions of the next stage; whether the report is complete.
    #[inline(never)]
    pub(super) fn advance(
        &mut self,
        model: &Model<P>,
        segment: &mut Segment<P>,
        report: &mut Report<P>,
        budget: usize,
    ) -> bool {
        let (plan, constants) = (model.plan(), model.constants());
        let layout = plan.layout();
        let stuck = segment.counts.stuck;
        // Parts with a stuck channel have no result.
        let reason = |mask: u16| stuck.first_of(mask).map(|channel| Reason::Stuck { channel });
        match self.stage {
            Stage::Trust => {
                (report.counts, report.rows, report.model) = (segment.counts, segment.rows, model.mark());
                if let Some(reason) = distrust(model, segment) {
                    report.verdict = Verdict::Undetermined(reason);
                    self.stage = Stage::Done;
                    return true;
                }
                report.averages = segment.averages.clone();
                average::mark_stuck::<P>(&mut report.averages, stuck);
                self.stage = Stage::Regression;
            }
            Stage::Regression => {
                let parts = (self.regression.part_mut(), segment.regression.part_mut(), layout.regression);
                let own = (constants.regression.part(), report.estimate.part_mut());
                let done =
                    if let ((Some(solve), Some(sums), Some(part)), (Some(regression), Some(estimate))) = (parts, own) {
                        if let Some(reason) = reason(part.mask()) {
                            estimate.reason = Some(reason);
                            true
                        } else {
                            solve.advance(plan, regression, sums, estimate, budget)
                        }
                    } else {
                        true
                    };
                if done {
                    self.stage = Stage::Shaft;
                }
            }
            Stage::Shaft => {
                let parts = (self.shaft.part_mut(), segment.shaft.part_mut(), layout.shaft);
                let own = (constants.shaft.part(), report.shaft.part_mut());
                let mut next = Stage::Classification;
                let done = if let ((Some(solve), Some(sums), Some(part)), (Some(shaft), Some(estimate))) = (parts, own)
                {
                    let reason = reason(part.mask());
                    if reason.is_some() {
                        (estimate.friction_reason, estimate.orders_reason) = (reason, reason);
                        true
                    } else {
                        next = Stage::Plausibility;
                        solve.advance(plan, shaft, sums, estimate, budget)
                    }
                } else {
                    true
                };
                if done {
                    self.stage = next;
                    report.decision = Some(Decision { model: model.mark(), ..Decision::empty(plan) });
                }
            }
            Stage::Plausibility => {
                // The first condition leaves no code in a plan without a shaft.
                if layout.watched() == 1 && contradicts(model, segment, report) {
                    self.stage = Stage::Done;
                    return true;
                }
                self.stage = Stage::Classification;
            }
            Stage::Classification => {
                let shaft = report.shaft.part().zip(constants.balance());
                let estimates = (report.estimate.part(), shaft, report.averages.cells());
                let Some(decision) = &mut report.decision else { return true };
                let step = self.classification.step(plan, &constants.classifier, estimates, decision);
                if let Some(result) = step {
                    judge(model, segment, report, result);
                    self.stage = Stage::Done;
                    return true;
                }
            }
            Stage::Done => return true,
        }
        false
    }

    /// Does all that is left.
    pub(super) fn run(&mut self, model: &Model<P>, segment: &mut Segment<P>, report: &mut Report<P>) {
        // Bounded: every call does a piece, and no model has so many.
        for _ in 0..MAX_PIECES {
            if self.advance(model, segment, report, usize::MAX) {
                break;
            }
        }
    }
}

/// Why nothing is concluded from a segment, whatever is in it.
#[inline(never)]
fn distrust<P: Plan>(model: &Model<P>, segment: &Segment<P>) -> Option<Reason> {
    if segment.model != model.mark() {
        return Some(Reason::OtherModel);
    }
    // The main loop may have other settings of the processor than the interrupt.
    segment.failed.or_else(|| arithmetic_test().err()).map(Reason::Arithmetic)
}

/// Whether the signals contradict the model or each other; then that is the reason for no verdict.
// Out of line, so that it takes no stack during the solve.
#[inline(never)]
fn contradicts<P: Plan>(model: &Model<P>, segment: &Segment<P>, report: &mut Report<P>) -> bool {
    let sums = (segment.shaft.part(), model.constants().shaft.part());
    let (Some(estimate), (Some(sums), Some(constants))) = (report.shaft.part_mut(), sums) else { return false };
    let Some(error) = estimate.contradiction(constants, sums) else { return false };
    report.verdict = Verdict::Undetermined(Reason::Implausible(error));
    report.decision = None;
    true
}

/// The verdict of a classified segment.
fn judge<P: Plan>(model: &Model<P>, segment: &Segment<P>, report: &mut Report<P>, result: Result<(), Reason>) {
    let constants = model.constants();
    // The model knows the spread of whole segments only.
    let short = segment.whole && report.rows < constants.sampling.segment_samples / 2;
    let result = if short { result.and(Err(Reason::ShortSegment { rows: report.rows })) } else { result };
    conclude(model, report, result);
}

/// The verdict of a decision.
#[inline(always)]
fn conclude<P: Plan>(model: &Model<P>, report: &mut Report<P>, result: Result<(), Reason>) {
    report.verdict = match (result, &report.decision) {
        (Ok(()), Some(decision)) => match model.constants().classifier.finding(decision) {
            Finding::Class(class) => Verdict::Class(class),
            Finding::Novel => Verdict::Novel,
            Finding::Ambiguous => Verdict::Ambiguous,
        },
        (Err(reason), _) => Verdict::Undetermined(reason),
        // Never: a classified segment has a decision.
        (Ok(()), None) => return,
    };
    if result.is_err() {
        report.decision = None;
    }
}

impl<P: Plan> Model<P> {
    /// Decides the segment of a report anew, relative to a baseline that follows slow changes, and lets the baseline
    /// follow. A report without a decision remains; one of another model, or by the baseline of another one, gets the
    /// reason [`Reason::OtherModel`].
    pub fn follow(&self, baseline: &mut Baseline<P>, report: &mut Report<P>) {
        let (plan, constants) = (self.plan(), self.constants());
        if report.decision.is_none() {
            return;
        }
        if baseline.model() != self.mark() || report.model != self.mark() {
            return conclude(self, report, Err(Reason::OtherModel));
        }
        let mut decision = Decision { model: self.mark(), ..Decision::empty(plan) };
        let result = baseline.decide(plan, &constants.classifier, report.estimates(constants.balance()), &mut decision);
        report.decision = Some(decision);
        conclude(self, report, result);
    }
}

/// More pieces than the largest model has: 254 columns need fewer than 254² steps of a piece each.
const MAX_PIECES: u32 = 1 << 17;

impl<P: Plan> Model<P> {
    /// The report of a closed segment, in a thread that has the time; adopt it by
    /// [`Detector::adopt`](crate::Detector::adopt).
    #[must_use]
    pub fn conclude(&self, mut segment: Segment<P>) -> Report<P> {
        self.report(&mut segment)
    }

    /// The report of a closed segment, whose sums are overwritten.
    pub(super) fn report(&self, segment: &mut Segment<P>) -> Report<P> {
        let mut report = Report::empty(self.plan());
        self.solve(segment, &mut report);
        report
    }

    /// Solves a closed segment. Its sums are overwritten, and the report is in the place of the caller's: a copy of
    /// either would take stack.
    #[inline(never)]
    pub(super) fn solve(&self, segment: &mut Segment<P>, report: &mut Report<P>) {
        Solve::new(self.plan()).run(self, segment, report);
        self.log(report);
    }

    /// With the feature `defmt`, logs each closed segment on a chip; host programs have no logger.
    pub(super) fn log(&self, report: &Report<P>) {
        #[cfg(all(feature = "defmt", target_os = "none"))]
        {
            let Report { rows, counts, .. } = report;
            match report.verdict {
                Verdict::Class(class) => {
                    if counts.rejected > 0 || counts.saturated > 0 {
                        defmt::warn!(
                            "samples refused: {=u32} rejected, {=u32} saturated",
                            counts.rejected,
                            counts.saturated
                        );
                    }
                    defmt::info!(
                        "{=u32} rows, {}, class {=u8}, verdict: {=str}",
                        rows,
                        counts,
                        class,
                        self.label(class)
                    );
                }
                Verdict::Novel => defmt::warn!("{=u32} rows, {}, verdict: novel", rows, counts),
                Verdict::Ambiguous => defmt::info!("{=u32} rows, {}, verdict: ambiguous", rows, counts),
                Verdict::Undetermined(reason) => defmt::warn!("{=u32} rows, {}, no verdict: {}", rows, counts, reason),
            }
        }
        #[cfg(not(all(feature = "defmt", target_os = "none")))]
        let _ = (self, report);
    }
}
