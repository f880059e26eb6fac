//! Words for verdicts, reasons and codes, and the names of codes, for logs and displays.

use core::ffi::c_char;

use crate::code::BwCode;
use crate::report::{BwReason, BwVerdict};

/// Numbers, and their names, each with a zero byte behind it. One array of bytes, not a text each: the linker joins the
/// texts of a program, and could not leave out those of a function that is not called.
type Names<const N: usize> = ([i32; N], &'static [u8]);

macro_rules! names {
    ($($number:path => $name:literal,)*) => {
        ([$($number as i32),*], concat!($($name, "\0"),*).as_bytes())
    };
}

const VERDICTS: Names<4> = names! {
    BwVerdict::Class => "class",
    BwVerdict::Novel => "novel",
    BwVerdict::Ambiguous => "ambiguous",
    BwVerdict::Undetermined => "undetermined",
};

const REASONS: Names<17> = names! {
    BwReason::None => "none",
    BwReason::TooFewRows => "too few usable rows",
    BwReason::ShortSegment => "less than half of the segment was usable",
    BwReason::AtRest => "the shaft or the inputs are at rest",
    BwReason::ParameterNotExcited => "the data do not excite a parameter",
    BwReason::TermNotExcited => "the motion does not excite a term of the torque balance",
    BwReason::WeakInstruments => "the instruments hardly follow the output",
    BwReason::Stuck => "a sensor is stuck",
    BwReason::LostSamples => "more samples of a channel were refused than used",
    BwReason::OutOfRange => "a covariate is outside the range of the training records",
    BwReason::NotFinite => "a result is not a finite number",
    BwReason::Other => "a reason that this interface does not know",
    BwReason::Implausible => "the signals contradict the model or each other",
    BwReason::Arithmetic => "the processor does not compute as the host does",
    BwReason::OtherModel => "the segment is that of another model",
    BwReason::FoundLate => "a fault that was found after the segment may have begun in it",
    BwReason::Unseen => "the segment would not have shown an acceptable defect",
};

/// Of each code its name, and its text.
macro_rules! codes {
    ($($code:ident: $name:literal, $text:literal;)*) => {
        const CODES: Names<CODE_COUNT> = names! { $(BwCode::$code => $name,)* };
        const TEXTS: Names<CODE_COUNT> = names! { $(BwCode::$code => $text,)* };
    };
}

const CODE_COUNT: usize = 60;

codes! {
    Ok: "BW_CODE_OK", "done";
    Segment: "BW_CODE_SEGMENT", "a segment is closed";
    Report: "BW_CODE_REPORT", "there is a new report";
    Withdrawn: "BW_CODE_WITHDRAWN", "the last report is withdrawn: a fault was found late";
    Idle: "BW_CODE_IDLE", "there is no closed segment to solve";
    Collect: "BW_CODE_COLLECT", "samples wait to be collected";
    EnoughSamples: "BW_CODE_ENOUGH_SAMPLES", "the calibration has enough samples";
    Block: "BW_CODE_BLOCK", "a block of samples waits to be sent";
    Null: "BW_CODE_NULL", "a pointer is NULL";
    Misaligned: "BW_CODE_MISALIGNED", "a pointer is not aligned";
    MemoryTooSmall: "BW_CODE_MEMORY_TOO_SMALL", "the memory has fewer bytes than the state or object needs";
    NotInitialised: "BW_CODE_NOT_INITIALISED", "no state or object was initialised at this address";
    Busy: "BW_CODE_BUSY", "another function works on the same part of the state";
    NoReport: "BW_CODE_NO_REPORT", "there is no report";
    WrongChannelCount: "BW_CODE_WRONG_CHANNEL_COUNT", "the number of values is not that of the channels";
    OutOfRange: "BW_CODE_OUT_OF_RANGE", "an index or a choice is out of range";
    BufferTooSmall: "BW_CODE_BUFFER_TOO_SMALL", "the buffer is too small";
    RecorderFull: "BW_CODE_RECORDER_FULL", "the blocks before were not sent: the sample is not recorded";
    Arithmetic: "BW_CODE_ARITHMETIC", "the chip computes otherwise than the host of the training";
    NoSample: "BW_CODE_NO_SAMPLE", "no samples come from the current loop";
    NotCollected: "BW_CODE_NOT_COLLECTED", "samples wait, but are not collected";
    NoSegment: "BW_CODE_NO_SEGMENT", "samples come, but no segment closes or is taken";
    NoVerdict: "BW_CODE_NO_VERDICT", "no segment has had a verdict for too long";
    WrongRate: "BW_CODE_WRONG_RATE", "the samples do not come at the rate of the model";
    NotAModel: "BW_CODE_NOT_A_MODEL", "these bytes are not a bearing-watch model";
    ModelVersion: "BW_CODE_MODEL_VERSION", "the model has another format version; train it again";
    ModelTruncated: "BW_CODE_MODEL_TRUNCATED", "the model is truncated";
    ModelChecksum: "BW_CODE_MODEL_CHECKSUM", "the checksum does not match: the model is corrupted";
    ModelValue: "BW_CODE_MODEL_VALUE", "a value of the model is out of range";
    ModelDoesNotFit: "BW_CODE_MODEL_DOES_NOT_FIT", "the model does not fit the arrays or the plan of this library";
    ModelChannel: "BW_CODE_MODEL_CHANNEL", "a channel of the model has another name or unit";
    ModelInterval: "BW_CODE_MODEL_INTERVAL", "the sampling interval differs from that of the model";
    ModelPark: "BW_CODE_MODEL_PARK", "the model was trained with the other Park convention";
    SavedState: "BW_CODE_SAVED_STATE", "these bytes are not a saved state, or are corrupted";
    OtherModel: "BW_CODE_OTHER_MODEL", "the saved state is that of another model";
    FrontEndControlRate: "BW_CODE_FRONT_END_CONTROL_RATE", "the control rate is not within 100 Hz and 1 MHz";
    FrontEndSensor: "BW_CODE_FRONT_END_SENSOR", "offset, gain or usable range of a current sensor is out of range";
    FrontEndBalance: "BW_CODE_FRONT_END_BALANCE",
        "noise, tolerance or window of the sum of the currents is out of range";
    FrontEndTracking: "BW_CODE_FRONT_END_TRACKING",
        "bandwidth, damping, limit or times of the tracking loop are out of range";
    FrontEndResolver: "BW_CODE_FRONT_END_RESOLVER", "the amplitudes of the resolver are out of range";
    FrontEndPolePairs: "BW_CODE_FRONT_END_POLE_PAIRS", "a motor has at least one pole pair";
    FrontEndFactor: "BW_CODE_FRONT_END_FACTOR", "there are no filters for this factor of decimation in this library";
    FrontEndFurther: "BW_CODE_FRONT_END_FURTHER", "the library has no front end with this number of further channels";
    CalibrationTooFew: "BW_CODE_CALIBRATION_TOO_FEW", "too few samples for offsets of the current sensors";
    CalibrationNoisy: "BW_CODE_CALIBRATION_NOISY", "a current sensor is too noisy for an offset";
    CalibrationStuck: "BW_CODE_CALIBRATION_STUCK", "the converter of a current sensor is stuck";
    CalibrationOutOfBand: "BW_CODE_CALIBRATION_OUT_OF_BAND", "the offset of a current sensor is out of its band";
    SignatureMissing: "BW_CODE_SIGNATURE_MISSING", "there is no signature";
    SignatureVersion: "BW_CODE_SIGNATURE_VERSION", "the signature has another format version or algorithm";
    SignatureFormat: "BW_CODE_SIGNATURE_FORMAT", "a field of the signature does not fit the bytes before it";
    SignatureTruncated: "BW_CODE_SIGNATURE_TRUNCATED", "the signature is cut short";
    SignatureKey: "BW_CODE_SIGNATURE_KEY", "the key of the signature is not accepted";
    SignatureMismatch: "BW_CODE_SIGNATURE_MISMATCH", "the signature is not that of these bytes";
    SignatureOlder: "BW_CODE_SIGNATURE_OLDER", "older than accepted";
    FlashFailed: "BW_CODE_FLASH_FAILED", "a function of the flash has failed";
    FlashPlaces: "BW_CODE_FLASH_PLACES", "the places in flash have no room for a record, or other multiples";
    FlashTooSmall: "BW_CODE_FLASH_TOO_SMALL", "the record is longer than its place in flash";
    FlashNotWritten: "BW_CODE_FLASH_NOT_WRITTEN", "the flash did not take what was written";
    FlashNoRecord: "BW_CODE_FLASH_NO_RECORD", "there is no good record in flash";
    CanFailed: "BW_CODE_CAN_FAILED", "the function that sends over CAN has failed";
}

fn name<const N: usize>((numbers, names): &Names<N>, number: i32) -> Option<*const c_char> {
    let mut all = numbers.iter().zip(names.split_inclusive(|byte| *byte == 0));
    all.find(|(known, _)| **known == number).map(|(_, name)| name.as_ptr().cast())
}

/// Returns the word for a verdict of `BwVerdict`, such as "novel"; for a class `bw_label` gives its name. "unknown" for
/// other numbers. Never NULL, ends in a zero byte.
#[unsafe(no_mangle)]
pub extern "C" fn bw_verdict_name(verdict: i32) -> *const c_char {
    name(&VERDICTS, verdict).unwrap_or(c"unknown".as_ptr())
}

/// Returns a text for a reason of `BwReason`; `place`, `part` and `reason_rows` of the report say which one and how
/// many. "unknown" for other numbers. Never NULL, ends in a zero byte.
#[unsafe(no_mangle)]
pub extern "C" fn bw_reason_name(reason: i32) -> *const c_char {
    name(&REASONS, reason).unwrap_or(c"unknown".as_ptr())
}

/// Returns the name of a code in this header, such as `BW_CODE_OK`; `bw_error_text` gives its text. "unknown" for other
/// numbers. Never NULL, ends in a zero byte.
#[unsafe(no_mangle)]
pub extern "C" fn bw_code_name(code: i32) -> *const c_char {
    name(&CODES, code).unwrap_or(c"unknown".as_ptr())
}

/// Returns a text for a code, ending in a zero byte; "unknown code" for other numbers. Never NULL.
#[unsafe(no_mangle)]
pub extern "C" fn bw_error_text(code: i32) -> *const c_char {
    name(&TEXTS, code).unwrap_or(c"unknown code".as_ptr())
}
