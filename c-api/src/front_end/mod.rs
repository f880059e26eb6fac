//! What makes samples of raw counts: currents, angle and decimation.
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

use bearing_watch::Model;
use bearing_watch::drive::{Faults, RawSample, RotorFrame, WiringCheck};
use bearing_watch::watch::{Sampled, Source};

#[cfg(not(bearing_watch_front_end))]
pub(crate) use any_factor::FURTHER;
#[cfg(bearing_watch_front_end)]
pub(crate) use of_plan::FURTHER;

#[cfg(not(bearing_watch_front_end))]
use any_factor::{Chain, Columns, create};
#[cfg(bearing_watch_front_end)]
use of_plan::{Chain, Columns, create};

use crate::code::{BwCode, Outcome, code};
use crate::memory::{Object, Tag, at, get, put_object, room};
use crate::plan::{Own, Sample};
use constants::BwFrontEndConstants;

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
    /// Interval of its samples, s.
    interval_s: f32,
    frame: RotorFrame,
    chain: Chain,
}

impl Object for BwFrontEnd {
    const MARK: u32 = 0x4257_4631;
    const PLACE_OF_TAG: usize = offset_of!(Self, tag);
}

impl BwFrontEnd {
    /// Checks that the model was trained with samples like those of this front end.
    ///
    /// # Errors
    /// Another interval, sign convention or number of channels.
    pub(crate) fn check(&self, model: &Model<Own>) -> Outcome<()> {
        model.check_interval(self.interval_s)?;
        model.check_rotor_frame(&self.frame)?;
        Columns::of(model, self.further).map(|_| ())
    }
}

/// What a state has of a front end: nothing in a drive with signals of its own.
#[derive(Debug)]
pub(crate) struct Front(Option<Used>);

#[derive(Debug)]
struct Used {
    chain: &'static mut Chain,
    columns: Columns,
}

impl Front {
    /// Takes a front end for a state, and gives its further channels in use; `None` without a front end. No other
    /// function has access to it any more.
    ///
    /// # Errors
    /// As [`at`].
    ///
    /// # Safety
    /// `front_end` is NULL, or was given by `bw_front_end_init` or has as many writable bytes, which nothing else
    /// uses as long as the state.
    pub(crate) unsafe fn take(front_end: *mut BwFrontEnd, model: &Model<Own>) -> Outcome<(Self, Option<u16>)> {
        if front_end.is_null() {
            return Ok((Self(None), None));
        }
        // SAFETY: the contract of the caller.
        let BwFrontEnd { tag, further, .. } = unsafe { at(front_end)? };
        let (further, columns) = (*further, Columns::of(model, *further)?);
        tag.clear();
        // SAFETY: the contract of the caller; without its tag it is no front end for any function.
        let chain = unsafe { &mut (*front_end).chain };
        Ok((Self(Some(Used { chain, columns })), Some(further)))
    }
}

impl Source for Front {
    type Reading = RawSample<FURTHER>;
    type Clean = Sample;

    #[inline]
    fn push(&mut self, reading: &RawSample<FURTHER>) -> Option<Sampled<Sample>> {
        let Used { chain, columns } = self.0.as_mut()?;
        let clean = chain.push(reading)?;
        let (found_late, alignment) = (clean.found_late, clean.alignment);
        Some(Sampled { clean: columns.sample(clean), found_late, alignment })
    }

    fn check_wiring(&mut self, reading: &RawSample<FURTHER>, velocity_rad_s: f32, check: &mut WiringCheck) {
        if let Some(used) = &mut self.0 {
            used.chain.check_wiring(reading, velocity_rad_s, check);
        }
    }

    fn faults(&self) -> Option<Faults> {
        self.0.as_ref().map(|used| used.chain.faults())
    }

    fn clear_faults(&mut self) {
        if let Some(used) = &mut self.0 {
            used.chain.clear_faults();
        }
    }
}

/// Returns the number of bytes of memory that `bw_front_end_init` needs: with a plan of its own a library needs less.
#[unsafe(no_mangle)]
pub extern "C" fn bw_front_end_size() -> usize {
    size_of::<BwFrontEnd>()
}

/// Makes a front end without samples in memory of the caller, for `bw_start`, and gives its address in `front_end`. The
/// constants are not needed afterwards. In case of an error the memory is unchanged.
///
/// Returns `BW_CODE_OK`, or what is wrong with memory or constants: `BW_CODE_FRONT_END_…`, or `BW_CODE_OUT_OF_RANGE`
/// for `park`.
///
/// # Safety
/// `memory` is NULL or has `size` writable bytes, which nothing else writes until the front end is used no more, also
/// by the state that has it. `constants` is NULL or readable. `front_end` is NULL or writable. No other function
/// works on the front end.
#[must_use]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_front_end_init(
    memory: *mut c_void,
    size: usize,
    constants: *const BwFrontEndConstants,
    front_end: *mut *mut BwFrontEnd,
) -> BwCode {
    let init = || {
        // SAFETY: the same contract; every bit pattern of the constants is valid.
        unsafe {
            let place = room(memory, size)?;
            let constants = get(constants)?;
            let (factor, further, core) = (constants.factor, constants.further, constants.core()?);
            let interval_s = f32::from(factor) / core.control_rate_hz;
            let chain = create(factor, further, &core)?;
            put_object(place, BwFrontEnd { tag: Tag::none(), further, interval_s, frame: core.frame, chain }, front_end)
        }
    };
    code(init())
}

#[cfg(all(test, not(bearing_watch_front_end)))]
mod tests;
