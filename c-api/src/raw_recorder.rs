//! Raw samples at the control rate in blocks, from the interrupt to the main loop, which sends them as frames.

use core::ffi::c_void;
use core::mem::offset_of;

use bearing_watch::telemetry::RawRecorder;

use crate::blocks::{Blocks, Gather};
use crate::code::{BwCode, code};
use crate::front_end::FURTHER;
use crate::front_end::sample::{BwRawSample, read};
use crate::memory::{Object, Tag, at, put_object, room};
use crate::recorder::BW_BLOCK_BYTES;

/// Bytes of memory that are enough for `bw_raw_recorder_init`, aligned to `BW_STATE_ALIGN` bytes.
pub const BW_RAW_RECORDER_SIZE: usize = 1088;

const _: () = assert!(size_of::<BwRawRecorder>() <= BW_RAW_RECORDER_SIZE);

/// What gathers the raw samples of a block.
type Samples = RawRecorder<FURTHER, BW_BLOCK_BYTES>;

/// Records what a front end takes, in memory of the caller.
#[derive(Debug)]
pub struct BwRawRecorder {
    tag: Tag,
    /// Further channels in use.
    further: u16,
    pub(crate) blocks: Blocks<Samples>,
}

impl Object for BwRawRecorder {
    const MARK: u32 = 0x4257_5241;
    const PLACE_OF_TAG: usize = offset_of!(Self, tag);
}

impl Gather for Samples {
    fn is_complete(&self) -> bool {
        Self::is_complete(self)
    }

    fn take(&mut self) -> Self {
        Self::take(self)
    }
}

/// Makes a recorder of raw samples with so many further channels in memory of the caller, and gives its address in
/// `recorder`. A drive that has no model yet records the traces that one is trained with.
///
/// Returns `BW_CODE_OK`, `BW_CODE_FRONT_END_CONTROL_RATE`, `BW_CODE_FRONT_END_FURTHER`, or what is wrong with the
/// memory.
///
/// # Safety
/// `memory` is NULL or has `size` writable bytes, which nothing else writes until the recorder is used no more.
/// `recorder` is NULL or writable. No other function works on the recorder.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_raw_recorder_init(
    memory: *mut c_void,
    size: usize,
    control_rate_hz: f32,
    further: u16,
    recorder: *mut *mut BwRawRecorder,
) -> BwCode {
    code(room(memory, size).and_then(|place| {
        if !(control_rate_hz > 0.0 && control_rate_hz < f32::INFINITY) {
            return Err(BwCode::FrontEndControlRate);
        }
        let channels = u8::try_from(further).ok().filter(|channels| usize::from(*channels) <= FURTHER);
        let samples = Samples::new(control_rate_hz).with_further(channels.ok_or(BwCode::FrontEndFurther)?);
        let object = BwRawRecorder { tag: Tag::none(), further, blocks: Blocks::new(samples) };
        // SAFETY: the same contract.
        unsafe { put_object(place, object, recorder) }
    }))
}

/// Takes a raw sample as `bw_front_end_push` takes it, in the same interrupt. A complete block waits for
/// `bw_telemetry_raw` in the main loop, while the next one is filled.
///
/// Returns `BW_CODE_OK`; `BW_CODE_BLOCK` if a complete block waits now; `BW_CODE_RECORDER_FULL` if two blocks are
/// complete: the sample is not recorded, and the receiver sees a gap; `BW_CODE_WRONG_CHANNEL_COUNT`;
/// `BW_CODE_OUT_OF_RANGE` if `phases` or `position` of the sample is; or `BW_CODE_BUSY`.
///
/// # Safety
/// `recorder` is NULL, or was given by `bw_raw_recorder_init` or has as many readable bytes. `raw` is NULL or readable.
/// `further` is NULL or has `count` readable values.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_raw_recorder_push(
    recorder: *mut BwRawRecorder,
    raw: *const BwRawSample,
    further: *const f32,
    count: usize,
) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { at(recorder) }.and_then(|own| {
        // SAFETY: the same contract.
        let raw = unsafe { read(raw, (further, count), own.further)? };
        own.blocks.push(|block| _ = block.push(&raw))
    }))
}
