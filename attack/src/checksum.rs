//! The checksum of models, states, records and frames, so that attacks reach what is behind it.

use crc::{CRC_32_ISO_HDLC, Crc};

const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// The checksum of bytes.
#[must_use]
pub fn of(bytes: &[u8]) -> u32 {
    CRC.checksum(bytes)
}

/// Makes the last four bytes the checksum of those before them.
pub fn put(bytes: &mut [u8]) {
    if let Some((content, check)) = bytes.split_last_chunk_mut() {
        *check = of(content).to_le_bytes();
    }
}
