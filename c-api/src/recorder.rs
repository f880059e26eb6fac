//! Samples in blocks, from the interrupt to the main loop, which sends them as frames: those of the detector, and raw
//! ones at the control rate.

use core::ffi::c_void;
use core::mem::offset_of;

use bearing_watch::Angle;
use bearing_watch::plan::Signals as _;
use bearing_watch::telemetry::{RawRecorder, Recorder};

use crate::blocks::{Blocks, Gather};
use crate::code::{BwCode, code};
use crate::front_end::FURTHER;
use crate::front_end::sample::{BwRawSample, read};
use crate::memory::{Object, Tag, at, elements, put_object, room};
use crate::plan::{Own, Sample};
use crate::sampling::closed;
use crate::state::BwState;

/// Bytes of a block. A sample has four for each channel, and four for the angle of a model that needs it.
pub const BW_BLOCK_BYTES: usize = 480;
/// Bytes of memory that are enough for `bw_recorder_init`, aligned to `BW_STATE_ALIGN` bytes.
pub const BW_RECORDER_SIZE: usize = 1152;
/// Bytes of memory that are enough for `bw_raw_recorder_init`, aligned to `BW_STATE_ALIGN` bytes.
pub const BW_RAW_RECORDER_SIZE: usize = 1088;

const _: () = assert!(size_of::<BwRecorder>() <= BW_RECORDER_SIZE);
const _: () = assert!(size_of::<BwRawRecorder>() <= BW_RAW_RECORDER_SIZE);

/// Records samples of a detector, in memory of the caller.
#[derive(Debug)]
pub struct BwRecorder(Recording<Samples>);

/// Records what a front end takes, in memory of the caller.
#[derive(Debug)]
pub struct BwRawRecorder(Recording<RawSamples>);

/// What gathers the samples of a block.
type Samples = Recorder<Own, BW_BLOCK_BYTES>;
type RawSamples = RawRecorder<FURTHER, BW_BLOCK_BYTES>;

/// What both recorders are.
#[derive(Debug)]
pub(crate) struct Recording<R> {
    tag: Tag,
    /// Channels of the model, or further channels in use.
    channels: u16,
    blocks: Blocks<R>,
}

impl<R: Gather> Recording<R> {
    const fn new(channels: u16, block: R) -> Self {
        Self { tag: Tag::none(), channels, blocks: Blocks::new(block) }
    }
}

/// Both recorders name these functions alike, but no trait has them.
macro_rules! recorder {
    ($object:ident of $samples:ident, $mark:literal) => {
        impl Object for $object {
            const MARK: u32 = $mark;
            const PLACE_OF_TAG: usize = offset_of!(Self, 0.tag);
        }

        impl $object {
            pub(crate) const fn blocks(&self) -> &Blocks<$samples> {
                &self.0.blocks
            }
        }

        impl Gather for $samples {
            fn is_complete(&self) -> bool {
                Self::is_complete(self)
            }

            fn take(&mut self) -> Self {
                Self::take(self)
            }
        }
    };
}

recorder!(BwRecorder of Samples, 0x4257_5231);
recorder!(BwRawRecorder of RawSamples, 0x4257_5241);

/// Makes a recorder of the samples of a detector in memory of the caller, and gives its address in `recorder`.
///
/// # Safety
/// `memory` is NULL or has `size` writable bytes, which nothing else writes until the recorder is used no more. `state`
/// is NULL, or was given by `bw_start` or has as many readable bytes. `recorder` is NULL or writable. No other function
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
        let recording = Recording::new(plan.layout().channels.into(), Samples::new(plan));
        put_object(place, BwRecorder(recording), recorder)
    }))
}

/// Takes a sample as `bw_sample` takes it, in the same interrupt; a drive with a front end calls `bw_collect_recorded`
/// instead. A complete block waits for `bw_telemetry_samples` in
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
        if count != usize::from(own.0.channels) {
            return Err(BwCode::WrongChannelCount);
        }
        // SAFETY: the same contract.
        let sample = Sample::of(unsafe { elements(values, count)? }, Angle::from_bits(angle));
        own.0.blocks.push(|block| _ = block.push(&sample))
    }))
}

/// As `bw_collect`, and records each sample that the detector takes: a complete block waits for `bw_telemetry_samples`
/// in the main loop. What finds both blocks complete is not recorded, and the receiver sees a gap.
///
/// # Safety
/// As `bw_collect`; `recorder` is NULL, or was given by `bw_recorder_init` or has as many readable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_collect_recorded(state: *mut BwState, recorder: *mut BwRecorder) -> BwCode {
    // SAFETY: the same contract.
    let given = unsafe { at(state) }.and_then(|state| unsafe { Ok((state, at(recorder)?)) });
    code(
        given.map(|(state, recorder)| closed(state.watch.collect_with(|sample, missed| recorder.take(sample, missed)))),
    )
}

impl BwRecorder {
    /// Takes a sample of the detector, behind some that were lost.
    pub(crate) fn take(&self, sample: &Sample, missed: u16) {
        if missed > 0 {
            let _busy = self.0.blocks.change(|block| block.skip(missed.into()));
        }
        let _full = self.0.blocks.push(|block| _ = block.push(sample));
    }
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
    code(unsafe { at(recorder) }.and_then(|own| own.0.blocks.change(|block| block.skip(samples))))
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
        let samples = RawSamples::new(control_rate_hz).with_further(channels.ok_or(BwCode::FrontEndFurther)?);
        // SAFETY: the same contract.
        unsafe { put_object(place, BwRawRecorder(Recording::new(further, samples)), recorder) }
    }))
}

/// Takes a raw sample as `bw_sample_raw` takes it, in the same interrupt. A complete block waits for
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
        let raw = unsafe { read(raw, (further, count), own.0.channels)? };
        own.0.blocks.push(|block| _ = block.push(&raw))
    }))
}
