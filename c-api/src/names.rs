//! Words for verdicts and reasons, and the names of codes, for logs and displays.

use core::ffi::{CStr, c_char};

use crate::code::BwCode;
use crate::report::{BwReason, BwVerdict};

/// Numbers with their names.
type Names<const N: usize> = [(i32, &'static CStr); N];

const VERDICTS: Names<4> = [
    (BwVerdict::Class as i32, c"class"),
    (BwVerdict::Novel as i32, c"novel"),
    (BwVerdict::Ambiguous as i32, c"ambiguous"),
    (BwVerdict::Undetermined as i32, c"undetermined"),
];

const REASONS: Names<16> = [
    (BwReason::None as i32, c"none"),
    (BwReason::TooFewRows as i32, c"too few usable rows"),
    (BwReason::ShortSegment as i32, c"less than half of the segment was usable"),
    (BwReason::AtRest as i32, c"the inputs are at rest"),
    (BwReason::ParameterNotExcited as i32, c"the data do not excite a parameter"),
    (BwReason::TermNotExcited as i32, c"the motion does not excite a term of the torque balance"),
    (BwReason::WeakInstruments as i32, c"the instruments hardly follow the output"),
    (BwReason::Stuck as i32, c"a sensor is stuck"),
    (BwReason::LostSamples as i32, c"more samples of a channel were refused than used"),
    (BwReason::OutOfRange as i32, c"a covariate is outside the range of the training records"),
    (BwReason::NotFinite as i32, c"a result is not a finite number"),
    (BwReason::Other as i32, c"a reason that this interface does not know"),
    (BwReason::Implausible as i32, c"the signals contradict the model or each other"),
    (BwReason::Arithmetic as i32, c"the processor does not compute as the host does"),
    (BwReason::OtherModel as i32, c"the segment is that of another model"),
    (BwReason::FoundLate as i32, c"a fault that was found after the segment may have begun in it"),
];

const CODES: Names<49> = [
    (BwCode::Ok as i32, c"BW_CODE_OK"),
    (BwCode::Segment as i32, c"BW_CODE_SEGMENT"),
    (BwCode::Report as i32, c"BW_CODE_REPORT"),
    (BwCode::NotAdopted as i32, c"BW_CODE_NOT_ADOPTED"),
    (BwCode::Idle as i32, c"BW_CODE_IDLE"),
    (BwCode::CleanSample as i32, c"BW_CODE_CLEAN_SAMPLE"),
    (BwCode::EnoughSamples as i32, c"BW_CODE_ENOUGH_SAMPLES"),
    (BwCode::Block as i32, c"BW_CODE_BLOCK"),
    (BwCode::Null as i32, c"BW_CODE_NULL"),
    (BwCode::Misaligned as i32, c"BW_CODE_MISALIGNED"),
    (BwCode::MemoryTooSmall as i32, c"BW_CODE_MEMORY_TOO_SMALL"),
    (BwCode::NotInitialised as i32, c"BW_CODE_NOT_INITIALISED"),
    (BwCode::Busy as i32, c"BW_CODE_BUSY"),
    (BwCode::SegmentLost as i32, c"BW_CODE_SEGMENT_LOST"),
    (BwCode::NoReport as i32, c"BW_CODE_NO_REPORT"),
    (BwCode::WrongChannelCount as i32, c"BW_CODE_WRONG_CHANNEL_COUNT"),
    (BwCode::OutOfRange as i32, c"BW_CODE_OUT_OF_RANGE"),
    (BwCode::BufferTooSmall as i32, c"BW_CODE_BUFFER_TOO_SMALL"),
    (BwCode::RecorderFull as i32, c"BW_CODE_RECORDER_FULL"),
    (BwCode::NotAModel as i32, c"BW_CODE_NOT_A_MODEL"),
    (BwCode::ModelVersion as i32, c"BW_CODE_MODEL_VERSION"),
    (BwCode::ModelTruncated as i32, c"BW_CODE_MODEL_TRUNCATED"),
    (BwCode::ModelChecksum as i32, c"BW_CODE_MODEL_CHECKSUM"),
    (BwCode::ModelValue as i32, c"BW_CODE_MODEL_VALUE"),
    (BwCode::ModelDoesNotFit as i32, c"BW_CODE_MODEL_DOES_NOT_FIT"),
    (BwCode::ModelChannel as i32, c"BW_CODE_MODEL_CHANNEL"),
    (BwCode::ModelInterval as i32, c"BW_CODE_MODEL_INTERVAL"),
    (BwCode::ModelPark as i32, c"BW_CODE_MODEL_PARK"),
    (BwCode::SavedState as i32, c"BW_CODE_SAVED_STATE"),
    (BwCode::OtherModel as i32, c"BW_CODE_OTHER_MODEL"),
    (BwCode::FrontEndControlRate as i32, c"BW_CODE_FRONT_END_CONTROL_RATE"),
    (BwCode::FrontEndSensor as i32, c"BW_CODE_FRONT_END_SENSOR"),
    (BwCode::FrontEndBalance as i32, c"BW_CODE_FRONT_END_BALANCE"),
    (BwCode::FrontEndTracking as i32, c"BW_CODE_FRONT_END_TRACKING"),
    (BwCode::FrontEndResolver as i32, c"BW_CODE_FRONT_END_RESOLVER"),
    (BwCode::FrontEndPolePairs as i32, c"BW_CODE_FRONT_END_POLE_PAIRS"),
    (BwCode::FrontEndFactor as i32, c"BW_CODE_FRONT_END_FACTOR"),
    (BwCode::FrontEndFurther as i32, c"BW_CODE_FRONT_END_FURTHER"),
    (BwCode::CalibrationTooFew as i32, c"BW_CODE_CALIBRATION_TOO_FEW"),
    (BwCode::CalibrationNoisy as i32, c"BW_CODE_CALIBRATION_NOISY"),
    (BwCode::CalibrationStuck as i32, c"BW_CODE_CALIBRATION_STUCK"),
    (BwCode::CalibrationOutOfBand as i32, c"BW_CODE_CALIBRATION_OUT_OF_BAND"),
    (BwCode::SignatureMissing as i32, c"BW_CODE_SIGNATURE_MISSING"),
    (BwCode::SignatureVersion as i32, c"BW_CODE_SIGNATURE_VERSION"),
    (BwCode::SignatureFormat as i32, c"BW_CODE_SIGNATURE_FORMAT"),
    (BwCode::SignatureTruncated as i32, c"BW_CODE_SIGNATURE_TRUNCATED"),
    (BwCode::SignatureKey as i32, c"BW_CODE_SIGNATURE_KEY"),
    (BwCode::SignatureMismatch as i32, c"BW_CODE_SIGNATURE_MISMATCH"),
    (BwCode::SignatureOlder as i32, c"BW_CODE_SIGNATURE_OLDER"),
];

fn name<const N: usize>(names: &Names<N>, number: i32) -> *const c_char {
    names.iter().find(|(known, _)| *known == number).map_or(c"unknown", |(_, name)| name).as_ptr()
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

/// Returns the name of a code in this header, such as "BW_CODE_OK"; `bw_error_text` gives its text. "unknown" for other
/// numbers. Never NULL, ends in a zero byte.
#[unsafe(no_mangle)]
pub extern "C" fn bw_code_name(code: i32) -> *const c_char {
    name(&CODES, code)
}
