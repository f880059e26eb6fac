//! The state of the alarm as bytes, so that it survives power-off.
//!
//! ```text
//! "BWST"  version u16  0 u16  words u32  model u32  words  CRC-32 u32        little-endian
//! words   segments, undetermined, those of the run; cause and segment of the alarm; scores; support
//!         segments since the last verdict, and why they have none; what raised the alarm
//!         runs learned, and of each direction the run, the drive's mean, scores and onsets, alarms denied, and level
//!         and slope of the size with their covariance
//! ```
//!
//! The number of bytes depends on the plan only. Bytes of another model, by [`Model::id`], are refused: scores are
//! relative to its healthy class. So are numbers that segments of this model cannot leave: under a good checksum they
//! come from a program that differs from this one. The bytes do not contain the open segment, which is lost at
//! power-off, nor do they end the run: call [`Evidence::end_run`] before saving at power-down, where a run is from
//! power-up to power-up.
//!
//! Store the bytes by [`crate::storage`], or by any other means.

use crate::alarm::{Evidence, StateError};
use crate::checksum::crc32;
use crate::model::Model;
use crate::plan::Plan;

const MAGIC: [u8; 4] = *b"BWST";
const VERSION: u16 = 4;
const HEADER: usize = 16;

impl<P: Plan> Evidence<P> {
    /// Number of bytes of a saved state.
    #[must_use]
    pub fn saved_len(model: &Model<P>) -> usize {
        Self::words(&model.plan().layout()).saturating_mul(4).saturating_add(HEADER + 4)
    }

    /// Writes this evidence of a model, with its alarm, into `buffer`; returns the number of bytes,
    /// [`Evidence::saved_len`]. Cost: a checksum over the state.
    ///
    /// # Errors
    /// [`StateError::BufferTooSmall`].
    pub fn save(&self, model: &Model<P>, buffer: &mut [u8]) -> Result<usize, StateError> {
        let length = Self::saved_len(model);
        let bytes = buffer.get_mut(..length).ok_or(StateError::BufferTooSmall)?;
        let (content, check) = bytes.split_last_chunk_mut().ok_or(StateError::BufferTooSmall)?;
        let (start, words) = content.split_first_chunk_mut().ok_or(StateError::BufferTooSmall)?;
        *start = header(model);
        let mut places = words.as_chunks_mut::<4>().0.iter_mut();
        self.save_words(&mut |word| {
            if let Some(place) = places.next() {
                *place = word.to_le_bytes();
            }
        });
        *check = crc32(content).to_le_bytes();
        Ok(length)
    }

    /// Continues from a saved state of this model. Nothing changes in case of an error.
    ///
    /// # Errors
    /// A [`StateError`]: not a state, of another version, length or model, corrupted, or with a value that this state
    /// cannot have.
    pub fn restore(&mut self, model: &Model<P>, bytes: &[u8]) -> Result<(), StateError> {
        let words = open(model, bytes)?;
        let mut words = words.as_chunks::<4>().0.iter().map(|word| u32::from_le_bytes(*word));
        // The limits of a silence are those of the program.
        let mut restored = Self::new(model).limited_as(self);
        restored.restore_words(&mut || words.next()).ok_or(StateError::Value)?;
        *self = restored;
        Ok(())
    }
}

fn header<P: Plan>(model: &Model<P>) -> [u8; HEADER] {
    let mut header = [0; HEADER];
    let words = u32::try_from(Evidence::<P>::words(&model.plan().layout())).unwrap_or(u32::MAX);
    let (version, words, model) = (VERSION.to_le_bytes(), words.to_le_bytes(), model.id().to_le_bytes());
    let fields: [&[u8]; 5] = [&MAGIC, &version, &[0; 2], &words, &model];
    header.iter_mut().zip(fields.into_iter().flatten()).for_each(|(cell, byte)| *cell = *byte);
    header
}

/// Checks the frame of a state of this model; returns its words.
fn open<'a, P: Plan>(model: &Model<P>, bytes: &'a [u8]) -> Result<&'a [u8], StateError> {
    let (magic, later) = bytes.split_first_chunk::<4>().ok_or(StateError::NotAState)?;
    if *magic != MAGIC {
        return Err(StateError::NotAState);
    }
    let (version, _) = later.split_first_chunk::<2>().ok_or(StateError::Truncated)?;
    let given = u16::from_le_bytes(*version);
    if given != VERSION {
        return Err(StateError::Version { given, supported: VERSION });
    }
    let (content, check) = bytes.split_last_chunk::<4>().ok_or(StateError::Truncated)?;
    let fits = bytes.len() == Evidence::saved_len(model);
    if crc32(content) != u32::from_le_bytes(*check) {
        // A state that is too short has no checksum where it ends.
        return Err(if fits { StateError::Checksum } else { StateError::Truncated });
    }
    let (start, words) = content.split_first_chunk::<HEADER>().ok_or(StateError::Truncated)?;
    let [.., m0, m1, m2, m3] = *start;
    let (saved, expected) = (u32::from_le_bytes([m0, m1, m2, m3]), model.id());
    if saved != expected {
        return Err(StateError::OtherModel { saved, expected });
    }
    if *start == header(model) && fits { Ok(words) } else { Err(StateError::Truncated) }
}

#[cfg(test)]
mod tests;
