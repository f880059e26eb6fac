//! The order of the segments of a drive: which frames are missing, came again, or withdraw a report.

use bearing_watch::telemetry::SegmentFrame;
use bearing_watch::{Reason, Verdict};

/// Missing segments that are believed; a larger step of the counter is a drive that starts again.
const MOST_LOST: u8 = 127;

/// A segment as it came.
#[derive(Clone, Copy, Debug)]
pub(super) struct Segment {
    pub(super) time_s: f64,
    /// Its number without wraps, if the log has the first one.
    pub(super) number: u64,
    pub(super) frame: SegmentFrame,
    /// Whether an earlier frame had the same number and other content.
    pub(super) again: bool,
}

/// What a frame is beside those before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Came {
    /// A segment with this number.
    New(u64),
    /// The last segment once more, with other content; with the frame before.
    Again(u64, SegmentFrame),
    /// A frame that came before.
    Repeated,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct CourseCounts {
    /// Segments of which a frame came.
    pub(super) segments: u64,
    /// Segments that are missing by the counter.
    pub(super) lost: u64,
    /// Equal frames.
    pub(super) repeated: u64,
    /// Reports that were withdrawn, by a frame with their number or by the count of undetermined segments.
    pub(super) withdrawn: u64,
    /// Frames with the number of the last segment and other content.
    pub(super) again: u64,
    /// How often the drive has started again.
    pub(super) restarts: u64,
}

/// Follows the counters of a drive.
#[derive(Clone, Debug, Default)]
pub(super) struct Course {
    last: Option<(u64, SegmentFrame)>,
    before: Option<SegmentFrame>,
    counts: CourseCounts,
}

impl Course {
    pub(super) const fn counts(&self) -> CourseCounts {
        self.counts
    }

    pub(super) fn take(&mut self, frame: SegmentFrame) -> Came {
        if self.before == Some(frame) || self.last.is_some_and(|(_, last)| last == frame) {
            self.counts.repeated += 1;
            return Came::Repeated;
        }
        let step = self.last.map(|(number, last)| (number, last, frame.segment().wrapping_sub(last.segment())));
        let came = match step {
            None => Came::New(frame.segment().into()),
            Some((number, last, 0)) => {
                self.counts.again += 1;
                self.counts.withdrawn += u64::from(is_withdrawn(frame) && !is_withdrawn(last));
                Came::Again(number, last)
            }
            Some((number, last, step)) if step <= MOST_LOST + 1 && !(step > 1 && is_first(frame)) => {
                self.counts.lost += u64::from(step) - 1;
                self.counts.withdrawn += u64::from(step == 1 && withdraws(last, frame));
                Came::New(number + u64::from(step))
            }
            Some(_) => {
                self.counts.restarts += 1;
                Came::New(frame.segment().into())
            }
        };
        let (Came::New(number) | Came::Again(number, _)) = came else { return came };
        if matches!(came, Came::New(_)) {
            self.counts.segments += 1;
            self.before = self.last.map(|(_, last)| last);
        }
        self.last = Some((number, frame));
        came
    }
}

fn is_undetermined(frame: SegmentFrame) -> bool {
    matches!(frame.verdict(), Verdict::Undetermined(_))
}

fn is_withdrawn(frame: SegmentFrame) -> bool {
    frame.verdict() == Verdict::Undetermined(Reason::FoundLate)
}

/// Whether the counters are those of the first segment of a drive.
fn is_first(frame: SegmentFrame) -> bool {
    frame.segment() == 1 && frame.undetermined() == u8::from(is_undetermined(frame))
}

/// Whether more segments are undetermined than the next frame itself: the one before was withdrawn after its frame.
fn withdraws(last: SegmentFrame, next: SegmentFrame) -> bool {
    let more = next.undetermined().wrapping_sub(last.undetermined()) & 7;
    !is_undetermined(last) && more == 1 + u8::from(is_undetermined(next))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A frame with this number, verdict (3: class 0) and count of undetermined segments.
    fn frame(segment: u64, verdict: u8, undetermined: u8) -> SegmentFrame {
        let reason = match verdict {
            0 => 3,
            15 => 15,
            _ => 0,
        };
        let verdict = if verdict == 15 { 0 } else { verdict };
        SegmentFrame::from_bytes([segment as u8, verdict, reason | undetermined << 5, 0, 0, 0, 90, 0])
            .expect("a segment")
    }

    /// Numbers of the frames, 0 for repeated ones, and lost, repeated, withdrawn, again, restarts.
    fn followed(frames: &[(u64, u8, u8)]) -> (Vec<u64>, [u64; 5]) {
        let mut course = Course::default();
        let numbers = frames.iter().map(|(segment, verdict, undetermined)| {
            match course.take(frame(*segment, *verdict, *undetermined)) {
                Came::New(number) | Came::Again(number, _) => number,
                Came::Repeated => 0,
            }
        });
        let numbers = numbers.collect();
        let CourseCounts { lost, repeated, withdrawn, again, restarts, .. } = course.counts();
        (numbers, [lost, repeated, withdrawn, again, restarts])
    }

    #[test]
    fn lost_and_repeated_segments_are_counted_over_the_wrap() {
        let wrapped = [(254, 3, 0), (255, 3, 0), (256, 3, 0), (258, 3, 0), (259, 3, 0), (259, 3, 0), (258, 3, 0)];
        assert_eq!(followed(&wrapped), (vec![254, 255, 256, 258, 259, 0, 0], [1, 2, 0, 0, 0]));
        assert_eq!(followed(&[(10, 3, 0), (138, 3, 0)]), (vec![10, 138], [127, 0, 0, 0, 0]));
        assert_eq!(followed(&[(10, 3, 0), (139, 3, 0)]), (vec![10, 139], [0, 0, 0, 0, 1]), "129 on, or 127 back");
    }

    #[test]
    fn a_drive_that_starts_again_has_lost_nothing() {
        assert_eq!(followed(&[(200, 3, 4), (1, 3, 0), (2, 3, 0)]), (vec![200, 1, 2], [0, 0, 0, 0, 1]));
        assert_eq!(followed(&[(200, 3, 4), (1, 0, 1)]), (vec![200, 1], [0, 0, 0, 0, 1]), "undetermined at once");
        assert_eq!(followed(&[(250, 3, 4), (257, 3, 4)]), (vec![250, 257], [6, 0, 0, 0, 0]), "a wrap");
        assert_eq!(followed(&[(256, 3, 0), (257, 3, 0)]), (vec![0, 1], [0; 5]));
    }

    #[test]
    fn a_withdrawn_report_is_told_by_a_second_frame_or_by_the_next_one() {
        let sent = [(5, 3, 0), (5, 15, 1), (6, 3, 1), (7, 0, 2)];
        assert_eq!(followed(&sent), (vec![5, 5, 6, 7], [0, 0, 1, 1, 0]));
        let unsent = [(5, 3, 0), (6, 3, 1), (7, 0, 3), (8, 0, 4)];
        assert_eq!(followed(&unsent), (vec![5, 6, 7, 8], [0, 0, 2, 0, 0]));
        assert_eq!(followed(&[(5, 3, 0), (7, 3, 1)]).1, [1, 0, 0, 0, 0], "the lost one may be the undetermined one");
    }
}
