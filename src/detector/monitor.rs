//! What the main loop owns: closed segments in, one report a segment out, and the alarm of all of them.
//!
//! ```text
//! interrupt   Detector::exchange ─► Segment ─┐
//! main loop                                 ▼
//! Monitor     solve ─► Report ─► Evidence ─► Alarm
//!                         ▲
//!                         └ withdrawn if the next segment says that a fault was found late
//! ```
//!
//! A fault that [`Detector::discard`](super::Detector::discard) finds in the first half of a segment may have begun in
//! the one before. The monitor keeps the evidence from before each report until the next segment, and takes the report
//! out again if that one puts it in doubt.

use core::borrow::BorrowMut;

use super::Detector;
use super::segment::Segment;
use super::sequence::Sequence;
use super::solver::SegmentSolver;
use super::verdict;
use crate::alarm::evidence::{Alarm, Evidence};
use crate::alarm::{Silence, SilenceLimits, StateError};
use crate::drive::Alignment;
use crate::model::Model;
use crate::plan::Plan;
use crate::reason::{Implausible, Reason};
use crate::report::{Report, Verdict};

/// The main loop's half of a detector: it solves closed segments and gathers the evidence for an alarm.
/// [`Detector::exchange`] shows both halves; a program without interrupts calls [`Monitor::step`].
///
/// The evidence takes each report once, from the monitor alone:
///
/// ```compile_fail
/// # use bearing_watch::{Model, Monitor, Segment, plan::Plan};
/// # fn run<P: Plan>(monitor: &mut Monitor<'_, P>) {
/// let report = monitor.report().unwrap();
/// monitor.evidence().observe_outcome(report.outcome());
/// # }
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Monitor<'m, P: Plan> {
    model: &'m Model<P>,
    evidence: Evidence<P>,
    /// The evidence without the report, in case that is withdrawn.
    evidence_before: Evidence<P>,
    segment: Option<Segment<P>>,
    solve: SegmentSolver<P>,
    report: Report<P>,
    work: Work,
    /// Of the segment of the report.
    sequence: Sequence,
    /// Why no segment has a verdict.
    refused: Option<Implausible>,
    alignment: Alignment,
    /// Whether the evidence before is that of before the trial.
    on_trial: bool,
}

/// What is in the report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
enum Work {
    /// Nothing, or a report that stands.
    Settled,
    /// The segment is being solved.
    Solving,
    /// A report that the next segment may withdraw.
    Withdrawable,
}

/// What is known with the last segment.
#[derive(Clone, Copy, Debug)]
pub struct Conclusion<'a, P: Plan> {
    /// The verdict on the segment, with the results behind it. It may be withdrawn until the next segment.
    pub report: &'a Report<P>,
    /// The alarm that stands. It goes again if the report that raised it is withdrawn.
    pub alarm: Option<Alarm>,
    /// Whether no segment has had a verdict for too long.
    pub silence: Option<Silence>,
    /// What the alarm is made of.
    pub evidence: &'a Evidence<P>,
    /// Whether this is the report of the last time, which has lost its verdict because a fault was found late; the
    /// alarm is that without it.
    pub withdrawn: bool,
}

impl<'m, P: Plan> Monitor<'m, P> {
    /// Nothing concluded yet.
    #[must_use]
    pub fn new(model: &'m Model<P>) -> Self {
        let plan = model.plan();
        Self {
            model,
            evidence: Evidence::new(model),
            evidence_before: Evidence::new(model),
            segment: None,
            solve: SegmentSolver::new(plan),
            report: Report::empty(plan),
            work: Work::Settled,
            sequence: Sequence::default(),
            refused: None,
            alignment: Alignment::Unknown,
            on_trial: false,
        }
    }

    /// Takes one sample for both halves, in a program without interrupts; returns the conclusion with the sample that
    /// closes a segment. That sample costs the whole solve. The estimate takes over as auxiliary model, if there is
    /// one.
    #[inline]
    pub fn step<O: BorrowMut<Segment<P>>>(
        &mut self,
        detector: &mut Detector<'_, P, O>,
        sample: &P::Sample,
    ) -> Option<Conclusion<'_, P>> {
        if detector.take(sample) { Some(self.close(detector)) } else { None }
    }

    #[cold]
    #[inline(never)]
    fn close<O: BorrowMut<Segment<P>>>(&mut self, detector: &mut Detector<'_, P, O>) -> Conclusion<'_, P> {
        self.take(detector.segment(true));
        self.solve_rest();
        detector.offer(&self.report);
        detector.next_segment();
        self.conclusion()
    }

    /// Closes the open segment at the end of a recording, and concludes it; the detector starts afresh. A part of no
    /// more than half a segment has no verdict.
    pub fn finish<O: BorrowMut<Segment<P>>>(&mut self, detector: &mut Detector<'_, P, O>) -> Conclusion<'_, P> {
        // The model knows the spread of whole segments only.
        let short = detector.pending() <= self.model.constants().sampling.segment_samples / 2;
        self.take(detector.segment(short));
        self.solve_rest();
        detector.restart();
        self.conclusion()
    }

    /// Sets other limits for the silence than [`SilenceLimits::USUAL`].
    pub const fn limit_silence(&mut self, limits: SilenceLimits) {
        self.evidence.limit_silence(limits);
        self.evidence_before.limit_silence(limits);
    }

    /// From now on no segment has a verdict, for this reason, which the signals do not show; with `None` they have one
    /// again. [`RateCheck`](crate::RateCheck) finds such a reason. It ends a trial: what segments have added to the
    /// evidence since [`Monitor::begin_trial`] is taken out again if there is a reason.
    pub fn refuse(&mut self, error: Option<Implausible>) {
        self.refused = error;
        if core::mem::replace(&mut self.on_trial, false) && error.is_some() {
            self.evidence.clone_from(&self.evidence_before);
        }
    }

    /// Segments from now on count under reserve, until [`Monitor::refuse`] says whether their samples are good. If a
    /// report of the trial is withdrawn, those of the trial before it go with it.
    pub fn begin_trial(&mut self) {
        self.settle(false);
        self.evidence_before.clone_from(&self.evidence);
        self.on_trial = true;
    }

    /// What the front end knows of the wiring: no segment has a verdict before its currents were seen to turn with
    /// the rotor ([`Implausible::WiringUndecided`]), or where they do not ([`Implausible::Wiring`]). A front end that
    /// cannot tell, and a drive without one, is [`Alignment::Unknown`], as at first.
    pub const fn tell_alignment(&mut self, alignment: Alignment) {
        self.alignment = alignment;
    }

    /// Why no segment has a verdict whatever its signals are.
    const fn refusal(&self) -> Option<Implausible> {
        match self.alignment {
            Alignment::Undecided => Some(Implausible::WiringUndecided),
            Alignment::Misaligned => Some(Implausible::Wiring),
            Alignment::Aligned | Alignment::Unknown => self.refused,
        }
    }

    /// Takes a closed segment, which [`Monitor::advance`] solves in steps, and [`Monitor::complete`] at once; what is
    /// left of the one before is solved now. The report before is withdrawn if this segment puts it in doubt, and
    /// stands otherwise. Clears the place for the next [`Detector::exchange`].
    pub fn take_from(&mut self, place: &mut Segment<P>) {
        self.follow(place.sequence);
        self.fetch(place);
        self.start();
    }

    /// Takes a copy of the open segment.
    fn take(&mut self, segment: Segment<P>) {
        self.follow(segment.sequence);
        self.segment = Some(segment);
        self.start();
    }

    /// Settles the segment before, which this one may put in doubt.
    #[inline(always)]
    fn follow(&mut self, sequence: Sequence) {
        self.settle(sequence.withdraws_that(self.sequence));
        self.sequence = sequence;
    }

    // Out of line, so that what it moves takes no stack during the solve.
    #[inline(never)]
    fn fetch(&mut self, place: &mut Segment<P>) {
        match &mut self.segment {
            Some(segment) => core::mem::swap(segment, place),
            none => *none = Some(place.clone()),
        }
        place.clear(self.model);
    }

    // Out of line, as `fetch` is.
    #[inline(never)]
    fn start(&mut self) {
        self.solve = SegmentSolver::new(self.model.plan());
        self.report = Report::empty(self.model.plan());
        self.work = Work::Solving;
    }

    /// Does the next step of the solve; returns the conclusion with the last one, and `None` where there is nothing to
    /// solve. `cargo xtask measure` prints the instructions of the longest step. Steps give the bits of
    /// [`Monitor::complete`].
    pub fn advance(&mut self) -> Option<Conclusion<'_, P>> {
        if self.work != Work::Solving {
            return None;
        }
        let segment = self.segment.as_mut()?;
        if !self.solve.advance(self.model, segment, &mut self.report) {
            return None;
        }
        self.judge();
        Some(self.conclusion())
    }

    /// Does what [`Monitor::advance`] has left to do; returns the conclusion, and `None` where there is nothing to
    /// solve.
    pub fn complete(&mut self) -> Option<Conclusion<'_, P>> {
        self.is_solving().then(|| {
            self.solve_rest();
            self.conclusion()
        })
    }

    fn solve_rest(&mut self) {
        let (Work::Solving, Some(segment)) = (self.work, &mut self.segment) else { return };
        self.solve.run(self.model, segment, &mut self.report);
        self.judge();
    }

    /// Gives the report to the evidence.
    fn judge(&mut self) {
        self.work = Work::Withdrawable;
        if let Some(error) = self.refusal() {
            (self.report.verdict, self.report.decision) = (Verdict::Undetermined(Reason::Implausible(error)), None);
        }
        verdict::log(self.model, &self.report);
        if !self.on_trial {
            self.evidence_before.clone_from(&self.evidence);
        }
        self.evidence.observe_outcome(self.report.outcome());
    }

    /// Withdraws the report if it is in doubt: the evidence is as without it.
    fn settle(&mut self, doubtful: bool) {
        self.solve_rest();
        if self.work == Work::Withdrawable && doubtful {
            self.report.withdraw();
            self.evidence.clone_from(&self.evidence_before);
            self.evidence.observe_outcome(self.report.outcome());
        }
        self.work = Work::Settled;
    }

    /// Withdraws the report of the segment with this number, which [`Detector::discard`] has returned; returns whether
    /// there is one that may be withdrawn. The next segment does it too, but comes later.
    pub fn withdraw(&mut self, number: u32) -> bool {
        self.withdraw_if(self.sequence.is(number))
    }

    /// As [`Monitor::withdraw`], of the report before a segment that is to be taken next.
    #[cfg(all(feature = "watch", target_has_atomic = "8"))]
    pub(crate) fn withdraw_before(&mut self, next: Option<&Segment<P>>) -> bool {
        self.withdraw_if(next.is_some_and(|next| next.sequence.withdraws_that(self.sequence)))
    }

    /// Withdraws the report if it is in doubt and may be withdrawn; returns whether it was.
    fn withdraw_if(&mut self, doubtful: bool) -> bool {
        let withdrawn = doubtful && self.work == Work::Withdrawable;
        if withdrawn {
            self.settle(true);
        }
        withdrawn
    }

    /// The report that was withdrawn; `None` if there is none any more.
    #[cfg(all(feature = "watch", target_has_atomic = "8"))]
    pub(crate) fn withdrawn(&self) -> Option<Conclusion<'_, P>> {
        self.report().map(|_| Conclusion { withdrawn: true, ..self.conclusion() })
    }

    fn conclusion(&self) -> Conclusion<'_, P> {
        let (report, evidence) = (&self.report, &self.evidence);
        Conclusion { report, alarm: evidence.alarm(), silence: evidence.silence(), evidence, withdrawn: false }
    }

    /// Whether [`Monitor::advance`] has something to solve.
    #[must_use]
    pub fn is_solving(&self) -> bool {
        self.work == Work::Solving
    }

    /// The last report; `None` before the first one, and while a segment is being solved.
    #[must_use]
    pub fn report(&self) -> Option<&Report<P>> {
        (self.segment.is_some() && self.work != Work::Solving).then_some(&self.report)
    }

    /// Ends a run, as at power-down or where a session ends; the last report stands. Returns the alarm that stands.
    pub fn end_run(&mut self) -> Option<Alarm> {
        self.settle(false);
        self.evidence.end_run()
    }

    /// What the alarm is made of.
    #[must_use]
    pub const fn evidence(&self) -> &Evidence<P> {
        &self.evidence
    }

    /// Denies the alarm that stands, because the bearing was inspected and is sound ([`Evidence::deny`]).
    pub fn deny(&mut self) -> bool {
        self.settle(false);
        let denied = self.evidence.deny();
        if denied {
            // What a trial takes out does not bring the alarm back.
            self.evidence_before.clone_from(&self.evidence);
        }
        denied
    }

    /// Starts afresh, as after a repair: alarm, scores, counts and silence.
    pub fn reset(&mut self) {
        self.evidence.reset();
        self.evidence_before.clone_from(&self.evidence);
        (self.work, self.segment) = (Work::Settled, None);
    }

    /// Ends the run and writes alarm and scores; returns the number of bytes, [`Evidence::saved_len`]. In a run that
    /// goes on, [`Evidence::save`] writes what is left if the power goes off.
    ///
    /// # Errors
    /// [`StateError::BufferTooSmall`].
    pub fn save(&mut self, buffer: &mut [u8]) -> Result<usize, StateError> {
        self.end_run();
        self.evidence.save(self.model, buffer)
    }

    /// Continues from a saved state of this model. Nothing changes in case of an error.
    ///
    /// # Errors
    /// As [`Evidence::restore`].
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), StateError> {
        self.evidence.restore(self.model, bytes)?;
        self.evidence_before.clone_from(&self.evidence);
        (self.work, self.segment) = (Work::Settled, None);
        Ok(())
    }
}

#[cfg(test)]
mod tests;
