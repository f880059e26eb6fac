//! Traces through the detector, whole or in pieces.

use bearing_watch::alarm::Baseline;
use bearing_watch::plan::RunTime;
use bearing_watch::{Detector, Report};

use super::embedded::Embedded;
use super::segment::SegmentReport;
use crate::trace::Trace;

/// A detector between two samples of a trace.
#[derive(Clone, Debug)]
pub struct Stream<'m> {
    model: &'m Embedded,
    detector: Detector<'m, RunTime>,
    /// Number of samples so far.
    taken: usize,
    /// Number of samples before the open segment.
    start: usize,
    /// Whether no segment has ended yet.
    first: bool,
}

impl Embedded {
    /// Runs one trace through the detector; a partial last segment counts if it is more than half a segment.
    #[must_use]
    pub fn run(&self, trace: &Trace) -> Vec<SegmentReport> {
        self.run_following(trace, None)
    }

    /// As [`Embedded::run`], with a baseline that follows slow changes from trace to trace.
    #[must_use]
    pub fn run_following(&self, trace: &Trace, mut baseline: Option<&mut Baseline<RunTime>>) -> Vec<SegmentReport> {
        let mut stream = self.stream();
        let mut segments = stream.take(trace, baseline.as_deref_mut());
        segments.extend(stream.finish(baseline));
        segments
    }

    /// The detector before the first sample of a trace that comes in pieces.
    #[must_use]
    pub fn stream(&self) -> Stream<'_> {
        Stream::new(self, Detector::new(self.model()))
    }
}

impl<'m> Stream<'m> {
    const fn new(model: &'m Embedded, detector: Detector<'m, RunTime>) -> Self {
        Self { model, detector, taken: 0, start: 0, first: true }
    }

    /// Number of samples so far.
    #[must_use]
    pub const fn taken(&self) -> usize {
        self.taken
    }

    /// Takes the next samples, and returns the segments that end with them. A baseline follows slow changes.
    pub fn take(&mut self, piece: &Trace, mut baseline: Option<&mut Baseline<RunTime>>) -> Vec<SegmentReport> {
        let mut feed = self.model.feed(piece);
        let mut segments = Vec::new();
        for k in 0..piece.y.len() {
            self.taken += 1;
            if let Some(report) = self.detector.step(feed.at(k)) {
                segments.push(self.judged(report, baseline.as_deref_mut()));
                (self.start, self.first) = (self.taken, false);
            }
        }
        segments
    }

    /// Ends the trace, and returns its last segment: the open one if it is more than half a segment, or the only one.
    /// The next sample is the first of another trace.
    pub fn finish(&mut self, baseline: Option<&mut Baseline<RunTime>>) -> Option<SegmentReport> {
        // The model contains the spread of complete segments, so a segment of less than half the length has no verdict.
        let (pending, whole) = (self.detector.pending(), self.model.sampling().segment_samples);
        let report = self.detector.finish();
        let last = if pending > whole / 2 {
            Some(self.judged(report, baseline))
        } else {
            self.first.then(|| {
                let problem = format!("{pending} samples are no more than half a segment of {whole}");
                self.placed(self.model.segment(&report)).undetermined(problem)
            })
        };
        *self = self.model.stream();
        last
    }

    fn judged(&self, mut report: Report<RunTime>, baseline: Option<&mut Baseline<RunTime>>) -> SegmentReport {
        let followed = baseline.map(|own| {
            self.model.model().follow(own, &mut report);
            (own.offset().to_vec(), own.at_bound())
        });
        SegmentReport { followed, ..self.placed(self.model.segment(&report)) }
    }

    fn placed(&self, segment: SegmentReport) -> SegmentReport {
        SegmentReport { start: self.start, length: self.taken - self.start, ..segment }
    }
}
