//! CRC-32/ISO-HDLC, that of zip and Ethernet, bit by bit: it needs no table in flash.
//!
//! It changes for every burst of up to 32 bits, so each corrupted byte is found; other corruption passes with a
//! probability of 2⁻³².

/// A checksum over bytes that come in parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Crc32(u32);

impl Crc32 {
    pub(crate) const START: Self = Self(u32::MAX);

    /// Takes the next bytes.
    pub(crate) fn add(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 ^= u32::from(byte);
            for _ in 0..8 {
                self.0 = (self.0 >> 1) ^ (0xEDB8_8320 & 0_u32.wrapping_sub(self.0 & 1));
            }
        }
    }

    /// The checksum of the bytes so far.
    pub(crate) const fn value(self) -> u32 {
        !self.0
    }
}

/// The checksum of these bytes.
pub(crate) fn crc32(bytes: &[u8]) -> u32 {
    let mut crc = Crc32::START;
    crc.add(bytes);
    crc.value()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn check_value_at_once_and_in_parts() {
        assert_eq!(crc32(b"123456789"), 0xCBF4_3926);
        let mut crc = Crc32::START;
        [&b"1234"[..], b"", b"56789"].iter().for_each(|part| crc.add(part));
        assert_eq!(crc.value(), 0xCBF4_3926);
    }
}
