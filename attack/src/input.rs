//! Bytes of an attack → numbers, choices and calls.
//!
//! An input that has ended gives zeros, so that every input is a whole attack and a longer one only adds to it.

use arbitrary::Unstructured;

/// The bytes that are left of an input.
#[derive(Debug)]
pub struct Input<'a>(Unstructured<'a>);

impl<'a> Input<'a> {
    /// All of the bytes.
    #[must_use]
    pub fn new(bytes: &'a [u8]) -> Self {
        Self(Unstructured::new(bytes))
    }

    /// Whether nothing is left.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// So many bytes; zeros where the input has ended.
    pub fn array<const N: usize>(&mut self) -> [u8; N] {
        let mut bytes = [0; N];
        // Fills with zeros beyond the end, and then cannot fail.
        let _never = self.0.fill_buffer(&mut bytes);
        bytes
    }

    /// One byte.
    pub fn byte(&mut self) -> u8 {
        let [byte] = self.array();
        byte
    }

    /// A number of 16 bits.
    pub fn half(&mut self) -> u16 {
        u16::from_le_bytes(self.array())
    }

    /// A number of 32 bits.
    pub fn word(&mut self) -> u32 {
        u32::from_le_bytes(self.array())
    }

    /// A number below `count`, which is at most 256.
    pub fn below(&mut self, count: usize) -> usize {
        usize::from(self.byte()) % count.max(1)
    }

    /// At most `most` bytes.
    pub fn bytes(&mut self, most: usize) -> &'a [u8] {
        let count = most.min(self.0.len());
        self.0.bytes(count).unwrap_or_default()
    }

    /// A number of any bits; about half of them are ordinary.
    pub fn number(&mut self) -> f32 {
        match self.byte() % 20 {
            0 => f32::NAN,
            1 => f32::INFINITY,
            2 => f32::NEG_INFINITY,
            3 => f32::from_bits(self.word() & 0x007F_FFFF),
            4 => f32::MAX,
            5 => f32::MIN,
            6 => -0.0,
            7 => f32::MIN_POSITIVE,
            8 | 9 => f32::from_bits(self.word()),
            _ => f32::from(self.half().cast_signed()) / 1024.0,
        }
    }
}
