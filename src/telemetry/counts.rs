//! What a decoder received, and the order of frames.

use super::{HELLO, Header};

/// What came over a line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LinkCounts {
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

/// The next frame by its numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Order {
    /// Stream and sequence; `None` before the first frame.
    next: Option<(u32, u32)>,
}

impl Order {
    /// Takes a right frame; returns whether it is new.
    pub fn take(&mut self, header: &Header, counts: &mut LinkCounts) -> bool {
        let lost = match self.next {
            // A listener that joins later has lost nothing.
            None => 0,
            Some((stream, next)) if stream == header.stream => {
                let ahead = header.sequence.wrapping_sub(next);
                if ahead < 1 << 31 {
                    ahead
                } else if header.kind == HELLO && header.sequence < next.wrapping_sub(1) {
                    // A restart with the same session.
                    header.sequence
                } else {
                    counts.repeated = counts.repeated.saturating_add(1);
                    return false;
                }
            }
            Some(_) => header.sequence,
        };
        counts.lost = counts.lost.saturating_add(lost);
        counts.frames = counts.frames.saturating_add(1);
        self.next = Some((header.stream, header.sequence.wrapping_add(1)));
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::telemetry::{REPORT, VERSION};

    #[test]
    fn gaps_repetitions_and_restarts() {
        let (mut order, mut counts) = (Order::default(), LinkCounts::default());
        let mut take = |kind, stream, sequence| {
            let new = order.take(&Header { version: VERSION, kind, stream, sequence }, &mut counts);
            (new, counts.lost, counts.repeated)
        };
        assert_eq!(take(REPORT, 1, 7), (true, 0, 0), "a listener that joins later");
        assert_eq!(take(REPORT, 1, 8), (true, 0, 0));
        assert_eq!(take(REPORT, 1, 8), (false, 0, 1), "doubled");
        assert_eq!(take(REPORT, 1, 12), (true, 3, 1));
        assert_eq!(take(REPORT, 1, 10), (false, 3, 2), "late");
        assert_eq!(take(HELLO, 1, 1), (true, 4, 2), "restart whose first frame was lost");
        assert_eq!(take(HELLO, 1, 1), (false, 4, 3), "doubled hello");
        assert_eq!(take(REPORT, 2, 2), (true, 6, 3), "another stream");
        assert_eq!(take(REPORT, 2, u32::MAX), (false, 6, 4));
        let mut order = Order { next: Some((1, u32::MAX)) };
        let mut counts = LinkCounts::default();
        for sequence in [u32::MAX, 1] {
            assert!(order.take(&Header { version: VERSION, kind: REPORT, stream: 1, sequence }, &mut counts));
        }
        assert_eq!(counts.lost, 1, "numbers wrap");
    }
}
