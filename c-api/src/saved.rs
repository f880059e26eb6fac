//! The state of the alarm as bytes, so that it survives power-off.

use bearing_watch::Evidence;
use bearing_watch::alarm::StateError;

use crate::code::{BwCode, Outcome, code};
use crate::memory::{at, check, elements, elements_mut, put};
use crate::state::BwState;

/// Gives the number of bytes that `bw_save` writes for the model of this state.
///
/// # Safety
/// `state` is NULL, or was given by `bw_start` or has as many readable bytes. `length` is NULL or writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_saved_size(state: *const BwState, length: *mut usize) -> BwCode {
    // SAFETY: the same contract.
    let size = unsafe { at(state) }.map(|state| Evidence::saved_len(state.model));
    // SAFETY: the same contract.
    code(size.and_then(|size| unsafe { put(length, size) }).map(|()| BwCode::Ok))
}

/// Ends a run (from power-up to power-up, a session), whose segments depend on each other, and writes alarm and scores
/// into `bytes` and their number into `length`, to be stored where they survive power-off; the next start gives them to
/// `bw_restore`. Call it at power-down or where a session ends, unless the model was trained with `--segments-a-run`.
/// `bytes` may be NULL: nothing is written then, and `length` is not used. A segment that is being solved is concluded
/// first, and belongs to the run; the open segment is not saved.
///
/// Returns `BW_CODE_OK`, `BW_CODE_BUFFER_TOO_SMALL` if `capacity` is less than `bw_saved_size` gives (the run has
/// ended), or `BW_CODE_BUSY`.
///
/// # Safety
/// `state` is NULL, or was given by `bw_start` or has as many readable bytes. `bytes` is NULL or has `capacity`
/// writable bytes. `length` is NULL or writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_end_run(
    state: *mut BwState,
    bytes: *mut u8,
    capacity: usize,
    length: *mut usize,
) -> BwCode {
    // SAFETY: the same contract.
    let ended = unsafe { at(state) }.and_then(|state| state.settled(|monitor| _ = monitor.end_run()));
    // SAFETY: the same contract.
    let write = |()| unsafe {
        if !bytes.is_null() {
            check(length)?;
            put(length, save(state, bytes, capacity)?.0.len())?;
        }
        Ok(BwCode::Ok)
    };
    code(ended.and_then(write))
}

/// Writes alarm and scores of a run that goes on into `bytes`, for a power-off that comes without a warning. The open
/// segment is not saved.
///
/// Returns `BW_CODE_OK`, `BW_CODE_BUFFER_TOO_SMALL` if `capacity` is less than `bw_saved_size` gives, or
/// `BW_CODE_BUSY`.
///
/// # Safety
/// `state` is NULL, or was given by `bw_start` or has as many readable bytes. `bytes` is NULL or has `capacity`
/// writable bytes.
#[must_use]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_save(state: *mut BwState, bytes: *mut u8, capacity: usize) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { save(state, bytes, capacity) }.map(|_| BwCode::Ok))
}

/// Writes the state; returns the bytes that were written, and the id of the model.
///
/// # Safety
/// As [`bw_save`].
pub(crate) unsafe fn save<'a>(state: *mut BwState, bytes: *mut u8, capacity: usize) -> Outcome<(&'a [u8], u32)> {
    // SAFETY: the contract of the caller.
    let state = unsafe { at(state) }?;
    check(bytes)?;
    let size = Evidence::saved_len(state.model);
    if capacity < size {
        return Err(BwCode::BufferTooSmall);
    }
    // SAFETY: writable by the contract; no other reference to them exists during this call.
    let buffer = unsafe { elements_mut(bytes, size) }?;
    state.settled(|monitor| monitor.evidence().save(state.model, buffer))?.map_err(refusal)?;
    Ok((buffer, state.model.id()))
}

/// Continues from the alarm and scores that `bw_save` wrote, for this model; there is no report then, and a
/// segment that was being solved is left out. In case of an error nothing changes.
///
/// Returns `BW_CODE_OK`, `BW_CODE_SAVED_STATE` if the bytes are not a saved state of this version or are corrupted,
/// `BW_CODE_OTHER_MODEL` if they are that of another model, or `BW_CODE_BUSY`.
///
/// # Safety
/// `state` is NULL, or was given by `bw_start` or has as many readable bytes. `bytes` is NULL or has `length` readable
/// bytes.
#[must_use]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_restore(state: *mut BwState, bytes: *const u8, length: usize) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { elements(bytes, length) }.and_then(|bytes| unsafe { restore(state, bytes) }))
}

/// Continues from these bytes.
///
/// # Safety
/// `state` is as for [`bw_restore`].
pub(crate) unsafe fn restore(state: *mut BwState, bytes: &[u8]) -> Outcome {
    // SAFETY: the contract of the caller.
    unsafe { at(state) }?.settled(|monitor| monitor.restore(bytes))?.map_err(refusal)?;
    Ok(BwCode::Ok)
}

fn refusal(error: StateError) -> BwCode {
    match error {
        StateError::BufferTooSmall => BwCode::BufferTooSmall,
        StateError::OtherModel { .. } => BwCode::OtherModel,
        // Not a state, of another version or length, corrupted, and what a later version of the core adds.
        _ => BwCode::SavedState,
    }
}
