//! The C interface of bearing-watch: a static library, and the headers in `include`, which a test makes
//! from this source and compares: `bearing_watch.h` is what a drive includes, `bearing_watch_service.h` has the rest.
//!
//! ```text
//! bw_verify_model   bytes of a signed model, public keys (feature `signature`) ─► whether bw_start may read them
//!
//! boot              bw_front_end_init   memory of the caller, constants ─► front end, for a drive with raw counts
//!                   bw_start            memory of the caller, bytes of a model, front end or none ─► state
//! current loop      bw_sample_raw       raw counts; or bw_sample: signals of the drive's own
//! interrupt below   bw_collect          samples ─► detector; now and then BW_CODE_SEGMENT
//! main loop         bw_advance          a segment ─► BW_CODE_REPORT with report and alarm, BW_CODE_WITHDRAWN
//!                   bw_clock            whether samples, segments and verdicts come, at the right rate
//!                   bw_values, bw_contribution, bw_growth   the numbers behind report and alarm
//!                   bw_end_run, bw_restore                  alarm and scores as bytes, which survive power-off
//!                   bw_seal, bw_open    these bytes under a key of the drive (feature `signature`)
//!                   bw_stop             another model can start without a reboot
//!
//! commissioning     bw_calibration_…    offsets of the current sensors at standstill
//!                   bw_wiring_…         phase order, pole pairs, electrical offset, delay, directions
//!
//! interrupts        bw_collect_recorded, bw_recorder_push, bw_raw_recorder_push   samples; now and then BW_CODE_BLOCK
//! main loop         bw_telemetry_…      reports and blocks of samples as frames, for `bearing-watch listen`
//!                   bw_can_frame        the report in one frame of 8 bytes
//!                   bw_can_stream       a frame of the telemetry in data frames
//! ```
//!
//! The functions are thin: queue, segments, withdrawals, liveness, alarm and saved state are those of the core's
//! `watch::Watch`, which the state contains.
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

// What tests share knows the crate by its name.
#[cfg(test)]
extern crate self as bearing_watch_c;

mod about;
mod alarm;
mod angle;
mod blocks;
mod calibration;
mod can;
mod code;
mod flash;
mod front_end;
mod growth;
mod main_loop;
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
mod state;
mod telemetry;
mod values;
mod wiring;

pub use about::{
    BwInfo, bw_check_channel, bw_check_interval, bw_check_park, bw_info, bw_known_answer_test, bw_label, bw_version,
};
pub use alarm::{BwAlarm, bw_alarm, bw_deny, bw_limit_silence, bw_reset};
pub use angle::{BwTurnCounter, bw_angle, bw_angle_from_cpr, bw_within_turn};
pub use calibration::{
    BW_CALIBRATION_SIZE, BwCalibration, BwCalibrationLimits, BwRefusedOffset, bw_calibration_finish,
    bw_calibration_init, bw_calibration_push,
};
pub use can::{BW_CAN_FRAME_SIZE, BwCanSend, bw_can_frame, bw_can_stream};
pub use code::BwCode;
pub use flash::{
    BW_FLASH_UNIT, BwFlash, bw_flash_load_model, bw_flash_prepare, bw_flash_restore, bw_flash_save,
    bw_flash_store_model,
};
pub use front_end::constants::{BwFrontEndConstants, BwPark, BwPhaseSensor};
pub use front_end::faults::{BwAlignment, BwFrontEndFaults, BwImbalance, BwLock};
pub use front_end::sample::{BwPosition, BwRawSample};
pub use front_end::{BW_FRONT_END_SIZE, BwFrontEnd, bw_front_end_init, bw_front_end_size};
pub use growth::{BwContribution, BwGrowth, BwInterval, bw_contribution, bw_growth, bw_growth_to};
pub use main_loop::{BwStatus, bw_advance, bw_clear_faults, bw_clock, bw_faults, bw_limit_liveness, bw_status};
pub use memory::BW_STATE_ALIGN;
pub use names::{bw_code_name, bw_error_text, bw_reason_name, bw_verdict_name};
pub use plan::{
    AnyModel, BW_MAX_AVERAGED, BW_MAX_CHANNELS, BW_MAX_CLASSES, BW_MAX_COLUMNS, BW_MAX_COORDINATES, BW_MAX_COVARIATES,
    BW_MAX_DELAYS, BW_MAX_DENSITIES, BW_MAX_FEATURES, BW_MAX_FILTERS, BW_MAX_FURTHER, BW_MAX_ORDERS, BW_MAX_PARAMETERS,
    BW_MAX_PROJECTION, BW_MAX_RISING,
};
pub use recorder::{
    BW_BLOCK_BYTES, BW_RAW_RECORDER_SIZE, BW_RECORDER_SIZE, BwRawRecorder, BwRecorder, bw_collect_recorded,
    bw_raw_recorder_init, bw_raw_recorder_push, bw_recorder_init, bw_recorder_push, bw_recorder_skip,
};
pub use report::{BwPart, BwReason, BwReport, BwVerdict, bw_report};
pub use sampling::{bw_collect, bw_restart, bw_sample, bw_sample_raw};
pub use saved::{bw_end_run, bw_restore, bw_save, bw_saved_size};
#[cfg(feature = "signature")]
pub use signature::{
    BW_KEY_SIZE, BW_SEAL_SIZE, BW_STATE_KEY_SIZE, BwSealed, BwSigned, bw_open, bw_seal, bw_verify_model,
};
pub use state::{BW_STATE_SIZE, BwState, bw_start, bw_start_own, bw_state_size, bw_stop};
pub use telemetry::{
    BW_FRAME_SIZE, BW_TELEMETRY_SIZE, BwTelemetry, bw_telemetry_hello, bw_telemetry_init, bw_telemetry_raw,
    bw_telemetry_report, bw_telemetry_samples,
};
pub use values::{BwValues, bw_values};
pub use wiring::{
    BW_WIRING_SIZE, BwWiring, BwWiringCheck, BwWiringFault, BwWiringLimits, bw_check_wiring, bw_wiring_conclude,
    bw_wiring_init, bw_wiring_text,
};

/// The core never panics: this is for the linker.
#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
