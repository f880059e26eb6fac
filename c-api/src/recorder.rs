//! Samples of the detector in blocks, from the interrupt to the main loop, which sends them as frames.

use core::ffi::c_void;
use core::mem::offset_of;

use bearing_watch::Angle;
use bearing_watch::plan::{Plan, Signals as _};
use bearing_watch::telemetry::Recorder;

use crate::blocks::{Blocks, Gather};
use crate::code::{BwCode, code};
use crate::memory::{Object, Tag, at, elements, put_object, room};
use crate::plan::Own;
use crate::state::BwState;

/// Bytes of a block. A sample has four for each channel, and four for the angle of a model that needs it.
pub const BW_BLOCK_BYTES: usize = 480;
/// Bytes of memory that are enough for `bw_recorder_init`, aligned to `BW_STATE_ALIGN` bytes.
pub const BW_RECORDER_SIZE: usize = 1152;

const _: () = assert!(size_of::<BwRecorder>() <= BW_RECORDER_SIZE);

/// What gathers the samples of a block.
type Samples = Recorder<Own, BW_BLOCK_BYTES>;

/// Records samples of a detector, in memory of the caller.
#[derive(Debug)]
pub struct BwRecorder {
    tag: Tag,
    /// Channels of the model.
    channels: u8,
    pub(crate) blocks: Blocks<Samples>,
}

impl Object for BwRecorder {
    const MARK: u32 = 0x4257_5231;
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

/// Makes a recorder of the samples of a detector in memory of the caller, and gives its address in `recorder`.
///
/// # Safety
/// `memory` is NULL or has `size` writable bytes, which nothing else writes until the recorder is used no more. `state`
/// is NULL, or was given by `bw_init` or has as many readable bytes. `recorder` is NULL or writable. No other function
/// works on the recorder.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_recorder_init(
    memory: *mut c_void,
    size: usize,
    state: *const BwState,
    recorder: *mut *mut BwRecorder,
) -> BwCode {
    // SAFETY: the same contract.
    code(room(memory, size).and_then(|place| unsafe {
        let plan = at(state)?.model.plan();
        let (channels, blocks) = (plan.layout().channels, Blocks::new(Samples::new(plan)));
        put_object(place, BwRecorder { tag: Tag::none(), channels, blocks }, recorder)
    }))
}

/// Takes a sample as `bw_collect` takes it, in the same interrupt. A complete block waits for `bw_telemetry_samples` in
/// the main loop, while the next one is filled.
///
/// Returns `BW_CODE_OK`; `BW_CODE_BLOCK` if a complete block waits now; `BW_CODE_RECORDER_FULL` if two blocks are
/// complete: the sample is not recorded, and the receiver sees a gap; `BW_CODE_WRONG_CHANNEL_COUNT`; or `BW_CODE_BUSY`.
///
/// # Safety
/// `recorder` is NULL, or was given by `bw_recorder_init` or has as many readable bytes. `values` is NULL or has
/// `count` readable values.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_recorder_push(
    recorder: *mut BwRecorder,
    values: *const f32,
    count: usize,
    angle: u32,
) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { at(recorder) }.and_then(|own| {
        if count != usize::from(own.channels) {
            return Err(BwCode::WrongChannelCount);
        }
        // SAFETY: the same contract.
        let sample = <Own as Plan>::Sample::of(unsafe { elements(values, count)? }, Angle::from_bits(angle));
        own.blocks.push(|block| _ = block.push(&sample))
    }))
}

/// Passes over samples that were not taken, such as those of missed interrupts. What follows `bw_restart` does not
/// continue from the samples before: pass over one. A block that has samples is complete.
///
/// Returns `BW_CODE_OK`, `BW_CODE_BLOCK` as `bw_recorder_push`, or `BW_CODE_BUSY`.
///
/// # Safety
/// `recorder` is NULL, or was given by `bw_recorder_init` or has as many readable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_recorder_skip(recorder: *mut BwRecorder, samples: u32) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { at(recorder) }.and_then(|own| own.blocks.change(|block| block.skip(samples))))
}
