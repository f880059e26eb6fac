//! A number at a place of a frame of 64 bits.

/// A signal of [`SegmentFrame`](super::SegmentFrame): unsigned, little-endian, with an offset of 0.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CanSignal {
    /// Name in the DBC file.
    pub name: &'static str,
    /// Place of its lowest bit.
    pub start: u8,
    /// Number of bits, 1 to 8.
    pub length: u8,
    /// Physical value of a step.
    pub factor: f32,
    /// Unit of the physical value; empty without one.
    pub unit: &'static str,
    /// What it is, in one sentence.
    pub about: &'static str,
}

impl CanSignal {
    pub(super) const fn of(name: &'static str, start: u8, length: u8, about: &'static str) -> Self {
        Self { name, start, length, factor: 1.0, unit: "", about }
    }

    pub(super) const fn in_steps(self, factor: f32, unit: &'static str) -> Self {
        Self { factor, unit, ..self }
    }

    /// The largest number that the signal can have.
    #[must_use]
    pub const fn largest(&self) -> u8 {
        u8::MAX.wrapping_shr(8_u32.wrapping_sub(self.length as u32))
    }

    /// The number in a frame of these bits.
    pub(super) const fn number(&self, bits: u64) -> u8 {
        bits.wrapping_shr(self.start as u32).to_le_bytes()[0] & self.largest()
    }

    /// The bits of a number that fits.
    pub(super) const fn bits(&self, number: u8) -> u64 {
        ((number & self.largest()) as u64).wrapping_shl(self.start as u32)
    }

    /// The number of a physical value: the nearest one, and the first or last one outside the range; 0 if it is NaN.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the conversion saturates")]
    pub(super) fn steps(&self, value: f32) -> u8 {
        ((value / self.factor + 0.5) as u8).min(self.largest())
    }

    pub(super) fn physical(&self, bits: u64) -> f32 {
        f32::from(self.number(bits)) * self.factor
    }
}
