//! The state of alarm and baseline as bytes, so that they survive power-off.
//!
//! ```text
//! "BWST"  version u16  flags u16  words u32  model u32  words  CRC-32 u32        little-endian
//! words   segments, undetermined, those of the run; cause and segment of the alarm; scores; support; sums of the trend
//!         whether the baseline reached its bound; its offset, one word a coordinate
//!         older sums of the trend; segments since the last verdict, and why they have none; constants of the baseline
//!         what raised the alarm; runs learned, and of each direction the run, the drive's mean, scores and onsets,
//!         alarms denied, and level and slope of the size with their covariance
//! ```
//!
//! The number of bytes depends on the plan only. Versions 1 and 2, without the last lines, are read too. Bytes of
//! another model, by [`Model::id`], are refused: scores and offset are relative to its healthy class. So are those of a
//! baseline with other constants, and numbers that segments of this model cannot leave: under a good checksum they come
//! from a program that differs from this one. The bytes do not contain the open segment, which is lost at power-off,
//! nor do they end the run: call [`Evidence::end_run`] before saving at power-down, where a run is from power-up to
//! power-up.
//!
//! Store the bytes by [`crate::storage`], or by any other means.

use crate::alarm::baseline::{Baseline, BaselineConstants, BaselineMismatch};
use crate::alarm::{Evidence, StateError};
use crate::checksum::crc32;
use crate::model::Model;
use crate::plan::{Layout, Plan};

const MAGIC: [u8; 4] = *b"BWST";
const VERSION: u16 = 3;
/// That of models without directions, without the last line.
const SECOND_VERSION: u16 = 2;
/// The version without the last two lines.
const FIRST_VERSION: u16 = 1;
const HEADER: usize = 16;
/// Flag: there is a baseline.
const WITH_BASELINE: u16 = 1;

impl<P: Plan> Evidence<P> {
    /// Number of bytes of a saved state, with or without a baseline.
    #[must_use]
    pub fn saved_len(model: &Model<P>) -> usize {
        let layout = model.plan().layout();
        let words = words_of::<P>(&layout, version_of(&layout)).unwrap_or(0);
        words.saturating_mul(4).saturating_add(HEADER + 4)
    }

    /// Writes this evidence of a model, with alarm and trend, and a baseline, if there is one, into `buffer`; returns
    /// the number of bytes, [`Evidence::saved_len`]. Cost: a checksum over the state, and [`Model::id`].
    ///
    /// # Errors
    /// [`StateError::BufferTooSmall`].
    pub fn save(
        &self,
        model: &Model<P>,
        baseline: Option<&Baseline<P>>,
        buffer: &mut [u8],
    ) -> Result<usize, StateError> {
        let layout = model.plan().layout();
        let (version, length) = (version_of(&layout), Self::saved_len(model));
        let bytes = buffer.get_mut(..length).ok_or(StateError::BufferTooSmall)?;
        let (content, check) = bytes.split_last_chunk_mut().ok_or(StateError::BufferTooSmall)?;
        let (start, words) = content.split_first_chunk_mut().ok_or(StateError::BufferTooSmall)?;
        *start = header::<P>(&layout, version, if baseline.is_some() { WITH_BASELINE } else { 0 }, model.id());
        words.fill(0);
        let mut places = words.as_chunks_mut::<4>().0.iter_mut();
        let mut put = |word: u32| {
            if let Some(place) = places.next() {
                *place = word.to_le_bytes();
            }
        };
        self.save_first(&mut put);
        match baseline {
            Some(baseline) => baseline.save(&mut put),
            None => (0..Baseline::<P>::words(layout.coordinates)).for_each(|_| put(0)),
        }
        self.save_second(&mut put);
        match baseline {
            Some(baseline) => baseline.save_constants(&mut put),
            None => (0..Baseline::<P>::LATER_WORDS).for_each(|_| put(0)),
        }
        if version == VERSION {
            self.save_third(&mut put);
        }
        *check = crc32(content).to_le_bytes();
        Ok(length)
    }

    /// Continues from a saved state of this model. A baseline remains as it is if none was saved; one that was saved is
    /// ignored by a program that has none. Nothing changes in case of an error.
    ///
    /// # Errors
    /// A [`StateError`]: not a state, of another version, length, model or baseline, corrupted, or with a value that
    /// this state cannot have.
    pub fn restore(
        &mut self,
        model: &Model<P>,
        bytes: &[u8],
        baseline: Option<&mut Baseline<P>>,
    ) -> Result<(), StateError> {
        let Opened { words, flags, version } = open(model, bytes)?;
        let mut words = words.as_chunks::<4>().0.iter().map(|word| u32::from_le_bytes(*word));
        let mut take = || words.next();
        // The limits of a silence are those of the program.
        let mut restored = Self::new(model).limited_as(self);
        restored.restore_first(&mut take).ok_or(StateError::Value)?;
        let given = baseline.as_deref();
        let mut followed = (flags == WITH_BASELINE).then(|| given.cloned().or_else(|| any_baseline(model))).flatten();
        match &mut followed {
            Some(followed) => followed.restore_words(&mut take).ok_or(StateError::Value)?,
            None => zeros(&mut take, Baseline::<P>::words(model.plan().layout().coordinates))?,
        }
        if version > FIRST_VERSION {
            restored.restore_second(&mut take).ok_or(StateError::Value)?;
            match &followed {
                Some(followed) => constants(followed, given.is_some(), &mut take)?,
                None => zeros(&mut take, Baseline::<P>::LATER_WORDS)?,
            }
        }
        if version > SECOND_VERSION {
            restored.restore_third(&mut take).ok_or(StateError::Value)?;
        }
        if !restored.is_plausible() {
            return Err(StateError::Value);
        }
        if let (Some(baseline), Some(followed)) = (baseline, followed) {
            *baseline = followed;
        }
        *self = restored;
        Ok(())
    }
}

/// The version of a state of a model of this layout.
const fn version_of(layout: &Layout) -> u16 {
    if layout.directions > 0 { VERSION } else { SECOND_VERSION }
}

/// Number of words of a version; `None` for one that is not read.
fn words_of<P: Plan>(layout: &Layout, version: u16) -> Option<usize> {
    let first = Evidence::<P>::words(layout.classes).saturating_add(Baseline::<P>::words(layout.coordinates));
    match version {
        FIRST_VERSION => Some(first),
        SECOND_VERSION | VERSION if version <= version_of(layout) => {
            let second = first.saturating_add(Evidence::<P>::SECOND_WORDS + Baseline::<P>::LATER_WORDS);
            let third = if version == VERSION { Evidence::<P>::third_words(layout.directions) } else { 0 };
            Some(second.saturating_add(third))
        }
        _ => None,
    }
}

/// A baseline that accepts every offset that any one has, to check one that is not used.
fn any_baseline<P: Plan>(model: &Model<P>) -> Option<Baseline<P>> {
    Baseline::new(model, BaselineConstants::WIDEST)
}

fn header<P: Plan>(layout: &Layout, version: u16, flags: u16, model: u32) -> [u8; HEADER] {
    let mut header = [0; HEADER];
    let words = words_of::<P>(layout, version).and_then(|words| u32::try_from(words).ok());
    let words = words.unwrap_or(u32::MAX).to_le_bytes();
    let (version, flags, model) = (version.to_le_bytes(), flags.to_le_bytes(), model.to_le_bytes());
    let fields: [&[u8]; 5] = [&MAGIC, &version, &flags, &words, &model];
    header.iter_mut().zip(fields.into_iter().flatten()).for_each(|(cell, byte)| *cell = *byte);
    header
}

/// Checks the frame of a state of this model.
fn open<'a, P: Plan>(model: &Model<P>, bytes: &'a [u8]) -> Result<Opened<'a>, StateError> {
    let layout = model.plan().layout();
    let (magic, later) = bytes.split_first_chunk::<4>().ok_or(StateError::NotAState)?;
    if *magic != MAGIC {
        return Err(StateError::NotAState);
    }
    let (version, _) = later.split_first_chunk::<2>().ok_or(StateError::Truncated)?;
    let version = u16::from_le_bytes(*version);
    let unsupported = StateError::Version { given: version, supported: version_of(&layout) };
    let length = words_of::<P>(&layout, version).ok_or(unsupported)?.saturating_mul(4).saturating_add(HEADER + 4);
    let (content, check) = bytes.split_last_chunk::<4>().ok_or(StateError::Truncated)?;
    if crc32(content) != u32::from_le_bytes(*check) {
        // A state that is too short has no checksum where it ends.
        return Err(if bytes.len() == length { StateError::Checksum } else { StateError::Truncated });
    }
    let (start, words) = content.split_first_chunk::<HEADER>().ok_or(StateError::Truncated)?;
    let [.., f0, f1, _, _, _, _, m0, m1, m2, m3] = *start;
    let (saved, expected, flags) = (u32::from_le_bytes([m0, m1, m2, m3]), model.id(), u16::from_le_bytes([f0, f1]));
    if saved != expected {
        return Err(StateError::OtherModel { saved, expected });
    }
    if *start != header::<P>(&layout, version, flags, expected) || bytes.len() != length {
        return Err(StateError::Truncated);
    }
    if flags > WITH_BASELINE { Err(StateError::Value) } else { Ok(Opened { words, flags, version }) }
}

/// The words of a state, with flags and version of its header.
struct Opened<'a> {
    words: &'a [u8],
    flags: u16,
    version: u16,
}

/// Takes words that have no meaning in this state.
fn zeros(take: &mut impl FnMut() -> Option<u32>, count: usize) -> Result<(), StateError> {
    let unused = (0..count).all(|_| take() == Some(0));
    if unused { Ok(()) } else { Err(StateError::Value) }
}

/// Takes the constants of a baseline; if it is `used`, they must be its own.
fn constants<P: Plan>(
    baseline: &Baseline<P>,
    used: bool,
    take: &mut impl FnMut() -> Option<u32>,
) -> Result<(), StateError> {
    match baseline.check_constants(take) {
        Err(BaselineMismatch::Value) => Err(StateError::Value),
        Err(BaselineMismatch::Constants) if used => Err(StateError::OtherBaseline),
        Ok(()) | Err(BaselineMismatch::Constants) => Ok(()),
    }
}

#[cfg(test)]
mod tests;
