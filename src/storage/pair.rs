//! Two slots for records of one kind.

mod prepared;

use embedded_storage::nor_flash::NorFlash;

use super::error::StorageError;
use super::record::{HEADER, PassedOver, Record, RecordKind, RecordLabel};
use crate::checksum::{Crc32, crc32};

/// A byte of erased flash.
const ERASED: u8 = 0xFF;

/// A pair of slots in flash, for records of one kind; see [`crate::storage`]. `PAGE` is the number of bytes of the
/// buffer through which it reads and writes.
///
/// A pair has no state in memory: it can be made again at any time, and the flash serves other purposes between calls.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SlotPair<const PAGE: usize> {
    start: u32,
    slot_bytes: u32,
    kind: RecordKind,
}

/// What a slot holds.
#[derive(Clone, Copy)]
enum Slot {
    /// Erased flash, or the record of another kind.
    Empty,
    Good(Record),
    /// A good header, whose payload is damaged.
    Damaged(Record),
    /// Neither a header nor erased flash.
    Unknown,
}

impl Slot {
    /// What it may hide from one who uses the record of the other slot.
    const fn hides(self, other: &Record) -> Option<PassedOver> {
        match self {
            Self::Good(record) if record.is_newer_than(other) => Some(PassedOver::Refused { counter: record.counter }),
            Self::Damaged(record) if record.is_newer_than(other) => {
                Some(PassedOver::Damaged { counter: record.counter })
            }
            Self::Unknown => Some(PassedOver::Unknown),
            Self::Empty | Self::Good(_) | Self::Damaged(_) => None,
        }
    }
}

/// What the slots hold.
enum Found {
    /// The newest good record, and whether it is in the second slot.
    Record { second: bool, record: Record },
    /// No record; the slot to begin with.
    Nothing { second: bool },
}

impl<const PAGE: usize> SlotPair<PAGE> {
    /// Two slots of `slot_bytes` each, from the address `start` of this flash on.
    ///
    /// # Errors
    /// [`StorageError::Geometry`].
    pub fn new<F: NorFlash>(
        flash: &F,
        start: u32,
        slot_bytes: u32,
        kind: RecordKind,
    ) -> Result<Self, StorageError<F::Error>> {
        let aligned = [start, slot_bytes].iter().all(|n| (*n as usize).is_multiple_of(F::ERASE_SIZE));
        let (more, less) = (F::WRITE_SIZE.max(F::READ_SIZE), F::WRITE_SIZE.min(F::READ_SIZE));
        let sized = less > 0 && more.is_multiple_of(less) && F::ERASE_SIZE.is_multiple_of(more);
        let end = u64::from(start).saturating_add(u64::from(slot_bytes).saturating_mul(2));
        let inside = usize::try_from(end).is_ok_and(|end| end <= flash.capacity()) && end <= u64::from(u32::MAX);
        let room = Self::header::<F>() <= PAGE && Self::header::<F>() < slot_bytes as usize;
        let fits = aligned && sized && inside && room && step::<F>(PAGE) > 0;
        if fits { Ok(Self { start, slot_bytes, kind }) } else { Err(StorageError::Geometry) }
    }

    /// Number of bytes of the longest payload.
    #[must_use]
    pub fn capacity<F: NorFlash>(&self) -> usize {
        (self.slot_bytes as usize).saturating_sub(Self::header::<F>())
    }

    /// The newest good record; `None` if there is none.
    ///
    /// # Errors
    /// [`StorageError::Flash`] if neither slot can be read.
    pub fn newest<F: NorFlash>(&self, flash: &mut F) -> Result<Option<Record>, StorageError<F::Error>> {
        Ok(match self.newest_slot(flash)? {
            Found::Record { record, .. } => Some(record),
            Found::Nothing { .. } => None,
        })
    }

    /// Reads the newest good record that `accept` accepts, which gets the payload and returns what to make of it; the
    /// older record is tried if the newer one is damaged or refused. It then says [`Record::passed_over`], and `accept`
    /// decides.
    ///
    /// # Errors
    /// [`StorageError::NoRecord`]; [`StorageError::BufferTooSmall`] or [`StorageError::Flash`] if that is why.
    pub fn load<F: NorFlash, T>(
        &self,
        flash: &mut F,
        buffer: &mut [u8],
        mut accept: impl FnMut(&Record, &[u8]) -> Option<T>,
    ) -> Result<T, StorageError<F::Error>> {
        let mut reason = StorageError::NoRecord;
        let Found::Record { second, record: newest } = self.newest_slot(flash)? else { return Err(reason) };
        let mut passed_over = newest.passed_over;
        for slot in [second, !second] {
            match self.read(flash, slot, Some(&mut *buffer)) {
                Ok(Slot::Good(record)) => {
                    let payload = buffer.get(..record.length as usize).unwrap_or_default();
                    if let Some(made) = accept(&Record { passed_over, ..record }, payload) {
                        return Ok(made);
                    }
                    passed_over = Some(PassedOver::Refused { counter: record.counter });
                }
                // What was good a moment ago.
                Ok(_) => passed_over = Some(PassedOver::Damaged { counter: newest.counter }),
                Err(error) => (reason, passed_over) = (error, Some(PassedOver::Unreadable)),
            }
        }
        Err(reason)
    }

    /// Stores a record in place of the older one; it erases that first, unless [`SlotPair::prepare`] has. Whatever
    /// happens on the way, the newest record is still there or this one is complete. Nothing is erased if neither slot
    /// can be read: then [`SlotPair::erase`] starts afresh.
    ///
    /// # Errors
    /// [`StorageError::TooLong`], [`StorageError::Flash`], [`StorageError::NotWritten`].
    pub fn store<F: NorFlash>(
        &self,
        flash: &mut F,
        label: &RecordLabel,
        payload: &[u8],
    ) -> Result<Record, StorageError<F::Error>> {
        let capacity = self.capacity::<F>();
        let length = u32::try_from(payload.len()).ok().filter(|length| *length as usize <= capacity);
        let too_long = || StorageError::TooLong { capacity: u32::try_from(capacity).unwrap_or(u32::MAX) };
        let length = length.ok_or_else(too_long)?;
        let (second, counter) = match self.newest_slot(flash)? {
            Found::Record { second, record } => (!second, record.counter.wrapping_add(1)),
            Found::Nothing { second } => (second, 1),
        };
        let record = Record { label: *label, counter, length, check: crc32(payload), passed_over: None };
        let at = self.address(second);
        // Only what the record needs: a slot may be longer.
        let used = rounded(Self::header::<F>().saturating_add(payload.len()), F::ERASE_SIZE);
        let end = at.saturating_add(u32::try_from(used).unwrap_or(u32::MAX)).min(at.saturating_add(self.slot_bytes));
        if !self.is_prepared(flash, second, payload.len()) {
            flash.erase(at, end).map_err(StorageError::Flash)?;
        }
        Self::write(flash, at.saturating_add(offset(Self::header::<F>())), payload)?;
        Self::write(flash, at, &record.to_bytes(self.kind))?;
        Ok(record)
    }

    /// Erases both slots with all records.
    ///
    /// # Errors
    /// [`StorageError::Flash`].
    pub fn erase<F: NorFlash>(&self, flash: &mut F) -> Result<(), StorageError<F::Error>> {
        let end = self.address(true).saturating_add(self.slot_bytes);
        flash.erase(self.start, end).map_err(StorageError::Flash)
    }

    /// Number of bytes of a header in this flash.
    fn header<F: NorFlash>() -> usize {
        rounded(HEADER, unit::<F>())
    }

    fn address(&self, second: bool) -> u32 {
        if second { self.start.saturating_add(self.slot_bytes) } else { self.start }
    }

    /// Reads both slots. One that cannot be read counts as empty.
    fn newest_slot<F: NorFlash>(&self, flash: &mut F) -> Result<Found, StorageError<F::Error>> {
        let slots = [self.read(flash, false, None), self.read(flash, true, None)];
        // A record beside what may have been a newer one.
        let beside = |second, record: &Record, other: &Result<Slot, StorageError<F::Error>>| {
            let passed_over = other.as_ref().map_or(Some(PassedOver::Unreadable), |other| other.hides(record));
            Found::Record { second, record: Record { passed_over, ..*record } }
        };
        Ok(match &slots {
            [Ok(Slot::Good(first)), Ok(Slot::Good(second))] => {
                let newer = second.is_newer_than(first);
                Found::Record { second: newer, record: if newer { *second } else { *first } }
            }
            [Ok(Slot::Good(record)), other] => beside(false, record, other),
            [other, Ok(Slot::Good(record))] => beside(true, record, other),
            [Ok(_), _] => Found::Nothing { second: false },
            [Err(_), Ok(_)] => Found::Nothing { second: true },
            [Err(_), Err(_)] => {
                let [first, _] = slots;
                return first.map(|_| Found::Nothing { second: false });
            }
        })
    }

    /// Reads the record of a slot into a buffer, if there is one, and checks it.
    fn read<F: NorFlash>(
        &self,
        flash: &mut F,
        second: bool,
        mut buffer: Option<&mut [u8]>,
    ) -> Result<Slot, StorageError<F::Error>> {
        let (mut page, header) = ([ERASED; PAGE], Self::header::<F>());
        let at = self.address(second);
        let Some(cells) = page.get_mut(..header) else { return Err(StorageError::Geometry) };
        flash.read(at, cells).map_err(StorageError::Flash)?;
        let Some(record) = Record::from_bytes(cells, self.kind) else {
            // The record of another kind is none of this pair's.
            let other = RecordKind::ALL.into_iter().any(|kind| Record::from_bytes(cells, kind).is_some());
            return Ok(if other || cells.iter().all(|byte| *byte == ERASED) { Slot::Empty } else { Slot::Unknown });
        };
        let length = record.length as usize;
        if length > self.capacity::<F>() {
            return Ok(Slot::Damaged(record));
        }
        if buffer.as_ref().is_some_and(|buffer| buffer.len() < length) {
            return Err(StorageError::BufferTooSmall { needed: record.length });
        }
        let (mut crc, mut done, step) = (Crc32::START, 0_usize, step::<F>(PAGE).max(1));
        while done < length {
            let part = length.saturating_sub(done).min(step);
            let from = at.saturating_add(offset(header.saturating_add(done)));
            let Some(cells) = page.get_mut(..rounded(part, unit::<F>())) else { return Err(StorageError::Geometry) };
            flash.read(from, cells).map_err(StorageError::Flash)?;
            let bytes = cells.get(..part).unwrap_or_default();
            crc.add(bytes);
            let to = buffer.as_mut().and_then(|buffer| buffer.get_mut(done..));
            to.unwrap_or_default().iter_mut().zip(bytes).for_each(|(cell, byte)| *cell = *byte);
            done = done.saturating_add(part);
        }
        Ok(if crc.value() == record.check { Slot::Good(record) } else { Slot::Damaged(record) })
    }

    /// Writes to erased flash, and reads back.
    fn write<F: NorFlash>(flash: &mut F, at: u32, bytes: &[u8]) -> Result<(), StorageError<F::Error>> {
        let (mut page, mut read_back) = ([ERASED; PAGE], [0; PAGE]);
        let step = step::<F>(PAGE).max(1);
        let mut at = at;
        for part in bytes.chunks(step) {
            let padded = rounded(part.len(), unit::<F>());
            let pages = (page.get_mut(..padded), read_back.get_mut(..padded));
            let (Some(page), Some(read_back)) = pages else { return Err(StorageError::Geometry) };
            page.fill(ERASED);
            page.iter_mut().zip(part).for_each(|(cell, byte)| *cell = *byte);
            flash.write(at, page).map_err(StorageError::Flash)?;
            flash.read(at, read_back).map_err(StorageError::Flash)?;
            if page != read_back {
                return Err(StorageError::NotWritten);
            }
            at = at.saturating_add(offset(padded));
        }
        Ok(())
    }
}

/// What every address and length is a multiple of.
fn unit<F: NorFlash>() -> usize {
    F::WRITE_SIZE.max(F::READ_SIZE)
}

/// Number of bytes that are read or written at once.
fn step<F: NorFlash>(page: usize) -> usize {
    page.saturating_sub(page.checked_rem(unit::<F>()).unwrap_or(page))
}

/// The next multiple of `unit`.
fn rounded(length: usize, unit: usize) -> usize {
    length.checked_next_multiple_of(unit).unwrap_or(usize::MAX)
}

fn offset(bytes: usize) -> u32 {
    u32::try_from(bytes).unwrap_or(u32::MAX)
}
