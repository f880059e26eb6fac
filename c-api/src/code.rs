//! What every function returns, and the text of it.

use core::ffi::{CStr, c_char};

use bearing_watch::ModelError;

/// What a function returns: 0 or above if it did what it says, below 0 if it did nothing. But with
/// `BW_CODE_SEGMENT_LOST` the sample is taken, and with `BW_CODE_BUFFER_TOO_SMALL` `bw_values` has filled the buffer.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BwCode {
    /// Done.
    Ok = 0,
    /// The sample closed a segment; the main loop can conclude it.
    Segment = 1,
    /// There is a new report.
    Report = 2,
    /// The estimate was not adopted: it came too late, has no use in this model, or is not stable. Not an error.
    NotAdopted = 3,
    /// There is no closed segment to solve.
    Idle = 4,
    /// A pointer is NULL.
    Null = -1,
    /// A pointer is not aligned: the memory of the state to `BW_STATE_ALIGN` bytes, other pointers to their type.
    Misaligned = -2,
    /// The memory has less than `bw_state_size()` bytes.
    MemoryTooSmall = -3,
    /// No state was initialised at this address; a copied state does not count.
    NotInitialised = -4,
    /// The function interrupted another one that works on the same part of the state. A sample is lost.
    Busy = -5,
    /// The sample closed a segment, but the main loop has not taken the segment before it. The new one is lost.
    SegmentLost = -6,
    /// There is no report yet, or the next segment is being solved.
    NoReport = -7,
    /// The number of values is not the number of channels of the model.
    WrongChannelCount = -8,
    /// No such thing: an index or a choice is out of range.
    OutOfRange = -9,
    /// The buffer has too few elements.
    BufferTooSmall = -10,
    /// The bytes are not a model.
    NotAModel = -20,
    /// The model has another format version: train it again.
    ModelVersion = -21,
    /// The model has fewer bytes than its header says.
    ModelTruncated = -22,
    /// The checksum does not match: the model is corrupted.
    ModelChecksum = -23,
    /// A value of the model is out of range.
    ModelValue = -24,
    /// The model does not fit the arrays of this library, see `BW_MAX_...`, or is not of the plan it was built for.
    ModelDoesNotFit = -25,
    /// The model has another name or unit of this channel.
    ModelChannel = -26,
    /// The model was trained on samples with another interval.
    ModelInterval = -27,
    /// The model was trained with the other Park convention.
    ModelPark = -28,
    /// The bytes are not a saved state of this version and of these sizes, or are corrupted.
    SavedState = -35,
    /// The saved state is that of another model.
    OtherModel = -36,
}

impl BwCode {
    const ALL: [Self; 26] = [
        Self::Ok,
        Self::Segment,
        Self::Report,
        Self::NotAdopted,
        Self::Idle,
        Self::Null,
        Self::Misaligned,
        Self::MemoryTooSmall,
        Self::NotInitialised,
        Self::Busy,
        Self::SegmentLost,
        Self::NoReport,
        Self::WrongChannelCount,
        Self::OutOfRange,
        Self::BufferTooSmall,
        Self::NotAModel,
        Self::ModelVersion,
        Self::ModelTruncated,
        Self::ModelChecksum,
        Self::ModelValue,
        Self::ModelDoesNotFit,
        Self::ModelChannel,
        Self::ModelInterval,
        Self::ModelPark,
        Self::SavedState,
        Self::OtherModel,
    ];

    const fn text(self) -> &'static CStr {
        match self {
            Self::Ok => c"done",
            Self::Segment => c"a segment is closed",
            Self::Report => c"there is a new report",
            Self::NotAdopted => c"the estimate was not adopted",
            Self::Idle => c"there is no closed segment to solve",
            Self::Null => c"a pointer is NULL",
            Self::Misaligned => c"a pointer is not aligned",
            Self::MemoryTooSmall => c"the memory has less than bw_state_size() bytes",
            Self::NotInitialised => c"no state was initialised at this address",
            Self::Busy => c"another function works on the same part of the state",
            Self::SegmentLost => c"a segment is lost: the one before it was not taken",
            Self::NoReport => c"there is no report",
            Self::WrongChannelCount => c"the number of values is not that of the model's channels",
            Self::OutOfRange => c"an index or a choice is out of range",
            Self::BufferTooSmall => c"the buffer is too small",
            Self::NotAModel => c"these bytes are not a bearing-watch model",
            Self::ModelVersion => c"the model has another format version; train it again",
            Self::ModelTruncated => c"the model is truncated",
            Self::ModelChecksum => c"the checksum does not match: the model is corrupted",
            Self::ModelValue => c"a value of the model is out of range",
            Self::ModelDoesNotFit => c"the model does not fit the arrays or the plan of this library",
            Self::ModelChannel => c"a channel of the model has another name or unit",
            Self::ModelInterval => c"the sampling interval differs from that of the model",
            Self::ModelPark => c"the model was trained with the other Park convention",
            Self::SavedState => c"these bytes are not a saved state, or are corrupted",
            Self::OtherModel => c"the saved state is that of another model",
        }
    }
}

impl From<ModelError> for BwCode {
    fn from(error: ModelError) -> Self {
        match error {
            ModelError::NotAModel => Self::NotAModel,
            ModelError::Version { .. } => Self::ModelVersion,
            ModelError::Truncated => Self::ModelTruncated,
            ModelError::Checksum => Self::ModelChecksum,
            ModelError::OtherPlan => Self::ModelDoesNotFit,
            ModelError::Channel { .. } => Self::ModelChannel,
            ModelError::Interval { .. } => Self::ModelInterval,
            ModelError::Park { .. } => Self::ModelPark,
            ModelError::BufferTooSmall => Self::BufferTooSmall,
            // Layout, Length, OutOfRange, and what a later version of the core adds.
            _ => Self::ModelValue,
        }
    }
}

/// What an internal function returns; the error goes to the caller.
pub(crate) type Outcome<T = BwCode> = Result<T, BwCode>;

/// The code of an outcome.
pub(crate) fn code(outcome: Outcome) -> BwCode {
    match outcome {
        Ok(code) | Err(code) => code,
    }
}

/// Returns a text for a code, ending in a zero byte; "unknown code" for other numbers. Never NULL.
#[unsafe(no_mangle)]
pub extern "C" fn bw_error_text(code: i32) -> *const c_char {
    let known = BwCode::ALL.into_iter().find(|known| *known as i32 == code);
    known.map_or(c"unknown code", BwCode::text).as_ptr()
}
