//! Where the bytes of a frame go: into its checksum, and without zeros into a buffer.

use core::fmt;

use cobs::CobsEncoder;
use postcard::ser_flavors::Flavor;
use serde::Serialize;

use crate::checksum::Crc32;

/// The buffer is too small for the frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TooSmall;

impl fmt::Display for TooSmall {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the buffer is too small for the frame")
    }
}

impl core::error::Error for TooSmall {}

/// The CRC-32 of bytes.
pub(super) fn checksum(bytes: &[u8]) -> u32 {
    let mut crc = Crc32::START;
    crc.add_by_table(bytes);
    crc.value()
}

/// A checksum, and a frame under construction or none.
pub(super) struct Sink<'a> {
    crc: Crc32,
    frame: Option<CobsEncoder<'a>>,
}

impl<'a> Sink<'a> {
    /// The checksum alone.
    pub fn sum() -> Self {
        Self { crc: Crc32::START, frame: None }
    }

    /// A frame in this buffer.
    pub fn frame(buffer: &'a mut [u8]) -> Self {
        Self { crc: Crc32::START, frame: Some(CobsEncoder::new(buffer)) }
    }

    pub fn fields(&mut self, fields: &impl Serialize) -> Result<(), TooSmall> {
        postcard::serialize_with_flavor(fields, self).map_err(|_| TooSmall)
    }

    pub fn bytes(&mut self, bytes: &[u8]) -> Result<(), TooSmall> {
        self.crc.add_by_table(bytes);
        self.frame.as_mut().map_or(Ok(()), |frame| frame.push(bytes).map_err(|_| TooSmall))
    }

    pub fn number(&mut self, x: f32) -> Result<(), TooSmall> {
        self.bytes(&x.to_le_bytes())
    }

    /// The text and a zero byte.
    pub fn text(&mut self, text: &str) -> Result<(), TooSmall> {
        self.bytes(text.as_bytes())?;
        self.bytes(&[0])
    }

    /// The checksum so far.
    pub fn checksum(&self) -> u32 {
        self.crc.value()
    }

    /// Appends the checksum; returns the length of the frame without its last byte, a zero.
    pub fn close(mut self) -> Result<usize, TooSmall> {
        self.bytes(&self.checksum().to_le_bytes())?;
        Ok(self.frame.map_or(0, CobsEncoder::finalize))
    }
}

impl Flavor for &mut Sink<'_> {
    type Output = ();

    fn try_push(&mut self, byte: u8) -> postcard::Result<()> {
        self.try_extend(&[byte])
    }

    fn try_extend(&mut self, bytes: &[u8]) -> postcard::Result<()> {
        self.bytes(bytes).map_err(|TooSmall| postcard::Error::SerializeBufferFull)
    }

    fn finalize(self) -> postcard::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crc_check_value() {
        assert_eq!(checksum(b"123456789"), 0xCBF4_3926);
    }

    #[test]
    fn zeros_are_stuffed_by_hand() {
        let mut buffer = [9; 16];
        let mut sink = Sink::frame(&mut buffer);
        sink.bytes(&[0x11, 0x22, 0x00, 0x33]).unwrap();
        let check = sink.checksum().to_le_bytes();
        assert!(check.iter().all(|byte| *byte != 0), "{check:?}");
        assert_eq!(sink.close(), Ok(9));
        assert_eq!(buffer[..5], [3, 0x11, 0x22, 6, 0x33]);
        assert_eq!(buffer[5..9], check);
    }
}
