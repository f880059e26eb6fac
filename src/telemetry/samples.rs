//! Blocks of samples, and lists of numbers, as bytes.

use serde::{Deserialize, Serialize};

use super::sink::{Sink, TooSmall};
use super::split;
use crate::signal::Angle;

/// A list of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Numbers<'a>(pub(super) &'a [u8]);

impl Numbers<'_> {
    /// Number of numbers.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.0.len() / 4
    }

    /// Whether there is none.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// A number by its index.
    #[must_use]
    pub fn get(&self, index: usize) -> Option<f32> {
        word(self.0, index).map(f32::from_le_bytes)
    }

    /// The numbers in their order.
    pub fn iter(&self) -> impl Iterator<Item = f32> {
        (0..self.len()).map(|index| self.get(index).unwrap_or(f32::NAN))
    }
}

/// Four bytes by their index.
pub(super) fn word(bytes: &[u8], index: usize) -> Option<[u8; 4]> {
    bytes.get(index.wrapping_mul(4)..)?.first_chunk().copied()
}

#[derive(Serialize, Deserialize)]
struct Fields {
    #[serde(with = "postcard::fixint::le")]
    first: u32,
    channels: u8,
    angle: bool,
}

/// Samples that follow each other at the sampling interval.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Block<'a> {
    /// Number of the first sample, since the recorder was made; it wraps.
    pub first: u32,
    /// Number of channels.
    pub channels: u8,
    /// Whether samples have an angle.
    pub with_angle: bool,
    pub(super) bytes: &'a [u8],
}

impl<'a> Block<'a> {
    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.bytes.len().checked_div(sample_bytes(self.channels, self.with_angle)).unwrap_or(0)
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Value of a channel, by the index of the sample in the block and that of the channel in the sample.
    #[must_use]
    pub fn value(&self, sample: usize, channel: usize) -> Option<f32> {
        let exists = channel < self.channels as usize;
        if exists { self.word(sample, channel).map(f32::from_le_bytes) } else { None }
    }

    /// Angle of a sample; `None` if samples have none.
    #[must_use]
    pub fn angle(&self, sample: usize) -> Option<Angle> {
        let bits = if self.with_angle { self.word(sample, self.channels as usize) } else { None };
        bits.map(|bits| Angle::from_bits(u32::from_le_bytes(bits)))
    }

    fn word(&self, sample: usize, index: usize) -> Option<[u8; 4]> {
        let words = sample_bytes(self.channels, self.with_angle) / 4;
        word(self.bytes, sample.wrapping_mul(words).wrapping_add(index))
    }

    pub(super) fn write(&self, sink: &mut Sink<'_>) -> Result<(), TooSmall> {
        sink.fields(&Fields { first: self.first, channels: self.channels, angle: self.with_angle })?;
        sink.bytes(self.bytes)
    }

    /// From fields and list; `None` if they do not fit.
    pub(super) fn read(bytes: &'a [u8]) -> Option<Self> {
        let (Fields { first, channels, angle }, bytes) = split(bytes)?;
        let whole = bytes.len().checked_rem(sample_bytes(channels, angle)) == Some(0);
        whole.then_some(Self { first, channels, with_angle: angle, bytes })
    }
}

/// Bytes of a sample.
pub(super) const fn sample_bytes(channels: u8, with_angle: bool) -> usize {
    4 * (channels as usize + with_angle as usize)
}
