//! The authentication code of a saved state.

use core::fmt;

use hmac::{Hmac, KeyInit, Mac};
use sha2::Sha256;

use super::block::{Kind, SEAL_HEAD};
use super::error::SignatureError;

/// Number of bytes that a seal adds to a state.
pub const SEAL: usize = SEAL_HEAD + CODE;
/// Number of bytes of an authentication code.
const CODE: usize = 32;

/// The key of a drive: random, another one in each drive, and in no other use.
#[derive(Clone)]
pub struct StateKey([u8; 32]);

/// A state that was sealed with the key. It refers to the bytes that were checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sealed<'b> {
    /// The state, for [`Evidence::restore`](crate::Evidence::restore).
    pub state: &'b [u8],
    /// Its number.
    pub sequence: u32,
}

impl StateKey {
    /// A key.
    #[must_use]
    pub const fn new(key: [u8; 32]) -> Self {
        Self(key)
    }

    /// Seals the state in the first `length` bytes of the buffer; returns the number of bytes with the seal, which are
    /// [`SEAL`] more. `sequence` is the number that the record will have, or any that rises.
    ///
    /// # Errors
    /// [`SignatureError::BufferTooSmall`].
    pub fn seal(&self, buffer: &mut [u8], length: usize, sequence: u32) -> Result<usize, SignatureError> {
        let end = length.saturating_add(SEAL);
        let bytes = buffer.get_mut(..end).ok_or(SignatureError::BufferTooSmall)?;
        let stored = u32::try_from(length).map_err(|_| SignatureError::BufferTooSmall)?;
        let (content, code) = bytes.split_last_chunk_mut::<CODE>().ok_or(SignatureError::BufferTooSmall)?;
        let start = content.last_chunk_mut::<SEAL_HEAD>().ok_or(SignatureError::BufferTooSmall)?;
        *start = Kind::State.start(sequence, stored);
        *code = self.code(content).finalize().into_bytes().into();
        Ok(end)
    }

    /// Checks a state and its seal.
    ///
    /// # Errors
    /// A [`SignatureError`]: not sealed, cut short, by another key, changed, or older than accepted.
    pub fn open<'b>(&self, bytes: &'b [u8], least_sequence: u32) -> Result<Sealed<'b>, SignatureError> {
        let (content, code) = bytes.split_last_chunk::<CODE>().ok_or(SignatureError::Truncated)?;
        let (state, start) = content.split_last_chunk::<SEAL_HEAD>().ok_or(SignatureError::Truncated)?;
        let sequence = Kind::State.read(start, state.len())?;
        // In constant time, whatever the bytes.
        self.code(content).verify_slice(code).map_err(|_| SignatureError::Mismatch)?;
        if sequence < least_sequence {
            return Err(SignatureError::Older { given: sequence, least: least_sequence });
        }
        Ok(Sealed { state, sequence })
    }

    fn code(&self, content: &[u8]) -> Hmac<Sha256> {
        // A key shorter than a block of the hash is filled up with zeros (RFC 2104).
        let mut key = [0; 64];
        key.iter_mut().zip(self.0).for_each(|(cell, byte)| *cell = byte);
        Hmac::<Sha256>::new(&key.into()).chain_update(content)
    }
}

/// Without the key.
impl fmt::Debug for StateKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("StateKey")
    }
}

/// Without the key.
#[cfg(feature = "defmt")]
impl defmt::Format for StateKey {
    fn format(&self, formatter: defmt::Formatter<'_>) {
        defmt::write!(formatter, "StateKey");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    const KEY: StateKey = StateKey::new([0x5A; 32]);

    fn sealed(sequence: u32) -> Vec<u8> {
        let mut buffer = Vec::from([0; 100]);
        buffer[..52].copy_from_slice(&[7; 52]);
        let length = KEY.seal(&mut buffer, 52, sequence).unwrap();
        assert_eq!(length, 100);
        buffer
    }

    #[test]
    fn code_is_that_of_rfc_4231() {
        let mut key = [0; 32];
        key[..4].copy_from_slice(b"Jefe");
        let code = StateKey::new(key).code(b"what do ya want for nothing?").finalize().into_bytes();
        let hexadecimal: std::string::String = code.iter().map(|byte| std::format!("{byte:02x}")).collect();
        assert_eq!(hexadecimal, "5bdcc146bf60754e6a042426089575c75a003f089d2739839dec58b964ec3843");
    }

    #[test]
    fn a_sealed_state_opens_and_every_changed_bit_is_refused() {
        let good = sealed(9);
        assert_eq!(KEY.open(&good, 9), Ok(Sealed { state: &[7; 52], sequence: 9 }));
        for bit in 0..8 * good.len() {
            let mut bytes = good.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            assert!(KEY.open(&bytes, 0).is_err(), "bit {bit}");
        }
        for length in 0..good.len() {
            assert!(KEY.open(&good[..length], 0).is_err(), "{length} bytes");
        }
        let longer: Vec<u8> = good.iter().copied().chain([0]).collect();
        assert_eq!(KEY.open(&longer, 0), Err(SignatureError::Unsigned));
    }

    #[test]
    fn older_states_and_other_keys_are_refused() {
        let older = Err(SignatureError::Older { given: 9, least: 10 });
        assert_eq!(KEY.open(&sealed(9), 10), older);
        assert_eq!(KEY.open(&sealed(u32::MAX), u32::MAX).map(|sealed| sealed.sequence), Ok(u32::MAX));
        assert_eq!(StateKey::new([0x5B; 32]).open(&sealed(9), 0), Err(SignatureError::Mismatch));
    }

    #[test]
    fn a_small_buffer_and_a_version_are_refused() {
        let mut small = [0; SEAL + 9];
        assert_eq!(KEY.seal(&mut small, 10, 1), Err(SignatureError::BufferTooSmall));
        assert_eq!(KEY.seal(&mut small, usize::MAX, 1), Err(SignatureError::BufferTooSmall));
        assert_eq!(KEY.seal(&mut small, 9, 1), Ok(SEAL + 9));
        let mut other = sealed(9);
        other[56] = 2;
        assert_eq!(KEY.open(&other, 0), Err(SignatureError::Version { given: 2, supported: 1 }));
        assert!(!std::format!("{KEY:?}").contains("90"), "the key is not printed");
    }
}
