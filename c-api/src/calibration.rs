//! Offsets of the current sensors, measured at standstill with the inverter off.

use core::ffi::c_void;
use core::mem::offset_of;

use bearing_watch::drive::{CalibrationError, CalibrationLimits, OffsetCalibration};

use crate::code::{BwCode, Outcome, code};
use crate::front_end::constants::BwFrontEndConstants;
use crate::front_end::faults::place_of;
use crate::front_end::sample::phase_counts;
use crate::memory::{Lock, Object, Tag, at, check, elements, get, put, put_object, room};

/// Bytes of memory that are enough for `bw_calibration_init`, aligned to `BW_STATE_ALIGN` bytes.
pub const BW_CALIBRATION_SIZE: usize = 128;

const _: () = assert!(size_of::<BwCalibration>() <= BW_CALIBRATION_SIZE);

/// What a calibration must look like.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BwCalibrationLimits {
    /// Number of samples, at least 2.
    pub samples: u16,
    /// Lowest plausible offset, counts.
    pub lowest_offset_counts: f32,
    /// Highest plausible offset, counts.
    pub highest_offset_counts: f32,
    /// Lowest plausible standard deviation, counts: less noise means a stuck converter; 0 accepts a constant.
    pub lowest_deviation_counts: f32,
    /// Highest plausible standard deviation, counts.
    pub highest_deviation_counts: f32,
}

/// A current sensor whose offset was refused.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BwRefusedOffset {
    /// The phase, 0, 1, 2 for a, b, c; 0 for `BW_CODE_CALIBRATION_TOO_FEW`.
    pub phase: u8,
    /// Standard deviation for `BW_CODE_CALIBRATION_NOISY` and offset for `BW_CODE_CALIBRATION_OUT_OF_BAND`, counts;
    /// number of samples for `BW_CODE_CALIBRATION_TOO_FEW`; 0 for `BW_CODE_CALIBRATION_STUCK`.
    pub value: f32,
}

/// The calibration of one drive, in memory of the caller.
#[derive(Debug)]
pub struct BwCalibration {
    tag: Tag,
    calibration: Lock<OffsetCalibration>,
}

impl Object for BwCalibration {
    const MARK: u32 = 0x4257_4F31;
    const PLACE_OF_TAG: usize = offset_of!(Self, tag);
}

/// Makes a calibration without samples in memory of the caller, and gives its address in `calibration`.
///
/// # Safety
/// `memory` is NULL or has `size` writable bytes, which nothing else writes until the calibration is used no more.
/// `limits` is NULL or readable. `calibration` is NULL or writable. No other function works on the calibration.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_calibration_init(
    memory: *mut c_void,
    size: usize,
    limits: *const BwCalibrationLimits,
    calibration: *mut *mut BwCalibration,
) -> BwCode {
    // SAFETY: the same contract; every bit pattern of the limits is valid.
    code(room(memory, size).and_then(|place| unsafe {
        let own = get(limits)?;
        let limits = CalibrationLimits {
            samples: own.samples,
            offset_counts: [own.lowest_offset_counts, own.highest_offset_counts],
            deviation_counts: [own.lowest_deviation_counts, own.highest_deviation_counts],
        };
        let object = BwCalibration { tag: Tag::none(), calibration: Lock::new(OffsetCalibration::new(limits)) };
        put_object(place, object, calibration)
    }))
}

/// Takes the counts of the phases a, b, and c if `phases` is 3 and not 2, in the interrupt of the converter with the
/// inverter off.
///
/// Returns `BW_CODE_OK`, `BW_CODE_ENOUGH_SAMPLES`, `BW_CODE_OUT_OF_RANGE` for another number of phases, or
/// `BW_CODE_BUSY`. Samples beyond the last one are ignored.
///
/// # Safety
/// `calibration` is NULL, or was given by `bw_calibration_init` or has as many readable bytes. `counts` is NULL or has
/// `phases` readable values.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_calibration_push(
    calibration: *mut BwCalibration,
    counts: *const u16,
    phases: u8,
) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { at(calibration) }.and_then(|own| {
        // SAFETY: the same contract.
        let counts = phase_counts(unsafe { elements(counts, phases.into())? }, phases)?;
        let enough = own.calibration.with(|calibration| calibration.push(&counts))?;
        Ok(if enough { BwCode::EnoughSamples } else { BwCode::Ok })
    }))
}

/// Puts the measured offsets into constants of a front end; a third phase that was never sampled keeps its own. If
/// one is refused, the constants are unchanged, and `refused` names the first one.
///
/// Returns `BW_CODE_OK`, `BW_CODE_CALIBRATION_…`, or `BW_CODE_BUSY`.
///
/// # Safety
/// `calibration` is NULL, or was given by `bw_calibration_init` or has as many readable bytes. `constants` is NULL, or
/// readable and writable. `refused` is NULL or writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_calibration_finish(
    calibration: *mut BwCalibration,
    constants: *mut BwFrontEndConstants,
    refused: *mut BwRefusedOffset,
) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { at(calibration) }.and_then(|own| unsafe { finish(own, constants, refused) }))
}

unsafe fn finish(own: &BwCalibration, constants: *mut BwFrontEndConstants, refused: *mut BwRefusedOffset) -> Outcome {
    check(refused)?;
    // SAFETY: the contract of the caller; every bit pattern of the constants is valid.
    let mut changed = unsafe { get(constants)? };
    match own.calibration.with(|calibration| calibration.finish(changed.phase_sensors()))? {
        Ok(sensors) => {
            let pairs = changed.sensors.iter_mut().zip(sensors);
            pairs.for_each(|(own, measured)| own.offset_counts = measured.offset_counts);
            // SAFETY: the contract of the caller.
            unsafe { put(constants, changed) }.map(|()| BwCode::Ok)
        }
        Err(error) => {
            let (phase, value) = match error {
                CalibrationError::Noisy { phase, deviation_counts } => (place_of(phase), deviation_counts),
                CalibrationError::Stuck { phase } => (place_of(phase), 0.0),
                CalibrationError::OutOfBand { phase, offset_counts } => (place_of(phase), offset_counts),
                CalibrationError::TooFew { samples } => (0, samples.into()),
                // What a later version of the core adds.
                _ => (0, 0.0),
            };
            // SAFETY: the contract of the caller.
            unsafe { put(refused, BwRefusedOffset { phase, value })? };
            Err(error.into())
        }
    }
}
