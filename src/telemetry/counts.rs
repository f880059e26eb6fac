//! What a decoder received, and the order of frames.
//!
//! A frame with a right checksum may be forged, or come from another line. Only frames that came before, byte for byte,
//! are dropped; numbers that do not continue are believed when a second frame continues them. So one frame can neither
//! make the following ones late, nor end the stream.

use super::{HELLO, Header};

/// Frames that are remembered by their checksums.
const REMEMBERED: usize = 64;
/// Missing frames that are believed at once.
const GAP: u32 = 1024;

/// What came over a line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LinkStats {
    /// Frames that were right.
    pub frames: u32,
    /// Runs of bytes between zeros that are no frame: wrong framing, checksum or content.
    pub bad: u32,
    /// Frames that exceed the decoder's buffer.
    pub oversize: u32,
    /// Right frames of another version or of an unknown kind.
    pub unknown: u32,
    /// Frames that are missing by their sequence numbers; at a restart, of those that followed it.
    pub lost: u32,
    /// Right frames that came again, and were dropped.
    pub repeated: u32,
}

/// Place in a stream: its number, and the sequence of its next frame.
type Place = (u32, u32);

/// The next frame by its numbers, and the frames that came last.
#[derive(Clone, Debug)]
pub struct Order {
    /// `None` before the first frame.
    next: Option<Place>,
    /// Where a frame led that did not continue the stream.
    other: Option<Place>,
    /// Checksums of the last frames, in a ring of which so many are used.
    seen: [u32; REMEMBERED],
    used: usize,
    place: usize,
}

impl Default for Order {
    fn default() -> Self {
        Self { next: None, other: None, seen: [0; REMEMBERED], used: 0, place: 0 }
    }
}

impl Order {
    /// Takes a right frame with the checksum of its content; returns whether it is new.
    pub fn take(&mut self, header: &Header, check: u32, counts: &mut LinkStats) -> bool {
        let Header { stream, sequence, .. } = *header;
        let restarts =
            |(known, next): Place| header.kind == HELLO && known == stream && sequence < next.wrapping_sub(1);
        if self.next.is_some_and(restarts) {
            // A drive that starts again sends what it sent before.
            (self.used, self.place) = (0, 0);
        }
        if self.seen.iter().take(self.used).any(|seen| *seen == check) {
            counts.repeated = counts.repeated.saturating_add(1);
            return false;
        }
        self.remember(check);
        counts.frames = counts.frames.saturating_add(1);
        let here = (stream, sequence.wrapping_add(1));
        let ahead = |(known, next): Place| (known == stream).then(|| sequence.wrapping_sub(next));
        let near = |place: Place| ahead(place).filter(|lost| *lost <= GAP);
        let lost = match (self.next, self.other) {
            // A listener that joins later has lost nothing.
            (None, _) => Some(0),
            (Some(next), other) => {
                let restart = || restarts(next).then_some(sequence);
                // The second frame that goes on from where another one led.
                let second = || other.and_then(|other| Some(near(other)?.saturating_add(skipped(next, other))));
                near(next).or_else(restart).or_else(second)
            }
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

    fn remember(&mut self, check: u32) {
        if let Some(cell) = self.seen.get_mut(self.place) {
            *cell = check;
        }
        self.used = self.used.saturating_add(1).min(REMEMBERED);
        self.place = if self.place >= REMEMBERED.saturating_sub(1) { 0 } else { self.place.saturating_add(1) };
    }
}

/// Frames between the place that was expected and the first frame elsewhere; numbers that go back have lost nothing.
fn skipped((stream, expected): Place, (other, next): Place) -> u32 {
    let first = next.wrapping_sub(1);
    let before = if other == stream { first.wrapping_sub(expected) } else { first };
    if before < 1 << 31 { before } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::telemetry::{REPORT, VERSION};
    use std::vec::Vec;

    /// Which frames of a kind, a stream and a number are new, and what is counted: frames, lost, repeated; equal frames
    /// have equal checksums.
    fn taken(frames: &[(u8, u32, u32, u32)]) -> (Vec<bool>, [u32; 3]) {
        let (mut order, mut counts) = (Order::default(), LinkStats::default());
        let news = frames.iter().map(|(kind, stream, sequence, check)| {
            let header = Header { version: VERSION, kind: *kind, stream: *stream, sequence: *sequence };
            order.take(&header, *check, &mut counts)
        });
        (news.collect(), [counts.frames, counts.lost, counts.repeated])
    }

    #[test]
    fn gaps_repetitions_and_restarts() {
        let late = [(REPORT, 1, 7, 0), (REPORT, 1, 8, 1), (REPORT, 1, 8, 1), (REPORT, 1, 12, 2), (REPORT, 1, 7, 0)];
        assert_eq!(taken(&late), (Vec::from([true, true, false, true, false]), [3, 3, 2]), "joined at 7");
        let restart = [(HELLO, 1, 0, 0), (REPORT, 1, 1, 1), (REPORT, 1, 2, 2), (HELLO, 1, 0, 0), (REPORT, 1, 1, 1)];
        assert_eq!(taken(&restart), (Vec::from([true; 5]), [5, 0, 0]), "it sends the same again");
        let first_lost = [(HELLO, 1, 0, 0), (REPORT, 1, 8, 1), (HELLO, 1, 1, 2)];
        assert_eq!(taken(&first_lost), (Vec::from([true; 3]), [3, 8, 0]), "seven, and the first of the restart");
        let doubled = [(HELLO, 1, 0, 0), (HELLO, 1, 0, 0), (REPORT, 1, 1, 1)];
        assert_eq!(taken(&doubled), (Vec::from([true, false, true]), [2, 0, 1]));
        let other = [(HELLO, 1, 5, 0), (HELLO, 2, 3, 1), (REPORT, 2, 4, 2), (REPORT, 2, 6, 3)];
        assert_eq!(taken(&other), (Vec::from([true; 4]), [4, 4, 0]), "three before the first, and one");
        let wrapped = [(REPORT, 1, u32::MAX - 1, 0), (REPORT, 1, u32::MAX, 1), (REPORT, 1, 1, 2)];
        assert_eq!(taken(&wrapped), (Vec::from([true; 3]), [3, 1, 0]));
        let far = [(REPORT, 1, 0, 0), (REPORT, 1, 5000, 1), (REPORT, 1, 5001, 2), (REPORT, 1, 5002, 3)];
        assert_eq!(taken(&far), (Vec::from([true; 4]), [4, 4999, 0]), "a long silence is believed at its second frame");
        let back = [(REPORT, 1, 5000, 0), (REPORT, 1, 3, 1), (REPORT, 1, 4, 2), (REPORT, 1, 6, 3)];
        assert_eq!(taken(&back), (Vec::from([true; 4]), [4, 1, 0]), "numbers that go back have lost nothing");
    }

    #[test]
    fn a_gap_is_believed_at_once_up_to_its_limit() {
        let after = |gap: u32| taken(&[(REPORT, 1, 0, 0), (REPORT, 1, 1 + gap, 1)]).1[1];
        assert_eq!((after(1024), after(1025)), (1024, 0), "as the format says");
    }

    #[test]
    fn one_forged_frame_loses_no_other() {
        for forged in [(1, 100_000), (1, u32::MAX), (1, 3), (1, 40), (1, 1 << 31), (7, 3), (7, u32::MAX)] {
            for kind in [HELLO, REPORT] {
                let mut frames: Vec<_> = (0..51).map(|k| (if k == 0 { HELLO } else { REPORT }, 1, k, k)).collect();
                frames.insert(10, (kind, forged.0, forged.1, 1000));
                let (news, [_, _, repeated]) = taken(&frames);
                assert_eq!((news, repeated), (Vec::from([true; 52]), 0), "{forged:?} {kind}");
            }
        }
    }

    #[test]
    fn so_many_frames_are_remembered() {
        // The format: one that equals one of the last 64.
        for (later, is_new) in [(63, false), (64, true)] {
            let mut frames: Vec<_> = (0..=later).map(|k| (REPORT, 1, k, k)).collect();
            frames.push((REPORT, 1, 0, 0));
            assert_eq!(taken(&frames).0.last(), Some(&is_new), "{later} frames later");
        }
    }
}
