//! Why a signed model or a sealed state is refused.

use core::fmt;

use crate::model::ModelError;

/// Why bytes are refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SignatureError {
    /// The bytes do not start with a model.
    Model(ModelError),
    /// No signature follows the model, or no seal the state.
    Unsigned,
    /// Format version or algorithm is none that this build reads.
    Version {
        /// Version of the bytes.
        given: u8,
        /// Version that this build reads.
        supported: u8,
    },
    /// A field does not fit the bytes: another length, or reserved bytes that are not zero.
    Format,
    /// There are fewer bytes than a signature has.
    Truncated,
    /// No accepted key has the id of the signature.
    UnknownKey,
    /// Signature or authentication code is not that of these bytes by this key.
    Mismatch,
    /// The counter, or the sequence, is older than accepted.
    Older {
        /// Counter or sequence of the bytes.
        given: u32,
        /// The least one that is accepted.
        least: u32,
    },
    /// The buffer is too small for state and seal.
    BufferTooSmall,
}

impl SignatureError {
    /// The error in words.
    #[must_use]
    pub const fn message(&self) -> &'static str {
        match self {
            Self::Model(error) => error.message(),
            Self::Unsigned => "there is no signature",
            Self::Version { .. } => "the signature has another format version or algorithm",
            Self::Format => "a field of the signature does not fit the bytes before it",
            Self::Truncated => "the signature is cut short",
            Self::UnknownKey => "the key of the signature is not accepted",
            Self::Mismatch => "the signature is not that of these bytes",
            Self::Older { .. } => "older than accepted",
            Self::BufferTooSmall => "the buffer is too small for the seal",
        }
    }
}

impl fmt::Display for SignatureError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Model(error) => error.fmt(f),
            Self::Older { given, least } => {
                write!(f, "older than accepted: the counter is {given}, the least accepted one {least}")
            }
            other => f.write_str(other.message()),
        }
    }
}

impl core::error::Error for SignatureError {}
