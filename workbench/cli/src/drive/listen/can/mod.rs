//! Segments of a drive, or the stream of its telemetry, from the log of a CAN bus.
//!
//! ```text
//! bytes ─► frames: lines, log, those of the identifier ─┬► course: lost, repeated, withdrawn ─► words
//!                                                       └► stream: pieces of the telemetry, joined
//! ```

mod course;
mod frames;
mod log;
mod segment_text;
mod stream;

use std::collections::BTreeMap;

use bearing_watch::Cause;
use bearing_watch::telemetry::SegmentFrame;

use super::names::Names;
use super::receiver::Output;
use crate::drive::can_id::CanId;
use course::{Came, Course, Segment};
use frames::Frames;
use model::Error;
pub(super) use stream::Stream;

/// Takes the bytes of a log, and shows the segments of one identifier.
pub(super) struct Listener {
    frames: Frames,
    names: Names,
    output: Output,
    course: Course,
    verdicts: BTreeMap<String, u64>,
    /// The cause that was shown, and since which segment.
    alarm: Option<(Cause, u64)>,
    silent: bool,
}

impl Listener {
    pub(super) fn new(id: CanId, names: Names, output: Output) -> Self {
        Self {
            frames: Frames::of(id),
            names,
            output,
            course: Course::default(),
            verdicts: BTreeMap::new(),
            alarm: None,
            silent: false,
        }
    }

    pub(super) fn take(&mut self, bytes: &[u8]) -> Result<(), Error> {
        let frames = self.frames.take(bytes);
        frames.into_iter().try_for_each(|(time_s, data)| self.data(time_s, &data))
    }

    fn data(&mut self, time_s: f64, data: &[u8]) -> Result<(), Error> {
        let frame = <[u8; 8]>::try_from(data).ok().and_then(SegmentFrame::from_bytes);
        let Some(frame) = frame else {
            self.frames.counts.bad += 1;
            return Ok(());
        };
        let (number, again) = match self.course.take(frame) {
            Came::Repeated => return Ok(()),
            Came::New(number) => (number, None),
            Came::Again(number, before) => (number, Some(before)),
        };
        if let Some(before) = again {
            self.verdicts.entry(segment_text::verdict(&self.names, before)).and_modify(|count| *count -= 1);
        }
        *self.verdicts.entry(segment_text::verdict(&self.names, frame)).or_default() += 1;
        let segment = Segment { time_s, number, frame, again: again.is_some() };
        self.tell(
            segment_text::segment_line(&self.names, &segment),
            segment_text::segment_value(&self.names, &segment),
        )?;
        self.notice(&segment)
    }

    /// Shows an alarm and a silence that begin.
    fn notice(&mut self, segment: &Segment) -> Result<(), Error> {
        let Segment { number, frame, .. } = segment;
        let cause = frame.alarm();
        if cause != self.alarm.map(|(cause, _)| cause) {
            self.alarm = cause.map(|cause| (cause, *number));
            if let Some(cause) = cause {
                (self.output.alarm)(&segment_text::alarm_line(&self.names, segment, cause))?;
            }
        }
        if frame.is_silent() && !self.silent {
            (self.output.alarm)(&format!("SILENCE at segment {number}: no verdict for too long"))?;
        }
        self.silent = frame.is_silent();
        Ok(())
    }

    pub(super) const fn has_segments(&self) -> bool {
        self.course.counts().segments > 0
    }

    /// Shows what came.
    pub(super) fn end(mut self, source: &str) -> Result<(), Error> {
        if let Some((time_s, data)) = self.frames.end() {
            self.data(time_s, &data)?;
        }
        let course = self.course.counts();
        if course.segments == 0 {
            return Err(Error::Usage(format!(
                "{source}: {}",
                segment_text::nothing(self.frames.id, &self.frames.counts, "a segment")
            )));
        }
        let alarm = self.alarm.map(|(cause, since)| (segment_text::alarm_name(&self.names, cause), since));
        let end = segment_text::End {
            id: self.frames.id,
            course,
            counts: &self.frames.counts,
            verdicts: &self.verdicts,
            alarm,
        };
        self.tell(end.line(), end.value())
    }

    fn tell(&self, line: String, value: serde_json::Value) -> Result<(), Error> {
        (self.output.tell)(line, value)
    }
}
