//! The frames of the telemetry in the data frames of one identifier.

use bearing_watch::telemetry::CanJoin;
use serde_json::{Value, json};

use super::frames::{Data, Frames};
use super::segment_text;
use crate::drive::can_id::CanId;

/// Joins data frames to the bytes that a serial line would have.
pub(in crate::drive::listen) struct Stream {
    frames: Frames,
    join: CanJoin,
    /// Data frames that are pieces.
    pieces: u64,
}

impl Stream {
    pub(in crate::drive::listen) fn of(id: CanId) -> Self {
        Self { frames: Frames::of(id), join: CanJoin::new(), pieces: 0 }
    }

    /// The bytes of the stream that these bytes of a log complete.
    pub(in crate::drive::listen) fn take(&mut self, bytes: &[u8]) -> Vec<u8> {
        let frames = self.frames.take(bytes);
        self.joined(frames)
    }

    /// Those of the last line, if that has no end.
    pub(in crate::drive::listen) fn rest(&mut self) -> Vec<u8> {
        let last = self.frames.end();
        self.joined(last)
    }

    fn joined(&mut self, frames: impl IntoIterator<Item = Data>) -> Vec<u8> {
        let mut stream = vec![];
        for (_, data) in frames {
            let repeated = self.join.repeated();
            match self.join.take(&data) {
                Some((gap, piece)) => {
                    // A zero ends the frame that is cut.
                    stream.extend(gap.then_some(0));
                    stream.extend_from_slice(piece);
                    self.pieces += 1;
                }
                None if self.join.repeated() > repeated => {}
                None => self.frames.counts.bad += 1,
            }
        }
        stream
    }

    /// Why there was no piece.
    pub(in crate::drive::listen) fn nothing(&self) -> Option<String> {
        (self.pieces == 0).then(|| segment_text::nothing(self.frames.id, &self.frames.counts, "a piece of a stream"))
    }

    pub(in crate::drive::listen) fn line(&self) -> String {
        let Self { frames, join, pieces } = self;
        let counts = &frames.counts;
        let mut line =
            format!("{pieces} data frames of {}: {} lost, {} repeated", frames.id, join.lost(), join.repeated());
        segment_text::further(&mut line, counts, "data frames that are no pieces");
        line
    }

    pub(in crate::drive::listen) fn value(&self) -> Value {
        let Self { frames, join, pieces } = self;
        let mut value = json!({
            "kind": "can",
            "id": frames.id.to_string(),
            "frames": pieces,
            "lost": join.lost(),
            "repeated": join.repeated(),
        });
        segment_text::counted(&mut value, &frames.counts);
        value
    }
}
