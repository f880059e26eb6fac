//! The state of alarm and baseline as bytes, so that they survive power-off.
//!
//! ```text
//! "BWST"  version u16  flags u16  words u32  model u32  words  CRC-32 u32        little-endian
//! words   segments, undetermined, those of the run; cause and segment of the alarm; scores; support; sums of the trend
//!         whether the baseline reached its bound; its offset, one word a coordinate
//! ```
//!
//! The number of bytes depends on the plan only. Bytes of another model, by [`Model::id`], are refused: scores and
//! offset are relative to its healthy class. The bytes do not contain the open segment, which is lost at power-off, nor
//! do they end the run: call [`Evidence::end_run`] before saving at power-down, where a run is from power-up to
//! power-up.
//!
//! Store the bytes by [`crate::storage`], or by any other means.

use core::fmt;

use crate::checksum::crc32;
use crate::decide::{Baseline, Evidence};
use crate::model::Model;
use crate::plan::Plan;

const MAGIC: [u8; 4] = *b"BWST";
const VERSION: u16 = 1;
const HEADER: usize = 16;
/// Flag: there is a baseline.
const WITH_BASELINE: u16 = 1;

/// Why a state is not saved or restored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum StateError {
    /// The buffer is too small: see [`Model::saved_len`].
    BufferTooSmall,
    /// The bytes are not a saved state.
    NotAState,
    /// The bytes are a state of another format version.
    Version {
        /// Version of the bytes.
        found: u16,
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
        own: u32,
    },
    /// A value is not a number, or none that this state can have.
    Value,
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
        }
    }
}

impl fmt::Display for StateError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Version { found, supported } => {
                write!(f, "state format version {found}, but this build reads version {supported}")
            }
            other => f.write_str(other.message()),
        }
    }
}

impl core::error::Error for StateError {}

impl<P: Plan> Model<P> {
    /// Number of bytes of a saved state, with or without a baseline.
    #[must_use]
    pub fn saved_len(&self) -> usize {
        self.words().saturating_mul(4).saturating_add(HEADER + 4)
    }

    fn words(&self) -> usize {
        let layout = self.plan().layout();
        Evidence::<P>::words(layout.classes).saturating_add(Baseline::<P>::words(layout.coordinates))
    }

    /// Writes evidence, with alarm and trend, and a baseline, if there is one, into `buffer`; returns the number of
    /// bytes, [`Model::saved_len`]. Cost: a checksum over the state, and [`Model::id`].
    ///
    /// # Errors
    /// [`StateError::BufferTooSmall`].
    pub fn save(
        &self,
        evidence: &Evidence<P>,
        baseline: Option<&Baseline<P>>,
        buffer: &mut [u8],
    ) -> Result<usize, StateError> {
        let length = self.saved_len();
        let bytes = buffer.get_mut(..length).ok_or(StateError::BufferTooSmall)?;
        let (content, check) = bytes.split_last_chunk_mut().ok_or(StateError::BufferTooSmall)?;
        let (header, words) = content.split_first_chunk_mut().ok_or(StateError::BufferTooSmall)?;
        *header = self.header(if baseline.is_some() { WITH_BASELINE } else { 0 }, self.id());
        words.fill(0);
        let mut places = words.as_chunks_mut::<4>().0.iter_mut();
        let mut put = |word: u32| {
            if let Some(place) = places.next() {
                *place = word.to_le_bytes();
            }
        };
        evidence.save(&mut put);
        if let Some(baseline) = baseline {
            baseline.save(&mut put);
        }
        *check = crc32(content).to_le_bytes();
        Ok(length)
    }

    /// Continues from a saved state of this model. A baseline remains as it is if none was saved. Nothing changes in
    /// case of an error.
    ///
    /// # Errors
    /// A [`StateError`]: not a state, of another version, length or model, corrupted, or with a value out of range.
    pub fn restore(
        &self,
        bytes: &[u8],
        evidence: &mut Evidence<P>,
        baseline: Option<&mut Baseline<P>>,
    ) -> Result<(), StateError> {
        let (words, flags) = self.open(bytes)?;
        let mut words = words.as_chunks::<4>().0.iter().map(|word| u32::from_le_bytes(*word));
        let mut take = || words.next();
        let mut own = self.evidence();
        own.restore(&mut take).ok_or(StateError::Value)?;
        if let (Some(baseline), WITH_BASELINE) = (baseline, flags) {
            let mut followed = baseline.clone();
            followed.restore_words(&mut take).ok_or(StateError::Value)?;
            *baseline = followed;
        }
        *evidence = own;
        Ok(())
    }

    fn header(&self, flags: u16, model: u32) -> [u8; HEADER] {
        let mut header = [0; HEADER];
        let words = u32::try_from(self.words()).unwrap_or(u32::MAX).to_le_bytes();
        let (version, flags, model) = (VERSION.to_le_bytes(), flags.to_le_bytes(), model.to_le_bytes());
        let fields: [&[u8]; 5] = [&MAGIC, &version, &flags, &words, &model];
        header.iter_mut().zip(fields.into_iter().flatten()).for_each(|(cell, byte)| *cell = *byte);
        header
    }

    /// Checks the frame; returns words and flags.
    fn open<'a>(&self, bytes: &'a [u8]) -> Result<(&'a [u8], u16), StateError> {
        let (magic, rest) = bytes.split_first_chunk::<4>().ok_or(StateError::NotAState)?;
        if *magic != MAGIC {
            return Err(StateError::NotAState);
        }
        let (found, _) = rest.split_first_chunk::<2>().ok_or(StateError::Truncated)?;
        let found = u16::from_le_bytes(*found);
        if found != VERSION {
            return Err(StateError::Version { found, supported: VERSION });
        }
        let (content, check) = bytes.split_last_chunk::<4>().ok_or(StateError::Truncated)?;
        if crc32(content) != u32::from_le_bytes(*check) {
            // A state that is too short has no checksum where it ends.
            return Err(if bytes.len() == self.saved_len() { StateError::Checksum } else { StateError::Truncated });
        }
        let (header, words) = content.split_first_chunk::<HEADER>().ok_or(StateError::Truncated)?;
        let [.., f0, f1, _, _, _, _, m0, m1, m2, m3] = *header;
        let (saved, own, flags) = (u32::from_le_bytes([m0, m1, m2, m3]), self.id(), u16::from_le_bytes([f0, f1]));
        if saved != own {
            return Err(StateError::OtherModel { saved, own });
        }
        if *header != self.header(flags, own) || bytes.len() != self.saved_len() {
            return Err(StateError::Truncated);
        }
        if flags > WITH_BASELINE { Err(StateError::Value) } else { Ok((words, flags)) }
    }
}
