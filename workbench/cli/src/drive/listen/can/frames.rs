//! The data frames of one identifier in the bytes of a log, and what else the log has.

use crate::drive::can_id::CanId;

use super::log::{Counts, Event, Log};

/// The longest line that is read; logs of CAN FD have up to some hundred letters.
const LONGEST: usize = 4096;

/// Reads a log.
pub(super) struct Frames {
    pub(super) id: CanId,
    pub(super) counts: Counts,
    log: Log,
    line: Vec<u8>,
    /// The bus of the first frame of the identifier.
    bus: Option<String>,
}

/// The data of a frame, and its time.
pub(super) type Data = (f64, Vec<u8>);

impl Frames {
    pub(super) fn of(id: CanId) -> Self {
        Self { id, counts: Counts::default(), log: Log::default(), line: vec![], bus: None }
    }

    /// The frames that these bytes complete.
    pub(super) fn take(&mut self, bytes: &[u8]) -> Vec<Data> {
        let mut frames = vec![];
        for byte in bytes {
            match byte {
                b'\n' => frames.extend(self.end_line()),
                // What is longer is cut, and then not read as an event.
                _ if self.line.len() < LONGEST => self.line.push(*byte),
                _ => {}
            }
        }
        frames
    }

    /// The frame of the last line, if that has no end.
    pub(super) fn end(&mut self) -> Option<Data> {
        if self.line.is_empty() { None } else { self.end_line() }
    }

    fn end_line(&mut self) -> Option<Data> {
        let line = std::mem::take(&mut self.line);
        let count = match self.log.read(&String::from_utf8_lossy(&line)) {
            Event::Nothing => return None,
            Event::Data { id, .. } if id != self.id => &mut self.counts.others,
            Event::Data { bus, time_s, data, .. } => {
                if *self.bus.get_or_insert_with(|| bus.clone()) == bus {
                    return Some((time_s, data));
                }
                &mut self.counts.other_buses
            }
            Event::Remote => &mut self.counts.remote,
            Event::Error => &mut self.counts.errors,
            Event::Unread => &mut self.counts.unread,
        };
        *count += 1;
        None
    }
}
