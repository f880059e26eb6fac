//! What the current loop and the interrupt below it call.

use bearing_watch::Angle;
use bearing_watch::plan::Signals as _;

use crate::code::{BwCode, code};
use crate::front_end::sample::{BwRawSample, read};
use crate::memory::{at, elements};
use crate::plan::Sample;
use crate::state::BwState;

/// Takes a sample of signals that the drive has itself, at the sampling rate of the model, into a queue of four for
/// `bw_collect`. `values` are the channels in the order of the model, in the unit that each name says; `angle` is the
/// shaft's (`bw_angle`), 0 if the model needs none. Bad values, such as NaN, are counted and left out. A sample that
/// finds the queue full takes the place of the one before the queue, which counts as one with bad values
/// (`BwStatus::lost_samples`).
///
/// Returns `BW_CODE_COLLECT` if samples wait: request the interrupt of `bw_collect`. `BW_CODE_OK` if it interrupted
/// another function of this state; `BW_CODE_WRONG_CHANNEL_COUNT`; or `BW_CODE_OUT_OF_RANGE` if the state has a front
/// end.
///
/// # Safety
/// `state` is NULL, or was given by `bw_start` or has as many readable bytes. `values` is NULL or has `count` readable
/// values.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_sample(state: *mut BwState, values: *const f32, count: usize, angle: u32) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { at(state) }.and_then(|state| {
        if count != usize::from(state.model.plan().layout().channels) {
            return Err(BwCode::WrongChannelCount);
        }
        if state.further.is_some() {
            return Err(BwCode::OutOfRange);
        }
        // SAFETY: the same contract.
        let sample = Sample::of(unsafe { elements(values, count)? }, Angle::from_bits(angle));
        Ok(waits(state.watch.sample_signals(sample)))
    }))
}

/// Takes what the current loop has read, at its rate, in its interrupt. `further` are the further channels of the
/// front end in their order and units, NaN if missing; it may be NULL if `count`, their number, is 0. Wrong counts,
/// angles and values are counted, and are missing from the samples: their channels are NaN.
///
/// Returns `BW_CODE_COLLECT` if samples wait: request the interrupt of `bw_collect`; `BW_CODE_OK`;
/// `BW_CODE_WRONG_CHANNEL_COUNT`; or `BW_CODE_OUT_OF_RANGE` if `phases` or `position` of the sample is, or if the state
/// has no front end. A sample that is not taken is a gap in the numbers.
///
/// # Safety
/// `state` is NULL, or was given by `bw_start` or has as many readable bytes. `raw` is NULL or readable. `further` is
/// NULL or has `count` readable values.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_sample_raw(
    state: *mut BwState,
    raw: *const BwRawSample,
    further: *const f32,
    count: usize,
) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { at(state) }.and_then(|state| {
        let used = state.further.ok_or(BwCode::OutOfRange)?;
        // SAFETY: the same contract.
        let raw = unsafe { read(raw, (further, count), used)? };
        Ok(waits(state.watch.sample(raw)))
    }))
}

const fn waits(waits: bool) -> BwCode {
    if waits { BwCode::Collect } else { BwCode::Ok }
}

/// Takes all samples that wait into the detector, in an interrupt below the current loop, up to three samples late, or
/// behind `bw_sample` in the same one. The first call tests the arithmetic of its context (`bw_known_answer_test`), in
/// some hundred thousand instructions: call it once before the power stage is on. If the test fails, no segment closes,
/// and `bw_clock` says so.
///
/// Returns `BW_CODE_SEGMENT` if a segment has closed, for a main loop that sleeps, or `BW_CODE_OK`, also if it
/// interrupted another function: the samples then wait for the next call.
///
/// # Safety
/// `state` is NULL, or was given by `bw_start` or has as many readable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_collect(state: *mut BwState) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { at(state) }.map(|state| closed(state.watch.collect())))
}

pub(crate) const fn closed(closed: bool) -> BwCode {
    if closed { BwCode::Segment } else { BwCode::Ok }
}

/// Starts the open segment afresh, for a stream that does not continue from the last sample: after a pause, or at
/// power-up of the motor. Samples that wait are dropped; a closed segment, report and alarm remain. In the interrupt of
/// `bw_collect`, or while the interrupts are stopped.
///
/// Returns `BW_CODE_OK` or `BW_CODE_BUSY`.
///
/// # Safety
/// As `bw_collect`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_restart(state: *mut BwState) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { at(state) }.and_then(|state| if state.watch.restart() { Ok(BwCode::Ok) } else { Err(BwCode::Busy) }))
}
