//! Samples and the gate: which channels of a sample may be used, and how many were refused.
//!
//! Enters: every sample of a stream. Leaves: a bit mask of refused channels, and [`Counts`] for the report.
//!
//! A channel is *rejected* if its value is not a number or exceeds the limit, and *saturated* if it exceeds the range
//! of its sensor. A channel that repeats the same bits `stuck_samples` times is *stuck*. The samples before that were
//! used already, so the segment gets no verdict; the samples after it are not used, since fading memory would keep them
//! beyond the segment. Each channel is checked once a sample, whichever parts use it.

use super::channel::Channel;
use crate::plan::{Array, Cells, Plan, Signals};

/// A set of channels by their indices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ChannelSet(pub(crate) u16);

impl ChannelSet {
    /// Whether the channel at this index is in the set.
    #[must_use]
    pub const fn contains(self, channel: usize) -> bool {
        channel < 16 && (self.0 >> channel) & 1 == 1
    }

    /// Whether the set is empty.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// The first channel of the set that the mask contains.
    pub(crate) fn first_of(self, mask: u16) -> Option<u8> {
        let members = self.0 & mask;
        if members == 0 { None } else { u8::try_from(members.trailing_zeros()).ok() }
    }
}

/// Samples, rows and channels of a segment that were refused.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Counts {
    /// Samples with a channel beyond its limit or not a number, or with a step of the angle that no motor makes.
    pub rejected: u32,
    /// Samples with a saturated sensor and no rejected channel.
    pub saturated: u32,
    /// Rows that fading memory ignored because the inputs hardly changed.
    pub resting: u32,
    /// Channels that were stuck at some time of the segment.
    pub stuck: ChannelSet,
    /// Segments in a row, before this one, whose model could not serve as auxiliary model; 0 by least squares.
    pub refused: u8,
}

/// The last value of a channel, and the number of times in a row that it came.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Repeat {
    last: f32,
    equal: u16,
}

/// Running state of the gate.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Gate<P: Plan> {
    repeats: Array<P::Channels, Repeat>,
    /// What was refused in the open segment.
    pub counts: Counts,
}

impl<P: Plan> Gate<P> {
    /// Nothing sampled yet.
    #[must_use]
    pub fn new(plan: P) -> Self {
        // Runs of length zero: the first value starts a run of length one.
        let repeat = Repeat { last: 0.0, equal: 0 };
        Self { repeats: Cells::filled(plan.layout().channels as usize, repeat), counts: Counts::default() }
    }

    /// The refused channels of a sample, as a bit mask; counts the sample if there are any.
    // Part of every sample: a call would cost as much as the comparisons.
    #[inline(always)]
    pub fn refused(&mut self, channels: &Array<P::Channels, Channel>, sample: &P::Sample) -> u16 {
        let (mut unused, mut stuck, mut bit) = (0, 0, 1_u16);
        let states = self.repeats.cells_mut().iter_mut();
        // In this order the count of places stays below a length, and needs no overflow check.
        for ((index, channel), repeat) in channels.cells().iter().enumerate().zip(states) {
            let x = sample.value(index);
            // The saturation is at most the limit. Written so that NaN is refused.
            let good = x.abs() <= channel.saturation;
            unused |= if good { 0 } else { bit };
            if channel.stuck_samples > 0 && repeat.takes(x, channel.stuck_samples) {
                stuck |= bit;
            }
            bit = bit.wrapping_shl(1);
        }
        if unused != 0 {
            self.count(channels.cells(), sample);
        }
        if stuck != 0 {
            self.counts.stuck.0 |= stuck;
        }
        unused | stuck
    }

    #[cold]
    #[inline(never)]
    fn count(&mut self, channels: &[Channel], sample: &P::Sample) {
        let plausible = channels.iter().enumerate().all(|(index, c)| sample.value(index).abs() <= c.limit);
        let count = if plausible { &mut self.counts.saturated } else { &mut self.counts.rejected };
        *count = count.saturating_add(1);
    }

    /// Counts from zero; runs of equal samples continue.
    pub fn next_segment(&mut self) {
        self.counts = Counts::default();
    }
}

impl Repeat {
    /// Takes a value; returns whether it is at least the `most`-th equal one in a row. Both zeros are equal, and a NaN
    /// equals every other one, since the bits of a NaN that was computed differ between processors.
    #[inline(always)]
    #[expect(clippy::float_cmp, reason = "a sensor that repeats a value repeats it exactly")]
    fn takes(&mut self, x: f32, most: u16) -> bool {
        let same = x == self.last || (x.is_nan() && self.last.is_nan());
        self.equal = if same { self.equal.saturating_add(1) } else { 1 };
        self.last = x;
        self.equal >= most
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{Layout, Memory, Method, RegressionLayout, Structure};

    crate::plan! {
        struct Two;
        struct Pair { y: "A", u: "rad/s" }
        layout: Layout {
            regression: Some(RegressionLayout {
                structure: Structure::new(1, 1, 0, 1, 0),
                method: Method::LeastSquares,
                memory: Memory::Segment,
                y,
                u1: u,
                u2: u,
            }),
            features: 1,
            coordinates: 1,
            classes: 1,
            ..Layout::EMPTY
        }
    }

    const CHANNELS: [Channel; 2] = [
        Channel { saturation: 9.0, stuck_samples: 3, ..Channel::within("y", "A", 10.0) },
        Channel::within("u", "rad/s", 10.0),
    ];

    #[test]
    fn saturated_and_rejected_are_counted_separately() {
        let mut gate = Gate::new(Two);
        let mut refused = |y, u| gate.refused(&CHANNELS, &Pair { y, u });
        assert_eq!([refused(9.0, 10.0), refused(9.5, 0.0), refused(-11.0, 0.0)], [0, 1, 1]);
        assert_eq!([refused(9.5, f32::NAN), refused(0.0, f32::INFINITY)], [3, 2]);
        assert_eq!((gate.counts.saturated, gate.counts.rejected), (1, 3));
        gate.next_segment();
        assert_eq!(gate.counts, Counts::default());
    }

    #[test]
    fn three_equal_samples_are_stuck_if_the_channel_must_vary() {
        let mut gate = Gate::new(Two);
        let mut refused = |y| gate.refused(&CHANNELS, &Pair { y, u: 1.0 });
        assert_eq!([1.0, 1.0, 2.0, 2.0].map(&mut refused), [0; 4]);
        assert_eq!(refused(2.0), 1);
        assert!(gate.counts.stuck.contains(0) && !gate.counts.stuck.contains(1));
        gate.next_segment();
        assert!(gate.counts.stuck.is_empty());
        assert_eq!(gate.refused(&CHANNELS, &Pair { y: 2.0, u: 1.0 }), 1, "still stuck in the next segment");
    }

    #[test]
    fn each_channel_is_stuck_by_itself() {
        let channels = CHANNELS.map(|channel| Channel { stuck_samples: 3, ..channel });
        for (index, mask) in [(0, 1), (1, 2)] {
            let mut gate = Gate::new(Two);
            let refused = [1.0, 2.0, 3.0].map(|x| {
                let sample = if index == 0 { Pair { y: 7.0, u: x } } else { Pair { y: x, u: 7.0 } };
                gate.refused(&channels, &sample)
            });
            assert_eq!((refused, gate.counts.stuck), ([0, 0, mask], ChannelSet(mask)));
        }
    }

    #[test]
    fn missing_samples_are_stuck_whatever_the_bits_of_their_nan() {
        for bits in [[0x7fc0_0000; 3], [0x7fc0_0000, 0xffc0_0000, 0x7fc0_0001]] {
            let mut gate = Gate::new(Two);
            let refused = bits.map(|bits| gate.refused(&CHANNELS, &Pair { y: f32::from_bits(bits), u: 1.0 }));
            assert_eq!(refused, [1; 3]);
            assert!(gate.counts.stuck.contains(0), "{bits:x?}");
        }
    }

    #[test]
    fn zeros_of_either_sign_are_one_value() {
        let mut gate = Gate::new(Two);
        let refused = [0.0, -0.0, 0.0, -0.0].map(|y| gate.refused(&CHANNELS, &Pair { y, u: 1.0 }));
        assert_eq!(refused, [0, 0, 1, 1]);
        assert!(gate.counts.stuck.contains(0));
    }
}
