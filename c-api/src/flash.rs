//! Records in flash that survive power-off, over functions of the caller.

use core::ffi::c_void;

use bearing_watch::model::Label;
use bearing_watch::storage::{RecordKind, RecordLabel, SlotPair, StorageError};
use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};

use crate::code::{BwCode, Outcome, code};
use crate::memory::{check, elements, elements_mut, get, put};
use crate::saved::{restore, save};
use crate::state::BwState;

/// Every address and length that the functions of a `BwFlash` get is a multiple of this number of bytes, the largest
/// word that a microcontroller programs at once.
pub const BW_FLASH_UNIT: usize = 32;

/// Bytes through which a record is read and written.
const PAGE: usize = 64;

/// Two places in flash for records of one kind, and the functions that reach them. Models and states need places of
/// their own. Each function returns 0 if it did what it says.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct BwFlash {
    /// Passed to the functions.
    pub context: *mut c_void,
    /// Reads `length` bytes. On a flash that checks its words, an error of a word is an error of this call.
    pub read: Option<unsafe extern "C" fn(context: *mut c_void, address: u32, bytes: *mut u8, length: usize) -> i32>,
    /// Programs `length` bytes of erased flash.
    pub write: Option<unsafe extern "C" fn(context: *mut c_void, address: u32, bytes: *const u8, length: usize) -> i32>,
    /// Erases every sector that has a byte from `address` on to before `end`.
    pub erase: Option<unsafe extern "C" fn(context: *mut c_void, address: u32, end: u32) -> i32>,
    /// The address of the first place, at the start of a sector.
    pub start: u32,
    /// Bytes from the first place to the second one: whole sectors.
    pub place_bytes: u32,
}

/// The same as the core reaches it.
#[derive(Clone, Copy)]
struct Flash(BwFlash);

/// A function of the caller has failed.
#[derive(Clone, Copy, Debug)]
struct Failed;

impl NorFlashError for Failed {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

impl ErrorType for Flash {
    type Error = Failed;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = BW_FLASH_UNIT;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Failed> {
        let BwFlash { context, read, .. } = self.0;
        let read = read.ok_or(Failed)?;
        // SAFETY: the contract of the functions that take a `BwFlash`; the bytes live until the call returns.
        if unsafe { read(context, offset, bytes.as_mut_ptr(), bytes.len()) } == 0 { Ok(()) } else { Err(Failed) }
    }

    fn capacity(&self) -> usize {
        usize::MAX
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = BW_FLASH_UNIT;
    // What is erased is rounded to sectors by the function of the caller.
    const ERASE_SIZE: usize = BW_FLASH_UNIT;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Failed> {
        let BwFlash { context, erase, .. } = self.0;
        let erase = erase.ok_or(Failed)?;
        // SAFETY: the contract of the functions that take a `BwFlash`.
        if unsafe { erase(context, from, to) } == 0 { Ok(()) } else { Err(Failed) }
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Failed> {
        let BwFlash { context, write, .. } = self.0;
        let write = write.ok_or(Failed)?;
        // SAFETY: the contract of the functions that take a `BwFlash`; the bytes live until the call returns.
        if unsafe { write(context, offset, bytes.as_ptr(), bytes.len()) } == 0 { Ok(()) } else { Err(Failed) }
    }
}

fn refusal(error: StorageError<Failed>) -> BwCode {
    match error {
        StorageError::Geometry => BwCode::FlashPlaces,
        StorageError::TooLong { .. } => BwCode::FlashTooSmall,
        StorageError::BufferTooSmall { .. } => BwCode::BufferTooSmall,
        StorageError::NotWritten => BwCode::FlashNotWritten,
        StorageError::NoRecord => BwCode::FlashNoRecord,
        // That of the caller, and what a later version of the core adds.
        _ => BwCode::FlashFailed,
    }
}

/// The flash, and its places for records of a kind.
///
/// # Safety
/// The flash is NULL or readable.
unsafe fn places(flash: *const BwFlash, kind: RecordKind) -> Outcome<(Flash, SlotPair<PAGE>)> {
    // SAFETY: the contract of the caller; every bit pattern of its numbers is valid, and its functions are those of C.
    let flash = Flash(unsafe { get(flash) }?);
    let pair = SlotPair::new(&flash, flash.0.start, flash.0.place_bytes, kind).map_err(refusal)?;
    Ok((flash, pair))
}

const fn label(model: u32) -> RecordLabel {
    RecordLabel { model, drive: Label::constant("") }
}

/// Erases ahead of the next `bw_flash_save`, which then only writes: at boot or at rest, since a chip that runs from
/// the bank that it erases stands still meanwhile, up to seconds for a large sector.
///
/// Returns `BW_CODE_OK`, or `BW_CODE_FLASH_…`.
///
/// # Safety
/// `flash` is NULL or readable, and its functions keep what `BwFlash` says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_flash_prepare(flash: *const BwFlash) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { places(flash, RecordKind::State) }.and_then(|(mut flash, pair)| {
        pair.prepare(&mut flash).map_err(refusal)?;
        Ok(BwCode::Ok)
    }))
}

/// Saves alarm and scores in flash, as `bw_save` does; if power fails on the way, the record before is still
/// there. `buffer` has room for `bw_saved_size` bytes.
///
/// Returns `BW_CODE_OK`, what `bw_save` returns, or `BW_CODE_FLASH_…`.
///
/// # Safety
/// `flash` is NULL or readable, and its functions keep what `BwFlash` says. `state` is as for `bw_save`. `buffer` is
/// NULL or has `size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_flash_save(
    flash: *const BwFlash,
    state: *mut BwState,
    buffer: *mut u8,
    size: usize,
) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { places(flash, RecordKind::State) }.and_then(|(mut flash, pair)| {
        // SAFETY: the same contract.
        let (bytes, model) = unsafe { save(state, buffer, size) }?;
        pair.store(&mut flash, &label(model), bytes).map_err(refusal)?;
        Ok(BwCode::Ok)
    }))
}

/// Continues from the newest good record of this model in flash, as `bw_restore` does, and from the one before if the
/// newest is damaged or of another model. `buffer` has room for `bw_saved_size` bytes.
///
/// Returns `BW_CODE_OK`, `BW_CODE_FLASH_NO_RECORD` if there is none, what `bw_restore` returns of the newest record, or
/// `BW_CODE_FLASH_…`.
///
/// # Safety
/// As for `bw_flash_save`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_flash_restore(
    flash: *const BwFlash,
    state: *mut BwState,
    buffer: *mut u8,
    size: usize,
) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { places(flash, RecordKind::State) }.and_then(|(mut flash, pair)| {
        // SAFETY: the same contract; no other reference to the bytes exists during this call.
        let buffer = unsafe { elements_mut(buffer, size) }?;
        let mut refused = None;
        let outcome = pair.load(&mut flash, buffer, |_, bytes| {
            // SAFETY: the same contract.
            unsafe { restore(state, bytes) }.inspect_err(|code| _ = refused.get_or_insert(*code)).ok()
        });
        outcome.map_err(|error| refused.unwrap_or_else(|| refusal(error)))
    }))
}

/// Stores the bytes of a model, with what follows it such as a signature, in the place of the older one.
///
/// Returns `BW_CODE_OK`, or `BW_CODE_FLASH_…`.
///
/// # Safety
/// `flash` is NULL or readable, and its functions keep what `BwFlash` says. `model` is NULL or has `length` readable
/// bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_flash_store_model(flash: *const BwFlash, model: *const u8, length: usize) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { places(flash, RecordKind::Model) }.and_then(|(mut flash, pair)| {
        // SAFETY: the same contract.
        let bytes = unsafe { elements(model, length) }?;
        pair.store(&mut flash, &label(0), bytes).map_err(refusal)?;
        Ok(BwCode::Ok)
    }))
}

/// Reads the newest good model of a flash into `buffer`, for `bw_start`, and gives the number of its bytes.
///
/// Returns `BW_CODE_OK`, `BW_CODE_FLASH_NO_RECORD`, `BW_CODE_BUFFER_TOO_SMALL`, or another `BW_CODE_FLASH_…`.
///
/// # Safety
/// As for `bw_flash_store_model`, with `size` writable bytes at `buffer`. `length` is NULL or writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_flash_load_model(
    flash: *const BwFlash,
    buffer: *mut u8,
    size: usize,
    length: *mut usize,
) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { places(flash, RecordKind::Model) }.and_then(|(mut flash, pair)| {
        check(length)?;
        // SAFETY: the same contract; no other reference to the bytes exists during this call.
        let buffer = unsafe { elements_mut(buffer, size) }?;
        let count = pair.load(&mut flash, buffer, |_, bytes| Some(bytes.len())).map_err(refusal)?;
        // SAFETY: the same contract.
        unsafe { put(length, count) }.map(|()| BwCode::Ok)
    }))
}
