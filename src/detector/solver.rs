//! A closed segment → its [`Report`], at once or in pieces of bounded cost.

use super::report::{Report, Verdict};
use crate::decide::{Classification, Decision, Finding};
use crate::estimate::{RegressionSolve, RegressionSums};
use crate::model::Model;
use crate::plan::{Array, Cells, Plan};
use crate::reason::Reason;
use crate::sample::Counts;
use crate::shaft::{ShaftSolve, ShaftSums};

/// Multiply-adds of a piece, about.
const PIECE: usize = 16;

/// The sums of a closed segment, separate from the detector.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Segment<P: Plan> {
    pub(super) regression: Array<P::Regressed, RegressionSums<P>>,
    pub(super) shaft: Array<P::Watched, ShaftSums<P>>,
    pub(super) counts: Counts,
    /// Rows of the regression, or usable samples in a plan without one.
    pub(super) rows: u32,
    /// Whether it is a whole segment, of which half must be usable.
    pub(super) whole: bool,
}

/// What the next piece does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
enum Stage {
    Regression,
    Shaft,
    Classification,
    Done,
}

/// The solve of a closed segment in pieces.
///
/// Each call of [`Solver::advance`] takes at most about 400 instructions on a Cortex-M4F with models of up to 8 parameters.
/// Pieces give the same bits as [`Model::conclude`].
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Solver<'m, P: Plan> {
    model: &'m Model<P>,
    segment: Segment<P>,
    report: Report<P>,
    decision: Decision<P>,
    regression: Array<P::Regressed, RegressionSolve<P>>,
    shaft: Array<P::Watched, ShaftSolve>,
    classification: Classification<P>,
    stage: Stage,
}

impl<'m, P: Plan> Solver<'m, P> {
    /// Nothing solved yet.
    #[must_use]
    pub fn new(model: &'m Model<P>, segment: Segment<P>) -> Self {
        let (plan, layout) = (model.plan(), model.plan().layout());
        let mut report = Report::empty(plan);
        (report.counts, report.rows) = (segment.counts, segment.rows);
        let mut solver = Self {
            model,
            report,
            decision: Decision::empty(plan),
            regression: Cells::from_fn(layout.regressed(), |_| RegressionSolve::new(plan)),
            shaft: Cells::from_fn(layout.watched(), |_| ShaftSolve::new()),
            classification: Classification::new(plan),
            stage: Stage::Regression,
            segment,
        };
        solver.refuse_stuck();
        solver
    }

    /// Parts with a stuck channel have no result.
    fn refuse_stuck(&mut self) {
        let (layout, stuck) = (self.model.plan().layout(), self.segment.counts.stuck);
        let reason = |mask: u16| stuck.first_of(mask).map(|channel| Reason::Stuck { channel });
        if let (Some(regression), Some(estimate)) = (layout.regression, self.report.estimate.part_mut())
            && let Some(reason) = reason(regression.mask())
        {
            (estimate.reason, self.stage) = (Some(reason), Stage::Shaft);
        }
    }

    /// Whether the channels of the shaft were stuck; then it has no result.
    fn shaft_is_stuck(&mut self) -> bool {
        let Some(shaft) = self.model.plan().layout().shaft else { return false };
        let reason = self.segment.counts.stuck.first_of(shaft.mask()).map(|channel| Reason::Stuck { channel });
        if let (Some(_), Some(estimate)) = (reason, self.report.shaft.part_mut()) {
            (estimate.friction_reason, estimate.orders_reason) = (reason, reason);
        }
        reason.is_some()
    }

    /// Does the next piece; returns the report with the last one. Further calls return it again.
    pub fn advance(&mut self) -> Option<&Report<P>> {
        let (plan, constants) = (self.model.plan(), self.model.constants());
        match self.stage {
            Stage::Regression => {
                let parts = (self.regression.part_mut(), self.segment.regression.part_mut());
                let own = (constants.regression.part(), self.report.estimate.part_mut());
                let ((Some(solve), Some(sums)), (Some(regression), Some(estimate))) = (parts, own) else {
                    self.stage = Stage::Shaft;
                    return None;
                };
                if solve.advance(plan, regression, sums, estimate, PIECE) {
                    self.stage = Stage::Shaft;
                }
            }
            Stage::Shaft => {
                if self.shaft_is_stuck() {
                    self.stage = Stage::Classification;
                    return None;
                }
                let parts = (self.shaft.part_mut(), self.segment.shaft.part_mut());
                let own = (constants.shaft.part(), self.report.shaft.part_mut());
                let ((Some(solve), Some(sums)), (Some(shaft), Some(estimate))) = (parts, own) else {
                    self.stage = Stage::Classification;
                    return None;
                };
                if solve.advance(plan, shaft, sums, estimate, PIECE) {
                    self.stage = Stage::Classification;
                }
            }
            Stage::Classification => {
                let estimates = (self.report.estimate.part(), self.report.shaft.part());
                let step = self.classification.step(plan, &constants.classifier, estimates, &mut self.decision);
                if let Some(result) = step {
                    self.judge(result);
                    self.stage = Stage::Done;
                    return Some(&self.report);
                }
            }
            Stage::Done => return Some(&self.report),
        }
        None
    }

    /// Does all that is left; returns the report.
    #[must_use]
    pub fn finish(mut self) -> Report<P> {
        self.run();
        self.report
    }

    /// Does all that is left.
    fn run(&mut self) {
        // Bounded: every call does a piece, and no model has so many.
        for _ in 0..MAX_PIECES {
            if self.advance().is_some() {
                break;
            }
        }
    }

    fn judge(&mut self, result: Result<(), Reason>) {
        let report = &mut self.report;
        // The model knows the spread of whole segments only.
        let short = self.segment.whole && report.rows < self.model.constants().sampling.segment_samples / 2;
        let result = if short { result.and(Err(Reason::ShortSegment { rows: report.rows })) } else { result };
        report.verdict = match result {
            Err(reason) => Verdict::Undetermined(reason),
            Ok(()) => match self.model.constants().classifier.finding(&self.decision) {
                Finding::Class(class) => Verdict::Class(class),
                Finding::Novel => Verdict::Novel,
                Finding::Ambiguous => Verdict::Ambiguous,
            },
        };
        report.decision = result.is_ok().then(|| self.decision.clone());
    }
}

/// More pieces than the largest model has: 254 columns need fewer than 254² steps of a piece each.
const MAX_PIECES: u32 = 1 << 17;

impl<P: Plan> Model<P> {
    /// The report of a closed segment, in a thread that has the time; adopt it by
    /// [`Detector::adopt`](crate::Detector::adopt).
    #[must_use]
    #[inline(never)]
    pub fn conclude(&self, segment: Segment<P>) -> Report<P> {
        // Not by `finish`, whose move would need room for another copy on the stack.
        let mut solver = Solver::new(self, segment);
        solver.run();
        self.log(&solver.report);
        solver.report
    }

    /// With the feature `defmt`, logs each closed segment on a chip; host programs have no logger.
    fn log(&self, report: &Report<P>) {
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
