//! What every function returns, and the text of it.

use core::ffi::{CStr, c_char};

use bearing_watch::ModelError;
use bearing_watch::drive::{CalibrationError, FrontEndError};

/// What a function returns: 0 or above if it did what it says, below 0 if it did nothing. But with
/// `BW_CODE_BUFFER_TOO_SMALL` `bw_values` has filled the buffer and `bw_end_run` has ended the run, and with a
/// `BW_CODE_CALIBRATION_…` `bw_calibration_finish` names the refused sensor.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BwCode {
    /// Done.
    Ok = 0,
    /// A segment has closed; the main loop can solve it.
    Segment = 1,
    /// There is a new report.
    Report = 2,
    /// The last report has lost its verdict, because a fault was found late.
    Withdrawn = 3,
    /// There is no closed segment to solve, or no alarm to deny.
    Idle = 4,
    /// Samples wait: the interrupt of `bw_collect` is to be requested.
    Collect = 5,
    /// The calibration has as many samples as it needs.
    EnoughSamples = 6,
    /// A block of recorded samples is complete and waits to be sent.
    Block = 7,
    /// A pointer is NULL.
    Null = -1,
    /// A pointer is not aligned: the memory of an object to `BW_STATE_ALIGN` bytes, other pointers to their type.
    Misaligned = -2,
    /// The memory has less than `bw_state_size()` bytes, or what another object needs.
    MemoryTooSmall = -3,
    /// No state, or other object, was initialised at this address; a copied one does not count.
    NotInitialised = -4,
    /// The function interrupted another one that works on the same part of the state.
    Busy = -5,
    /// There is no report yet, or the next segment is being solved.
    NoReport = -7,
    /// The number of values is not the number of channels of the model, or of further channels of the front end.
    WrongChannelCount = -8,
    /// No such thing: an index or a choice is out of range.
    OutOfRange = -9,
    /// The buffer has too few elements.
    BufferTooSmall = -10,
    /// The blocks before were not sent: the sample is not recorded.
    RecorderFull = -11,
    /// The chip, or its settings in this context, computes otherwise than the host of the training.
    Arithmetic = -13,
    /// No sample has come for too long: `bw_sample` is not called, or the front end gives none.
    NoSample = -14,
    /// Samples wait, but were not collected for too long.
    NotCollected = -15,
    /// Samples come, but no segment has closed for too long, or none was taken by the main loop.
    NoSegment = -16,
    /// No segment has had a verdict for too long: `BwReport` and `BwAlarm` say why.
    NoVerdict = -17,
    /// Samples do not come at the rate of the model: no segment has a verdict.
    WrongRate = -18,
    /// The bytes are not a model.
    NotAModel = -20,
    /// The model has another format version: a newer one needs a newer library, an older one is trained again.
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
    /// The control rate is not within 100 Hz and 1 MHz.
    FrontEndControlRate = -40,
    /// Offset, gain or usable range of a current sensor is out of range.
    FrontEndSensor = -41,
    /// Noise, tolerance or window of the sum of the currents is out of range.
    FrontEndBalance = -42,
    /// Bandwidth, damping, limit or times of the tracking loop are out of range.
    FrontEndTracking = -43,
    /// The amplitudes of the resolver are out of range.
    FrontEndResolver = -44,
    /// A motor has at least one pole pair.
    FrontEndPolePairs = -45,
    /// There are no filters for this factor of decimation, or the plan of this library has another one.
    FrontEndFactor = -46,
    /// There are more further channels than `BW_MAX_FURTHER`, or not as many as the plan of this library has.
    FrontEndFurther = -47,
    /// There are not enough samples for the offsets of the current sensors yet.
    CalibrationTooFew = -50,
    /// A current sensor is too noisy: the motor turns, a current flows, or the sensor is broken.
    CalibrationNoisy = -51,
    /// The converter of a current sensor repeats itself.
    CalibrationStuck = -52,
    /// The offset of a current sensor is not plausible: a current flows, or the sensor is broken.
    CalibrationOutOfBand = -53,
    /// No signature follows the model.
    SignatureMissing = -60,
    /// The signature has another format version or algorithm.
    SignatureVersion = -61,
    /// A field of the signature does not fit the model before it.
    SignatureFormat = -62,
    /// The signature is cut short.
    SignatureTruncated = -63,
    /// The key of the signature is not accepted.
    SignatureKey = -64,
    /// The signature is not that of these bytes: they were changed, or signed by somebody else.
    SignatureMismatch = -65,
    /// The model is older than accepted.
    SignatureOlder = -66,
    /// A function of the flash has failed; the record before is still there.
    FlashFailed = -70,
    /// The places are not multiples of `BW_FLASH_UNIT`, or have no room for a record.
    FlashPlaces = -71,
    /// The record is longer than its place.
    FlashTooSmall = -72,
    /// The flash reads back other bytes than were written: it is worn, or was not erased.
    FlashNotWritten = -73,
    /// Neither place has a good record.
    FlashNoRecord = -74,
    /// The function that sends over CAN has failed.
    CanFailed = -80,
}

impl BwCode {
    const ALL: [Self; 60] = [
        Self::Ok,
        Self::Segment,
        Self::Report,
        Self::Withdrawn,
        Self::Idle,
        Self::Collect,
        Self::EnoughSamples,
        Self::Block,
        Self::Null,
        Self::Misaligned,
        Self::MemoryTooSmall,
        Self::NotInitialised,
        Self::Busy,
        Self::NoReport,
        Self::WrongChannelCount,
        Self::OutOfRange,
        Self::BufferTooSmall,
        Self::RecorderFull,
        Self::Arithmetic,
        Self::NoSample,
        Self::NotCollected,
        Self::NoSegment,
        Self::NoVerdict,
        Self::WrongRate,
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
        Self::FrontEndControlRate,
        Self::FrontEndSensor,
        Self::FrontEndBalance,
        Self::FrontEndTracking,
        Self::FrontEndResolver,
        Self::FrontEndPolePairs,
        Self::FrontEndFactor,
        Self::FrontEndFurther,
        Self::CalibrationTooFew,
        Self::CalibrationNoisy,
        Self::CalibrationStuck,
        Self::CalibrationOutOfBand,
        Self::SignatureMissing,
        Self::SignatureVersion,
        Self::SignatureFormat,
        Self::SignatureTruncated,
        Self::SignatureKey,
        Self::SignatureMismatch,
        Self::SignatureOlder,
        Self::FlashFailed,
        Self::FlashPlaces,
        Self::FlashTooSmall,
        Self::FlashNotWritten,
        Self::FlashNoRecord,
        Self::CanFailed,
    ];

    const fn text(self) -> &'static CStr {
        match self {
            Self::Ok => c"done",
            Self::Segment => c"a segment is closed",
            Self::Report => c"there is a new report",
            Self::Withdrawn => c"the last report is withdrawn: a fault was found late",
            Self::Idle => c"there is no closed segment to solve",
            Self::Collect => c"samples wait to be collected",
            Self::EnoughSamples => c"the calibration has enough samples",
            Self::Block => c"a block of samples waits to be sent",
            Self::Null => c"a pointer is NULL",
            Self::Misaligned => c"a pointer is not aligned",
            Self::MemoryTooSmall => c"the memory has fewer bytes than the state or object needs",
            Self::NotInitialised => c"no state or object was initialised at this address",
            Self::Busy => c"another function works on the same part of the state",
            Self::NoReport => c"there is no report",
            Self::WrongChannelCount => c"the number of values is not that of the channels",
            Self::OutOfRange => c"an index or a choice is out of range",
            Self::BufferTooSmall => c"the buffer is too small",
            Self::RecorderFull => c"the blocks before were not sent: the sample is not recorded",
            Self::Arithmetic => c"the chip computes otherwise than the host of the training",
            Self::NoSample => c"no samples come from the current loop",
            Self::NotCollected => c"samples wait, but are not collected",
            Self::NoSegment => c"samples come, but no segment closes or is taken",
            Self::NoVerdict => c"no segment has had a verdict for too long",
            Self::WrongRate => c"the samples do not come at the rate of the model",
            Self::NotAModel => c"these bytes are not a bearing-watch model",
            Self::ModelVersion => c"the model has another format version: update the library, or train it again",
            Self::ModelTruncated => c"the model is truncated",
            Self::ModelChecksum => c"the checksum does not match: the model is corrupted",
            Self::ModelValue => c"a value of the model is out of range",
            Self::ModelDoesNotFit => c"the model does not fit the arrays or the plan of this library",
            Self::ModelChannel => c"a channel of the model has another name or unit",
            Self::ModelInterval => c"the sampling interval differs from that of the model",
            Self::ModelPark => c"the model was trained with the other Park convention",
            Self::SavedState => c"these bytes are not a saved state, or are corrupted",
            Self::OtherModel => c"the saved state is that of another model",
            Self::FrontEndControlRate => c"the control rate is not within 100 Hz and 1 MHz",
            Self::FrontEndSensor => c"offset, gain or usable range of a current sensor is out of range",
            Self::FrontEndBalance => c"noise, tolerance or window of the sum of the currents is out of range",
            Self::FrontEndTracking => c"bandwidth, damping, limit or times of the tracking loop are out of range",
            Self::FrontEndResolver => c"the amplitudes of the resolver are out of range",
            Self::FrontEndPolePairs => c"a motor has at least one pole pair",
            Self::FrontEndFactor => c"there are no filters for this factor of decimation in this library",
            Self::FrontEndFurther => c"the library has no front end with this number of further channels",
            Self::CalibrationTooFew => c"too few samples for offsets of the current sensors",
            Self::CalibrationNoisy => c"a current sensor is too noisy for an offset",
            Self::CalibrationStuck => c"the converter of a current sensor is stuck",
            Self::CalibrationOutOfBand => c"the offset of a current sensor is out of its band",
            Self::SignatureMissing => c"there is no signature",
            Self::SignatureVersion => c"the signature has another format version or algorithm",
            Self::SignatureFormat => c"a field of the signature does not fit the bytes before it",
            Self::SignatureTruncated => c"the signature is cut short",
            Self::SignatureKey => c"the key of the signature is not accepted",
            Self::SignatureMismatch => c"the signature is not that of these bytes",
            Self::SignatureOlder => c"older than accepted",
            Self::FlashFailed => c"a function of the flash has failed",
            Self::FlashPlaces => c"the places in flash have no room for a record, or other multiples",
            Self::FlashTooSmall => c"the record is longer than its place in flash",
            Self::FlashNotWritten => c"the flash did not take what was written",
            Self::FlashNoRecord => c"there is no good record in flash",
            Self::CanFailed => c"the function that sends over CAN has failed",
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

impl From<FrontEndError> for BwCode {
    fn from(error: FrontEndError) -> Self {
        match error {
            FrontEndError::ControlRate => Self::FrontEndControlRate,
            FrontEndError::Sensor => Self::FrontEndSensor,
            FrontEndError::Balance => Self::FrontEndBalance,
            FrontEndError::Tracking => Self::FrontEndTracking,
            FrontEndError::Resolver => Self::FrontEndResolver,
            FrontEndError::PolePairs => Self::FrontEndPolePairs,
            // What a later version of the core adds.
            _ => Self::OutOfRange,
        }
    }
}

impl From<CalibrationError> for BwCode {
    fn from(error: CalibrationError) -> Self {
        match error {
            CalibrationError::TooFew { .. } => Self::CalibrationTooFew,
            CalibrationError::Noisy { .. } => Self::CalibrationNoisy,
            CalibrationError::Stuck { .. } => Self::CalibrationStuck,
            CalibrationError::OutOfBand { .. } => Self::CalibrationOutOfBand,
            // What a later version of the core adds.
            _ => Self::OutOfRange,
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
