//! The queue from the current loop to an interrupt below it, which runs the detector.

use core::sync::atomic::Ordering;

use bearing_watch::known_answer_test;

use crate::code::{BwCode, Outcome, code};
use crate::memory::at;
use crate::sampling::{self, sample, take_into};
use crate::state::{BwState, OwnDetector};
use crate::waiting::Put;

/// Puts a sample into a queue of four in the interrupt of the current loop, for `bw_collect_waiting` in an interrupt
/// below it, which may come up to three samples late. `values` and `angle` are those of `bw_collect`; `found_late` is
/// that of `BwCleanSample`.
///
/// Returns `BW_CODE_OK`, `BW_CODE_WRONG_CHANNEL_COUNT`, or `BW_CODE_SAMPLE_LOST` if four samples wait: this one then
/// counts as one with bad values. Request the interrupt below after both `BW_CODE_OK` and `BW_CODE_SAMPLE_LOST`, or a
/// full queue stays full.
///
/// # Safety
/// `state` is NULL, or was given by `bw_init` or has as many readable bytes. `values` is NULL or has `count` readable
/// values. Only one context calls this function.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_put(
    state: *mut BwState,
    values: *const f32,
    count: usize,
    angle: u32,
    found_late: bool,
) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { sample(state, values, count, angle) }.and_then(|(state, sample)| {
        // SAFETY: the same contract.
        unsafe { state.waiting.put(sample, found_late) }.inspect_err(|_| sampling::count(&state.lost_samples))?;
        Ok(BwCode::Ok)
    }))
}

/// Takes all samples that wait, as `bw_collect` and `bw_discard` do, in an interrupt below the current loop or in the
/// same one. The first call tests the arithmetic of its context (`bw_known_answer_test`): call it once before the power
/// stage is on. If the test fails, the samples stay, and no segment closes.
///
/// Returns `BW_CODE_OK`, `BW_CODE_SEGMENT` or `BW_CODE_SEGMENT_LOST` as `bw_collect` does, `BW_CODE_ARITHMETIC`, or
/// `BW_CODE_BUSY` if it interrupted `bw_adopt`, `bw_restart` or the like: the samples then wait for the next call.
///
/// # Safety
/// `state` is NULL, or was given by `bw_init` or has as many readable bytes. Only one context calls this function.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_collect_waiting(state: *mut BwState) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { at(state) }.and_then(|state| state.sampling.with(|detector| take_all(state, detector)).flatten()))
}

fn take_all(state: &BwState, detector: &mut OwnDetector) -> Outcome {
    if !state.waiting.tested.load(Ordering::Relaxed) {
        known_answer_test().map_err(|_| {
            state.waiting.failed.store(true, Ordering::Relaxed);
            BwCode::Arithmetic
        })?;
        state.waiting.failed.store(false, Ordering::Relaxed);
        state.waiting.tested.store(true, Ordering::Relaxed);
    }
    let mut outcome = Ok(BwCode::Ok);
    // SAFETY: this function holds the sampling half of the state.
    while let Some(Put { sample, found_late, missed }) = unsafe { state.waiting.take() } {
        if found_late && let Some(number) = detector.discard() {
            state.doubted.store(number, Ordering::Relaxed);
        }
        if missed > 0 {
            state.missed.store(state.missed.load(Ordering::Relaxed).saturating_add(missed), Ordering::Relaxed);
        }
        match take_into(state, detector, &sample) {
            Ok(BwCode::Ok) => {}
            closed => outcome = closed,
        }
    }
    outcome
}
