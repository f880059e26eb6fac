//! Reports and recorded samples as frames for a serial line, which `bearing-watch listen` reads.

use core::ffi::c_void;
use core::mem::offset_of;

use bearing_watch::model::Label;
use bearing_watch::telemetry::{Encoder, RawEncoder, Source, TooSmall};

use crate::code::{BwCode, Outcome, code};
use crate::memory::{Lock, Object, Tag, at, check, elements_mut, put, put_object, room};
use crate::plan::{
    BW_MAX_CHANNELS, BW_MAX_CLASSES, BW_MAX_COORDINATES, BW_MAX_DIRECTIONS, BW_MAX_FEATURES, BW_MAX_ORDERS,
    BW_MAX_RISING, Own,
};
use crate::recorder::{BW_BLOCK_BYTES, BwRawRecorder, BwRecorder};
use crate::state::BwState;

/// Bytes of memory that are enough for `bw_telemetry_init`, aligned to `BW_STATE_ALIGN` bytes.
pub const BW_TELEMETRY_SIZE: usize = 48;
/// A buffer of so many bytes is enough for every frame of a library without a plan of its own, and of any plan that is
/// not larger than `BW_MAX_…`.
pub const BW_FRAME_SIZE: usize = 560;

const _: () = assert!(size_of::<BwTelemetry>() <= BW_TELEMETRY_SIZE);
const _: () = {
    // Names and units that end in a zero byte.
    const CHANNEL: usize = 32 + 8 + 2;
    const LABEL: usize = size_of::<Label>() + 1;
    // Header and fields, and the lists after them.
    let of_model = 2 * BW_MAX_FEATURES + BW_MAX_COORDINATES + 4 * BW_MAX_ORDERS;
    let hello = 10 + 26 + of_model + CHANNEL * BW_MAX_CHANNELS + LABEL * BW_MAX_CLASSES;
    let lists = 4 * (BW_MAX_CLASSES + BW_MAX_FEATURES + BW_MAX_ORDERS + BW_MAX_RISING) + 13 * BW_MAX_DIRECTIONS;
    let report = 10 + 66 + 15 + lists;
    let raw = 10 + 10 + BW_BLOCK_BYTES;
    assert!(fits(hello) && fits(report) && fits(raw));
};

/// Whether a frame of so many bytes of content fits into a buffer of [`BW_FRAME_SIZE`]
/// ([`bearing_watch::telemetry`]).
const fn fits(content: usize) -> bool {
    content * 255 / 254 + 6 <= BW_FRAME_SIZE
}

/// Makes the frames of one line, in memory of the caller.
#[derive(Debug)]
pub struct BwTelemetry {
    tag: Tag,
    line: Lock<Line>,
}

impl Object for BwTelemetry {
    const MARK: u32 = 0x4257_5431;
    const PLACE_OF_TAG: usize = offset_of!(Self, tag);
}

#[derive(Debug)]
enum Line {
    /// Of a drive without a model.
    Raw(RawEncoder),
    Model(&'static BwState, Encoder<'static, Own>),
}

/// Makes a line without frames in memory of the caller, and gives its address in `telemetry`. With a `state` it sends
/// its reports and samples, and raw samples; without one, NULL, raw samples only. `model_id` is any number that
/// identifies the model, such as `BW_MODEL_ID`; `session` is one that changes with each power-up, such as a count of
/// them. After another `bw_start` of the state the line has to be initialised again, too.
///
/// # Safety
/// `memory` is NULL or has `size` writable bytes, which nothing else writes until the line is used no more. `state`
/// is NULL, or was given by `bw_start` or has as many readable bytes, and is there as long as the line. `telemetry`
/// is NULL or writable. No other function works on the line.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_telemetry_init(
    memory: *mut c_void,
    size: usize,
    state: *const BwState,
    model_id: u32,
    session: u32,
    telemetry: *mut *mut BwTelemetry,
) -> BwCode {
    let source = Source { model_id, session };
    // SAFETY: the same contract.
    code(room(memory, size).and_then(|place| unsafe {
        let line = if state.is_null() {
            Line::Raw(RawEncoder::new(source))
        } else {
            let state: &'static BwState = at(state)?;
            Line::Model(state, Encoder::new(state.model, source))
        };
        put_object(place, BwTelemetry { tag: Tag::none(), line: Lock::new(line) }, telemetry)
    }))
}

/// Writes a frame with names and constants of the model into `buffer`, and its length into `length`. Send it at the
/// start and again every few seconds: a receiver needs it for reports and samples. Raw samples need none.
///
/// Returns `BW_CODE_OK`, `BW_CODE_NOT_INITIALISED` if the line has no state, `BW_CODE_BUFFER_TOO_SMALL`, or
/// `BW_CODE_BUSY`.
///
/// # Safety
/// `telemetry` is NULL, or was given by `bw_telemetry_init` or has as many readable bytes. `buffer` is NULL or has
/// `capacity` writable bytes. `length` is NULL or writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_telemetry_hello(
    telemetry: *mut BwTelemetry,
    buffer: *mut u8,
    capacity: usize,
    length: *mut usize,
) -> BwCode {
    let hello = |line: &mut Line, buffer: &mut [u8]| match line {
        Line::Model(_, encoder) => written(encoder.hello(buffer)),
        Line::Raw(_) => Err(BwCode::NotInitialised),
    };
    // SAFETY: the same contract.
    code(unsafe { frame(telemetry, (buffer, capacity), length, hello) })
}

/// Writes a frame with the report of the last segment, as `bw_report` and `bw_alarm` give it, and with the values of
/// the features into `buffer`, and its length into `length`.
///
/// Returns `BW_CODE_OK`, `BW_CODE_NO_REPORT`, `BW_CODE_NOT_INITIALISED` if the line has no state,
/// `BW_CODE_BUFFER_TOO_SMALL`, or `BW_CODE_BUSY`.
///
/// # Safety
/// As `bw_telemetry_hello`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_telemetry_report(
    telemetry: *mut BwTelemetry,
    buffer: *mut u8,
    capacity: usize,
    length: *mut usize,
) -> BwCode {
    let report = |line: &mut Line, buffer: &mut [u8]| {
        let Line::Model(state, encoder) = line else { return Err(BwCode::NotInitialised) };
        state.settled(|monitor| {
            let report = monitor.report().ok_or(BwCode::NoReport)?;
            written(encoder.report(report, monitor.evidence(), buffer))
        })?
    };
    // SAFETY: the same contract.
    code(unsafe { frame(telemetry, (buffer, capacity), length, report) })
}

/// Writes a frame with the block of samples that waits in a recorder into `buffer`, and its length into `length`. The
/// recorder is one of the same state.
///
/// Returns `BW_CODE_OK`; `BW_CODE_IDLE` if no block waits; `BW_CODE_NOT_INITIALISED` if the line has no state; or
/// `BW_CODE_BUFFER_TOO_SMALL` or `BW_CODE_BUSY`: the block still waits.
///
/// # Safety
/// As `bw_telemetry_hello`. `recorder` is NULL, or was given by `bw_recorder_init` or has as many readable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_telemetry_samples(
    telemetry: *mut BwTelemetry,
    recorder: *mut BwRecorder,
    buffer: *mut u8,
    capacity: usize,
    length: *mut usize,
) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { at(recorder) }.and_then(|recorder| {
        let samples = |line: &mut Line, buffer: &mut [u8]| match line {
            Line::Model(_, encoder) => recorder.blocks().serve(|own| written(encoder.samples(&own.block(), buffer))),
            Line::Raw(_) => Err(BwCode::NotInitialised),
        };
        // SAFETY: the same contract.
        unsafe { frame(telemetry, (buffer, capacity), length, samples) }
    }))
}

/// Writes a frame with the block of raw samples that waits in a recorder into `buffer`, and its length into `length`.
///
/// Returns `BW_CODE_OK`; `BW_CODE_IDLE` if no block waits; or `BW_CODE_BUFFER_TOO_SMALL` or `BW_CODE_BUSY`: the block
/// still waits.
///
/// # Safety
/// As `bw_telemetry_hello`. `recorder` is NULL, or was given by `bw_raw_recorder_init` or has as many readable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_telemetry_raw(
    telemetry: *mut BwTelemetry,
    recorder: *mut BwRawRecorder,
    buffer: *mut u8,
    capacity: usize,
    length: *mut usize,
) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { at(recorder) }.and_then(|recorder| {
        let raw = |line: &mut Line, buffer: &mut [u8]| {
            recorder.blocks().serve(|own| {
                written(match line {
                    Line::Model(_, encoder) => encoder.raw(&own.block(), buffer),
                    Line::Raw(encoder) => encoder.raw(&own.block(), buffer),
                })
            })
        };
        // SAFETY: the same contract.
        unsafe { frame(telemetry, (buffer, capacity), length, raw) }
    }))
}

/// Lets `write` make a frame in the buffer, and gives its length.
///
/// # Safety
/// As `bw_telemetry_hello`.
unsafe fn frame(
    telemetry: *mut BwTelemetry,
    (buffer, capacity): (*mut u8, usize),
    length: *mut usize,
    write: impl FnOnce(&mut Line, &mut [u8]) -> Outcome<usize>,
) -> Outcome {
    // SAFETY: the contract of the caller.
    let own = unsafe { at(telemetry)? };
    check(length)?;
    // SAFETY: writable by the contract; no other reference to them exists during this call.
    let buffer = unsafe { elements_mut(buffer, capacity)? };
    let written = own.line.with(|line| write(line, buffer))??;
    // SAFETY: the contract of the caller.
    unsafe { put(length, written)? };
    Ok(BwCode::Ok)
}

fn written(frame: Result<&[u8], TooSmall>) -> Outcome<usize> {
    frame.map(<[u8]>::len).map_err(|TooSmall| BwCode::BufferTooSmall)
}
