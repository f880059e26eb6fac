//! The detector: samples in, one [`Report`] a segment out.
//!
//! ```text
//! sample ─► gate ─┬─ block mean ─► Estimator ─┬─ segment full ─► solve ─► classification ─► Report
//!                 ├─ Shaft: friction, orders ─┤
//!                 └─ averages of channels ──────┘
//! ```
//!
//! [`Detector::exchange`] costs about the same for every sample. It hands out the sums of a closed segment; [`Monitor`]
//! makes the report in the main loop, and [`Detector::adopt`] returns it. Programs without interrupts call
//! [`Detector::step`], which does all of it.

mod evidence;
mod monitor;
mod saved;
mod segment;
mod sequence;
mod solver;
mod verdict;

pub use monitor::{Conclusion, Monitor};
pub use segment::Segment;

use core::borrow::BorrowMut;

use sequence::Sequence;

use crate::known_answers::arithmetic_test;
use crate::model::Model;
use crate::plan::{Array, Cells, Plan, Presence};
use crate::regression::Inputs;
use crate::regression::estimate::Estimator;
use crate::report::Report;
use crate::shaft::{Shaft, ShaftSums};
use crate::signal::BlockMean;
use crate::signal::average;
use crate::signal::{Counts, Gate, limit};

/// Running state next to the current loop. The model stays where it is (flash) and may live shorter than the program,
/// so that another one can replace it without a restart.
///
/// ```
/// # use bearing_watch::{Detector, Model, Verdict, plan::Plan};
/// # fn run<P: Plan>(model: &Model<P>, sample: P::Sample) {
/// let mut detector = Detector::new(model);
/// // at each sample
/// if let Some(report) = detector.step(&sample) {
///     match report.verdict {
///         Verdict::Class(class) => { let _name = model.label(class); }
///         Verdict::Novel | Verdict::Ambiguous => {}
///         Verdict::Undetermined(_reason) => {}
///     }
/// }
/// # }
/// ```
///
/// The sums of the open segment are in the detector, or in a place outside that is exchanged when the segment closes:
/// [`Detector::with_place`].
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Detector<'m, P: Plan, O = Segment<P>> {
    model: &'m Model<P>,
    gate: Gate<P>,
    block: BlockMean<3>,
    /// Whether a sample of the open block was refused.
    spoiled: bool,
    estimator: Array<P::Regressed, Estimator<P>>,
    shaft: Array<P::Watched, Shaft<P>>,
    /// Samples of the open segment, after averaging.
    samples: u32,
    /// Of the open segment.
    sequence: Sequence,
    /// The open segment.
    open: O,
}

/// What a sample did to the open segment.
#[derive(Debug)]
pub enum Exchange<'s, P: Plan> {
    /// It goes on.
    Open,
    /// It is closed, and in this place.
    Closed(&'s mut Segment<P>),
    /// It was closed, and is lost: there was no spare place for the next one.
    Lost,
}

impl<'m, P: Plan> Detector<'m, P> {
    /// Nothing sampled yet.
    #[must_use]
    pub fn new(model: &'m Model<P>) -> Self {
        Self::around(model, Segment::new(model))
    }
}

impl<'m, 's, P: Plan> Detector<'m, P, &'s mut Segment<P>> {
    /// Nothing sampled yet; the sums are in this place.
    #[must_use]
    pub fn with_place(model: &'m Model<P>, place: &'s mut Segment<P>) -> Self {
        place.clear(model);
        Self::around(model, place)
    }

    /// Takes one sample, in time that hardly depends on the data. The sample that closes a segment takes the place out
    /// of `spare` for the next one, and returns that of the closed one: the sums are neither copied nor cleared. Give
    /// the place to [`Monitor::take_from`] in the main loop, and its report to [`Detector::adopt`]. The monitor clears
    /// the place for the next exchange; one that is not clear is cleared here.
    ///
    /// Two places and two queues of references, there and back, connect interrupt and main loop:
    ///
    /// ```
    /// # use bearing_watch::{Detector, Exchange, Model, Monitor, Segment, plan::Plan};
    /// # fn run<P: Plan>(model: &Model<P>, samples: impl Iterator<Item = P::Sample>) {
    /// let (mut first, mut second) = (Segment::new(model), Segment::new(model));
    /// let (mut detector, mut spare) = (Detector::with_place(model, &mut first), Some(&mut second));
    /// let mut monitor = Monitor::new(model);
    /// for sample in samples {
    ///     if let Exchange::Closed(place) = detector.exchange(&sample, &mut spare) {
    ///         monitor.take_from(place);
    ///         spare = Some(place);
    ///     }
    ///     if let Some(now) = monitor.advance() {
    ///         detector.adopt(now.report);
    ///     }
    /// }
    /// # }
    /// ```
    #[inline]
    pub fn exchange(&mut self, sample: &P::Sample, spare: &mut Option<&'s mut Segment<P>>) -> Exchange<'s, P> {
        if self.take(sample) { self.replace(spare) } else { Exchange::Open }
    }

    /// Closes the segment and opens the next one in the spare place.
    #[inline(never)]
    fn replace(&mut self, spare: &mut Option<&'s mut Segment<P>>) -> Exchange<'s, P> {
        let Some(place) = spare.take() else {
            self.next_segment();
            return Exchange::Lost;
        };
        if !place.clear || place.model != self.model.id() {
            place.clear(self.model);
        }
        let closed = core::mem::replace(&mut self.open, place);
        self.complete(closed, true);
        if let (Some(sums), Some(last)) = (self.open.regression.part_mut(), closed.regression.part()) {
            sums.follow(self.model.plan(), last);
        }
        self.start_segment();
        Exchange::Closed(closed)
    }
}

impl<'m, P: Plan, O: BorrowMut<Segment<P>>> Detector<'m, P, O> {
    #[inline(always)]
    fn around(model: &'m Model<P>, open: O) -> Self {
        let (plan, constants) = (model.plan(), model.constants());
        Self {
            model,
            gate: Gate::new(plan),
            block: BlockMean::new(),
            spoiled: false,
            estimator: P::Regressed::map_part(&constants.regression, |regression| Estimator::new(plan, regression)),
            shaft: P::Watched::map_part(&constants.shaft, |shaft| Shaft::new(plan, shaft)),
            samples: 0,
            sequence: Sequence::default(),
            open,
        }
    }

    /// Takes one sample; returns the report with the sample that closes a segment. That sample costs the whole solve
    /// and classification, often more than a control interval has time for: in an interrupt use [`Detector::exchange`].
    #[inline]
    pub fn step(&mut self, sample: &P::Sample) -> Option<Report<P>> {
        if self.take(sample) { self.close() } else { None }
    }

    /// Closes the segment and concludes it.
    #[cold]
    #[inline(never)]
    fn close(&mut self) -> Option<Report<P>> {
        let mut report = Some(Report::empty(self.model.plan()));
        if let Some(report) = &mut report {
            self.segment(true).solve(self.model, report);
            self.offer(report);
        }
        self.next_segment();
        report
    }

    /// Lets the estimate of a concluded segment take over as auxiliary model at the handover. Returns `false`, and does
    /// nothing, if the handover is past, if it is not the segment that was closed last, also by
    /// [`Detector::restart`] or [`Detector::discard`] since then, or if the estimate cannot be used.
    pub fn adopt(&mut self, report: &Report<P>) -> bool {
        let (Some(estimator), Some(estimate)) = (self.estimator.part_mut(), report.estimate.part()) else {
            return false;
        };
        report.model == self.model.id() && estimator.adopt(self.model.plan(), estimate)
    }

    /// Takes one sample; returns whether the segment is full.
    #[inline(always)]
    fn take(&mut self, sample: &P::Sample) -> bool {
        let (plan, constants) = (self.model.plan(), self.model.constants());
        let layout = plan.layout();
        let open = self.open.borrow_mut();
        let refused = self.gate.refused(&constants.channels, sample);
        average::take(plan, &mut open.averages, sample, refused);
        let parts = (self.shaft.part_mut(), open.shaft.part_mut());
        let given = (constants.shaft.part(), layout.shaft);
        if let ((Some(shaft), Some(sums)), (Some(shaft_constants), Some(layout))) = (parts, given) {
            let good = refused & layout.mask() == 0;
            shaft.step(sums, plan, shaft_constants, (sample, good));
            open.usable = open.usable.wrapping_add(u32::from(good));
        }
        let parts = (self.estimator.part_mut(), open.regression.part_mut());
        let given = (constants.regression.part(), layout.regression);
        if let ((Some(estimator), Some(sums)), (Some(regression), Some(layout))) = (parts, given) {
            let good = refused & layout.mask() == 0;
            let inputs = Inputs::of(&layout, sample);
            let block = constants.sampling.block_mean;
            let (inputs, good) = if block <= 1 {
                (inputs, good)
            } else {
                // A mean would hide one refused sample, so that sample spoils its block.
                self.spoiled |= !good;
                let Some([y, u1, u2]) = self.block.push([inputs.y, inputs.u1, inputs.u2], block) else { return false };
                (Inputs { y, u1, u2 }, !core::mem::take(&mut self.spoiled))
            };
            if good {
                estimator.take(sums, plan, regression, (inputs, limit(&constants.channels, layout.y)));
            } else {
                estimator.skip(plan);
            }
        }
        self.samples = self.samples.wrapping_add(1);
        self.samples >= constants.sampling.segment_samples
    }

    /// A copy of the open segment as if it were closed.
    // Out of line, so that what it moves takes no stack during the solve.
    #[inline(never)]
    fn segment(&self, whole: bool) -> Segment<P> {
        let mut segment = self.open.borrow().clone();
        self.complete(&mut segment, whole);
        segment
    }

    /// Completes the sums for the main loop.
    fn complete(&self, segment: &mut Segment<P>, whole: bool) {
        let (plan, constants) = (self.model.plan(), self.model.constants());
        (segment.counts, segment.rows) = (self.counted(segment), segment.usable);
        if let (Some(estimator), Some(sums)) = (self.estimator.part(), segment.regression.part_mut()) {
            let rest = constants.regression.part().map_or(0.0, |regression| regression.rest);
            estimator.close(sums, plan, rest);
            segment.rows = sums.count;
        }
        (segment.whole, segment.clear, segment.failed) = (whole, false, arithmetic_test().err());
        (segment.model, segment.sequence) = (self.model.id(), self.sequence);
    }

    fn counted(&self, segment: &Segment<P>) -> Counts {
        let mut counts = self.gate.counts;
        if let (Some(estimator), Some(sums)) = (self.estimator.part(), segment.regression.part()) {
            (counts.resting, counts.refused) = estimator.counts(sums);
        }
        let steps = segment.shaft.part().map_or(0, ShaftSums::steps);
        counts.rejected = counts.rejected.saturating_add(steps);
        counts
    }

    /// Offers the estimate of the open segment as auxiliary model of the next one, before it is closed.
    fn offer(&mut self, report: &Report<P>) {
        let (Some(estimator), Some(estimate)) = (self.estimator.part_mut(), report.estimate.part()) else { return };
        if report.model == self.model.id() {
            estimator.offer(self.model.plan(), estimate);
        }
    }

    /// Starts a segment in the place of the last one.
    #[inline(always)]
    fn next_segment(&mut self) {
        self.open.borrow_mut().next(self.model);
        self.start_segment();
    }

    /// Starts a segment in a place that is clear.
    #[inline(always)]
    fn start_segment(&mut self) {
        let (plan, constants) = (self.model.plan(), self.model.constants());
        self.samples = 0;
        self.sequence = self.sequence.next();
        self.gate.next_segment();
        if let (Some(estimator), Some(regression)) = (self.estimator.part_mut(), constants.regression.part()) {
            estimator.next_segment(plan, regression);
        }
        if let Some(shaft) = self.shaft.part_mut() {
            shaft.next_segment();
        }
    }

    /// The report that the open segment would give now; the segment stays open. With fading memory this is the present
    /// state.
    #[must_use]
    pub fn preview(&self) -> Report<P> {
        self.segment(false).report(self.model)
    }

    /// Number of samples in the open segment, after averaging.
    #[must_use]
    pub const fn pending(&self) -> u32 {
        self.samples
    }

    /// What was refused in the open segment so far.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.counted(self.open.borrow())
    }

    /// Closes the open segment at the end of a recording, reports it, and starts afresh. The caller decides whether a
    /// part of a segment is enough: see [`Detector::pending`].
    pub fn finish(&mut self) -> Report<P> {
        let report = self.segment(false).report(self.model);
        self.restart();
        report
    }

    /// Discards what the open segment has taken, which was found to be wrong after it was taken:
    /// [`CleanSample::found_late`](crate::drive::CleanSample::found_late). The segment closes where it would have, and
    /// has a verdict if half of it follows this call and is usable. Fading memory begins anew.
    ///
    /// In the first half of the segment, the fault may have begun in the segment before: [`Monitor`] then
    /// takes the report of that one out of its evidence again, with the segment or by [`Monitor::withdraw`] before it.
    /// Returns the number of the segment that is in doubt.
    #[cold]
    #[inline(never)]
    pub fn discard(&mut self) -> Option<u32> {
        // The open block of a mean keeps its place among the samples, and is spoilt.
        self.spoiled = !self.block.is_empty();
        self.renew();
        self.is_in_first_half().then(|| self.sequence.withdraw())
    }

    /// Whether less than half of the open segment has passed: what is found late may then have begun in the one before.
    #[must_use]
    pub const fn is_in_first_half(&self) -> bool {
        self.samples < self.model.constants().sampling.segment_samples / 2
    }

    /// Starts afresh without a report, for a stream that does not continue from the last sample: lags, sums and
    /// auxiliary model.
    pub fn restart(&mut self) {
        (self.gate, self.block) = (Gate::new(self.model.plan()), BlockMean::new());
        (self.spoiled, self.samples) = (false, 0);
        self.sequence.keep();
        self.renew();
    }

    /// Nothing in the sums yet; an estimate from before is none of the next segment.
    #[cold]
    #[inline(never)]
    fn renew(&mut self) {
        let (plan, constants) = (self.model.plan(), self.model.constants());
        // Part by part and in place: a new detector would be moved twice.
        if let (Some(estimator), Some(regression)) = (self.estimator.part_mut(), constants.regression.part()) {
            estimator.restart(plan, regression);
        }
        if let (Some(shaft), Some(shaft_constants)) = (self.shaft.part_mut(), constants.shaft.part()) {
            shaft.renew(shaft_constants);
        }
        self.open.borrow_mut().empty(self.model);
    }
}

#[cfg(test)]
pub(crate) mod tests;
