//! Words for verdicts and reasons, and the names of codes, for logs and displays.

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

const CODES: Names<60> = names! {
    BwCode::Ok => "BW_CODE_OK",
    BwCode::Segment => "BW_CODE_SEGMENT",
    BwCode::Report => "BW_CODE_REPORT",
    BwCode::Withdrawn => "BW_CODE_WITHDRAWN",
    BwCode::Idle => "BW_CODE_IDLE",
    BwCode::Collect => "BW_CODE_COLLECT",
    BwCode::EnoughSamples => "BW_CODE_ENOUGH_SAMPLES",
    BwCode::Block => "BW_CODE_BLOCK",
    BwCode::Null => "BW_CODE_NULL",
    BwCode::Misaligned => "BW_CODE_MISALIGNED",
    BwCode::MemoryTooSmall => "BW_CODE_MEMORY_TOO_SMALL",
    BwCode::NotInitialised => "BW_CODE_NOT_INITIALISED",
    BwCode::Busy => "BW_CODE_BUSY",
    BwCode::NoReport => "BW_CODE_NO_REPORT",
    BwCode::WrongChannelCount => "BW_CODE_WRONG_CHANNEL_COUNT",
    BwCode::OutOfRange => "BW_CODE_OUT_OF_RANGE",
    BwCode::BufferTooSmall => "BW_CODE_BUFFER_TOO_SMALL",
    BwCode::RecorderFull => "BW_CODE_RECORDER_FULL",
    BwCode::Arithmetic => "BW_CODE_ARITHMETIC",
    BwCode::NoSample => "BW_CODE_NO_SAMPLE",
    BwCode::NotCollected => "BW_CODE_NOT_COLLECTED",
    BwCode::NoSegment => "BW_CODE_NO_SEGMENT",
    BwCode::NoVerdict => "BW_CODE_NO_VERDICT",
    BwCode::WrongRate => "BW_CODE_WRONG_RATE",
    BwCode::NotAModel => "BW_CODE_NOT_A_MODEL",
    BwCode::ModelVersion => "BW_CODE_MODEL_VERSION",
    BwCode::ModelTruncated => "BW_CODE_MODEL_TRUNCATED",
    BwCode::ModelChecksum => "BW_CODE_MODEL_CHECKSUM",
    BwCode::ModelValue => "BW_CODE_MODEL_VALUE",
    BwCode::ModelDoesNotFit => "BW_CODE_MODEL_DOES_NOT_FIT",
    BwCode::ModelChannel => "BW_CODE_MODEL_CHANNEL",
    BwCode::ModelInterval => "BW_CODE_MODEL_INTERVAL",
    BwCode::ModelPark => "BW_CODE_MODEL_PARK",
    BwCode::SavedState => "BW_CODE_SAVED_STATE",
    BwCode::OtherModel => "BW_CODE_OTHER_MODEL",
    BwCode::FrontEndControlRate => "BW_CODE_FRONT_END_CONTROL_RATE",
    BwCode::FrontEndSensor => "BW_CODE_FRONT_END_SENSOR",
    BwCode::FrontEndBalance => "BW_CODE_FRONT_END_BALANCE",
    BwCode::FrontEndTracking => "BW_CODE_FRONT_END_TRACKING",
    BwCode::FrontEndResolver => "BW_CODE_FRONT_END_RESOLVER",
    BwCode::FrontEndPolePairs => "BW_CODE_FRONT_END_POLE_PAIRS",
    BwCode::FrontEndFactor => "BW_CODE_FRONT_END_FACTOR",
    BwCode::FrontEndFurther => "BW_CODE_FRONT_END_FURTHER",
    BwCode::CalibrationTooFew => "BW_CODE_CALIBRATION_TOO_FEW",
    BwCode::CalibrationNoisy => "BW_CODE_CALIBRATION_NOISY",
    BwCode::CalibrationStuck => "BW_CODE_CALIBRATION_STUCK",
    BwCode::CalibrationOutOfBand => "BW_CODE_CALIBRATION_OUT_OF_BAND",
    BwCode::SignatureMissing => "BW_CODE_SIGNATURE_MISSING",
    BwCode::SignatureVersion => "BW_CODE_SIGNATURE_VERSION",
    BwCode::SignatureFormat => "BW_CODE_SIGNATURE_FORMAT",
    BwCode::SignatureTruncated => "BW_CODE_SIGNATURE_TRUNCATED",
    BwCode::SignatureKey => "BW_CODE_SIGNATURE_KEY",
    BwCode::SignatureMismatch => "BW_CODE_SIGNATURE_MISMATCH",
    BwCode::SignatureOlder => "BW_CODE_SIGNATURE_OLDER",
    BwCode::FlashFailed => "BW_CODE_FLASH_FAILED",
    BwCode::FlashPlaces => "BW_CODE_FLASH_PLACES",
    BwCode::FlashTooSmall => "BW_CODE_FLASH_TOO_SMALL",
    BwCode::FlashNotWritten => "BW_CODE_FLASH_NOT_WRITTEN",
    BwCode::FlashNoRecord => "BW_CODE_FLASH_NO_RECORD",
    BwCode::CanFailed => "BW_CODE_CAN_FAILED",
};

fn name<const N: usize>((numbers, names): &Names<N>, number: i32) -> *const c_char {
    let mut all = numbers.iter().zip(names.split_inclusive(|byte| *byte == 0));
    all.find(|(known, _)| **known == number).map_or(c"unknown".as_ptr(), |(_, name)| name.as_ptr().cast())
}

/// Returns the word for a verdict of `BwVerdict`, such as "novel"; for a class `bw_label` gives its name. "unknown" for
/// other numbers. Never NULL, ends in a zero byte.
#[unsafe(no_mangle)]
pub extern "C" fn bw_verdict_name(verdict: i32) -> *const c_char {
    name(&VERDICTS, verdict)
}

/// Returns a text for a reason of `BwReason`; `place`, `part` and `reason_rows` of the report say which one and how
/// many. "unknown" for other numbers. Never NULL, ends in a zero byte.
#[unsafe(no_mangle)]
pub extern "C" fn bw_reason_name(reason: i32) -> *const c_char {
    name(&REASONS, reason)
}

/// Returns the name of a code in this header, such as `BW_CODE_OK`; `bw_error_text` gives its text. "unknown" for other
/// numbers. Never NULL, ends in a zero byte.
#[unsafe(no_mangle)]
pub extern "C" fn bw_code_name(code: i32) -> *const c_char {
    name(&CODES, code)
}
