//! What every function returns.

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
