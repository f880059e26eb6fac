//! Why the state of the alarm is not saved or restored.

use core::fmt;

/// Why a state is not saved or restored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum StateError {
    /// The buffer is too small: see [`Evidence::saved_len`](crate::Evidence::saved_len).
    BufferTooSmall,
    /// The bytes are not a saved state.
    NotAState,
    /// The bytes are a state of another format version.
    Version {
        /// Version of the bytes.
        given: u16,
        /// Version that this build reads.
        supported: u16,
    },
    /// There are fewer or more bytes than this plan has.
    Truncated,
    /// The checksum does not match the content.
    Checksum,
    /// The state is that of another model.
    OtherModel {
        /// Id of the model of the state.
        saved: u32,
        /// Id of this model.
        expected: u32,
    },
    /// A value is not a number, or none that this state can have.
    Value,
    /// A `Watch` has not started, or another context works on its monitor.
    Unavailable,
}

impl StateError {
    /// The error in words.
    #[must_use]
    pub const fn message(&self) -> &'static str {
        match self {
            Self::BufferTooSmall => "the buffer is too small for the state",
            Self::NotAState => "these bytes are not a saved state",
            Self::Version { .. } => "the state has another format version",
            Self::Truncated => "the state has fewer or more bytes than this plan has",
            Self::Checksum => "the checksum of the state does not match",
            Self::OtherModel { .. } => "the state is that of another model",
            Self::Value => "a value of the state is out of range",
            Self::Unavailable => "there is no monitor yet, or another context works on it",
        }
    }
}

impl fmt::Display for StateError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Version { given, supported } => {
                write!(f, "state format version {given}, but this build reads version {supported}")
            }
            other => f.write_str(other.message()),
        }
    }
}

impl core::error::Error for StateError {}
