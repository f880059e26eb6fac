//! What the sampling interrupt calls.

use core::sync::atomic::{AtomicU32, Ordering};

use bearing_watch::plan::{MAX_CHANNELS, Signals as _};
use bearing_watch::{Angle, Exchange};

use crate::code::{BwCode, Outcome, code};
use crate::memory::{at, check, elements, put};
use crate::plan::Own;
use crate::solving::reported;
use crate::state::{BwState, Clock, OwnDetector, OwnMonitor, Sample, count_on};

/// Most lost samples that are made up for at once: more than the shaft bridges, so that everything starts anew.
const MOST_MISSED: u32 = 16;

/// Takes one sample in the sampling interrupt, in time that hardly depends on the data. `values` are the channels in
/// the order of the model, in the unit that each name says; `angle` is the shaft's (`bw_angle`), 0 if the model needs
/// none. Bad values, such as NaN, are counted and left out.
///
/// Returns `BW_CODE_OK`; `BW_CODE_SEGMENT` with the sample that closes a segment, which the main loop then concludes by
/// `bw_advance` or `bw_conclude`; `BW_CODE_SEGMENT_LOST` if it has not done so with the segment before; or
/// `BW_CODE_BUSY` if the interrupt came during `bw_adopt`, `bw_discard`, `bw_restart`, `bw_pending`, `bw_step` or
/// `bw_reset`. The sample is then lost, and counts as one with bad values.
///
/// # Safety
/// `state` is NULL, or was given by `bw_init` or has as many readable bytes. `values` is NULL or has `count`
/// readable values.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_collect(state: *mut BwState, values: *const f32, count: usize, angle: u32) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { sample(state, values, count, angle) }.and_then(|(state, sample)| collect(state, &sample)))
}

/// The state and the sample, if both are good.
#[inline]
pub(crate) unsafe fn sample<'a>(
    state: *const BwState,
    values: *const f32,
    count: usize,
    angle: u32,
) -> Outcome<(&'a BwState, Sample)> {
    // SAFETY: the contract of the caller.
    let state = unsafe { at(state)? };
    check(values)?;
    if count != usize::from(state.model.plan().layout().channels) {
        return Err(BwCode::WrongChannelCount);
    }
    // SAFETY: the contract of the caller.
    let values = unsafe { elements(values, count)? };
    Ok((state, Sample::of(values, Angle::from_bits(angle))))
}

fn collect(state: &BwState, sample: &Sample) -> Outcome {
    state.sampling.with(|detector| take_into(state, detector, sample)).unwrap_or_else(|busy| lose(state, busy))
}

/// Takes a sample into the detector, which the caller holds.
#[inline]
pub(crate) fn take_into(state: &BwState, detector: &mut OwnDetector, sample: &Sample) -> Outcome {
    take(state, sample, |sample| {
        // SAFETY: the caller holds the sampling half of the state, and nothing else fills the slot.
        match unsafe { state.closed.with_spare(|spare| detector.exchange(sample, spare)) } {
            Exchange::Open => Ok(BwCode::Ok),
            closed => keep(state, closed),
        }
    })
}

/// Counts a sample that the detector could not take.
#[cold]
fn lose<T>(state: &BwState, why: BwCode) -> Outcome<T> {
    count(&state.lost_samples);
    count(&state.missed);
    Err(why)
}

/// Gives the detector a sample, and before it samples without values for those that were lost since the last one:
/// without them it would take the samples before and after the gap for neighbours. Returns the code of a segment that
/// one of them closes.
#[inline(always)]
fn take(state: &BwState, sample: &Sample, mut take: impl FnMut(&Sample) -> Outcome) -> Outcome {
    // For one plan the code of a sample is small: a copy of its own for the usual case saves instructions.
    if cfg!(bearing_watch_plan) && state.missed.load(Ordering::Relaxed) == 0 {
        return take(sample);
    }
    take_with_gap(state, sample, take)
}

#[cfg_attr(bearing_watch_plan, cold, inline(never))]
#[cfg_attr(not(bearing_watch_plan), inline(always))]
fn take_with_gap(state: &BwState, sample: &Sample, mut take: impl FnMut(&Sample) -> Outcome) -> Outcome {
    let mut gap = None;
    let mut left = if state.missed.load(Ordering::Relaxed) == 0 { 0 } else { missed(state, sample, &mut gap) };
    let mut outcome = Ok(BwCode::Ok);
    // One call for both kinds of samples, so that the code of a sample is here once.
    loop {
        let next = if left == 0 { sample } else { gap.as_ref().unwrap_or(sample) };
        match take(next) {
            Ok(BwCode::Ok) => {}
            closed => outcome = closed,
        }
        if left == 0 {
            return outcome;
        }
        left -= 1;
    }
}

/// Makes the sample that stands in for a lost one; returns how often it does.
#[cold]
#[inline(never)]
fn missed(state: &BwState, next: &Sample, gap: &mut Option<Sample>) -> u32 {
    *gap = Some(Sample::of(&[f32::NAN; MAX_CHANNELS], next.angle()));
    state.missed.swap(0, Ordering::Relaxed).min(MOST_MISSED)
}

/// Keeps a closed segment for the main loop.
#[cold]
#[inline(never)]
fn keep(state: &BwState, exchange: Exchange<'static, Own>) -> Outcome {
    let Exchange::Closed(place) = exchange else {
        count(&state.lost_segments);
        return Err(BwCode::SegmentLost);
    };
    count_on(&state.closed_segments);
    // SAFETY: the caller holds the sampling half of the state, and has taken the place of the slot for this one.
    unsafe { state.closed.fill(place) };
    Ok(BwCode::Segment)
}

/// Adds one. By load and store: only the holder of the part counts, and a lost count would only be a lost count.
pub(crate) fn count(counter: &AtomicU32) {
    counter.store(counter.load(Ordering::Relaxed).saturating_add(1), Ordering::Relaxed);
}

/// Takes one sample, as `bw_collect`, and solves at once when it closes a segment: for programs without interrupts. The
/// alarm takes account of the report.
///
/// Returns `BW_CODE_OK`, `BW_CODE_REPORT` with the sample that closes a segment, or `BW_CODE_BUSY` as `bw_collect` does,
/// and while a segment of `bw_collect` is not concluded.
///
/// # Safety
/// As `bw_collect`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_step(state: *mut BwState, values: *const f32, count: usize, angle: u32) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { sample(state, values, count, angle) }.and_then(|(state, sample)| step(state, &sample)))
}

fn step(state: &BwState, sample: &Sample) -> Outcome {
    let step = |monitor: &mut OwnMonitor| {
        // A segment of `bw_collect` is older, and has to be concluded first.
        if state.closed.is_full() || monitor.is_solving() {
            return Err(BwCode::Busy);
        }
        state.sampling.with(|detector| {
            take(state, sample, |sample| match monitor.step(detector, sample) {
                Some(now) => {
                    count_on(&state.closed_segments);
                    Ok(reported(state, now.report.verdict))
                }
                None => Ok(BwCode::Ok),
            })
        })
    };
    state.settled(step).flatten().flatten().or_else(|why| lose(state, why))
}

/// Starts the open segment afresh, for a stream that does not continue from the last sample: after a pause, or at
/// power-up of the motor. Samples that wait for `bw_collect_waiting` are dropped; a closed segment, report and alarm
/// remain. In the interrupt, or with the interrupt masked; that of `bw_put` is masked or stopped too.
///
/// # Safety
/// `state` is NULL, or was given by `bw_init` or has as many readable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_restart(state: *mut BwState) -> BwCode {
    // SAFETY: the same contract.
    let found = unsafe { at(state) };
    let restart = |state: &BwState| {
        state.sampling.with(|detector| {
            // SAFETY: only the holder of the sampling half takes samples from the queue.
            unsafe { state.waiting.clear() };
            state.missed.store(0, Ordering::Relaxed);
            detector.restart();
            // The main loop may be reading the clock: then its times count on.
            let _free = state.clock.with(Clock::restart);
        })
    };
    code(found.and_then(restart).map(|()| BwCode::Ok))
}

/// Discards what the open segment has taken, which was found to be wrong after it was taken: `found_late` of
/// `BwCleanSample`. The segment closes where it would have, and has a verdict if half of it follows this call and is
/// usable. `before_in_doubt` gets 1 if less than half of the segment had passed: the fault may have begun in the
/// segment before; NULL if that is not wanted. The report of that segment is then withdrawn: it is undetermined by
/// `BW_REASON_FOUND_LATE`, and the alarm is as if it had been from the start, also if it had been given before. In the
/// interrupt, or with the interrupt masked.
///
/// # Safety
/// `state` is NULL, or was given by `bw_init` or has as many readable bytes. `before_in_doubt` is NULL or writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_discard(state: *mut BwState, before_in_doubt: *mut u8) -> BwCode {
    // SAFETY: the same contract.
    let in_doubt = unsafe { at(state) }.and_then(|state| {
        state.sampling.with(|detector| {
            let doubted = detector.discard();
            if let Some(number) = doubted {
                state.doubted.store(number, Ordering::Relaxed);
            }
            doubted.is_some()
        })
    });
    let told = |in_doubt: bool| {
        // SAFETY: the same contract.
        if before_in_doubt.is_null() { Ok(()) } else { unsafe { put(before_in_doubt, in_doubt.into()) } }
    };
    code(in_doubt.and_then(told).map(|()| BwCode::Ok))
}

/// Gives the number of samples in the open segment, after averaging. In the interrupt, or with the interrupt masked.
///
/// # Safety
/// `state` is NULL, or was given by `bw_init` or has as many readable bytes. `samples` is NULL or writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_pending(state: *mut BwState, samples: *mut u32) -> BwCode {
    // SAFETY: the same contract.
    let pending = unsafe { at(state) }.and_then(|state| state.sampling.with(|detector| detector.pending()));
    // SAFETY: the same contract.
    code(pending.and_then(|pending| unsafe { put(samples, pending) }).map(|()| BwCode::Ok))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::bw_init;
    use crate::{BW_STATE_SIZE, bw_advance, bw_conclude, bw_reset};

    static FILE: &[u8] = include_bytes!("../../examples/support/standard_rig/model.bwm");

    /// A state of the standard rig's model in this memory.
    fn initialised(memory: &mut [u64]) -> *mut BwState {
        let mut state = core::ptr::null_mut();
        let (place, bytes) = (memory.as_mut_ptr().cast(), size_of_val(memory));
        // SAFETY: memory and file have these lengths.
        let code = unsafe { bw_init(place, bytes, FILE.as_ptr(), FILE.len(), &raw mut state) };
        assert_eq!(code, BwCode::Ok);
        state
    }

    #[test]
    fn an_interrupt_in_another_function_is_refused_and_its_sample_counted() {
        let (mut memory, values) = (vec![0_u64; BW_STATE_SIZE / 8], [0.5; 3]);
        let (own, sample) = (initialised(&mut memory), values.as_ptr());
        // SAFETY: the memory is there as long as the state is used.
        unsafe {
            let state = at(own).unwrap();
            let during = || [bw_collect(own, sample, 3, 0), bw_step(own, sample, 3, 0), bw_restart(own), bw_reset(own)];
            assert_eq!(state.sampling.with(|_| during()), Ok([BwCode::Busy; 4]));
            assert_eq!(state.lost_samples.load(Ordering::Relaxed), 2);
            let during = || (bw_collect(own, sample, 3, 0), bw_step(own, sample, 3, 0));
            assert_eq!(state.solving.with(|_| during()), Ok((BwCode::Ok, BwCode::Busy)), "the halves are independent");
            assert_eq!(state.lost_samples.load(Ordering::Relaxed), 3);
            assert_eq!([bw_step(own, sample, 3, 0), bw_reset(own)], [BwCode::Ok; 2], "free again");
        }
    }

    /// The detector must know of a gap, or it takes the samples on both sides for neighbours.
    #[test]
    fn lost_samples_count_as_refused_ones_in_the_segment() {
        let (mut memory, values) = (vec![0_u64; BW_STATE_SIZE / 8], [0.5; 3]);
        let (own, sample) = (initialised(&mut memory), values.as_ptr());
        // SAFETY: the memory is there as long as the state is used.
        unsafe {
            let state = at(own).unwrap();
            let counted = || state.sampling.with(|detector| (detector.pending(), detector.counts().rejected)).unwrap();
            bw_collect(own, sample, 3, 0);
            assert_eq!(counted(), (1, 0));
            let _busy = state.sampling.with(|_| [0; 3].map(|_| bw_collect(own, sample, 3, 0)));
            assert_eq!(counted(), (1, 0));
            assert_eq!(bw_collect(own, sample, 3, 0), BwCode::Ok);
            assert_eq!(counted(), (5, 3));
            let _busy = state.sampling.with(|_| [0; 40].map(|_| bw_collect(own, sample, 3, 0)));
            assert_eq!(bw_step(own, sample, 3, 0), BwCode::Ok);
            assert_eq!(counted(), (6 + MOST_MISSED, 3 + MOST_MISSED));
            let _busy = state.sampling.with(|_| bw_collect(own, sample, 3, 0));
            bw_restart(own);
            bw_collect(own, sample, 3, 0);
            assert_eq!(counted().0, 1, "a new stream has no gap");
        }
    }

    #[test]
    fn samples_lost_before_a_reset_are_no_gap_behind_it() {
        let (mut memory, values) = (vec![0_u64; BW_STATE_SIZE / 8], [0.5; 3]);
        let (own, sample) = (initialised(&mut memory), values.as_ptr());
        // SAFETY: the memory is there as long as the state is used.
        unsafe {
            let state = at(own).unwrap();
            let _busy = state.sampling.with(|_| [0; 5].map(|_| bw_collect(own, sample, 3, 0)));
            assert_eq!([bw_reset(own), bw_collect(own, sample, 3, 0)], [BwCode::Ok; 2]);
            let counted = state.sampling.with(|detector| (detector.pending(), detector.counts().rejected));
            assert_eq!(counted, Ok((1, 0)));
            assert_eq!(state.lost_samples.load(Ordering::Relaxed), 5, "counted since the start");
        }
    }

    #[test]
    fn a_step_waits_for_the_segment_of_the_interrupt() {
        let (mut memory, values) = (vec![0_u64; BW_STATE_SIZE / 8], [0.5; 3]);
        let (own, sample) = (initialised(&mut memory), values.as_ptr());
        // SAFETY: the memory is there as long as the state is used.
        unsafe {
            while bw_collect(own, sample, 3, 0) != BwCode::Segment {}
            assert_eq!(bw_step(own, sample, 3, 0), BwCode::Busy, "it waits to be solved");
            assert_eq!(bw_advance(own), BwCode::Ok);
            assert_eq!(bw_step(own, sample, 3, 0), BwCode::Busy, "it is being solved");
            assert_eq!(bw_conclude(own), BwCode::Report);
            assert_eq!(bw_step(own, sample, 3, 0), BwCode::Ok);
        }
    }
}
