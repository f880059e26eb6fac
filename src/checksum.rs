//! CRC-32/ISO-HDLC, that of zip and Ethernet: bit by bit, which needs no table in flash, and by a table.
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
                self.0 = shifted(self.0);
            }
        }
    }

    /// The same by a table of 1 KiB: eight times as fast, for a recorder, which sends many bytes.
    #[cfg(feature = "telemetry")]
    pub(crate) fn add_by_table(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            let [low, ..] = (self.0 ^ u32::from(byte)).to_le_bytes();
            self.0 = (self.0 >> 8) ^ TABLE.get(low as usize).copied().unwrap_or(0);
        }
    }

    /// The checksum of the bytes so far.
    pub(crate) const fn value(self) -> u32 {
        !self.0
    }
}

/// One bit further.
#[inline(always)]
const fn shifted(crc: u32) -> u32 {
    (crc >> 1) ^ (0xEDB8_8320 & 0_u32.wrapping_sub(crc & 1))
}

/// The checksums of all bytes.
#[cfg(feature = "telemetry")]
static TABLE: [u32; 256] = {
    let mut table = [0; 256];
    let (mut cells, mut byte): (&mut [u32], u32) = (&mut table, 0);
    while let [cell, later @ ..] = cells {
        let (mut crc, mut bit) = (byte, 0);
        while bit < 8 {
            (crc, bit) = (shifted(crc), bit + 1);
        }
        *cell = crc;
        (cells, byte) = (later, byte + 1);
    }
    table
};

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
        #[cfg(feature = "telemetry")]
        {
            let mut crc = Crc32::START;
            [&b"1234"[..], b"", b"56789"].iter().for_each(|part| crc.add_by_table(part));
            assert_eq!(crc.value(), 0xCBF4_3926);
        }
    }
}
