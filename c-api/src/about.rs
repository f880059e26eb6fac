//! What the library and the model say of themselves.

use core::ffi::{CStr, c_char};

use bearing_watch::drive::RotorFrame;
use bearing_watch::{Angle, ArithmeticFault, Park, known_answer_test};

use crate::code::{BwCode, Outcome, code};
use crate::front_end::constants::BwPark;
use crate::memory::{at, check, put};
use crate::state::BwState;

const VERSION: &CStr = match CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
    Ok(version) => version,
    Err(_) => c"",
};

/// What the model wants.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BwInfo {
    /// Number of channels of a sample.
    pub channels: u8,
    /// Number of classes.
    pub classes: u8,
    /// Number of features.
    pub features: u8,
    /// Number of bearing orders.
    pub orders: u8,
    /// Whether samples need the angle of the shaft.
    pub needs_angle: bool,
    /// Sampling interval, s; 0 if it is unknown.
    pub interval_s: f32,
    /// Samples averaged into one before the regression.
    pub block_mean: u32,
    /// Samples of a segment, after averaging.
    pub segment_samples: u32,
    /// Samples of the next segment within which a segment is to be solved, so that its estimate is the auxiliary
    /// model of instrumental variables.
    pub handover: u32,
    /// Sign convention of the quadrature current.
    pub park: BwPark,
}

/// Returns the version of the library, a text that ends in a zero byte.
#[unsafe(no_mangle)]
pub extern "C" fn bw_version() -> *const c_char {
    VERSION.as_ptr()
}

/// Runs the kernels on numbers whose results are known, and compares every bit. Call it at start, and once in the
/// interrupt that calls `bw_collect`, before the power stage is on: interrupts take their floating-point settings from
/// the register FPDSCR, not from `main`. It takes some hundred thousand instructions. Later each segment tests these
/// settings (`BW_REASON_ARITHMETIC`).
///
/// Returns 0, or the first part whose results differ: 1 rounding, 2 subnormal numbers, 3 square root, exponential or
/// logarithm, 4 transforms, 5 decimation, 6 the factor of a least-squares problem, 7 its solution.
#[must_use]
#[unsafe(no_mangle)]
pub extern "C" fn bw_known_answer_test() -> u32 {
    fault_number(known_answer_test().err())
}

/// The number of a part whose results differ; 0 for none.
pub(crate) fn fault_number(fault: Option<ArithmeticFault>) -> u32 {
    let number = |wrong| (1..).zip(ArithmeticFault::ALL).find(|(_, part)| *part == wrong);
    fault.and_then(number).map_or(0, |(number, _)| number)
}

/// Gives what the model wants.
///
/// # Safety
/// `state` is NULL, or was given by `bw_start` or has as many readable bytes. `info` is NULL or writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_info(state: *const BwState, info: *mut BwInfo) -> BwCode {
    // SAFETY: the same contract.
    let found = unsafe { at(state) }.map(about);
    // SAFETY: the same contract.
    code(found.and_then(|found| unsafe { put(info, found) }).map(|()| BwCode::Ok))
}

fn about(state: &BwState) -> BwInfo {
    let (layout, constants) = (state.model.plan().layout(), state.model.constants());
    let sampling = &constants.sampling;
    BwInfo {
        channels: layout.channels,
        classes: layout.classes,
        features: layout.features,
        orders: layout.shaft.map_or(0, |shaft| shaft.orders),
        needs_angle: layout.needs_angle(),
        interval_s: sampling.interval_s,
        block_mean: sampling.block_mean.into(),
        segment_samples: sampling.segment_samples,
        handover: constants.regression.first().map_or(0, |regression| regression.handover.into()),
        park: match sampling.park {
            None => BwPark::Unknown,
            Some(Park::Standard) => BwPark::Standard,
            Some(Park::Thesis) => BwPark::Thesis,
        },
    }
}

/// Writes the name of a class, ending in a zero byte, into `text`: 17 bytes are enough for every name.
///
/// Returns `BW_CODE_OK`, `BW_CODE_OUT_OF_RANGE` if there is no such class, or `BW_CODE_BUFFER_TOO_SMALL`.
///
/// # Safety
/// `state` is NULL, or was given by `bw_start` or has as many readable bytes. `text` is NULL or has `capacity`
/// writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_label(
    state: *const BwState,
    class_index: u8,
    text: *mut c_char,
    capacity: usize,
) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { at(state) }.and_then(|state| {
        let label = state.model.constants().labels.get(usize::from(class_index)).ok_or(BwCode::OutOfRange)?;
        check(text)?;
        let bytes = label.as_str().as_bytes();
        if bytes.len() >= capacity {
            return Err(BwCode::BufferTooSmall);
        }
        // SAFETY: bytes and the zero byte are within the capacity that the caller promises.
        unsafe {
            text.cast::<u8>().copy_from_nonoverlapping(bytes.as_ptr(), bytes.len());
            text.add(bytes.len()).write(0);
        }
        Ok(BwCode::Ok)
    }))
}

/// Checks that a channel of the model has this name and unit, such as `current_a` and `A`. A program that passes its
/// channels in a fixed order does so at start.
///
/// Returns `BW_CODE_OK`, `BW_CODE_MODEL_CHANNEL`, or `BW_CODE_OUT_OF_RANGE` if there is no such channel.
///
/// # Safety
/// `state` is NULL, or was given by `bw_start` or has as many readable bytes. `name` and `unit` are NULL or
/// readable up to a zero byte.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_check_channel(
    state: *const BwState,
    channel: u8,
    name: *const c_char,
    unit: *const c_char,
) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { at(state) }.and_then(|state| {
        check(name)?;
        check(unit)?;
        let own = state.model.constants().channels.get(usize::from(channel)).ok_or(BwCode::OutOfRange)?;
        // SAFETY: not NULL, and texts by the contract.
        let (name, unit) = unsafe { (CStr::from_ptr(name), CStr::from_ptr(unit)) };
        let same = own.name.as_str().as_bytes() == name.to_bytes() && own.unit.as_str().as_bytes() == unit.to_bytes();
        if same { Ok(BwCode::Ok) } else { Err(BwCode::ModelChannel) }
    }))
}

/// Checks that the drive samples as the recordings were sampled on which the model was trained, to 1 %.
///
/// Returns `BW_CODE_OK`, also if either interval is unknown (0), or `BW_CODE_MODEL_INTERVAL`.
///
/// # Safety
/// `state` is NULL, or was given by `bw_start` or has as many readable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_check_interval(state: *const BwState, interval_s: f32) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { at(state) }.and_then(|state| {
        state.model.check_interval(interval_s)?;
        Ok(BwCode::Ok)
    }))
}

/// Checks that the drive's quadrature current has the sign convention of the recordings, `park` of `BwPark`.
///
/// Returns `BW_CODE_OK`, also if the model does not say, `BW_CODE_MODEL_PARK`, or `BW_CODE_OUT_OF_RANGE`.
///
/// # Safety
/// `state` is NULL, or was given by `bw_start` or has as many readable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_check_park(state: *const BwState, park: i32) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { at(state) }.and_then(|state| check_park(state, park)))
}

fn check_park(state: &BwState, number: i32) -> Outcome {
    let frame = RotorFrame { pole_pairs: 1, electrical_offset: Angle::ZERO, park: park(number)? };
    state.model.check_rotor_frame(&frame)?;
    Ok(BwCode::Ok)
}

/// The sign convention with a number of [`BwPark`].
///
/// # Errors
/// [`BwCode::OutOfRange`], also for [`BwPark::Unknown`].
pub(crate) const fn park(number: i32) -> Outcome<Park> {
    match number {
        1 => Ok(Park::Standard),
        2 => Ok(Park::Thesis),
        _ => Err(BwCode::OutOfRange),
    }
}
