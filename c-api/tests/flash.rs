//! States and models in flash over functions of the caller, with power that fails at any write.
#![allow(clippy::expect_used, clippy::indexing_slicing, clippy::panic, reason = "a test fails by a panic")]

#[path = "../../examples/support/standard_rig/mod.rs"]
mod standard_rig;
#[allow(dead_code, reason = "other tests use the rest")]
mod support;

use core::convert::Infallible;
use core::ffi::c_void;
use core::ptr::null_mut;

use bearing_watch::model::Label;
use bearing_watch::storage::{RecordKind, RecordLabel, SlotPair};
use bearing_watch_c::*;
use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};

use standard_rig::model::{Drive, MODEL};
use support::{FILE, Memory, SEGMENT, alarm, bytes, channels};

/// Two sectors from the address 1024 on. It refuses what a flash cannot do.
struct Chip {
    bytes: Vec<u8>,
    sector: usize,
    /// Writes and erasures until power fails.
    left: usize,
}

const START: u32 = 1024;

impl Chip {
    fn new(sector: usize) -> Self {
        Self { bytes: vec![0xFF; START as usize + 2 * sector], sector, left: usize::MAX }
    }

    fn powered(&mut self) -> bool {
        self.left = self.left.saturating_sub(1);
        self.left > 0
    }

    fn flash(&mut self) -> BwFlash {
        let place_bytes = u32::try_from(self.sector).expect("a small sector");
        let context = (&raw mut *self).cast();
        BwFlash { context, read: Some(read), write: Some(write), erase: Some(erase), start: START, place_bytes }
    }
}

/// The chip behind a context.
fn chip<'a>(context: *mut c_void) -> &'a mut Chip {
    // SAFETY: the tests pass the address of a chip that lives longer than the call.
    unsafe { &mut *context.cast::<Chip>() }
}

unsafe extern "C" fn read(context: *mut c_void, address: u32, bytes: *mut u8, length: usize) -> i32 {
    let from = address as usize;
    let Some(found) = chip(context).bytes.get(from..from + length) else { return 1 };
    // SAFETY: the library passes so many writable bytes.
    unsafe { bytes.copy_from_nonoverlapping(found.as_ptr(), length) };
    0
}

unsafe extern "C" fn write(context: *mut c_void, address: u32, bytes: *const u8, length: usize) -> i32 {
    let (chip, from) = (chip(context), address as usize);
    assert!(from.is_multiple_of(BW_FLASH_UNIT) && length.is_multiple_of(BW_FLASH_UNIT));
    // SAFETY: the library passes so many readable bytes.
    let bytes = unsafe { core::slice::from_raw_parts(bytes, length) };
    let powered = chip.powered();
    let part = if powered { length } else { length / 3 };
    let Some(cells) = chip.bytes.get_mut(from..from + length) else { return 1 };
    // Programming clears bits only.
    cells.iter_mut().zip(bytes).take(part).for_each(|(cell, byte)| *cell &= byte);
    i32::from(!powered)
}

unsafe extern "C" fn erase(context: *mut c_void, address: u32, end: u32) -> i32 {
    let chip = chip(context);
    let (from, to) =
        ((address as usize - START as usize) / chip.sector, (end as usize - START as usize).div_ceil(chip.sector));
    let powered = chip.powered();
    if powered {
        let range = START as usize + from * chip.sector..START as usize + to * chip.sector;
        chip.bytes[range].fill(0xFF);
    }
    i32::from(!powered)
}

/// The same for the core.
impl ErrorType for Chip {
    type Error = Infallible;
}

impl ReadNorFlash for Chip {
    const READ_SIZE: usize = BW_FLASH_UNIT;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Infallible> {
        bytes.copy_from_slice(&self.bytes[offset as usize..][..bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl NorFlash for Chip {
    const WRITE_SIZE: usize = BW_FLASH_UNIT;
    const ERASE_SIZE: usize = BW_FLASH_UNIT;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Infallible> {
        self.bytes[from as usize..to as usize].fill(0xFF);
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Infallible> {
        self.bytes[offset as usize..][..bytes.len()].copy_from_slice(bytes);
        Ok(())
    }
}

fn save(chip: &mut Chip, state: *mut BwState) -> BwCode {
    let (flash, mut buffer) = (chip.flash(), [0; 1024]);
    // SAFETY: the chip, the state and the buffer live longer than the call.
    unsafe { bw_flash_save(&raw const flash, state, buffer.as_mut_ptr(), buffer.len()) }
}

fn restore(chip: &mut Chip, state: *mut BwState) -> BwCode {
    let (flash, mut buffer) = (chip.flash(), [0; 1024]);
    // SAFETY: the chip, the state and the buffer live longer than the call.
    unsafe { bw_flash_restore(&raw const flash, state, buffer.as_mut_ptr(), buffer.len()) }
}

/// Concludes a segment, so that the state is another one.
fn conclude(state: *mut BwState) {
    for sample in standard_rig::samples().take(SEGMENT) {
        let values = channels(&MODEL, &sample);
        support::collect(state, &values, 0);
    }
    assert_eq!(support::conclude(state), BwCode::Report);
}

#[test]
fn a_state_survives_power_off_at_any_write() {
    let mut memory = Memory::new();
    let state = memory.state(FILE).expect("a good model");
    conclude(state);
    for prepared in [false, true] {
        let mut chip = Chip::new(4096);
        assert_eq!(restore(&mut chip, state), BwCode::FlashNoRecord);
        assert_eq!(save(&mut chip, state), BwCode::Ok);
        let segments = alarm(state).segments;
        conclude(state);
        let mut outcomes = vec![];
        for left in 1..40 {
            let mut cut = Chip { bytes: chip.bytes.clone(), left: usize::MAX, ..Chip::new(4096) };
            if prepared {
                let flash = cut.flash();
                // SAFETY: the chip lives longer than the call.
                assert_eq!(unsafe { bw_flash_prepare(&raw const flash) }, BwCode::Ok);
            }
            cut.left = left;
            let saved = save(&mut cut, state);
            cut.left = usize::MAX;
            let mut other = Memory::new();
            let again = other.state(FILE).expect("a good model");
            assert_eq!(restore(&mut cut, again), BwCode::Ok, "{left}");
            let expected = if saved == BwCode::Ok { segments + 1 } else { segments };
            assert_eq!(alarm(again).segments, expected, "{left}: {saved:?}");
            outcomes.push(saved);
        }
        assert!(outcomes.contains(&BwCode::FlashFailed) && outcomes.last() == Some(&BwCode::Ok), "{outcomes:?}");
    }
}

#[test]
fn a_model_is_stored_and_the_state_of_another_is_refused() {
    let mut chip = Chip::new(8192);
    let (flash, mut buffer, mut length) = (chip.flash(), [0; 8192], 0);
    // SAFETY: the chip and the buffers live longer than the calls.
    unsafe {
        assert_eq!(bw_flash_store_model(&raw const flash, FILE.as_ptr(), FILE.len()), BwCode::Ok);
        let load = bw_flash_load_model(&raw const flash, buffer.as_mut_ptr(), buffer.len(), &raw mut length);
        assert_eq!((load, &buffer[..length]), (BwCode::Ok, FILE));
        let load = bw_flash_load_model(&raw const flash, buffer.as_mut_ptr(), 10, &raw mut length);
        assert_eq!(load, BwCode::BufferTooSmall);
    }
    let mut memory = Memory::new();
    let state = memory.state(FILE).expect("a good model");
    assert_eq!(restore(&mut chip, state), BwCode::FlashNoRecord, "a model is no state");
}

#[test]
fn the_newest_record_of_this_model_is_restored_or_the_newest_is_refused_by_its_code() {
    /// Puts something into a chip, as the newest record.
    type Put<'a> = &'a dyn Fn(&mut Chip);
    let [mut memory, mut changed] = [(); 2].map(|()| Memory::new());
    let state = memory.state(FILE).expect("a good model");
    let mut constants = MODEL.constants().clone();
    constants.classifier.discriminant.log_prior[0] -= 0.5;
    let of_other = changed.state(&bytes(&Drive::model(constants).expect("a good model"))).expect("a good model");
    let label = RecordLabel { model: 0, drive: Label::constant("") };
    let good: Put<'_> = &|chip| assert_eq!(save(chip, state), BwCode::Ok);
    let other: Put<'_> = &|chip| assert_eq!(save(chip, of_other), BwCode::Ok);
    let strange: Put<'_> = &|chip| {
        let pair = SlotPair::<64>::new(chip, START, 4096, RecordKind::State).expect("two places");
        pair.store(chip, &label, b"no state, with a good checksum").expect("it fits");
    };
    let restored = |records: [Put<'_>; 2]| {
        let mut chip = Chip::new(4096);
        records.iter().for_each(|put| put(&mut chip));
        restore(&mut chip, state)
    };
    assert_eq!([restored([good, strange]), restored([good, other])], [BwCode::Ok; 2], "the one before");
    assert_eq!(restored([other, strange]), BwCode::SavedState);
    assert_eq!(restored([strange, other]), BwCode::OtherModel);
}

#[test]
fn what_no_flash_can_be_is_refused() {
    let mut memory = Memory::new();
    let state = memory.state(FILE).expect("a good model");
    let mut chip = Chip::new(4096);
    let good = chip.flash();
    let code = |flash: &BwFlash, size: usize| {
        let mut buffer = [0; 1024];
        // SAFETY: the chip, the state and the buffer live longer than the call.
        unsafe { bw_flash_save(flash, state, buffer.as_mut_ptr(), size) }
    };
    assert_eq!(code(&BwFlash { start: 1025, ..good }, 1024), BwCode::FlashPlaces);
    assert_eq!(code(&BwFlash { place_bytes: 32, ..good }, 1024), BwCode::FlashPlaces);
    assert_eq!(code(&BwFlash { place_bytes: 96, ..good }, 1024), BwCode::FlashTooSmall);
    assert_eq!(code(&BwFlash { write: None, ..good }, 1024), BwCode::FlashFailed);
    assert_eq!(code(&good, 3), BwCode::BufferTooSmall);
    // SAFETY: NULL is refused.
    let null =
        unsafe { [bw_flash_prepare(core::ptr::null()), bw_flash_store_model(&raw const good, core::ptr::null(), 5)] };
    assert_eq!(null, [BwCode::Null; 2]);
    let mut buffer = [0; 64];
    // SAFETY: NULL is refused.
    let load = unsafe { bw_flash_load_model(&raw const good, buffer.as_mut_ptr(), 64, null_mut()) };
    assert_eq!(load, BwCode::Null);
}
