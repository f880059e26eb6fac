//! The state in the caller's memory: a [`Watch`] of the core, and the model that it has.

use core::ffi::c_void;
use core::mem::{ManuallyDrop, offset_of};

use bearing_watch::watch::Watch;
use bearing_watch::{Model, Monitor, known_answer_test};

use crate::code::{BwCode, Outcome, code};
use crate::front_end::{BwFrontEnd, Front};
use crate::memory::{BW_STATE_ALIGN, Object, Tag, at, check, elements, put, room};
use crate::plan::Own;

/// Bytes of memory that are enough for `bw_start` of a library without a plan of its own; `bw_state_size` returns what
/// exactly is needed.
pub const BW_STATE_SIZE: usize = 23552;

const _: () = assert!(size_of::<WithModel>() <= BW_STATE_SIZE || cfg!(bearing_watch_plan));
const _: () = assert!(align_of::<BwState>() <= BW_STATE_ALIGN);

/// The diagnosis of one drive, in memory of the caller.
#[derive(Debug)]
pub struct BwState {
    tag: Tag,
    /// Further channels in use; `None` without a front end.
    pub(crate) further: Option<u16>,
    pub(crate) model: &'static Model<Own>,
    pub(crate) watch: Watch<Own, Front>,
}

/// A state with the model that it read.
#[repr(C)]
struct WithModel {
    state: BwState,
    model: Model<Own>,
}

/// What the main loop works on.
pub(crate) type OwnMonitor = Monitor<'static, Own>;

impl BwState {
    /// Works on what the main loop works on, once a report in doubt is withdrawn.
    ///
    /// # Errors
    /// [`BwCode::Busy`].
    pub(crate) fn settled<R>(&self, work: impl FnOnce(&mut OwnMonitor) -> R) -> Outcome<R> {
        self.watch.monitor(work).ok_or(BwCode::Busy)
    }
}

impl Object for WithModel {
    const MARK: u32 = BwState::MARK;
    const PLACE_OF_TAG: usize = offset_of!(Self, state) + BwState::PLACE_OF_TAG;
}

impl Object for BwState {
    const MARK: u32 = 0x4257_4331;
    const PLACE_OF_TAG: usize = offset_of!(Self, tag);
}

/// Returns the number of bytes of memory that `bw_start` needs: with a plan of its own a library needs less.
#[unsafe(no_mangle)]
pub extern "C" fn bw_state_size() -> usize {
    size_of::<WithModel>()
}

/// Starts the diagnosis of a drive in memory of the caller, by a model as `bearing-watch train --model` or `--c`
/// writes it, and gives the address of its state in `state`. `front_end` is that of `bw_front_end_init` for a drive
/// that gives raw counts to `bw_sample_raw`, and belongs to the state from here on; NULL for one that gives signals
/// of its own to `bw_sample`. What follows the model, such as the erased rest of a flash sector, is ignored. The
/// bytes of the model are not needed afterwards. Needs about three times the memory of a model on the stack. Call it
/// before the interrupts run, or behind `bw_stop`: another model and other constants need no reboot.
///
/// Returns `BW_CODE_OK`; or what is wrong with memory or model; `BW_CODE_MODEL_INTERVAL` or `BW_CODE_MODEL_PARK` if the
/// model was trained with another front end, `BW_CODE_FRONT_END_FURTHER` if it has other channels;
/// `BW_CODE_ARITHMETIC` (`bw_known_answer_test`); or `BW_CODE_BUSY` if a state runs in this memory. Nothing is changed
/// then, and nothing runs that did not run before: a start with a right model may follow.
///
/// # Safety
/// `memory` is NULL or has `size` writable bytes, which nothing else writes until the state is used no more. `model`
/// is NULL or has `length` readable bytes. `front_end` is NULL, or was given by `bw_front_end_init` or has as many
/// writable bytes. `state` is NULL or writable. No other function works on the state.
#[must_use]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_start(
    memory: *mut c_void,
    size: usize,
    model: *const u8,
    length: usize,
    front_end: *mut BwFrontEnd,
    state: *mut *mut BwState,
) -> BwCode {
    let start = || {
        check(state)?;
        let whole: *mut WithModel = room(memory, size)?;
        // SAFETY: the memory is large enough, aligned, and writable by the contract, and no other function works on it;
        // the bytes are readable by the contract. What was there owns nothing that would have to be dropped. The model
        // is never changed, and stays where it is as long as the state that borrows it: both are in this memory.
        unsafe {
            place_model(whole, elements(model, length)?, front_end)?;
            fill(whole.cast(), &(*whole).model, front_end, state)
        }
    };
    code(start())
}

/// As `bw_start`, with the model that the library was built with (`BEARING_WATCH_PLAN=model.rs`), whose number in the
/// model's header is `id`. No model is read or checked when it runs: the compiler has done that. It needs less memory
/// than `bw_start`, little stack, and half of the flash.
///
/// Returns what `bw_start` does, or `BW_CODE_MODEL_DOES_NOT_FIT` if the library was built with another model or with
/// none.
///
/// # Safety
/// As `bw_start`.
#[must_use]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_start_own(
    memory: *mut c_void,
    size: usize,
    id: u32,
    front_end: *mut BwFrontEnd,
    state: *mut *mut BwState,
) -> BwCode {
    let start = || {
        check(state)?;
        let own: *mut BwState = room(memory, size)?;
        let model = own_model().filter(|model| model.id() == id).ok_or(BwCode::ModelDoesNotFit)?;
        // SAFETY: the memory is large enough, aligned, and writable by the contract, and no other function works on it.
        unsafe {
            fits(model, front_end)?;
            is_free(own)?;
            fill(own, model, front_end, state)
        }
    };
    code(start())
}

/// The model that the library was built with.
#[cfg(bearing_watch_plan)]
fn own_model() -> Option<&'static Model<Own>> {
    Some(&crate::plan::MODEL)
}

#[cfg(not(bearing_watch_plan))]
const fn own_model() -> Option<&'static Model<Own>> {
    None
}

/// Whether the chip computes as the host, and the model was trained with such a front end.
///
/// # Safety
/// As for [`bw_start`].
unsafe fn fits(model: &Model<Own>, front_end: *const BwFrontEnd) -> Outcome<()> {
    known_answer_test().map_err(|_| BwCode::Arithmetic)?;
    // SAFETY: the contract of the caller.
    if front_end.is_null() { Ok(()) } else { unsafe { at(front_end) }?.check(model) }
}

/// Whether no state runs in the memory.
///
/// # Safety
/// As for [`bw_start`].
unsafe fn is_free(own: *const BwState) -> Outcome<()> {
    // SAFETY: the contract of the caller.
    if unsafe { at(own) }.is_ok() { Err(BwCode::Busy) } else { Ok(()) }
}

/// Reads the model, and puts it in its place if it is good. The state is not valid from there on.
// Out of line, so that it takes no stack while the state is made.
#[inline(never)]
unsafe fn place_model(whole: *mut WithModel, bytes: &[u8], front_end: *const BwFrontEnd) -> Outcome<()> {
    let model = ManuallyDrop::new(Model::<Own>::from_sector(bytes));
    match &*model {
        Ok(model) => {
            // SAFETY: the contract of the caller; the other model is neither used nor dropped after this. To take it
            // out of the result would move it once more on the stack.
            unsafe {
                fits(model, front_end)?;
                is_free(&raw const (*whole).state)?;
                (&raw mut (*whole).model).copy_from_nonoverlapping(model, 1);
            }
            Ok(())
        }
        Err(error) => Err((*error).into()),
    }
}

/// Makes the state around a model and a front end that fit.
///
/// # Safety
/// The state has its memory, and no other function works on it. `front_end` and `state` are as for [`bw_start`].
unsafe fn fill(
    own: *mut BwState,
    model: &'static Model<Own>,
    front_end: *mut BwFrontEnd,
    state: *mut *mut BwState,
) -> Outcome {
    // SAFETY: the contract of the caller; a state that was here before owns nothing that would have to be dropped,
    // and the memory is there until the new one is used no more.
    unsafe {
        let (front, further) = Front::take(front_end, model)?;
        (&raw mut (*own).tag).write(Tag::none());
        (&raw mut (*own).model).write(model);
        (&raw mut (*own).further).write(further);
        (&raw mut (*own).watch).write(Watch::new());
        let watch: &'static Watch<Own, Front> = &(*own).watch;
        watch.start_around(model, front).map_err(|_| BwCode::Busy)?; // a new watch has no start
        (*own).tag.set(own);
        put(state, own)?;
    }
    Ok(BwCode::Ok)
}

/// Ends the diagnosis, so that `bw_start` can follow in the same memory; the front end is to be initialised again, too.
/// Save what `bw_end_run` writes before. In the main loop; the interrupts may go on, and are refused.
///
/// Returns `BW_CODE_OK`, or `BW_CODE_BUSY` if another context is in a call: nothing is changed then.
///
/// # Safety
/// `state` is NULL, or was given by `bw_start` or has as many readable bytes.
#[must_use]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_stop(state: *mut BwState) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { at(state) }.and_then(|state| {
        if !state.watch.stop() {
            return Err(BwCode::Busy);
        }
        state.tag.clear();
        Ok(BwCode::Ok)
    }))
}
