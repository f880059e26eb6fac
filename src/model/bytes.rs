//! The model as bytes, for drives that load it at run time, and for files.
//!
//! ```text
//! "BWMD"  version u16  flags u16  payload length u32  notes length u32  payload  notes  CRC-32 u32
//! ```
//!
//! Little-endian. The CRC (ISO-HDLC, that of zip and Ethernet) covers everything before it. It changes for every burst
//! of up to 32 bits, so each corrupted byte is found. The payload starts with the layout, and a plan reads only models
//! of its own layout. The notes are text for people and tools (preparation, training set); the firmware ignores them.

use super::reader::{read, read_layout};
use super::stored::put;
use super::{Model, ModelError};
use crate::checksum::crc32;
use crate::plan::{Layout, Load, Plan};
use crate::record::{Fault, Field, Input, Output};

const MAGIC: [u8; 4] = *b"BWMD";
/// The newest version that is read, which models with a weight on an axis have; all others have the one before.
const VERSION: u16 = 12;
const WITHOUT_WEIGHT: u16 = 11;
const HEADER: usize = 16;
/// Largest length of payload and of notes; a length field beyond it is corruption.
pub const MAX_BYTES: usize = 1 << 20;

/// Number of bytes of the model that these bytes start with, so that a flash sector with an erased tail can be read.
///
/// # Errors
/// [`ModelError::NotAModel`], [`ModelError::Version`], or [`ModelError::Truncated`] if the header asks for more bytes.
pub fn stored_len(bytes: &[u8]) -> Result<usize, ModelError> {
    let (payload, notes) = header(bytes)?;
    let length = HEADER.saturating_add(payload).saturating_add(notes).saturating_add(4);
    if length <= bytes.len() { Ok(length) } else { Err(ModelError::Truncated) }
}

/// The notes of a stored model.
///
/// # Errors
/// As [`Model::from_bytes`], for what concerns the bytes as a whole.
pub fn notes(bytes: &[u8]) -> Result<&str, ModelError> {
    let (_, notes) = open(bytes)?;
    core::str::from_utf8(notes).map_err(|_| ModelError::OutOfRange(Field::Notes))
}

/// The layout of a stored model.
///
/// # Errors
/// As [`Model::from_bytes`], for what concerns the bytes as a whole and the layout.
pub fn layout(bytes: &[u8]) -> Result<Layout, ModelError> {
    let (payload, _) = open(bytes)?;
    Ok(read_layout(&mut Input::new(payload))?)
}

/// Lengths of payload and notes.
fn header(bytes: &[u8]) -> Result<(usize, usize), ModelError> {
    let mut header = Input::new(bytes);
    if header.array() != MAGIC {
        return Err(ModelError::NotAModel);
    }
    let (given, flags) = (header.u16(), header.u16());
    let (payload, notes) = (header.u32() as usize, header.u32() as usize);
    header.so_far()?;
    if !(WITHOUT_WEIGHT..=VERSION).contains(&given) {
        return Err(ModelError::Version { given, supported: VERSION });
    }
    // Reserved: a later build may give them a meaning that this one must not ignore.
    if flags != 0 {
        return Err(ModelError::OutOfRange(Field::Flags));
    }
    if payload > MAX_BYTES || notes > MAX_BYTES { Err(ModelError::Truncated) } else { Ok((payload, notes)) }
}

/// Checks the frame; returns payload and notes.
fn open(bytes: &[u8]) -> Result<(&[u8], &[u8]), ModelError> {
    let (payload, _) = header(bytes)?;
    if stored_len(bytes)? != bytes.len() {
        return Err(ModelError::Truncated);
    }
    let (content, check) = bytes.split_last_chunk().ok_or(ModelError::Truncated)?;
    if u32::from_le_bytes(*check) != crc32(content) {
        return Err(ModelError::Checksum);
    }
    let content = content.get(HEADER..).ok_or(ModelError::Truncated)?;
    content.split_at_checked(payload).ok_or(ModelError::Truncated)
}

impl<P: Plan> Model<P> {
    /// Reads a model from its binary form and checks it.
    ///
    /// # Errors
    /// A [`ModelError`]: not a model, another version, truncated, corrupted, for another plan, or with a value out of
    /// range.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, ModelError> {
        let (payload, _) = open(bytes)?;
        let mut input = Input::new(payload);
        let layout = read_layout(&mut input)?;
        layout.check().map_err(ModelError::Layout)?;
        let plan = P::of(layout).ok_or(ModelError::OtherPlan)?;
        let constants = read(&mut input, plan);
        input.finish()?;
        Self::new(plan, constants)
    }

    /// Reads the model that these bytes start with; what follows is ignored (the erased tail of a flash sector).
    ///
    /// # Errors
    /// As [`Model::from_bytes`].
    pub fn from_sector(bytes: &[u8]) -> Result<Self, ModelError> {
        Self::from_bytes(bytes.get(..stored_len(bytes)?).unwrap_or(bytes))
    }

    /// Writes the binary form with `notes` into `buffer`; returns its length.
    ///
    /// # Errors
    /// [`ModelError::BufferTooSmall`].
    pub fn to_bytes(&self, notes: &str, buffer: &mut [u8]) -> Result<usize, ModelError> {
        let (header, free) = buffer.split_first_chunk_mut::<HEADER>().ok_or(ModelError::BufferTooSmall)?;
        let mut output = Output::new(free);
        put(&self.constants().parts(self.plan()), &mut output);
        let payload = output.written().ok_or(ModelError::BufferTooSmall)?;
        output.text(notes.as_bytes());
        let end = output.written().ok_or(ModelError::BufferTooSmall)?.saturating_add(HEADER);
        *header = header_of(version(&self.plan().layout()), (payload, notes.len()))?;
        let (content, rest) = buffer.split_at_mut_checked(end).ok_or(ModelError::BufferTooSmall)?;
        *rest.first_chunk_mut().ok_or(ModelError::BufferTooSmall)? = crc32(content).to_le_bytes();
        Ok(end.saturating_add(4))
    }
}

impl From<Fault> for ModelError {
    fn from(fault: Fault) -> Self {
        match fault {
            Fault::Truncated => Self::Truncated,
            Fault::OutOfRange(field) => Self::OutOfRange(field),
            Fault::Newer => Self::Version { given: VERSION.saturating_add(1), supported: VERSION },
        }
    }
}

/// The first version that has all of this layout, so that an older firmware refuses only what it cannot read.
fn version(layout: &Layout) -> u16 {
    let weighs = layout.shaft.is_some_and(|shaft| matches!(shaft.load, Load::Weight { .. }));
    if weighs { VERSION } else { WITHOUT_WEIGHT }
}

/// The header before so many bytes of payload and notes.
fn header_of(version: u16, (payload, notes): (usize, usize)) -> Result<[u8; HEADER], ModelError> {
    if payload > MAX_BYTES || notes > MAX_BYTES {
        return Err(ModelError::BufferTooSmall);
    }
    let length = |n: usize| u32::try_from(n).map(u32::to_le_bytes).map_err(|_| ModelError::BufferTooSmall);
    let [m0, m1, m2, m3] = MAGIC;
    let [v0, v1] = version.to_le_bytes();
    let ([p0, p1, p2, p3], [n0, n1, n2, n3]) = (length(payload)?, length(notes)?);
    Ok([m0, m1, m2, m3, v0, v1, 0, 0, p0, p1, p2, p3, n0, n1, n2, n3])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{ShaftLayout, Signal};

    #[test]
    fn the_header_has_the_bytes_of_the_format() {
        let bytes = [b'B', b'W', b'M', b'D', 11, 0, 0, 0, 4, 3, 2, 0, 6, 5, 1, 0];
        assert_eq!(header_of(11, (0x2_0304, 0x1_0506)), Ok(bytes));
        assert_eq!(header(&bytes), Ok((0x2_0304, 0x1_0506)));
        for given in [9, 10, 13] {
            let mut other = bytes;
            other[4] = given;
            assert_eq!(header(&other), Err(ModelError::Version { given: given.into(), supported: 12 }));
        }
        let mut flagged = bytes;
        flagged[6] = 1;
        assert_eq!(header(&flagged), Err(ModelError::OutOfRange(Field::Flags)));
    }

    #[test]
    fn only_a_model_with_a_weight_has_the_newer_version() {
        let with = |load| {
            let current = Signal::channel(0);
            let shaft = ShaftLayout { current, velocity: None, load, orders: 0, harmonics: 1, decimation: 1 };
            Layout { shaft: Some(shaft), ..Layout::EMPTY }
        };
        let all = [Load::Unknown, Load::Measured(Signal::channel(0)), Load::Weight { axis_q32: 1, changes: true }];
        assert_eq!(all.map(|load| version(&with(load))), [11, 11, 12]);
        assert_eq!(version(&Layout::EMPTY), 11);
    }

    #[test]
    fn payload_and_notes_have_at_most_a_mebibyte_each() {
        let (most, more) = (MAX_BYTES, MAX_BYTES + 1);
        assert_eq!(header(&header_of(11, (most, most)).unwrap()), Ok((most, most)));
        for (payload, notes) in [(more, 0), (0, more), (2 * more, 2 * more)] {
            assert_eq!(header_of(11, (payload, notes)), Err(ModelError::BufferTooSmall));
            let mut bytes = header_of(11, (0, 0)).unwrap();
            bytes[8..12].copy_from_slice(&(payload as u32).to_le_bytes());
            bytes[12..].copy_from_slice(&(notes as u32).to_le_bytes());
            assert_eq!(header(&bytes), Err(ModelError::Truncated), "{payload} {notes}");
        }
    }
}
