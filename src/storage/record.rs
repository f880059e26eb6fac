//! The header of a record.

use crate::checksum::crc32;
use crate::signal::Label;

/// Number of bytes of a header.
pub(super) const HEADER: usize = 44;
const MAGIC: [u8; 4] = *b"BWSL";
const VERSION: u8 = 1;

/// What a record contains.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RecordKind {
    /// A model in its binary form.
    Model,
    /// The state of the alarm.
    State,
}

impl RecordKind {
    pub(super) const ALL: [Self; 2] = [Self::Model, Self::State];
}

/// What a record belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RecordLabel {
    /// Id of the model, [`Model::id`](crate::Model::id).
    pub model: u32,
    /// Type of the drive.
    pub drive: Label,
}

/// What the other slot has, where it may have been newer than the record that is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum PassedOver {
    /// A newer good record, which was refused.
    Refused {
        /// Its number.
        counter: u32,
    },
    /// A newer record whose header is good and whose payload is damaged.
    Damaged {
        /// Its number.
        counter: u32,
    },
    /// Neither a record nor erased flash: a damaged record, or one that was being stored when power failed. Whether it
    /// was newer is not known.
    Unknown,
    /// The flash does not read it.
    Unreadable,
}

/// A record in flash. Records are equal if they are the same, however they were found.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Record {
    /// What it belongs to.
    pub label: RecordLabel,
    /// Number of the record in its pair of slots; the first is 1, and after 2³² records it starts again.
    pub counter: u32,
    /// Number of bytes of the payload.
    pub length: u32,
    /// Checksum of the payload.
    pub(super) check: u32,
    pub(super) passed_over: Option<PassedOver>,
}

impl PartialEq for Record {
    fn eq(&self, other: &Self) -> bool {
        let Self { label, counter, length, check, passed_over: _ } = *self;
        (label, counter, length, check) == (other.label, other.counter, other.length, other.check)
    }
}

impl Eq for Record {}

impl Record {
    /// Whether this record may be older than the newest that was stored: what the other slot has instead of an older
    /// record. A state that is not the newest may lack an alarm that had been raised; the firmware decides whether it
    /// accepts that, and tells it.
    #[must_use]
    pub const fn passed_over(&self) -> Option<PassedOver> {
        self.passed_over
    }

    /// Whether this record was stored after the other one: counters wrap around.
    pub(super) const fn is_newer_than(&self, other: &Self) -> bool {
        let ahead = self.counter.wrapping_sub(other.counter);
        ahead != 0 && ahead < 1 << 31
    }

    pub(super) fn to_bytes(self, kind: RecordKind) -> [u8; HEADER] {
        let Self { label, counter, length, check, .. } = self;
        let mut bytes = [0; HEADER];
        let fields: [&[u8]; 7] = [
            &MAGIC,
            &[VERSION, code(kind), 0, 0],
            &counter.to_le_bytes(),
            &length.to_le_bytes(),
            &label.model.to_le_bytes(),
            &label.drive.to_bytes(),
            &check.to_le_bytes(),
        ];
        bytes.iter_mut().zip(fields.into_iter().flatten()).for_each(|(cell, byte)| *cell = *byte);
        if let Some((fields, last)) = bytes.split_last_chunk_mut() {
            *last = crc32(fields).to_le_bytes();
        }
        bytes
    }

    /// `None` if the bytes are not the header of a record of this kind, or are corrupted.
    pub(super) fn from_bytes(bytes: &[u8], kind: RecordKind) -> Option<Self> {
        let (fields, last) = bytes.get(..HEADER)?.split_last_chunk::<4>()?;
        if crc32(fields) != u32::from_le_bytes(*last) {
            return None;
        }
        let (magic, rest) = fields.split_first_chunk::<4>()?;
        let (format, rest) = rest.split_first_chunk::<4>()?;
        if *magic != MAGIC || *format != [VERSION, code(kind), 0, 0] {
            return None;
        }
        let (counter, rest) = rest.split_first_chunk::<4>()?;
        let (length, rest) = rest.split_first_chunk::<4>()?;
        let (model, rest) = rest.split_first_chunk::<4>()?;
        let (drive, rest) = rest.split_first_chunk::<16>()?;
        let check = rest.first_chunk::<4>()?;
        let label = RecordLabel { model: u32::from_le_bytes(*model), drive: Label::from_bytes(*drive)? };
        let [counter, length, check] = [counter, length, check].map(|field| u32::from_le_bytes(*field));
        Some(Self { label, counter, length, check, passed_over: None })
    }
}

const fn code(kind: RecordKind) -> u8 {
    match kind {
        RecordKind::Model => 1,
        RecordKind::State => 2,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RECORD: Record = Record {
        label: RecordLabel { model: 0x0102_0304, drive: Label::constant("actuator") },
        counter: 7,
        length: 99,
        check: 0xA5A5_5A5A,
        passed_over: None,
    };

    #[test]
    fn a_header_has_the_bytes_of_the_format() {
        let bytes = RECORD.to_bytes(RecordKind::State);
        let start = [b'B', b'W', b'S', b'L', 1, 2, 0, 0, 7, 0, 0, 0, 99, 0, 0, 0, 4, 3, 2, 1];
        assert_eq!((&bytes[..20], &bytes[20..36]), (&start[..], &b"actuator\0\0\0\0\0\0\0\0"[..]));
        assert_eq!(
            (&bytes[36..40], &bytes[40..]),
            (&[0x5A, 0x5A, 0xA5, 0xA5][..], &crc32(&bytes[..40]).to_le_bytes()[..])
        );
        assert_eq!(RECORD.to_bytes(RecordKind::Model)[5], 1);
    }

    #[test]
    fn headers_are_read_back_and_altered_ones_refused() {
        let bytes = RECORD.to_bytes(RecordKind::State);
        assert_eq!(Record::from_bytes(&bytes, RecordKind::State), Some(RECORD));
        assert_eq!(Record::from_bytes(&bytes, RecordKind::Model), None);
        assert_eq!(Record::from_bytes(&bytes[..HEADER - 1], RecordKind::State), None);
        for index in 0..HEADER * 8 {
            let mut other = bytes;
            other[index / 8] ^= 1 << (index % 8);
            assert_eq!(Record::from_bytes(&other, RecordKind::State), None, "bit {index}");
        }
    }

    #[test]
    fn counters_wrap() {
        let at = |counter| Record { counter, ..RECORD };
        for (newer, older) in [(2, 1), (0, u32::MAX), (5, u32::MAX - 5)] {
            assert!(at(newer).is_newer_than(&at(older)) && !at(older).is_newer_than(&at(newer)));
        }
        assert!(!RECORD.is_newer_than(&RECORD));
    }
}
