//! The C interface of bearing-watch: a static library, and the header `include/bearing_watch.h`, which a test makes
//! from this source and compares.
//!
//! ```text
//! bw_verify_model   bytes of a signed model, public keys (feature `signature`) ─► whether bw_init may read them
//!
//! bw_init      memory of the caller, bytes of a model ─► state
//! interrupt    bw_collect   a sample; now and then BW_CODE_SEGMENT: a segment is closed
//! main loop    bw_advance, or bw_conclude   the closed segment ─► BW_CODE_REPORT
//!              bw_report, bw_values         verdict, and the numbers behind it
//!              bw_adopt                     its estimate becomes the next auxiliary model (interrupt masked)
//!              bw_alarm                     the evidence of all segments
//!              bw_contribution, bw_growth   what each direction has risen by, size of a defect and time left
//!              bw_clock                     whether samples, segments and verdicts come, at the right rate
//!              bw_save, bw_restore          the same as bytes, which survive power-off
//!              bw_seal, bw_open             these bytes under a key of the drive (feature `signature`)
//! or at once   bw_step                      a sample; now and then BW_CODE_REPORT
//!
//! bw_front_end_init    memory of the caller, constants ─► front end, for drives without Clarke, Park and decimation
//! control interrupt    bw_front_end_push   raw counts; now and then BW_CODE_CLEAN_SAMPLE, for bw_collect
//! commissioning        bw_calibration_…    offsets of the current sensors at standstill
//!                      bw_wiring_…         phase order, pole pairs, electrical offset, delay, directions
//!
//! interrupts           bw_recorder_push, bw_raw_recorder_push   samples; now and then BW_CODE_BLOCK
//! main loop            bw_telemetry_…      reports and blocks of samples as frames, for `bearing-watch listen`
//!                      bw_can_frame        the report in one frame of 8 bytes
//!                      bw_can_stream       a frame of the telemetry in data frames
//! ```
//!
//! No function allocates, blocks, panics or has global state; of `bw_verify_model` the linker does not prove the third.
//! Pointers that are NULL or not aligned, memory that is too
//! small or holds no state, and calls in another order are refused by a code. The results have the same bits as those
//! of the Rust core.
//!
//! The library serves every model whose sizes are at most `BW_MAX_…`. If `BEARING_WATCH_PLAN` names a file of
//! `bearing-watch train --rust` when the library is built, it serves the models of that plan only: it is several times
//! smaller and faster, since the compiler then knows every length. The functions are the same.
#![cfg_attr(target_os = "none", no_std)]
#![cfg_attr(
    test,
    allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing, clippy::float_cmp)
)]

mod about;
mod alarm;
mod angle;
mod below;
mod blocks;
mod calibration;
mod can;
mod clock;
mod code;
mod flash;
mod front_end;
mod growth;
mod memory;
mod names;
mod plan;
mod recorder;
mod report;
mod sampling;
mod saved;
#[cfg(feature = "signature")]
mod signature;
#[cfg(all(target_os = "none", bearing_watch_plan))]
mod sizes;
mod solving;
mod state;
mod telemetry;
mod waiting;
mod wiring;

pub use about::{
    BwInfo, BwPark, bw_check_channel, bw_check_interval, bw_check_park, bw_info, bw_known_answer_test, bw_label,
    bw_version,
};
pub use alarm::{BwAlarm, bw_alarm, bw_deny, bw_end_run, bw_limit_silence, bw_reset};
pub use angle::{bw_angle, bw_angle_from_cpr};
pub use below::{bw_collect_waiting, bw_put};
pub use calibration::{
    BW_CALIBRATION_SIZE, BwCalibration, BwCalibrationLimits, BwRefusedOffset, bw_calibration_finish,
    bw_calibration_init, bw_calibration_push,
};
pub use can::{BW_CAN_FRAME_SIZE, BwCanSend, bw_can_frame, bw_can_stream};
pub use clock::{bw_clock, bw_limit_liveness};
pub use code::{BwCode, bw_error_text};
pub use flash::{
    BW_FLASH_UNIT, BwFlash, bw_flash_load_model, bw_flash_prepare, bw_flash_restore, bw_flash_save,
    bw_flash_store_model,
};
pub use front_end::constants::{BwFrontEndConstants, BwPhaseSensor, bw_check_front_end, bw_tell_alignment};
pub use front_end::faults::{
    BwAlignment, BwFrontEndFaults, BwImbalance, BwLock, bw_front_end_clear_faults, bw_front_end_faults,
};
pub use front_end::sample::{BwCleanSample, BwPosition, BwRawSample};
pub use front_end::{
    BW_FRONT_END_SIZE, BwFrontEnd, bw_front_end_check_wiring, bw_front_end_init, bw_front_end_push, bw_front_end_size,
};
pub use growth::{BwContribution, BwGrowth, BwInterval, bw_contribution, bw_growth, bw_growth_to};
pub use memory::BW_STATE_ALIGN;
pub use names::{bw_code_name, bw_reason_name, bw_verdict_name};
pub use plan::{
    AnyModel, BW_MAX_AVERAGED, BW_MAX_CHANNELS, BW_MAX_CLASSES, BW_MAX_COLUMNS, BW_MAX_COORDINATES, BW_MAX_COVARIATES,
    BW_MAX_DELAYS, BW_MAX_DENSITIES, BW_MAX_FEATURES, BW_MAX_FILTERS, BW_MAX_FURTHER, BW_MAX_ORDERS, BW_MAX_PARAMETERS,
    BW_MAX_PROJECTION, BW_MAX_RISING,
};
pub use recorder::{
    BW_BLOCK_BYTES, BW_RAW_RECORDER_SIZE, BW_RECORDER_SIZE, BwRawRecorder, BwRecorder, bw_raw_recorder_init,
    bw_raw_recorder_push, bw_recorder_init, bw_recorder_push, bw_recorder_skip,
};
pub use report::{BwPart, BwReason, BwReport, BwValues, BwVerdict, bw_report, bw_values};
pub use sampling::{bw_collect, bw_discard, bw_pending, bw_restart, bw_step};
pub use saved::{bw_restore, bw_save, bw_saved_size};
#[cfg(feature = "signature")]
pub use signature::{
    BW_KEY_SIZE, BW_SEAL_SIZE, BW_STATE_KEY_SIZE, BwSealed, BwSigned, bw_open, bw_seal, bw_verify_model,
};
pub use solving::{bw_adopt, bw_advance, bw_conclude};
pub use state::{BW_STATE_SIZE, BwState, bw_init, bw_init_own, bw_state_size};
pub use telemetry::{
    BW_FRAME_SIZE, BW_TELEMETRY_SIZE, BwTelemetry, bw_telemetry_hello, bw_telemetry_init, bw_telemetry_raw,
    bw_telemetry_report, bw_telemetry_samples,
};
pub use wiring::{
    BW_WIRING_SIZE, BwWiring, BwWiringCheck, BwWiringFault, BwWiringLimits, bw_wiring_conclude, bw_wiring_init,
    bw_wiring_text,
};

/// The core never panics: this is for the linker.
#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
