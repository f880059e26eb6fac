//! What each direction of the model says: by how much its runs have risen, the size of a defect, its slope, and the
//! time left.

use bearing_watch::Evidence;
use bearing_watch::alarm::{Growth, Interval};
use bearing_watch::plan::Cells as _;

use crate::code::{BwCode, code};
use crate::memory::{at, put};
use crate::plan::Own;
use crate::state::BwState;

/// What a direction contributes to the alarm.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BwContribution {
    /// The coordinate that a defect raises, a place in `BW_MODEL_COORDINATE_NAMES`.
    pub coordinate: u8,
    /// The mean of the last run less the usual mean of this drive, standard deviations of runs.
    pub deviations: f32,
    /// Largest score of the direction, nats. The alarm is raised where it reaches `BwAlarm::limit`.
    pub score: f32,
    /// Number of the last segment before it rose.
    pub since: u32,
}

/// A value with its 90 % interval.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BwInterval {
    /// The value.
    pub value: f32,
    /// Lower end.
    pub low: f32,
    /// Upper end.
    pub high: f32,
}

/// The size of a defect in a direction, and the time left: an estimate from the past of this drive, and no promise.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BwGrowth {
    /// By how much the runs exceed the usual mean of this drive, standard deviations of a usual run.
    pub size: BwInterval,
    /// Its change in a usual run; divided by `run_hours`, in an hour.
    pub slope: BwInterval,
    /// The named size, to which the time is left, standard deviations of a usual run.
    pub named: f32,
    /// Whether the size grows: the interval of the slope is above zero, the size above four of its deviations, and its
    /// lower end above two deviations of a usual run.
    pub growing: bool,
    /// Usual runs until the named size, 0 if it is reached; NaN if the size does not grow.
    pub runs_left: BwInterval,
    /// The same in hours of segments, not of the time between runs; NaN also if the model has no sampling interval.
    pub hours_left: BwInterval,
    /// Hours of the segments of a usual run; 0 if the model has no sampling interval.
    pub run_hours: f32,
}

impl BwInterval {
    const NONE: Self = Self { value: f32::NAN, low: f32::NAN, high: f32::NAN };
}

impl From<Interval> for BwInterval {
    fn from(Interval { value, low, high }: Interval) -> Self {
        Self { value, low, high }
    }
}

impl From<Growth> for BwGrowth {
    fn from(growth: Growth) -> Self {
        let hours_left = growth.left_hours().filter(|_| growth.run_hours > 0.0);
        Self {
            size: growth.size.into(),
            slope: growth.slope.into(),
            named: growth.named,
            growing: growth.is_growing(),
            runs_left: growth.left.map_or(BwInterval::NONE, Into::into),
            hours_left: hours_left.map_or(BwInterval::NONE, Into::into),
            run_hours: growth.run_hours,
        }
    }
}

/// Gives what a direction of the model contributes to the alarm at the end of the last run. Directions count from 0.
///
/// Returns `BW_CODE_OK`, `BW_CODE_OUT_OF_RANGE` if the model does not have the direction, or `BW_CODE_BUSY`.
///
/// # Safety
/// `state` is NULL, or was given by `bw_start` or has as many readable bytes. `contribution` is NULL or writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_contribution(
    state: *mut BwState,
    direction: u8,
    contribution: *mut BwContribution,
) -> BwCode {
    // SAFETY: the same contract.
    let value = unsafe { at(state) }.and_then(|state| {
        let directions = state.model.constants().classifier.novelty.directions.list.cells();
        let watched = directions.get(usize::from(direction)).ok_or(BwCode::OutOfRange)?;
        let value = state.settled(|monitor| monitor.evidence().contribution(direction))?.ok_or(BwCode::OutOfRange)?;
        let (coordinate, deviations) = (watched.coordinate, value.deviations);
        Ok(BwContribution { coordinate, deviations, score: value.score, since: value.since })
    });
    // SAFETY: the same contract.
    code(value.and_then(|value| unsafe { put(contribution, value) }).map(|()| BwCode::Ok))
}

/// Gives the size of a defect in a direction of the model, its slope, and the time until a single segment would show
/// it: four standard deviations of segments of healthy drives. Directions count from 0.
///
/// Returns `BW_CODE_OK`, `BW_CODE_OUT_OF_RANGE` if the model does not have the direction, or `BW_CODE_BUSY`.
///
/// # Safety
/// `state` is NULL, or was given by `bw_start` or has as many readable bytes. `growth` is NULL or writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_growth(state: *mut BwState, direction: u8, growth: *mut BwGrowth) -> BwCode {
    // SAFETY: the same contract.
    unsafe { put_growth(state, growth, |evidence| evidence.growth(direction)) }
}

/// As `bw_growth`, until another named size, such as that of a known full defect: standard deviations of a usual run.
///
/// Returns `BW_CODE_OK`, `BW_CODE_OUT_OF_RANGE` if the model does not have the direction or the size is not above 0 and
/// finite, or `BW_CODE_BUSY`.
///
/// # Safety
/// `state` is NULL, or was given by `bw_start` or has as many readable bytes. `growth` is NULL or writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_growth_to(state: *mut BwState, direction: u8, size: f32, growth: *mut BwGrowth) -> BwCode {
    let known = size > 0.0 && size < f32::INFINITY;
    // SAFETY: the same contract.
    unsafe { put_growth(state, growth, |evidence| evidence.growth_to(direction, size).filter(|_| known)) }
}

/// # Safety
/// As [`bw_growth`].
unsafe fn put_growth(
    state: *mut BwState,
    growth: *mut BwGrowth,
    of: impl FnOnce(&Evidence<Own>) -> Option<Growth>,
) -> BwCode {
    // SAFETY: the same contract.
    let value = unsafe { at(state) }.and_then(|state| {
        let value = state.settled(|monitor| of(monitor.evidence()))?;
        value.map(BwGrowth::from).ok_or(BwCode::OutOfRange)
    });
    // SAFETY: the same contract.
    code(value.and_then(|value| unsafe { put(growth, value) }).map(|()| BwCode::Ok))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::BW_STATE_SIZE;
    use crate::state::bw_start;
    use core::mem::MaybeUninit;

    static FILE: &[u8] = include_bytes!("../../examples/support/standard_rig/model.bwm");

    #[test]
    fn a_question_while_the_main_loop_works_is_refused() {
        let mut memory = vec![0_u64; BW_STATE_SIZE / 8];
        let mut handle = core::ptr::null_mut();
        let (mut growth, mut contribution) = (MaybeUninit::uninit(), MaybeUninit::uninit());
        // SAFETY: the memory is there as long as the state is used.
        unsafe {
            let (place, none) = (memory.as_mut_ptr().cast(), core::ptr::null_mut());
            let code = bw_start(place, BW_STATE_SIZE, FILE.as_ptr(), FILE.len(), none, &raw mut handle);
            assert_eq!(code, BwCode::Ok);
            let mut growths = || {
                let growth = growth.as_mut_ptr();
                [bw_growth(handle, 0, growth), bw_growth_to(handle, 0, 9.0, growth)]
            };
            let state = at(handle).unwrap();
            assert_eq!(state.settled(|_| growths()), Ok([BwCode::Busy; 2]));
            assert_eq!(growths(), [BwCode::OutOfRange; 2], "this model has no directions");
            assert_eq!(bw_contribution(handle, 0, contribution.as_mut_ptr()), BwCode::OutOfRange);
        }
    }
}
