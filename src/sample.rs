//! Samples and the gate: which channels of a sample may be used, and how many were refused.
//!
//! Enters: every sample of a stream. Leaves: a bit mask of refused channels, and [`Counts`] for the report.
//!
//! A channel is *rejected* if its value is not a number or exceeds the limit, and *saturated* if it exceeds the range
//! of its sensor. A channel that repeats the same bits `stuck_samples` times is *stuck*. The samples before that were
//! used already, so the segment gets no verdict; the samples after it are not used, since fading memory would keep them
//! beyond the segment. Each channel is checked once a sample, whichever parts use it.

use crate::plan::{Array, Cells, Plan, Signal, Signals};

/// A text of at most `N` bytes of UTF-8, padded with zeros.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Name<const N: usize>([u8; N]);

impl<const N: usize> Name<N> {
    /// The empty text.
    pub const EMPTY: Self = Self([0; N]);

    /// From a text; `None` if it is longer than `N` bytes or contains a zero byte.
    #[must_use]
    pub const fn new(text: &str) -> Option<Self> {
        let mut bytes = [0; N];
        let mut from = text.as_bytes();
        let mut to = bytes.as_mut_slice();
        while let Some((byte, rest)) = from.split_first() {
            if *byte == 0 {
                return None;
            }
            let Some((cell, next)) = to.split_first_mut() else { return None };
            *cell = *byte;
            from = rest;
            to = next;
        }
        Some(Self(bytes))
    }

    /// As [`Name::new`], for constants: a text that does not fit becomes the empty one, which no model accepts as the
    /// label of a class, and no plan as the name of a channel.
    #[must_use]
    pub const fn constant(text: &str) -> Self {
        match Self::new(text) {
            Some(name) => name,
            None => Self::EMPTY,
        }
    }

    /// From padded bytes; `None` if they are not UTF-8 followed by zeros only.
    #[must_use]
    pub fn from_bytes(bytes: [u8; N]) -> Option<Self> {
        let name = Self(bytes);
        let text = name.text_bytes();
        let padding = bytes.get(text.len()..).unwrap_or(&[]);
        (core::str::from_utf8(text).is_ok() && padding.iter().all(|&b| b == 0)).then_some(name)
    }

    /// Whether this is the text; in constants, where `==` is not available.
    pub(crate) const fn is(&self, text: &str) -> bool {
        let (mut own, mut other) = (self.0.as_slice(), text.as_bytes());
        while let [byte, rest @ ..] = own {
            match other {
                [first, later @ ..] if *first == *byte => other = later,
                [] if *byte == 0 => {}
                _ => return false,
            }
            own = rest;
        }
        other.is_empty()
    }

    /// The padded bytes.
    #[must_use]
    pub const fn to_bytes(self) -> [u8; N] {
        self.0
    }

    fn text_bytes(&self) -> &[u8] {
        self.0.split(|&b| b == 0).next().unwrap_or(&[])
    }

    /// The text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        core::str::from_utf8(self.text_bytes()).unwrap_or("")
    }
}

/// The name of a class.
pub type Label = Name<16>;

/// A channel of the sample with the values that are plausible.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Channel {
    /// Name, by convention with the unit as suffix: `current_a`.
    pub name: Name<32>,
    /// Unit.
    pub unit: Name<8>,
    /// Largest plausible magnitude, in the unit of the channel: a larger value is rejected.
    pub limit: f32,
    /// Magnitude above which the sensor is saturated, at most the limit.
    pub saturation: f32,
    /// Number of equal samples in a row that mean a stuck sensor; 0 if the channel may be constant.
    pub stuck_samples: u16,
}

impl Channel {
    /// A channel with a limit: no saturation below it, and it may be constant. A name or unit that does not fit becomes
    /// empty, which no plan accepts.
    #[must_use]
    pub const fn within(name: &str, unit: &str, limit: f32) -> Self {
        Self { name: Name::constant(name), unit: Name::constant(unit), limit, saturation: limit, stuck_samples: 0 }
    }
}

/// The largest plausible magnitude of a signal.
#[inline(always)]
#[must_use]
pub fn limit(channels: &impl Cells<Channel>, signal: Signal) -> f32 {
    let limit = |place: u8| channels.cells().get(place as usize).map_or(0.0, |channel| channel.limit);
    limit(signal.channel) + signal.minus.map_or(0.0, limit)
}

/// A set of channels by their places.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ChannelSet(pub(crate) u16);

impl ChannelSet {
    /// Whether the channel at this place is in the set.
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
        let found = self.0 & mask;
        if found == 0 { None } else { u8::try_from(found.trailing_zeros()).ok() }
    }
}

/// Samples, rows and channels of a segment that were refused or weighted less.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Counts {
    /// Samples with a channel beyond its limit or not a number.
    pub rejected: u32,
    /// Samples with a saturated sensor and no rejected channel.
    pub saturated: u32,
    /// Rows with a reduced weight because their residual was large.
    pub downweighted: u32,
    /// Rows that fading memory ignored because the inputs hardly changed.
    pub resting: u32,
    /// Channels that were stuck at some time of the segment.
    pub stuck: ChannelSet,
    /// Segments in a row, before this one, whose model could not serve as auxiliary model.
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
        for ((place, channel), repeat) in channels.cells().iter().enumerate().zip(states) {
            let x = sample.value(place);
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
        let plausible = channels.iter().enumerate().all(|(place, c)| sample.value(place).abs() <= c.limit);
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

    #[test]
    fn names_fit_or_are_refused() {
        assert_eq!(Label::new("healthy").map(|label| label.to_bytes()[..8].to_vec()), Some(b"healthy\0".to_vec()));
        assert_eq!(Label::new("seventeen letters"), None);
        assert_eq!(Label::constant("sixteen letters!").as_str(), "sixteen letters!");
        assert_eq!(Label::constant("seventeen letters"), Label::EMPTY);
        assert_eq!(Label::constant("zero\0byte"), Label::EMPTY);
        assert_eq!(Name::<4>::from_bytes(*b"a\0b\0"), None);
        assert_eq!(Name::<4>::from_bytes(*b"abcd").unwrap().as_str(), "abcd");
    }
}
