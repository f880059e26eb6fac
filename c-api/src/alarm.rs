//! The evidence of all segments.

use bearing_watch::alarm::SilenceLimits;
use bearing_watch::{Cause, Evidence};

use crate::code::{BwCode, code};
use crate::memory::{at, put};
use crate::plan::Own;
use crate::report::{BwReason, named};
use crate::state::{BwState, OwnMonitor};

/// The alarm, and what leads to it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BwAlarm {
    /// Whether there is an alarm. It stays until `bw_reset`.
    pub raised: bool,
    /// Whether its cause is a trained defect, `class_index`.
    pub known: bool,
    /// The defect that caused it.
    pub class_index: u8,
    /// Number of the segment that raised it; the first is 1.
    pub segment: u32,
    /// Segments observed.
    pub segments: u32,
    /// Of these, segments without a verdict.
    pub undetermined: u32,
    /// Evidence of the runs that have ended, nats.
    pub score: f32,
    /// The score that raises the alarm, nats; infinite if the model has none.
    pub limit: f32,
    /// Whether no segment has had a verdict for too long (`bw_limit_silence`): the diagnosis is lost. False again with
    /// the next verdict.
    pub silent: bool,
    /// Parameter, term, channel, covariate or error of `silent_reason`, as in `BwReport`.
    pub silent_place: u8,
    /// Segments without a verdict since the last verdict, if `silent`.
    pub silent_segments: u32,
    /// The most frequent reason of them.
    pub silent_reason: BwReason,
    /// Whether the alarm names what has risen above what is usual for this drive.
    pub risen: bool,
    /// Whether the alarm names what has fallen below it: the load or a sensor, and no bearing defect.
    pub fallen: bool,
    /// The coordinate that has risen or fallen, a place in `BW_MODEL_COORDINATE_NAMES`.
    pub coordinate: u8,
    /// By how many standard deviations of runs.
    pub deviations: f32,
    /// Number of the last segment before it rose.
    pub since: u32,
}

/// Gives the alarm.
///
/// # Safety
/// `state` is NULL, or was given by `bw_start` or has as many readable bytes. `alarm` is NULL or writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_alarm(state: *mut BwState, alarm: *mut BwAlarm) -> BwCode {
    // SAFETY: the same contract.
    let found = unsafe { at(state) }.and_then(|state| state.settled(|monitor| of(state, monitor.evidence())));
    // SAFETY: the same contract.
    code(found.and_then(|found| unsafe { put(alarm, found) }).map(|()| BwCode::Ok))
}

/// The alarm that this evidence makes.
pub(crate) fn of(state: &BwState, evidence: &Evidence<Own>) -> BwAlarm {
    let limit = state.model.constants().evidence.limit;
    let (segments, undetermined) = evidence.segments();
    let (raised, cause) = (evidence.alarm(), evidence.alarm().map(|alarm| alarm.cause));
    let class = match cause {
        Some(Cause::Class(class)) => Some(class),
        _ => None,
    };
    let (main, silence) = (evidence.main_contribution(), evidence.silence());
    let (silent_reason, silent_place) = silence.and_then(|silence| silence.reason).map_or((BwReason::None, 0), named);
    BwAlarm {
        raised: raised.is_some(),
        known: class.is_some(),
        class_index: class.unwrap_or(0),
        segment: raised.map_or(0, |alarm| alarm.segment),
        segments,
        undetermined,
        score: evidence.score(),
        limit,
        silent: silence.is_some(),
        silent_place,
        silent_segments: silence.map_or(0, |silence| silence.segments),
        silent_reason,
        risen: main.is_some(),
        fallen: matches!(cause, Some(Cause::Fallen(_))),
        coordinate: match cause {
            Some(Cause::Coordinate(place) | Cause::Fallen(place)) => place,
            _ => 0,
        },
        deviations: main.map_or(0.0, |main| main.deviations),
        since: main.map_or(0, |main| main.since),
    }
}

/// Sets how long verdicts may be missing before `bw_alarm` calls the diagnosis lost: a number of segments in a row, and
/// hours by the sampling interval of the model; 0 for no such limit. `bw_start` sets 10000 segments and 24 hours.
///
/// Returns `BW_CODE_OK`, `BW_CODE_OUT_OF_RANGE` if the hours are negative or not a number, or `BW_CODE_BUSY`.
///
/// # Safety
/// `state` is NULL, or was given by `bw_start` or has as many readable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_limit_silence(state: *mut BwState, segments: u32, hours: f32) -> BwCode {
    // SAFETY: the same contract.
    let state = unsafe { at(state) };
    code(state.and_then(|state| {
        if !(0.0..f32::INFINITY).contains(&hours) {
            return Err(BwCode::OutOfRange);
        }
        let limits = SilenceLimits { segments, hours };
        state.settled(|monitor| monitor.limit_silence(limits))?;
        Ok(BwCode::Ok)
    }))
}

/// Denies the alarm, because the bearing was inspected and is sound: scores start afresh, and what raised the alarm
/// must be 1.5 times as large to raise the next one, for three alarms at most. `BW_CODE_IDLE` without an alarm.
///
/// # Safety
/// `state` is NULL, or was given by `bw_start` or has as many readable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_deny(state: *mut BwState) -> BwCode {
    // SAFETY: the same contract.
    let state = unsafe { at(state) };
    let denied = state.and_then(|state| state.settled(OwnMonitor::deny));
    code(denied.map(|denied| if denied { BwCode::Ok } else { BwCode::Idle }))
}

/// Starts afresh, as after a repair: open and closed segment, report, alarm and scores. In the main loop while the
/// interrupts are stopped. `BW_CODE_BUSY` if another function works on the state: call it again.
///
/// # Safety
/// `state` is NULL, or was given by `bw_start` or has as many readable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_reset(state: *mut BwState) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { at(state) }.and_then(|state| if state.watch.reset() { Ok(BwCode::Ok) } else { Err(BwCode::Busy) }))
}
