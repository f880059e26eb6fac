//! Segments of a drive from the log of a CAN bus.
//!
//! ```text
//! bytes ─► lines ─► log: frames of the identifier ─► course: lost, repeated, withdrawn ─► words
//! ```

mod course;
mod log;
mod words;

use std::collections::BTreeMap;

use bearing_watch::Cause;
use bearing_watch::telemetry::SegmentFrame;

use super::names::Names;
use super::receiver::Output;
use crate::can_id::CanId;
use course::{Came, Course, Segment};
use log::{Counts, Event, Log};
use model::Error;

/// The longest line that is read; logs of CAN FD have up to some hundred letters.
const LONGEST: usize = 4096;

/// Takes the bytes of a log, and shows the segments of one identifier.
pub(super) struct Listener {
    id: CanId,
    names: Names,
    output: Output,
    log: Log,
    line: Vec<u8>,
    /// The bus of the first frame of the identifier.
    bus: Option<String>,
    course: Course,
    counts: Counts,
    verdicts: BTreeMap<String, u64>,
    /// The cause that was shown, and since which segment.
    alarm: Option<(Cause, u64)>,
    silent: bool,
}

impl Listener {
    pub(super) fn new(id: CanId, names: Names, output: Output) -> Self {
        Self {
            id,
            names,
            output,
            log: Log::default(),
            line: vec![],
            bus: None,
            course: Course::default(),
            counts: Counts::default(),
            verdicts: BTreeMap::new(),
            alarm: None,
            silent: false,
        }
    }

    pub(super) fn take(&mut self, bytes: &[u8]) -> Result<(), Error> {
        for byte in bytes {
            match byte {
                b'\n' => self.end_line()?,
                // What is longer is cut, and then not read as an event.
                _ if self.line.len() < LONGEST => self.line.push(*byte),
                _ => {}
            }
        }
        Ok(())
    }

    fn end_line(&mut self) -> Result<(), Error> {
        let line = std::mem::take(&mut self.line);
        let event = self.log.read(&String::from_utf8_lossy(&line));
        let count = match event {
            Event::Nothing => return Ok(()),
            Event::Data { id, .. } if id != self.id => &mut self.counts.others,
            Event::Data { bus, time_s, data, .. } => {
                if *self.bus.get_or_insert_with(|| bus.clone()) == bus {
                    return self.data(time_s, &data);
                }
                &mut self.counts.other_buses
            }
            Event::Remote => &mut self.counts.remote,
            Event::Error => &mut self.counts.errors,
            Event::Unread => &mut self.counts.unread,
        };
        *count += 1;
        Ok(())
    }

    fn data(&mut self, time_s: f64, data: &[u8]) -> Result<(), Error> {
        let frame = <[u8; 8]>::try_from(data).ok().and_then(SegmentFrame::from_bytes);
        let Some(frame) = frame else {
            self.counts.bad += 1;
            return Ok(());
        };
        let (number, again) = match self.course.take(frame) {
            Came::Repeated => return Ok(()),
            Came::New(number) => (number, None),
            Came::Again(number, before) => (number, Some(before)),
        };
        if let Some(before) = again {
            self.verdicts.entry(words::verdict(&self.names, before)).and_modify(|count| *count -= 1);
        }
        *self.verdicts.entry(words::verdict(&self.names, frame)).or_default() += 1;
        let segment = Segment { time_s, number, frame, again: again.is_some() };
        self.tell(words::segment_line(&self.names, &segment), words::segment_value(&self.names, &segment))?;
        self.notice(&segment)
    }

    /// Shows an alarm and a silence that begin.
    fn notice(&mut self, segment: &Segment) -> Result<(), Error> {
        let Segment { number, frame, .. } = segment;
        let cause = frame.alarm();
        if cause != self.alarm.map(|(cause, _)| cause) {
            self.alarm = cause.map(|cause| (cause, *number));
            if let Some(cause) = cause {
                (self.output.alarm)(&words::alarm_line(&self.names, segment, cause))?;
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
        if !self.line.is_empty() {
            self.end_line()?;
        }
        let course = self.course.counts();
        if course.segments == 0 {
            return Err(Error::Usage(format!("{source}: {}", words::nothing(self.id, &self.counts))));
        }
        let alarm = self.alarm.map(|(cause, since)| (words::alarm_name(&self.names, cause), since));
        let end = words::End { id: self.id, course, counts: &self.counts, verdicts: &self.verdicts, alarm };
        self.tell(end.line(), end.value())
    }

    fn tell(&self, line: String, value: serde_json::Value) -> Result<(), Error> {
        (self.output.tell)(line, value)
    }
}
