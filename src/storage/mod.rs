//! Records in flash that survive power-off: a pair of slots, of which one always holds the last good record.
//!
//! Enters: bytes, such as a model ([`Model::to_bytes`](crate::Model::to_bytes)) or a saved state
//! ([`Monitor::save`](crate::Monitor::save)). Leaves: the same bytes after the next power-up.
//!
//! ```text
//! slot    header | payload | erased rest          at `start`, and again `slot_bytes` later
//! prepare erase the slot without the newest record ─► mark in its last unit
//! store   the same without a mark ─► payload, read back ─► header, read back
//! load    of both slots the records whose checksums match, the one with the larger counter first
//! header  "BWSL"  version u8  kind u8  0 u16  counter u32  length u32  model u32  drive [u8; 16]
//!         CRC-32 of the payload u32  CRC-32 of the header u32                    little-endian, 44 bytes
//! ```
//!
//! The header is written last and switches from the old record to the new one. If power is lost before its last word,
//! the old record is still there and remains the newest; the next store erases what was begun. A slot that cannot be
//! read, as a word of flash with error correction whose programming was cut off, counts as empty.
//!
//! **Sizes.** Sizes of reads, writes and erasures are those of the flash's traits. One erasure at least separates the
//! slots, so a flash with sectors of 16 kB needs 32 kB for a pair. `PAGE` bytes of stack are needed once to read and
//! twice to write: at least 44, rounded up to the size of a write.
//!
//! **Stalls.** A chip that runs from the bank that it erases stands still meanwhile. By its data sheet an STM32F405
//! takes 0.25 to 0.8 s for a sector of 16 kB, and 1 to 4 s for one of 128 kB. Call [`SlotPair::prepare`] at boot or at
//! rest, and a store at power-down only writes.
//!
//! **Error correction.** On a flash that checks words, such as those of an STM32G4, L4 or H7, reading a word whose
//! programming was cut off raises a fault: a non-maskable interrupt on G4 and L4 (`FLASH_ECCR`, bit ECCD), a bus fault
//! on H7. Its handler must clear the flag and return, and the driver's `read` return an error; the slot then counts as
//! empty.
//!
//! **Wear.** A store erases one slot once, and stores alternate between the slots: a flash of 10 000 erasures endures
//! 20 000 stores. A state that is saved once an hour lasts two years, once a day fifty. Save at power-down, at the end
//! of a run or where an alarm is raised, not after each segment.
//!
//! **Limits.** A cut can leave a cell between 0 and 1, which reads differently at different times. Such a record is
//! either complete or refused by its checksum, but it may be the newest at one boot and refused at the next. Two kinds
//! of records need two pairs.
//!
//! **Fallback.** If the newest record is damaged, the older one serves, and [`Record::passed_over`] says so: an older
//! state may lack an alarm. Tell it, and store again; or refuse the record in [`SlotPair::load`].
//!
//! ```
//! use bearing_watch::storage::{RecordKind, RecordLabel, SlotPair};
//! # use bearing_watch::model::Label;
//! # use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
//! # struct Flash([u8; 512]);
//! # impl ErrorType for Flash { type Error = core::convert::Infallible; }
//! # impl ReadNorFlash for Flash {
//! #     const READ_SIZE: usize = 1;
//! #     fn read(&mut self, at: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
//! #         bytes.copy_from_slice(&self.0[at as usize..at as usize + bytes.len()]);
//! #         Ok(())
//! #     }
//! #     fn capacity(&self) -> usize { 512 }
//! # }
//! # impl NorFlash for Flash {
//! #     const WRITE_SIZE: usize = 4;
//! #     const ERASE_SIZE: usize = 256;
//! #     fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
//! #         self.0[from as usize..to as usize].fill(0xFF);
//! #         Ok(())
//! #     }
//! #     fn write(&mut self, at: u32, bytes: &[u8]) -> Result<(), Self::Error> {
//! #         self.0[at as usize..at as usize + bytes.len()].copy_from_slice(bytes);
//! #         Ok(())
//! #     }
//! # }
//! # let mut flash = Flash([0xFF; 512]);
//! let pair = SlotPair::<64>::new(&flash, 0, 256, RecordKind::State)?;
//! let label = RecordLabel { model: 0x1234_5678, drive: Label::constant("actuator 7") };
//! pair.store(&mut flash, &label, b"the state")?;
//! // After the next power-up:
//! let mut buffer = [0; 128];
//! let state = pair.load(&mut flash, &mut buffer, |record, bytes| {
//!     (record.label.model == 0x1234_5678).then(|| bytes.to_vec())
//! })?;
//! assert_eq!(state, b"the state");
//! # Ok::<(), bearing_watch::storage::StorageError<core::convert::Infallible>>(())
//! ```

mod error;
mod pair;
mod record;

pub use error::StorageError;
pub use pair::SlotPair;
pub use record::{PassedOver, Record, RecordKind, RecordLabel};

#[cfg(test)]
mod tests;
