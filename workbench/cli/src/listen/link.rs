//! Bytes → new frames, whatever single frames claim.
//!
//! A frame with a right checksum may be forged, or come from another line. Only frames that came before, byte for byte,
//! are dropped; numbers that do not continue are believed when a second frame continues them. So one frame can neither
//! make the following ones late, nor end the stream.

use std::collections::VecDeque;
use std::hash::{DefaultHasher, Hasher as _};

use bearing_watch::telemetry::{Body, Decoder, Frame, LinkCounts};

/// Longest content of a frame.
const LONGEST: usize = 16_384;
/// Frames whose bytes are remembered.
const REMEMBERED: usize = 256;
/// Missing frames that are believed at once.
const GAP: u32 = 1024;

/// The frames of a line.
pub(super) struct Link {
    /// Without memory of its frames: it is a new one after each.
    decoder: Box<Decoder<LONGEST>>,
    /// Whether the last byte completed a frame.
    is_complete: bool,
    bytes: DefaultHasher,
    order: Order,
    counts: LinkCounts,
}

impl Link {
    pub(super) fn new() -> Self {
        Self {
            decoder: Box::default(),
            is_complete: false,
            bytes: DefaultHasher::new(),
            order: Order::default(),
            counts: LinkCounts::default(),
        }
    }

    /// What came so far.
    pub(super) fn counts(&self) -> LinkCounts {
        // The frame of the decoder is counted by its order.
        let LinkCounts { bad, oversize, unknown, .. } = self.decoder.counts();
        let mut counts = self.counts;
        counts.bad = counts.bad.saturating_add(bad);
        counts.oversize = counts.oversize.saturating_add(oversize);
        counts.unknown = counts.unknown.saturating_add(unknown);
        counts
    }

    /// Takes a byte; returns the new frame that it completes.
    pub(super) fn push(&mut self, byte: u8) -> Option<Frame<'_>> {
        if self.is_complete {
            self.counts = self.counts();
            *self.decoder = Decoder::new();
            self.is_complete = false;
        }
        self.bytes.write_u8(byte);
        let bytes = if byte == 0 { std::mem::take(&mut self.bytes).finish() } else { 0 };
        let frame = self.decoder.push(byte)?;
        self.is_complete = true;
        let Frame { stream, sequence, body } = frame;
        let head = Head { is_hello: matches!(body, Body::Hello(_)), stream, sequence };
        self.order.take(&head, bytes, &mut self.counts).then_some(frame)
    }
}

/// Place in a stream: its number, and that of its next frame.
type Place = (u32, u32);

/// What places a frame.
struct Head {
    is_hello: bool,
    stream: u32,
    sequence: u32,
}

#[derive(Default)]
struct Order {
    next: Option<Place>,
    /// Where a frame led that did not continue the stream.
    other: Option<Place>,
    /// Hashes of the bytes of the last frames.
    seen: VecDeque<u64>,
}

impl Order {
    /// Takes a right frame; returns whether it is new.
    fn take(&mut self, frame: &Head, bytes: u64, counts: &mut LinkCounts) -> bool {
        let Head { is_hello, stream, sequence } = frame;
        let restarts = |(own, next): Place| *is_hello && own == *stream && *sequence < next.wrapping_sub(1);
        if self.next.is_some_and(restarts) {
            // A drive that starts again sends what it sent before.
            self.seen.clear();
        }
        if self.seen.contains(&bytes) {
            counts.repeated = counts.repeated.saturating_add(1);
            return false;
        }
        if self.seen.len() == REMEMBERED {
            self.seen.pop_front();
        }
        self.seen.push_back(bytes);
        counts.frames = counts.frames.saturating_add(1);
        let here = (*stream, sequence.wrapping_add(1));
        let ahead = |(own, next): Place| (own == *stream).then(|| sequence.wrapping_sub(next));
        let lost = match (self.next, self.other) {
            // A listener that joins later has lost nothing.
            (None, _) => Some(0),
            (Some(next), _) if ahead(next).is_some_and(|lost| lost <= GAP) => ahead(next),
            (Some(next), _) if restarts(next) => Some(*sequence),
            // The second frame that goes on from there.
            (Some(next), Some(other)) if ahead(other).is_some_and(|lost| lost <= GAP) => {
                let first = other.1.wrapping_sub(1);
                let before = if other.0 == next.0 { first.wrapping_sub(next.1) } else { first };
                // Numbers that go back have lost nothing.
                ahead(other).map(|lost| lost.saturating_add(if before < 1 << 31 { before } else { 0 }))
            }
            _ => None,
        };
        match lost {
            Some(lost) => {
                counts.lost = counts.lost.saturating_add(lost);
                (self.next, self.other) = (Some(here), None);
            }
            None => self.other = Some(here),
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Which frames of a kind, a stream and a number are new, and what is counted; `bytes` are equal for equal frames.
    fn taken(frames: &[(bool, u32, u32, u64)]) -> (Vec<bool>, [u32; 3]) {
        let (mut order, mut counts) = (Order::default(), LinkCounts::default());
        let news = frames.iter().map(|(hello, stream, sequence, bytes)| {
            order.take(&Head { is_hello: *hello, stream: *stream, sequence: *sequence }, *bytes, &mut counts)
        });
        (news.collect(), [counts.frames, counts.lost, counts.repeated])
    }

    #[test]
    fn gaps_and_repetitions_and_restarts() {
        let (news, counts) = taken(&[(true, 1, 7, 0), (false, 1, 8, 1), (false, 1, 8, 1), (false, 1, 12, 2)]);
        assert_eq!((news, counts), (vec![true, true, false, true], [3, 3, 1]));
        let restart = [(true, 1, 0, 0), (false, 1, 1, 1), (false, 1, 2, 2), (true, 1, 0, 0), (false, 1, 1, 1)];
        assert_eq!(taken(&restart), (vec![true; 5], [5, 0, 0]), "it sends the same again");
        let doubled = [(true, 1, 0, 0), (true, 1, 0, 0), (false, 1, 1, 1)];
        assert_eq!(taken(&doubled), (vec![true, false, true], [2, 0, 1]));
        let other = [(true, 1, 5, 0), (true, 2, 3, 1), (false, 2, 4, 2), (false, 2, 6, 3)];
        assert_eq!(taken(&other), (vec![true; 4], [4, 4, 0]), "three before the first, and one");
        let wrapped = [(false, 1, u32::MAX - 1, 0), (false, 1, u32::MAX, 1), (false, 1, 1, 2)];
        assert_eq!(taken(&wrapped), (vec![true; 3], [3, 1, 0]));
        let far = [(false, 1, 0, 0), (false, 1, 5000, 1), (false, 1, 5001, 2), (false, 1, 5002, 3)];
        assert_eq!(taken(&far), (vec![true; 4], [4, 4999, 0]), "a long silence is believed at its second frame");
    }

    #[test]
    fn one_forged_frame_loses_no_other() {
        for forged in [(1, 100_000), (1, u32::MAX), (1, 3), (1, 40), (1, 1 << 31), (7, 3), (7, u32::MAX)] {
            for hello in [false, true] {
                let mut frames: Vec<_> = (0..51).map(|k| (k == 0, 1, k, u64::from(k))).collect();
                frames.insert(10, (hello, forged.0, forged.1, 1000));
                let (news, [_, _, repeated]) = taken(&frames);
                assert_eq!((news, repeated), (vec![true; 52], 0), "{forged:?} {hello}");
            }
        }
    }
}
