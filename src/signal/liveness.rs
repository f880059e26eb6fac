//! Is the drive watched at all: do samples, segments and verdicts come?
//!
//! A lower interrupt that is never requested, a main loop that hangs in other work, or a processor that computes
//! otherwise than the host end the diagnosis without a wrong verdict: nothing is said any more. Each of the three has a
//! time within which its count must grow, by the clock of the firmware. Cost: three comparisons, in the main loop.

/// What must come at least so often, in seconds; infinite for never.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LivenessLimits {
    /// A sample that the detector takes.
    pub sample_s: f32,
    /// A closed segment.
    pub segment_s: f32,
    /// A verdict.
    pub verdict_s: f32,
}

impl LivenessLimits {
    /// For segments of this duration: the front end gives its first sample within two seconds, whatever its sensors do;
    /// three segments and their search for the angle pass before one is missed; and the day without a verdict is that of
    /// [`SilenceLimits::USUAL`](crate::alarm::SilenceLimits::USUAL).
    #[must_use]
    pub fn of_segments(segment_s: f32) -> Self {
        Self { sample_s: 3.0, segment_s: 3.0 * segment_s + 3.0, verdict_s: 24.0 * 3600.0 }
    }
}

/// What has not come for too long.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Stage {
    /// Samples.
    Samples,
    /// Segments.
    Segments,
    /// Verdicts.
    Verdicts,
}

impl Stage {
    const ALL: [Self; 3] = [Self::Samples, Self::Segments, Self::Verdicts];
}

/// A count that must grow.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Growing {
    count: u32,
    /// The clock when it grew last.
    at_ms: u32,
    lapsed: bool,
}

/// Compares counts of samples, segments and verdicts with a clock.
///
/// ```
/// use bearing_watch::{Liveness, LivenessLimits, Stage};
/// let mut liveness = Liveness::new(LivenessLimits::of_segments(10.0));
/// assert_eq!(liveness.push([100, 0, 0], 0), None);
/// assert_eq!(liveness.push([200, 0, 0], 2_000), None);
/// assert_eq!(liveness.push([200, 0, 0], 5_000), Some(Stage::Samples));
/// assert_eq!(liveness.push([200, 0, 0], 9_000), None); // told once
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Liveness {
    limits_ms: [u32; 3],
    growing: Option<[Growing; 3]>,
}

impl Liveness {
    /// Nothing has come yet; the times count from the first call of [`Liveness::push`].
    #[must_use]
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "`as` saturates: 49 days are never")]
    pub fn new(limits: LivenessLimits) -> Self {
        let LivenessLimits { sample_s, segment_s, verdict_s } = limits;
        Self { limits_ms: [sample_s, segment_s, verdict_s].map(|s| (1e3 * s) as u32), growing: None }
    }

    /// Takes the numbers of samples, segments and verdicts so far, and the clock in milliseconds; all may wrap. Returns
    /// what has not come for too long: each is told once, and again after it has come. Without samples there are no
    /// segments, and without either no verdicts: only the first of them is told.
    #[must_use = "nothing else tells that the diagnosis has ended"]
    pub fn push(&mut self, counts: [u32; 3], now_ms: u32) -> Option<Stage> {
        let start = || counts.map(|count| Growing { count, at_ms: now_ms, lapsed: false });
        let growing = self.growing.get_or_insert_with(start);
        let (mut told, mut before) = (None, false);
        for (((own, count), limit_ms), stage) in growing.iter_mut().zip(counts).zip(self.limits_ms).zip(Stage::ALL) {
            // A segment takes its time after samples have come back; a day without a verdict goes on.
            if own.count != count || (before && stage == Stage::Segments) {
                *own = Growing { count, at_ms: now_ms, lapsed: false };
            }
            let late = own.lapsed || (limit_ms < u32::MAX && now_ms.wrapping_sub(own.at_ms) >= limit_ms);
            if late && !before && !own.lapsed {
                (own.lapsed, told) = (true, Some(stage));
            }
            before |= late;
        }
        told
    }

    /// What has not come for too long now.
    #[must_use]
    pub fn lapsed(&self) -> Option<Stage> {
        let growing = self.growing.as_ref()?;
        growing.iter().zip(Stage::ALL).find(|(own, _)| own.lapsed).map(|(_, stage)| stage)
    }

    /// Starts anew, after a pause of samples or clock.
    pub const fn restart(&mut self) {
        self.growing = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    /// What is told at which second, of counts by the second.
    fn told(counts: impl Fn(u32) -> [u32; 3], seconds: u32) -> Vec<(u32, Stage)> {
        let mut liveness = Liveness::new(LivenessLimits { sample_s: 3.0, segment_s: 10.0, verdict_s: 100.0 });
        // Across the wrap of the clock.
        let at = |second: u32| (1000 * second).wrapping_sub(50_000);
        (0..seconds).filter_map(|second| Some((second, liveness.push(counts(second), at(second))?))).collect()
    }

    #[test]
    fn each_is_told_once_and_again_after_it_has_come() {
        assert_eq!(told(|s| [s, s / 5, s / 50], 1000), []);
        // No samples from the 20th second on, and none of the rest.
        assert_eq!(told(|s| [s.min(20), s.min(20) / 5, 0], 90), [(23, Stage::Samples)]);
        // They come again for a while; a segment needs its time, and none is missed at once.
        let pause = |s: u32| if (20..40).contains(&s) { 20 } else { s };
        assert_eq!(told(|s| [pause(s), pause(s) / 5, pause(s) / 50], 90), [(23, Stage::Samples)]);
        // So it is if the counts go on where they stood: the next segment closes five seconds later.
        let resumed = |s: u32| s.min(20) + s.saturating_sub(40);
        assert_eq!(told(|s| [resumed(s), resumed(s) / 5, resumed(s) / 50], 90), [(23, Stage::Samples)]);
        let twice = |s: u32| s.min(20) + s.clamp(40, 45) - 40;
        assert_eq!(told(|s| [twice(s), 0, 0], 60), [(10, Stage::Segments), (23, Stage::Samples), (48, Stage::Samples)]);
        // Samples without segments, segments without verdicts.
        assert_eq!(told(|s| [s, s.min(20), 0], 90), [(30, Stage::Segments)]);
        assert_eq!(told(|s| [s, s, s.min(7)], 300), [(107, Stage::Verdicts)]);
    }

    #[test]
    fn pauses_of_samples_do_not_hide_a_day_without_a_verdict() {
        // A pause of four seconds of twenty.
        let samples = |s: u32| if s % 20 < 4 { s - s % 20 } else { s };
        let told = told(|s| [samples(s), samples(s), 0], 130);
        assert!(told.iter().any(|(second, stage)| *stage == Stage::Verdicts && *second <= 104), "{told:?}");
    }

    #[test]
    fn limits_that_are_infinite_are_never_reached_and_a_restart_forgets() {
        let mut liveness = Liveness::new(LivenessLimits {
            sample_s: f32::INFINITY,
            segment_s: f32::INFINITY,
            verdict_s: f32::INFINITY,
        });
        assert_eq!([liveness.push([0; 3], 0), liveness.push([0; 3], u32::MAX)], [None, None]);
        let mut liveness = Liveness::new(LivenessLimits::of_segments(1.0));
        assert_eq!([liveness.push([0; 3], 0), liveness.push([0; 3], 3_000)], [None, Some(Stage::Samples)]);
        assert_eq!(liveness.lapsed(), Some(Stage::Samples));
        liveness.restart();
        assert_eq!((liveness.lapsed(), liveness.push([0; 3], 99_000)), (None, None));
    }
}
