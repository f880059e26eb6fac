//! For a line that is CAN or CAN FD: the report of a segment in one data frame of 8 bytes, and frames of the telemetry
//! in as many data frames as they need.

use core::ffi::c_void;

use bearing_watch::telemetry::{CanPieces, SegmentFrame};

use crate::code::{BwCode, Outcome, code};
use crate::memory::{at, check, elements, get, put};
use crate::state::BwState;

/// Bytes of the frame of `bw_can_frame`.
pub const BW_CAN_FRAME_SIZE: usize = 8;

/// Writes the last segment, as `bw_report` and `bw_alarm` give it, into the `BW_CAN_FRAME_SIZE` bytes of a CAN frame:
/// number, verdict with its reason, alarm with its cause, silence, usable share and distance. Send one after each
/// `BW_CODE_REPORT`, under any identifier, and again with `BW_CODE_WITHDRAWN`. `bearing-watch dbc`
/// writes the DBC file of the frame, and `bearing-watch listen --can-id` reads it from logs.
///
/// Returns `BW_CODE_OK`, `BW_CODE_NO_REPORT`, or `BW_CODE_BUSY`; the bytes are then as before.
///
/// # Safety
/// `state` is NULL, or was given by `bw_start` or has as many readable bytes. `frame` is NULL or has
/// `BW_CAN_FRAME_SIZE` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_can_frame(state: *mut BwState, frame: *mut u8) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { at(state) }.and_then(|state| {
        check(frame)?;
        let sent = state.settled(|monitor| {
            monitor.report().map(|report| SegmentFrame::of(state.model, report, monitor.evidence()).to_bytes())
        })?;
        let bytes = sent.ok_or(BwCode::NoReport)?;
        // SAFETY: an array of bytes has their alignment, and so many are writable by the contract.
        unsafe { put(frame.cast::<[u8; BW_CAN_FRAME_SIZE]>(), bytes)? };
        Ok(BwCode::Ok)
    }))
}

/// Sends the `size` bytes of a data frame under the identifier of the stream; returns 0 if the bus has taken them.
pub type BwCanSend = Option<unsafe extern "C" fn(context: *mut c_void, data: *const u8, size: usize) -> i32>;

/// Sends a frame that `bw_telemetry_…` has made, in data frames of at most `most` bytes: 8, or 64 for CAN FD, whose
/// lengths are then kept. `number` counts them: a byte of yours, 0 at start, that is kept from call to call.
/// `bearing-watch listen --can-stream` joins them, and counts lost and doubled ones.
///
/// Returns `BW_CODE_OK`, `BW_CODE_OUT_OF_RANGE` for another `most`, or `BW_CODE_CAN_FAILED` if `send` has failed: the
/// rest of the frame is then not sent, and the receiver counts it as lost.
///
/// # Safety
/// `number` is NULL, or readable and writable. `frame` is NULL or has `length` readable bytes. `send` may be called
/// with `context`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_can_stream(
    number: *mut u8,
    frame: *const u8,
    length: usize,
    most: usize,
    send: BwCanSend,
    context: *mut c_void,
) -> BwCode {
    let stream = || -> Outcome {
        let pieces = match most {
            8 => CanPieces::classic(),
            64 => CanPieces::fd(),
            _ => return Err(BwCode::OutOfRange),
        };
        let send = send.ok_or(BwCode::Null)?;
        // SAFETY: the contract of the caller.
        let (first, frame) = unsafe { (get(number)?, elements(frame, length)?) };
        let mut pieces = pieces.with_number(first);
        let sent = pieces.cut(frame).all(|piece| {
            let data = piece.data();
            // SAFETY: the contract of the caller; the bytes live until the call returns.
            unsafe { send(context, data.as_ptr(), data.len()) == 0 }
        });
        // SAFETY: the contract of the caller.
        unsafe { put(number, pieces.number())? };
        if sent { Ok(BwCode::Ok) } else { Err(BwCode::CanFailed) }
    };
    code(stream())
}
