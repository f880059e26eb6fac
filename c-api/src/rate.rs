//! Rows against the clock of the firmware.

use bearing_watch::Implausible;

use crate::code::{BwCode, code};
use crate::memory::at;
use crate::state::BwState;

/// Compares the number of samples that `bw_collect` was given so far with a clock, in milliseconds; both may wrap. Call
/// it in the main loop, as often as you like; no time counts before the first sample. If over ten seconds the samples
/// did not come at the rate of the model, to two per cent, no segment has a verdict (`BW_REASON_IMPLAUSIBLE`) until
/// they do. Rows that come twice, held or interpolated, are found by nothing else. A pause of the samples counts as a
/// wrong rate.
///
/// Returns `BW_CODE_OK`, `BW_CODE_OUT_OF_RANGE` if the interval of the model is not known, or `BW_CODE_BUSY`.
///
/// # Safety
/// As `bw_advance`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_check_rate(state: *mut BwState, samples: u32, milliseconds: u32) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { at(state) }.and_then(|state| {
        if state.model.constants().sampling.interval_s <= 0.0 {
            return Err(BwCode::OutOfRange);
        }
        if let Some(right) = state.rate.with(|rate| rate.push(samples, milliseconds))? {
            state.settled(|monitor| monitor.refuse((!right).then_some(Implausible::Rate)))?;
        }
        Ok(BwCode::Ok)
    }))
}
