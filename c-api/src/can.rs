//! The report of a segment in one data frame of 8 bytes, for a line that is CAN or CAN FD.

use bearing_watch::telemetry::SegmentFrame;

use crate::code::{BwCode, code};
use crate::memory::{at, check, put};
use crate::state::BwState;

/// Bytes of the frame of `bw_can_frame`.
pub const BW_CAN_FRAME_SIZE: usize = 8;

/// Writes the last segment, as `bw_report` and `bw_alarm` give it, into the `BW_CAN_FRAME_SIZE` bytes of a CAN frame:
/// number, verdict with its reason, alarm with its cause, silence, usable share and distance. Send one after each
/// `BW_CODE_REPORT`, under any identifier, and again if `bw_discard` has withdrawn the report. `bearing-watch dbc`
/// writes the DBC file of the frame, and `bearing-watch listen --can-id` reads it from logs.
///
/// Returns `BW_CODE_OK`, `BW_CODE_NO_REPORT`, or `BW_CODE_BUSY`; the bytes are then as before.
///
/// # Safety
/// `state` is NULL, or was given by `bw_init` or has as many readable bytes. `frame` is NULL or has
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
