//! The channels of a sample: names, plausible values, and the signals that are taken from them.

use crate::plan::{Cells, Signal, Signals};

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
        let (mut bytes, mut other) = (self.0.as_slice(), text.as_bytes());
        while let [byte, rest @ ..] = bytes {
            match other {
                [first, later @ ..] if *first == *byte => other = later,
                [] if *byte == 0 => {}
                _ => return false,
            }
            bytes = rest;
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
    let limit = |index: u8| channels.cells().get(index as usize).map_or(0.0, |channel| channel.limit);
    limit(signal.channel) + signal.minus.map_or(0.0, limit)
}

/// The value of a signal in a sample.
#[inline(always)]
pub fn read(signal: Signal, sample: &impl Signals) -> f32 {
    let value = sample.value(signal.channel as usize);
    match signal.minus {
        Some(other) => value - sample.value(other as usize),
        None => value,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
