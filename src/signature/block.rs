//! What precedes a signature or an authentication code.

use super::error::SignatureError;
use super::key::{PublicKey, key_id};

/// Number of bytes between a model and the signature.
pub const HEAD: usize = 24;
/// Number of bytes of a signature with what precedes it.
pub const BLOCK: usize = HEAD + SIGNATURE;
/// Number of bytes of an Ed25519 signature.
pub(super) const SIGNATURE: usize = 64;
/// Number of bytes before an authentication code.
pub(super) const SEAL_HEAD: usize = 16;

const VERSION: u8 = 1;

/// Whether a block or a seal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Model,
    State,
}

impl Kind {
    const fn magic(self) -> [u8; 4] {
        match self {
            Self::Model => *b"BWSG",
            Self::State => *b"BWSM",
        }
    }

    const fn algorithm(self) -> u8 {
        match self {
            Self::Model => 1,
            Self::State => 2,
        }
    }

    /// The common first bytes of block and seal.
    pub(super) fn start(self, counter: u32, length: u32) -> [u8; SEAL_HEAD] {
        let ([m0, m1, m2, m3], [c0, c1, c2, c3]) = (self.magic(), counter.to_le_bytes());
        let [l0, l1, l2, l3] = length.to_le_bytes();
        [m0, m1, m2, m3, VERSION, self.algorithm(), 0, 0, c0, c1, c2, c3, l0, l1, l2, l3]
    }

    /// Reads these bytes for a content of `length` bytes; returns the counter.
    pub(super) fn read(self, start: &[u8; SEAL_HEAD], length: usize) -> Result<u32, SignatureError> {
        let [m0, m1, m2, m3, version, algorithm, .., c0, c1, c2, c3, _, _, _, _] = *start;
        if [m0, m1, m2, m3] != self.magic() {
            return Err(SignatureError::Unsigned);
        }
        if version != VERSION || algorithm != self.algorithm() {
            return Err(SignatureError::Version { given: version, supported: VERSION });
        }
        let counter = u32::from_le_bytes([c0, c1, c2, c3]);
        let length = u32::try_from(length).map_err(|_| SignatureError::Format)?;
        if *start == self.start(counter, length) { Ok(counter) } else { Err(SignatureError::Format) }
    }
}

/// The bytes between a model of `length` bytes and the signature. The private key of `key` signs the model and them;
/// the signature follows.
#[must_use]
pub fn head(length: u32, key: &PublicKey, counter: u32) -> [u8; HEAD] {
    let (start, id) = (Kind::Model.start(counter, length), key_id(key));
    let mut head = [0; HEAD];
    head.iter_mut().zip(start.iter().chain(&id)).for_each(|(cell, byte)| *cell = *byte);
    head
}
