//! Why a record could not be stored or loaded.

use core::fmt;

/// An error of the storage; `E` is that of the flash.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum StorageError<E> {
    /// The flash reports an error. In a store, the older record is still there.
    Flash(E),
    /// Start or size of a slot is not a multiple of an erasure, the pair exceeds the flash, a slot has no room for a
    /// payload, or `PAGE` is smaller than a header or a write.
    Geometry,
    /// The payload is longer than a slot has room for.
    TooLong {
        /// Number of bytes that a slot has room for.
        capacity: u32,
    },
    /// The buffer is shorter than the payload of the record.
    BufferTooSmall {
        /// Number of bytes of the payload.
        needed: u32,
    },
    /// What was read back is not what was written: the flash is worn, or is not erased. The older record is still
    /// there.
    NotWritten,
    /// No slot has a record of this kind that is good and accepted.
    NoRecord,
}

impl<E> StorageError<E> {
    /// The error in words.
    #[must_use]
    pub const fn message(&self) -> &'static str {
        match self {
            Self::Flash(_) => "the flash reports an error",
            Self::Geometry => "the slots do not fit the flash, or the page buffer is too small",
            Self::TooLong { .. } => "the payload is longer than a slot",
            Self::BufferTooSmall { .. } => "the buffer is shorter than the record",
            Self::NotWritten => "the flash did not take what was written",
            Self::NoRecord => "there is no good record",
        }
    }
}

impl<E: fmt::Debug> fmt::Display for StorageError<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Flash(error) => write!(f, "the flash reports {error:?}"),
            Self::TooLong { capacity } => write!(f, "the payload is longer than the {capacity} bytes of a slot"),
            Self::BufferTooSmall { needed } => write!(f, "the record has {needed} bytes, more than the buffer"),
            other => f.write_str(other.message()),
        }
    }
}

impl<E: fmt::Debug> core::error::Error for StorageError<E> {}
