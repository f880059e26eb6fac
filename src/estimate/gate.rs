//! The gate before the estimator: which samples are let in, and the count of those that are not.
//!
//! Enters: every sample of a stream. Leaves: whether it may be used; [`Counts`] for the report.
//!
//! A sample beyond its limit, NaN and infinity are *rejected*; one beyond the saturation of its sensor is not used
//! either and counted apart. A signal that repeats the same bits for too long is *stuck*: what came before its
//! detection is in the sums already, so the segment gets no verdict; what comes after it is not used, since fading memory
//! would keep it beyond the segment.

use super::regression::{Guard, within};
use crate::detector::Sample;

/// What a segment was denied, and why.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Counts {
    /// Samples refused by the range guard: beyond the limit, or no number.
    pub rejected: u32,
    /// Samples refused because a sensor was saturated.
    pub saturated: u32,
    /// Rows that weighed less because their residual was large.
    pub downweighted: u32,
    /// Rows neither learnt from nor forgotten, because nothing moved (fading memory).
    pub still: u32,
    /// Whether y, u1, u2 was stuck at some time.
    pub stuck: [bool; 3],
    /// Segments in a row, before this one, whose model could not take over as auxiliary model.
    pub refused: u8,
}

/// Running state of the gate.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(crate) struct Gate {
    last: [f32; 3],
    equal: [u16; 3],
    pub(crate) counts: Counts,
    /// Number of the segment, wrapping.
    pub(crate) segment: u8,
    /// Closed for a regression that the estimator's types do not fit.
    pub(crate) open: bool,
}

impl Gate {
    pub(crate) fn new(open: bool) -> Self {
        // Runs of length zero: whatever comes first makes them one long.
        Self { last: [0.0; 3], equal: [0; 3], counts: Counts::default(), segment: 0, open }
    }

    /// Whether the sample may be used; counts it where it is out of range.
    // Part of every sample: a call would cost as much as the comparisons.
    #[inline(always)]
    pub(crate) fn admits(&mut self, guard: &Guard, sample: &Sample) -> bool {
        let stuck = self.watch(guard, sample);
        // One comparison a signal in the usual case: saturation is at most the limit.
        let good = within(sample, &guard.saturation);
        if !good {
            self.refuse(guard, sample);
        }
        good && !stuck
    }

    /// Whether a sensor is stuck now.
    #[inline(always)]
    fn watch(&mut self, guard: &Guard, sample: &Sample) -> bool {
        // Signal by signal: as a loop it costs three times as much.
        let [last_y, last_u1, last_u2] = &mut self.last;
        let [equal_y, equal_u1, equal_u2] = &mut self.equal;
        let [most_y, most_u1, most_u2] = guard.stuck_samples;
        let now = [
            is_stuck(sample.y, last_y, equal_y, most_y),
            is_stuck(sample.u1, last_u1, equal_u1, most_u1),
            is_stuck(sample.u2, last_u2, equal_u2, most_u2),
        ];
        let any = now[0] | now[1] | now[2];
        if any {
            self.note(now);
        }
        any
    }

    #[cold]
    fn note(&mut self, now: [bool; 3]) {
        self.counts.stuck.iter_mut().zip(now).for_each(|(stuck, now)| *stuck |= now);
    }

    #[cold]
    fn refuse(&mut self, guard: &Guard, sample: &Sample) {
        let count = if within(sample, &guard.limit) { &mut self.counts.saturated } else { &mut self.counts.rejected };
        *count = count.saturating_add(1);
    }

    /// Counts from zero; runs of equal samples go on.
    pub(crate) fn next_segment(&mut self) {
        let refused = self.counts.refused;
        self.counts = Counts { refused, ..Counts::default() };
        self.segment = self.segment.wrapping_add(1);
    }
}

/// Whether the value has come so many times in a row; never for zero times.
#[inline(always)]
fn is_stuck(x: f32, last: &mut f32, equal: &mut u16, most: u16) -> bool {
    if most == 0 {
        return false;
    }
    *equal = if x.to_bits() == last.to_bits() { equal.saturating_add(1) } else { 1 };
    *last = x;
    *equal >= most
}

#[cfg(test)]
mod tests {
    use super::*;

    const GUARD: Guard =
        Guard { limit: [10.0; 3], saturation: [9.0, 10.0, 10.0], stuck_samples: [3, 0, 0], huber: 0.0 };

    #[test]
    fn saturated_and_rejected_are_counted_apart() {
        let mut gate = Gate::new(true);
        let mut fed = |y, u1| gate.admits(&GUARD, &Sample { y, u1, u2: 0.0 });
        assert!(fed(9.0, 10.0) && !fed(9.5, 0.0) && !fed(-11.0, 0.0) && !fed(9.5, f32::NAN));
        assert_eq!((gate.counts.saturated, gate.counts.rejected), (1, 2));
        gate.next_segment();
        assert_eq!(gate.counts, Counts::default());
    }

    #[test]
    fn three_equal_samples_are_stuck_where_that_is_asked() {
        let mut gate = Gate::new(true);
        let mut stuck = |y| {
            gate.admits(&GUARD, &Sample { y, u1: 1.0, u2: 1.0 });
            gate.counts.stuck
        };
        assert_eq!([stuck(1.0), stuck(1.0), stuck(2.0), stuck(2.0)], [[false; 3]; 4]);
        assert_eq!(stuck(2.0), [true, false, false]);
        gate.next_segment();
        assert_eq!(gate.counts.stuck, [false; 3]);
        gate.admits(&GUARD, &Sample { y: 2.0, u1: 1.0, u2: 1.0 });
        assert!(gate.counts.stuck[0], "still stuck in the next segment");
    }
}
