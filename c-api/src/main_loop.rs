//! What the main loop calls: closed segments, and the clock.

use bearing_watch::watch::Lapse;
use bearing_watch::{Conclusion, LivenessLimits};

use crate::about::fault_number;
use crate::alarm::{self, BwAlarm};
use crate::code::{BwCode, Outcome, code};
use crate::front_end::faults::{BwAlignment, BwFrontEndFaults};
use crate::memory::{at, check, put};
use crate::plan::Own;
use crate::report::{BwReport, summary};
use crate::state::BwState;

/// Does the next step of the solve of a closed segment, of bounded cost; call it again and again in the main loop. The
/// last step writes the report and the alarm that stands; either may be NULL.
///
/// Returns `BW_CODE_REPORT` with the last step; `BW_CODE_WITHDRAWN` if the last report has lost its verdict because a
/// fault was found late (`BW_REASON_FOUND_LATE`): report and alarm are those without it; `BW_CODE_OK` if there is
/// more to do; `BW_CODE_IDLE` if there is no closed segment; or `BW_CODE_BUSY`.
///
/// # Safety
/// `state` is NULL, or was given by `bw_start` or has as many readable bytes. `report` and `alarm` are NULL or
/// writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_advance(state: *mut BwState, report: *mut BwReport, alarm: *mut BwAlarm) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { at(state) }.and_then(|state| unsafe { advance(state, report, alarm) }))
}

unsafe fn advance(state: &BwState, report: *mut BwReport, alarm_to: *mut BwAlarm) -> Outcome {
    if !report.is_null() {
        check(report)?;
    }
    if !alarm_to.is_null() {
        check(alarm_to)?;
    }
    // SAFETY: writable by the contract.
    let tell = |now: Conclusion<'_, Own>| unsafe {
        if !report.is_null() {
            put(report, summary(state.watch.status(), now.report, now.evidence))?;
        }
        if !alarm_to.is_null() {
            put(alarm_to, alarm::of(state, now.evidence))?;
        }
        Ok(if now.withdrawn { BwCode::Withdrawn } else { BwCode::Report })
    };
    state.watch.advance(tell).unwrap_or_else(|| {
        let solving = state.settled(|monitor| monitor.is_solving())?;
        Ok(if solving { BwCode::Ok } else { BwCode::Idle })
    })
}

/// Compares what was done so far with a clock, in milliseconds with wrap-around, which the timer of the samples does
/// not make. Call it in the main loop, as often as you like: the times count from the first call, and anew from
/// `bw_restart` and from the last sample of `bw_check_wiring`.
///
/// Returns `BW_CODE_OK`, `BW_CODE_OUT_OF_RANGE` if the interval of the model is not known, `BW_CODE_BUSY`, or why the
/// drive is not watched as it should be, each reason once until it is right again: `BW_CODE_NO_SAMPLE`,
/// `BW_CODE_NOT_COLLECTED` or `BW_CODE_ARITHMETIC` if no sample was taken for three seconds; `BW_CODE_NO_SEGMENT` if
/// no segment has closed for three of its durations and three seconds; `BW_CODE_NO_VERDICT` if none has had a verdict
/// for 24 hours; `BW_CODE_WRONG_RATE` if over ten seconds samples did not come at the rate of the model, to two per
/// cent. While they do not, no segment has a verdict (`BW_REASON_IMPLAUSIBLE`), and what the first ten seconds have
/// added to the alarm is taken out again. Rows that come twice, held or interpolated, are found by nothing else.
///
/// # Safety
/// `state` is NULL, or was given by `bw_start` or has as many readable bytes.
#[must_use]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_clock(state: *mut BwState, milliseconds: u32) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { at(state) }.and_then(|state| {
        if state.model.constants().sampling.interval_s <= 0.0 {
            return Err(BwCode::OutOfRange);
        }
        state.settled(|_| ())?;
        match state.watch.clock(milliseconds) {
            None => Ok(BwCode::Ok),
            Some(Lapse::NoSample) => Err(BwCode::NoSample),
            Some(Lapse::NotCollected) => Err(BwCode::NotCollected),
            Some(Lapse::Arithmetic(_)) => Err(BwCode::Arithmetic),
            Some(Lapse::NoSegment) => Err(BwCode::NoSegment),
            Some(Lapse::Rate) => Err(BwCode::WrongRate),
            // And what a later version of the core adds.
            Some(Lapse::NoVerdict(_) | _) => Err(BwCode::NoVerdict),
        }
    }))
}

/// Sets other times than those of `bw_clock`, within which samples, segments and verdicts must come, in seconds;
/// `INFINITY` for never. The times count anew.
///
/// # Safety
/// As `bw_clock`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_limit_liveness(
    state: *mut BwState,
    sample_s: f32,
    segment_s: f32,
    verdict_s: f32,
) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { at(state) }.and_then(|state| {
        state.settled(|_| ())?;
        state.watch.limit_liveness(LivenessLimits { sample_s, segment_s, verdict_s });
        Ok(BwCode::Ok)
    }))
}

/// What a drive can tell beside verdicts and alarms.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BwStatus {
    /// Samples that the detector took, with wrap-around.
    pub samples: u32,
    /// Samples that were lost because `bw_collect` came too late.
    pub lost_samples: u32,
    /// Segments that were lost because `bw_advance` came too late.
    pub lost_segments: u32,
    /// What the context of `bw_collect` computes otherwise than the host: as `bw_known_answer_test`, 0 if nothing.
    pub failed: u32,
    /// Whether the currents turn with the rotor; `BW_ALIGNMENT_UNKNOWN`: the wiring is not checked.
    pub alignment: BwAlignment,
}

/// Gives what was lost or refused.
///
/// # Safety
/// `state` is NULL, or was given by `bw_start` or has as many readable bytes. `status` is NULL or writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_status(state: *mut BwState, status: *mut BwStatus) -> BwCode {
    // SAFETY: the same contract.
    let told = unsafe { at(state) }.map(|state| {
        let status = state.watch.status();
        BwStatus {
            samples: status.rows,
            lost_samples: status.lost_samples,
            lost_segments: status.lost_segments,
            failed: fault_number(status.failed),
            alignment: status.alignment.into(),
        }
    });
    // SAFETY: the same contract.
    code(told.and_then(|told| unsafe { put(status, told) }).map(|()| BwCode::Ok))
}

/// Gives what the front end has refused, as of the end of the last segment, and of `bw_clear_faults`.
///
/// Returns `BW_CODE_OK`, or `BW_CODE_OUT_OF_RANGE` if the state has no front end.
///
/// # Safety
/// As `bw_clock`; `faults` is NULL or writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_faults(state: *mut BwState, faults: *mut BwFrontEndFaults) -> BwCode {
    // SAFETY: the same contract.
    let told = unsafe { at(state) }.and_then(|state| state.watch.status().faults.ok_or(BwCode::OutOfRange));
    // SAFETY: the same contract.
    code(told.and_then(|told| unsafe { put(faults, told.into()) }).map(|()| BwCode::Ok))
}

/// Counts what the front end refuses from zero, from the next raw sample on; what is wrong now stays. In the main loop.
///
/// # Safety
/// As `bw_clock`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_clear_faults(state: *mut BwState) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { at(state) }.map(|state| {
        state.watch.clear_faults();
        BwCode::Ok
    }))
}
