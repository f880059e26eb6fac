//! What the contexts of the drive do, against the clock of the firmware.

use core::sync::atomic::Ordering;

use bearing_watch::{Implausible, Liveness, LivenessLimits, Stage};

use crate::code::{BwCode, Outcome, code};
use crate::memory::at;
use crate::state::{BwState, Clock, OwnMonitor};

/// Compares what was done so far with a clock, in milliseconds, which the timer of the samples does not make. `samples`
/// is the number of samples that `bw_put` or `bw_collect` was given; both may wrap. Call it in the main loop, as often as
/// you like, from the end of a commissioning on: the times count from the first call, and anew from `bw_restart`.
///
/// Returns `BW_CODE_OK`, `BW_CODE_OUT_OF_RANGE` if the interval of the model is not known, `BW_CODE_BUSY`, or why the
/// drive is not watched as it should be, each reason once until it is right again: `BW_CODE_NO_SAMPLE`,
/// `BW_CODE_NOT_COLLECTED` or `BW_CODE_ARITHMETIC` if no sample was taken for three seconds; `BW_CODE_NO_SEGMENT` if no
/// segment has closed for three of its durations and three seconds; `BW_CODE_NO_VERDICT` if none has had a verdict for 24
/// hours; `BW_CODE_WRONG_RATE` if over ten seconds samples did not come at the rate of the model, to two per cent. While
/// they do not, no segment has a verdict (`BW_REASON_IMPLAUSIBLE`), and what the first ten seconds have added to the
/// alarm is taken out again. Rows that come twice, held or interpolated, are found by nothing else.
///
/// # Safety
/// As `bw_advance`.
#[must_use]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_clock(state: *mut BwState, samples: u32, milliseconds: u32) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { at(state) }.and_then(|state| {
        if state.model.constants().sampling.interval_s <= 0.0 {
            return Err(BwCode::OutOfRange);
        }
        let with = |clock: &mut Clock| {
            state.settled(|monitor| compare(state, (clock, monitor), samples, milliseconds)).flatten()
        };
        state.clock.with(with).flatten()
    }))
}

fn compare(
    state: &BwState,
    (clock, monitor): (&mut Clock, &mut OwnMonitor),
    samples: u32,
    milliseconds: u32,
) -> Outcome {
    if !core::mem::replace(&mut clock.started, true) {
        monitor.begin_trial();
    }
    if let Some(right) = clock.rate.push(samples, milliseconds) {
        monitor.refuse((!right).then_some(Implausible::Rate));
        if !right && core::mem::replace(&mut clock.right, right) {
            return Err(BwCode::WrongRate);
        }
        clock.right = right;
    }
    // A program without a queue gives its samples to the detector itself.
    let taken = state.waiting.taken().unwrap_or(samples);
    let [closed, verdicts] = [&state.closed_segments, &state.verdicts].map(|count| count.load(Ordering::Relaxed));
    match clock.liveness.push([taken, closed, verdicts], milliseconds) {
        None => Ok(BwCode::Ok),
        Some(Stage::Samples) if state.waiting.failed.load(Ordering::Relaxed) => Err(BwCode::Arithmetic),
        Some(Stage::Samples) if state.waiting.is_empty() => Err(BwCode::NoSample),
        Some(Stage::Samples) => Err(BwCode::NotCollected),
        Some(Stage::Segments) => Err(BwCode::NoSegment),
        Some(Stage::Verdicts) => Err(BwCode::NoVerdict),
    }
}

/// Sets other times than those of `bw_clock`, within which samples, segments and verdicts must come, in seconds;
/// `INFINITY` for never. The times count anew.
///
/// # Safety
/// As `bw_advance`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_limit_liveness(
    state: *mut BwState,
    sample_s: f32,
    segment_s: f32,
    verdict_s: f32,
) -> BwCode {
    let limits = LivenessLimits { sample_s, segment_s, verdict_s };
    // SAFETY: the same contract.
    let set = unsafe { at(state) }.and_then(|state| state.clock.with(|clock| clock.liveness = Liveness::new(limits)));
    code(set.map(|()| BwCode::Ok))
}
