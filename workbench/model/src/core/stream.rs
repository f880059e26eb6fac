//! Traces through the two halves of the firmware, whole or in pieces.

use bearing_watch::alarm::StateError;
use bearing_watch::drive::Alignment;
use bearing_watch::plan::RunTime;
use bearing_watch::{Detector, Evidence, Monitor, Report};

use super::embedded::Embedded;
use super::segment::SegmentReport;
use super::watch::AlarmState;
use crate::trace::Trace;

/// A segment with the evidence after it.
pub type Judged = (SegmentReport, AlarmState);

/// Detector and monitor of a drive, between two samples of a trace. The monitor goes on from trace to trace.
#[derive(Clone, Debug)]
pub struct Stream<'m> {
    model: &'m Embedded,
    detector: Detector<'m, RunTime>,
    monitor: Monitor<'m, RunTime>,
    /// Number of samples so far.
    taken: usize,
    /// Number of samples before the open segment.
    start: usize,
    /// Whether no segment has ended yet.
    first: bool,
    /// Whether there is no verdict before the wiring is known, as in the drive, and whether it was told in this run.
    waits: bool,
    told: bool,
}

impl Embedded {
    /// Runs one trace through the detector; a partial last segment counts if it is more than half a segment. Its first
    /// segments are judged, too, as if the drive had turned before.
    #[must_use]
    pub fn run(&self, trace: &Trace) -> Vec<SegmentReport> {
        Stream { waits: false, ..self.stream() }.run(trace, false).into_iter().map(|(segment, _)| segment).collect()
    }

    /// The detector and its monitor before the first sample of a drive.
    #[must_use]
    pub fn stream(&self) -> Stream<'_> {
        let (detector, monitor) = (Detector::new(self.model()), Monitor::new(self.model()));
        Stream { model: self, detector, monitor, taken: 0, start: 0, first: true, waits: true, told: false }
    }
}

impl Stream<'_> {
    /// Number of samples of the trace so far.
    #[must_use]
    pub const fn taken(&self) -> usize {
        self.taken
    }

    /// Runs a whole trace; a run, from power-up to power-up, may end with it.
    pub fn run(&mut self, trace: &Trace, run_ends: bool) -> Vec<Judged> {
        let mut segments = self.take(trace);
        segments.extend(self.end());
        if run_ends {
            let ended = self.end_run();
            if let Some((_, watched)) = segments.last_mut() {
                *watched = ended;
            }
        }
        segments
    }

    /// Denies the alarm, because the bearing was inspected and is sound; whether there was one.
    pub fn deny(&mut self) -> bool {
        self.monitor.deny()
    }

    /// Ends the run, from power-up to power-up; gives what is known then.
    pub fn end_run(&mut self) -> AlarmState {
        self.monitor.end_run();
        self.told = false;
        AlarmState::of_run(self.monitor.evidence())
    }

    /// Takes the next samples, and returns the segments that end with them. A report that was returned before is not
    /// changed by a fault that is found later; the evidence is.
    pub fn take(&mut self, piece: &Trace) -> Vec<Judged> {
        let mut feed = self.model.feed(piece);
        let (mut segments, mut wiring) = (Vec::new(), piece.wiring.iter().peekable());
        for k in 0..piece.y.len() {
            if piece.found_late.binary_search(&k).is_ok() {
                self.discard(segments.last_mut());
            }
            while let Some((_, known)) = wiring.next_if(|(row, _)| *row == k) {
                self.tell(*known);
            }
            self.taken += 1;
            if self.monitor.step(&mut self.detector, feed.at(k)).is_some() {
                segments.extend(self.judged());
                (self.start, self.first) = (self.taken, false);
            }
        }
        segments
    }

    /// The next trace of a run has a front end that begins anew, which that of the drive does not.
    fn tell(&mut self, alignment: Alignment) {
        let known = alignment != Alignment::Undecided;
        if self.waits && (known || !self.told) {
            self.told |= known;
            self.monitor.tell_alignment(alignment);
        }
    }

    /// A fault was found late: what the open segment has is discarded, and the report of the last one is withdrawn if
    /// the fault may have begun in it, as in the drive.
    fn discard(&mut self, last: Option<&mut Judged>) {
        let Some(number) = self.detector.discard() else { return };
        if !self.monitor.withdraw(number) {
            return;
        }
        if let (Some((before, watched)), Some((now, told))) = (last, self.judged()) {
            let (start, length) = (before.start, before.length);
            (*before, *watched) = (SegmentReport { start, length, ..now }, told);
        }
    }

    /// Ends the trace, and returns its last segment: the open one if it is more than half a segment, or the only one.
    /// The next sample is the first of another trace. A run may end with it.
    pub fn finish(&mut self, run_ends: bool) -> Option<Judged> {
        let last = self.end();
        if !run_ends {
            return last;
        }
        let ended = self.end_run();
        last.map(|(segment, _)| (segment, ended))
    }

    fn end(&mut self) -> Option<Judged> {
        let (pending, whole) = (self.detector.pending(), self.model.sampling().segment_samples);
        let short = pending <= whole / 2;
        let last = if short && !self.first {
            None
        } else {
            self.monitor.finish(&mut self.detector);
            self.judged()
        };
        let last = last.map(|(segment, watched)| {
            if !short {
                return (segment, watched);
            }
            let problem = format!("{pending} samples are no more than half a segment of {whole}");
            (segment.undetermined(problem), watched)
        });
        self.detector = Detector::new(self.model.model());
        (self.taken, self.start, self.first) = (0, 0, true);
        last
    }

    /// The last segment, with what is known then.
    fn judged(&self) -> Option<Judged> {
        let segment = self.model.segment(self.monitor.report()?);
        let (start, length) = (self.start, self.taken - self.start);
        Some((SegmentReport { start, length, ..segment }, self.watched()))
    }

    /// The core's report on the last segment; `None` before the first.
    #[must_use]
    pub fn report(&self) -> Option<&Report<RunTime>> {
        self.monitor.report()
    }

    /// The core's evidence.
    #[must_use]
    pub fn evidence(&self) -> &Evidence<RunTime> {
        self.monitor.evidence()
    }

    fn watched(&self) -> AlarmState {
        AlarmState::of(self.monitor.evidence())
    }

    /// The evidence, with its alarm, as bytes, as the firmware stores them.
    #[must_use]
    pub fn save(&self) -> Vec<u8> {
        let mut bytes = vec![0; Evidence::saved_len(self.model.model())];
        // The buffer has the length that the state needs.
        let _saved = self.monitor.evidence().save(self.model.model(), &mut bytes);
        bytes
    }

    /// Goes on from these bytes.
    ///
    /// # Errors
    /// They are of another model, or no state.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), StateError> {
        self.monitor.restore(bytes)
    }
}
