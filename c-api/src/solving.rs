//! What the main loop calls: a closed segment → its report.

use bearing_watch::Verdict;

use crate::code::{BwCode, Outcome, code};
use crate::memory::at;
use crate::state::{BwState, OwnMonitor, count_on};

/// Does the next step of the solve of the closed segment, of bounded cost; call it again and again in the main loop.
/// The first step takes the segment, so that the interrupt can close the next one. The alarm takes account of the
/// report, unless `bw_discard` has withdrawn it.
///
/// Returns `BW_CODE_OK` if there is more to do, `BW_CODE_REPORT` with the last step, or `BW_CODE_IDLE` if there is no
/// closed segment.
///
/// # Safety
/// `state` is NULL, or was given by `bw_init` or has as many readable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_advance(state: *mut BwState) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { at(state) }.and_then(|state| state.settled(|monitor| advance(state, monitor))))
}

/// Solves the closed segment as a whole, or what `bw_advance` has left of it, with the same bits.
///
/// Returns `BW_CODE_REPORT`, or `BW_CODE_IDLE` if there is no closed segment.
///
/// # Safety
/// As `bw_advance`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_conclude(state: *mut BwState) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { at(state) }.and_then(|state| state.settled(|monitor| conclude(state, monitor))))
}

/// Takes the closed segment, if none is being solved.
fn take(state: &BwState, monitor: &mut OwnMonitor) {
    if !monitor.is_solving() {
        // SAFETY: the caller holds the main loop's half of the state.
        unsafe { state.closed.empty(|place| monitor.take_from(place)) };
    }
}

fn advance(state: &BwState, monitor: &mut OwnMonitor) -> BwCode {
    take(state, monitor);
    match (monitor.is_solving(), monitor.advance()) {
        (_, Some(now)) => reported(state, now.report.verdict),
        (true, None) => BwCode::Ok,
        (false, None) => BwCode::Idle,
    }
}

fn conclude(state: &BwState, monitor: &mut OwnMonitor) -> BwCode {
    take(state, monitor);
    monitor.complete().map_or(BwCode::Idle, |now| reported(state, now.report.verdict))
}

/// Counts a report with a verdict, for the clock.
pub(crate) fn reported(state: &BwState, verdict: Verdict) -> BwCode {
    if !matches!(verdict, Verdict::Undetermined(_)) {
        count_on(&state.verdicts);
    }
    BwCode::Report
}

/// Makes the estimate of the report the auxiliary model of instrumental variables; other models need no call. It must
/// come before `handover` samples (`bw_info`) of the next segment have been taken, with the interrupt masked. A model
/// whose `handover` is 0 adopts by `bw_step` only.
///
/// Returns `BW_CODE_OK`, `BW_CODE_NOT_ADOPTED`, or `BW_CODE_NO_REPORT`.
///
/// # Safety
/// As `bw_advance`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_adopt(state: *mut BwState) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { at(state) }.and_then(|state| state.settled(|monitor| adopt(state, monitor)).flatten()))
}

fn adopt(state: &BwState, monitor: &OwnMonitor) -> Outcome {
    let report = monitor.report().ok_or(BwCode::NoReport)?;
    let adopted = state.sampling.with(|detector| detector.adopt(report))?;
    Ok(if adopted { BwCode::Ok } else { BwCode::NotAdopted })
}
