//! What the control interrupt calls: raw counts at the control rate → samples for `bw_collect`.
//!
//! A library for a plan that was trained with `--front-end` has the front end of that plan. Any other library has one
//! for every factor of decimation, with places for `BW_MAX_FURTHER` further channels.

#[cfg(not(bearing_watch_front_end))]
mod any_factor;
pub(crate) mod constants;
pub(crate) mod faults;
#[cfg(bearing_watch_front_end)]
mod of_plan;
pub(crate) mod sample;

use core::ffi::c_void;
use core::mem::offset_of;

#[cfg(not(bearing_watch_front_end))]
pub(crate) use any_factor::FURTHER;
#[cfg(bearing_watch_front_end)]
pub(crate) use of_plan::FURTHER;

#[cfg(not(bearing_watch_front_end))]
use any_factor::{Chain, create};
#[cfg(bearing_watch_front_end)]
use of_plan::{Chain, create};

use crate::code::{BwCode, Outcome, code};
use crate::memory::{Object, Tag, at, check, get, put, put_object, room};
use crate::state::Lock;
use crate::wiring::BwWiringCheck;
use constants::BwFrontEndConstants;
use sample::{BwCleanSample, BwRawSample, read};

/// Bytes of memory that are enough for `bw_front_end_init` of a library without a plan of its own;
/// `bw_front_end_size` returns what exactly is needed. The memory is aligned to `BW_STATE_ALIGN` bytes.
pub const BW_FRONT_END_SIZE: usize = 3328;

const _: () = assert!(size_of::<BwFrontEnd>() <= BW_FRONT_END_SIZE || cfg!(bearing_watch_front_end));

/// The front end of one drive, in memory of the caller.
#[derive(Debug)]
pub struct BwFrontEnd {
    tag: Tag,
    /// Further channels in use.
    further: u16,
    chain: Lock<Chain>,
}

impl Object for BwFrontEnd {
    const MARK: u32 = 0x4257_4631;
    const PLACE_OF_TAG: usize = offset_of!(Self, tag);
}

/// Returns the number of bytes of memory that `bw_front_end_init` needs: with a plan of its own a library needs less.
#[unsafe(no_mangle)]
pub extern "C" fn bw_front_end_size() -> usize {
    size_of::<BwFrontEnd>()
}

/// Makes a front end without samples in memory of the caller, and gives its address in `front_end`. The constants are
/// not needed afterwards. In case of an error the memory is unchanged. A front end can be initialised again, to start
/// afresh, while no other function works on it.
///
/// Returns `BW_CODE_OK`, or what is wrong with memory or constants: `BW_CODE_FRONT_END_…`, or `BW_CODE_OUT_OF_RANGE` for
/// `park`.
///
/// # Safety
/// `memory` is NULL or has `size` writable bytes, which nothing else writes until the front end is used no more.
/// `constants` is NULL or readable. `front_end` is NULL or writable. No other function works on the front end.
#[must_use]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_front_end_init(
    memory: *mut c_void,
    size: usize,
    constants: *const BwFrontEndConstants,
    front_end: *mut *mut BwFrontEnd,
) -> BwCode {
    // SAFETY: the same contract; every bit pattern of the constants is valid.
    let outcome = room(memory, size).and_then(|place| unsafe {
        let BwFrontEndConstants { factor, further, .. } = get(constants)?;
        let chain = Lock::new(create(factor, further, &get(constants)?.core()?)?);
        put_object(place, BwFrontEnd { tag: Tag::none(), further, chain }, front_end)
    });
    code(outcome)
}

/// Takes a raw sample in the interrupt of the control loop. `further` are the further channels in their order and units,
/// NaN if missing; it may be NULL if `count`, their number, is 0. One in `factor` calls gives a clean sample once the
/// filters are filled: pass it to `bw_collect`. Wrong counts, angles and values are counted, and are missing from the
/// clean samples: their channels are NaN.
///
/// Returns `BW_CODE_OK`; `BW_CODE_CLEAN_SAMPLE` if `clean` was written; `BW_CODE_WRONG_CHANNEL_COUNT`;
/// `BW_CODE_OUT_OF_RANGE` if `phases` or `position` of the sample is; or `BW_CODE_BUSY` if the interrupt came during
/// another function of this front end. A sample that is not taken is a gap in the numbers.
///
/// # Safety
/// `front_end` is NULL, or was given by `bw_front_end_init` or has as many readable bytes. `raw` is NULL or readable.
/// `further` is NULL or has `count` readable values. `clean` is NULL or writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_front_end_push(
    front_end: *mut BwFrontEnd,
    raw: *const BwRawSample,
    further: *const f32,
    count: usize,
    clean: *mut BwCleanSample,
) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { at(front_end) }.and_then(|own| unsafe { push(own, raw, (further, count), clean) }))
}

#[inline]
unsafe fn push(
    own: &BwFrontEnd,
    raw: *const BwRawSample,
    (further, count): (*const f32, usize),
    clean: *mut BwCleanSample,
) -> Outcome {
    check(clean)?;
    // SAFETY: the contract of the caller.
    let raw = unsafe { read(raw, (further, count), own.further)? };
    match own.chain.with(|chain| chain.push(&raw))? {
        // SAFETY: the contract of the caller.
        Some(found) => unsafe { put(clean, BwCleanSample::of(found, own.further)) }.map(|()| BwCode::CleanSample),
        None => Ok(BwCode::Ok),
    }
}

/// Takes a raw sample at commissioning, for a check of the wiring instead of the filters. `velocity_rad_s` is one of the
/// drive's own, NaN if there is none.
///
/// Returns `BW_CODE_OK`, `BW_CODE_OUT_OF_RANGE` if `phases` or `position` of the sample is, or `BW_CODE_BUSY`.
///
/// # Safety
/// `front_end` is NULL, or was given by `bw_front_end_init` or has as many readable bytes; likewise `wiring` by
/// `bw_wiring_init`. `raw` is NULL or readable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_front_end_check_wiring(
    front_end: *mut BwFrontEnd,
    raw: *const BwRawSample,
    velocity_rad_s: f32,
    wiring: *mut BwWiringCheck,
) -> BwCode {
    // SAFETY: the same contract; every bit pattern of a raw sample is valid.
    let given = unsafe { at(front_end) }.and_then(|own| unsafe { Ok((own, get(raw)?.core(&[])?, at(wiring)?)) });
    code(given.and_then(|(own, raw, wiring)| {
        let take = |chain: &mut Chain| wiring.check.with(|check| chain.check_wiring(&raw, velocity_rad_s, check));
        own.chain.with(take).flatten().map(|()| BwCode::Ok)
    }))
}

#[cfg(test)]
mod tests {
    use super::faults::{bw_front_end_clear_faults, bw_front_end_faults};
    use super::*;
    use core::mem::MaybeUninit;

    const CONSTANTS: BwFrontEndConstants = BwFrontEndConstants {
        control_rate_hz: 10_000.0,
        factor: 10,
        further: 0,
        sensors: [constants::BwPhaseSensor {
            offset_counts: 2048.0,
            gain_a: 0.025,
            lowest_counts: 16,
            highest_counts: 4079,
        }; 3],
        stuck_samples: 0,
        balance_window_samples: 400,
        balance_noise_a: 0.5,
        balance_offset_a: 1.0,
        balance_gain_tolerance: 0.02,
        tracking_bandwidth_hz: 300.0,
        tracking_damping: 0.7,
        tracking_error_limit_rad: 0.1,
        tracking_lost_samples: 20,
        tracking_settle_samples: 20,
        resolver_lowest_amplitude: 0.5,
        resolver_highest_amplitude: 1.5,
        resolver_mismatch: 0.1,
        pole_pairs: 6,
        electrical_offset_turn32: 0,
        park: 1,
    };

    #[test]
    fn an_interrupt_in_another_function_is_refused_and_its_sample_is_a_gap() {
        let mut memory = [0_u64; BW_FRONT_END_SIZE / 8];
        let mut own = core::ptr::null_mut();
        let (mut clean, mut faults) = (MaybeUninit::uninit(), MaybeUninit::uninit());
        let mut raw = BwRawSample {
            number: 0,
            counts: [2048; 3],
            phases: 3,
            position: sample::BwPosition::Absolute as u8,
            angle: 0,
            sin: 0.0,
            cos: 0.0,
            current_a: 0.0,
        };
        // SAFETY: the memory is there as long as the front end is used.
        unsafe {
            let place = memory.as_mut_ptr().cast();
            assert_eq!(bw_front_end_init(place, BW_FRONT_END_SIZE, &CONSTANTS, &raw mut own), BwCode::Ok);
            let mut push = |number| {
                raw.number = number;
                bw_front_end_push(own, &raw, core::ptr::null(), 0, clean.as_mut_ptr())
            };
            assert_eq!(push(0), BwCode::Ok);
            let object = at(own).unwrap();
            let during = object
                .chain
                .with(|_| [push(1), bw_front_end_faults(own, faults.as_mut_ptr()), bw_front_end_clear_faults(own)]);
            assert_eq!(during, Ok([BwCode::Busy; 3]));
            assert_eq!([push(2), bw_front_end_faults(own, faults.as_mut_ptr())], [BwCode::Ok; 2]);
            assert_eq!(faults.assume_init().gaps, 1);
        }
    }
}
