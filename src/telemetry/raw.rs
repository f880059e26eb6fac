//! Raw samples of the front end → blocks.

use serde::{Deserialize, Serialize};

use super::filling::Filling;
use super::samples::word;
use super::sink::{Sink, TooSmall};
use super::split;
use crate::drive::{PhaseCounts, Position, RawSample};
use crate::signal::Angle;

/// Flags of a sample, in the upper half of its second word.
const TWO_CURRENTS: u32 = 1 << 16;
const NO_POSITION: u32 = 1 << 17;
/// The first word is the quadrature current instead of two counts.
const QUADRATURE: u32 = 1 << 18;
/// Words of a sample before those of its position.
const CURRENTS: usize = 2;

/// Gathers raw samples in a block of at most `BYTES` bytes; a sample has 12, four more with sine and cosine of a
/// resolver, and four for each further channel.
///
/// In the interrupt of the control loop, hand over what [`RawRecorder::take`] returns by a queue. A line that is too
/// slow for all samples carries single blocks: the receiver sees gaps, and each series between them is a recording.
/// `cargo xtask firmware measure_telemetry` prints the instructions of a push.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RawRecorder<const FURTHER: usize, const BYTES: usize> {
    control_rate_hz: f32,
    /// Number of the first sample of the block, and that which the next one must have.
    first: u32,
    next: u32,
    /// Whether positions are sine and cosine.
    resolver: bool,
    /// Number of further channels.
    further: u8,
    samples: Filling<BYTES>,
}

impl<const FURTHER: usize, const BYTES: usize> RawRecorder<FURTHER, BYTES> {
    /// No sample yet.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, reason = "a front end has few channels")]
    pub const fn new(control_rate_hz: f32) -> Self {
        let further = FURTHER as u8;
        Self { control_rate_hz, first: 0, next: 0, resolver: false, further, samples: Filling::new() }
    }

    /// Records only so many of the further channels, the first ones.
    #[must_use]
    pub const fn with_further(self, channels: u8) -> Self {
        let further = if (channels as usize) < FURTHER { channels } else { self.further };
        Self { further, ..self }
    }

    /// Takes a raw sample; returns whether the block is complete. A complete block takes no sample until
    /// [`RawRecorder::clear`] or [`RawRecorder::take`], and a sample whose number does not follow, or whose position is
    /// of another kind, completes a block without being in it: the receiver sees a gap.
    #[inline]
    pub fn push(&mut self, raw: &RawSample<FURTHER>) -> bool {
        let (resolver, position, mut flags) = match raw.position {
            Position::Absolute(angle) => (false, [angle.bits(), 0], 0),
            Position::Resolver { sin, cos } => (true, [sin.to_bits(), cos.to_bits()], 0),
            Position::Missing => (self.resolver, [0; 2], NO_POSITION),
        };
        let pair = |a: u16, b: u16| u32::from(a) | u32::from(b) << 16;
        let (first, c) = match raw.currents {
            PhaseCounts::Three([a, b, c]) => (pair(a, b), c),
            PhaseCounts::Two([a, b]) => {
                flags |= TWO_CURRENTS;
                (pair(a, b), 0)
            }
            PhaseCounts::Quadrature(current_a) => {
                flags |= QUADRATURE;
                (current_a.to_bits(), 0)
            }
        };
        if self.samples.is_empty() {
            (self.first, self.next, self.resolver) = (raw.number, raw.number, resolver);
        }
        if raw.number != self.next || resolver != self.resolver {
            self.samples.complete();
        }
        let further = usize::from(self.further);
        let taken = self.samples.add(sample_bytes(resolver, further), |words| {
            let mut words = words.iter_mut();
            let mut put = |word: u32| words.next().into_iter().for_each(|cell| *cell = word.to_le_bytes());
            put(first);
            put(u32::from(c) | flags);
            let [angle, cosine] = position;
            put(angle);
            if resolver {
                put(cosine);
            }
            raw.further.iter().take(further).for_each(|value| put(value.to_bits()));
        });
        self.next = self.next.wrapping_add(u32::from(taken));
        self.samples.is_complete()
    }

    /// Whether the block is complete: it takes no more samples.
    #[must_use]
    pub const fn is_complete(&self) -> bool {
        self.samples.is_complete()
    }

    /// The samples so far.
    #[must_use]
    pub fn block(&self) -> RawBlock<'_> {
        let bytes = self.samples.bytes();
        let Self { first, control_rate_hz, resolver, further, .. } = *self;
        RawBlock { first, control_rate_hz, resolver, further, bytes }
    }

    /// Starts the next block.
    pub const fn clear(&mut self) {
        self.samples.clear();
    }

    /// Gives the block away and starts the next one.
    #[must_use]
    pub fn take(&mut self) -> Self {
        let whole = self.clone();
        self.clear();
        whole
    }
}

#[derive(Serialize, Deserialize)]
struct Fields {
    #[serde(with = "postcard::fixint::le")]
    first: u32,
    control_rate_hz: f32,
    resolver: bool,
    further: u8,
}

/// Raw samples that follow each other at the control rate.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RawBlock<'a> {
    /// Number of the first sample, that of [`RawSample::number`].
    pub first: u32,
    /// Rate of the samples, Hz.
    pub control_rate_hz: f32,
    /// Whether positions are sine and cosine of a resolver, and not angles.
    pub resolver: bool,
    /// Number of further channels.
    pub further: u8,
    pub(super) bytes: &'a [u8],
}

impl<'a> RawBlock<'a> {
    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.bytes.len().checked_div(sample_bytes(self.resolver, self.further.into())).unwrap_or(0)
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Counts of the phase currents, or the quadrature current, by the index of the sample in the block.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, reason = "two counts a word")]
    pub fn currents(&self, sample: usize) -> Option<PhaseCounts> {
        let (first, second) = (self.word(sample, 0)?, self.word(sample, 1)?);
        let [a, b] = [first as u16, (first >> 16) as u16];
        if second & QUADRATURE != 0 {
            return Some(PhaseCounts::Quadrature(f32::from_bits(first)));
        }
        let two = second & TWO_CURRENTS != 0;
        Some(if two { PhaseCounts::Two([a, b]) } else { PhaseCounts::Three([a, b, second as u16]) })
    }

    /// Reading of the position sensor.
    #[must_use]
    pub fn position(&self, sample: usize) -> Option<Position> {
        let (flags, first) = (self.word(sample, 1)?, self.word(sample, CURRENTS)?);
        if flags & NO_POSITION != 0 {
            return Some(Position::Missing);
        }
        if !self.resolver {
            return Some(Position::Absolute(Angle::from_bits(first)));
        }
        let cos = f32::from_bits(self.word(sample, CURRENTS.wrapping_add(1))?);
        Some(Position::Resolver { sin: f32::from_bits(first), cos })
    }

    /// Value of a further channel, by its index.
    #[must_use]
    pub fn further(&self, sample: usize, channel: usize) -> Option<f32> {
        let before = sample_bytes(self.resolver, 0) / 4;
        let exists = channel < self.further as usize;
        if exists { self.word(sample, before.wrapping_add(channel)).map(f32::from_bits) } else { None }
    }

    fn word(&self, sample: usize, index: usize) -> Option<u32> {
        let words = sample_bytes(self.resolver, self.further.into()) / 4;
        word(self.bytes, sample.wrapping_mul(words).wrapping_add(index)).map(u32::from_le_bytes)
    }

    pub(super) fn write(&self, sink: &mut Sink<'_>) -> Result<(), TooSmall> {
        let Self { first, control_rate_hz, resolver, further, bytes } = *self;
        sink.fields(&Fields { first, control_rate_hz, resolver, further })?;
        sink.bytes(bytes)
    }

    /// From fields and list; `None` if they do not fit.
    pub(super) fn read(bytes: &'a [u8]) -> Option<Self> {
        let (Fields { first, control_rate_hz, resolver, further }, bytes) = split(bytes)?;
        let whole = bytes.len().checked_rem(sample_bytes(resolver, further.into())) == Some(0);
        let rate = control_rate_hz > 0.0 && control_rate_hz < f32::INFINITY;
        (whole && rate).then_some(Self { first, control_rate_hz, resolver, further, bytes })
    }
}

/// Bytes of a sample.
const fn sample_bytes(resolver: bool, further: usize) -> usize {
    4_usize.saturating_mul((CURRENTS + 1 + resolver as usize).saturating_add(further))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    const THREE: PhaseCounts = PhaseCounts::Three([1, 0xffff, 4079]);

    fn sample(number: u32, position: Position) -> RawSample<2> {
        RawSample { number, currents: THREE, position, further: [f32::from_bits(0x7FC0_1234), -0.5] }
    }

    fn turned(number: u32) -> RawSample<2> {
        sample(number, Position::Absolute(Angle::from_bits(0xFFFF_0000 ^ number)))
    }

    #[test]
    fn a_full_block_waits_and_a_gap_completes_one() {
        // Two samples of 20 bytes.
        let mut recorder = RawRecorder::<2, 50>::new(1e4);
        assert_eq!([7, 8, 9].map(|number| recorder.push(&turned(number))), [false, true, true]);
        let whole = recorder.take();
        let block = whole.block();
        assert_eq!((block.first, block.len(), block.further, block.resolver), (7, 2, 2, false));
        assert_eq!((block.currents(1), block.position(1)), (Some(THREE), Some(turned(8).position)));
        assert_eq!(block.further(1, 0).unwrap().to_bits(), 0x7FC0_1234, "NaN keeps its bits");
        assert_eq!((block.further(1, 1), block.further(1, 2)), (Some(-0.5), None));
        assert_eq!((block.currents(2), block.position(2), block.further(2, 0)), (None, None, None));
        assert!(!recorder.push(&turned(10)));
        assert!(recorder.push(&turned(12)), "samples on both sides of a gap are not in one block");
        assert_eq!((recorder.block().first, recorder.block().len()), (10, 1));
        recorder.clear();
        assert!(!recorder.push(&turned(u32::MAX)));
        assert!(recorder.push(&turned(0)), "numbers wrap");
        assert_eq!(recorder.block().len(), 2);
        assert!(RawRecorder::<2, 19>::new(1e4).push(&turned(1)), "less than a sample");
    }

    #[test]
    fn fewer_further_channels() {
        // Three samples of 16 bytes.
        let mut recorder = RawRecorder::<2, 50>::new(1e4).with_further(1);
        assert_eq!([7, 8, 9].map(|number| recorder.push(&turned(number))), [false, false, true]);
        let block = recorder.block();
        assert_eq!((block.len(), block.further, block.position(2)), (3, 1, Some(turned(9).position)));
        assert_eq!((block.further(2, 0).unwrap().to_bits(), block.further(2, 1)), (0x7FC0_1234, None));
        assert_eq!(RawRecorder::<2, 50>::new(1e4).with_further(3).block().further, 2, "there are no more");
    }

    #[test]
    fn a_quadrature_current_comes_back_with_its_bits() {
        let mut recorder = RawRecorder::<2, 80>::new(8000.0);
        for (number, current_a) in [(0, -12.75), (1, f32::NAN)] {
            assert!(!recorder.push(&RawSample { currents: PhaseCounts::Quadrature(current_a), ..turned(number) }));
        }
        let block = recorder.block();
        assert_eq!(
            (block.currents(0), block.position(0)),
            (Some(PhaseCounts::Quadrature(-12.75)), Some(turned(0).position))
        );
        assert!(matches!(block.currents(1), Some(PhaseCounts::Quadrature(current_a)) if current_a.is_nan()));
    }

    #[test]
    fn two_currents_a_resolver_and_missing_positions_come_back() {
        let mut recorder = RawRecorder::<0, 80>::new(8000.0);
        let positions = [Position::Resolver { sin: 0.6, cos: -0.8 }, Position::Missing];
        let currents = PhaseCounts::Two([5, 6]);
        for (number, position) in (0..).zip(positions) {
            assert!(!recorder.push(&RawSample { number, currents, position, further: [] }));
        }
        let (block, two) = (recorder.block(), [0, 1]);
        assert_eq!(two.map(|index| block.position(index)), positions.map(Some));
        assert_eq!((block.currents(1), block.resolver, block.further(1, 0)), (Some(currents), true, None));
        let angle = RawSample { number: 2, currents, position: Position::Absolute(Angle::ZERO), further: [] };
        assert!(recorder.push(&angle), "a position of another kind begins another block");
        assert_eq!(recorder.block().len(), 2);
    }

    #[test]
    fn what_does_not_fit_is_no_block() {
        let fields = |rate: f32, resolver: u8, further: u8, bytes: usize| {
            let mut all = Vec::from([3, 0, 0, 0]);
            all.extend(rate.to_le_bytes());
            all.extend([resolver, further]);
            all.resize(10 + bytes, 0);
            RawBlock::read(&all).map(|block| block.len())
        };
        assert_eq!([fields(1e4, 0, 2, 40), fields(1e4, 1, 2, 48), fields(1e4, 0, 0, 0)], [Some(2), Some(2), Some(0)]);
        assert_eq!([fields(1e4, 0, 2, 41), fields(1e4, 2, 2, 40)], [None; 2]);
        assert_eq!([fields(0.0, 0, 2, 40), fields(f32::NAN, 0, 2, 40), fields(f32::INFINITY, 0, 2, 40)], [None; 3]);
    }
}
