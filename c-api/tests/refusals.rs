//! Wrong pointers, wrong memory, wrong models and calls out of order are refused by their codes, and change nothing.
#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::expect_used,
    clippy::float_cmp,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::unwrap_used,
    reason = "a test fails by a panic"
)]

#[allow(dead_code, reason = "other tests use the rest")]
#[path = "support/drive.rs"]
mod drive;
#[allow(dead_code, reason = "other tests use the rest")]
mod support;

use core::ffi::{CStr, c_char};
use core::mem::MaybeUninit;
use core::ptr::{null, null_mut};

use bearing_watch_c::*;

use drive::{raw, raw_for_c};
use support::{FILE, Memory};

const SAMPLE: [f32; 3] = [0.5, 20.0, 0.1];
/// Samples of a segment of the standard rig's model.
const SEGMENT: usize = 5000;

/// Calls a function that takes a state, on memory of the test.
macro_rules! call {
    ($($call:tt)*) => {
        // SAFETY: every pointer is NULL, misaligned, or that of memory that the test owns.
        unsafe { $($call)* }
    };
}

fn text(text: *const c_char) -> &'static str {
    // SAFETY: the library gives texts that end in a zero byte and live as long as the program.
    unsafe { CStr::from_ptr(text) }.to_str().expect("text")
}

/// Takes samples that move; returns the last code.
fn collect(state: *mut BwState, samples: usize) -> BwCode {
    let sample = |k: usize| [0.3 * (k % 7) as f32, 10.0 * (k % 5) as f32, 0.1 * (k % 3) as f32];
    (0..samples).fold(None, |_, k| Some(support::collect(state, &sample(k), 0))).expect("a sample")
}

/// Samples that the detector took, and the samples and segments that were lost.
fn status(state: *mut BwState) -> (u32, u32, u32) {
    let mut status = MaybeUninit::<BwStatus>::uninit();
    assert_eq!(call!(bw_status(state, status.as_mut_ptr())), BwCode::Ok);
    let BwStatus { samples, lost_samples, lost_segments, failed: 0, alignment: BwAlignment::Unknown } =
        call!(status.assume_init())
    else {
        panic!("a fault")
    };
    (samples, lost_samples, lost_segments)
}

/// What every function says to this state.
fn all(state: *mut BwState) -> Vec<BwCode> {
    let (mut values, mut count, raw) = ([0.0; 32], 0, raw_for_c(&raw(0)));
    let (mut report, mut alarm, mut info) = (MaybeUninit::uninit(), MaybeUninit::uninit(), MaybeUninit::uninit());
    let (mut status, mut faults) = (MaybeUninit::uninit(), MaybeUninit::uninit());
    let (mut name, mut bytes) = ([0; 17], [0; 256]);
    call!(vec![
        bw_sample(state, SAMPLE.as_ptr(), 3, 0),
        bw_sample_raw(state, &raw, null(), 0),
        bw_check_wiring(state, &raw, 0.0, null_mut()),
        bw_collect(state),
        bw_collect_recorded(state, null_mut()),
        bw_restart(state),
        bw_advance(state, report.as_mut_ptr(), alarm.as_mut_ptr()),
        bw_clock(state, 0),
        bw_limit_liveness(state, 1.0, 2.0, 3.0),
        bw_limit_silence(state, 1, 2.0),
        bw_status(state, status.as_mut_ptr()),
        bw_faults(state, faults.as_mut_ptr()),
        bw_clear_faults(state),
        bw_report(state, report.as_mut_ptr()),
        bw_values(state, 0, values.as_mut_ptr(), values.len(), &raw mut count),
        bw_alarm(state, alarm.as_mut_ptr()),
        bw_end_run(state, bytes.as_mut_ptr(), bytes.len(), &raw mut count),
        bw_deny(state),
        bw_saved_size(state, &raw mut count),
        bw_save(state, bytes.as_mut_ptr(), bytes.len()),
        bw_restore(state, bytes.as_ptr(), bytes.len()),
        bw_reset(state),
        bw_info(state, info.as_mut_ptr()),
        bw_label(state, 0, name.as_mut_ptr(), name.len()),
        bw_check_channel(state, 0, c"current_a".as_ptr(), c"A".as_ptr()),
        bw_check_interval(state, 0.002),
        bw_check_park(state, 1),
        bw_stop(state),
    ])
}

#[test]
fn every_function_refuses_what_is_no_state() {
    let mut memory = Memory::new();
    assert!(all(null_mut()).iter().all(|code| *code == BwCode::Null));
    assert!(all(memory.address().wrapping_byte_add(1).cast()).iter().all(|code| *code == BwCode::Misaligned));
    assert!(all(memory.address().cast()).iter().all(|code| *code == BwCode::NotInitialised));
}

#[test]
fn a_copied_state_is_refused() {
    let (mut memory, mut other) = (Memory::new(), Memory::new());
    let state = memory.state(FILE).expect("good model");
    call!(other.address().cast::<u8>().copy_from(state.cast::<u8>(), BW_STATE_SIZE));
    assert!(all(other.address().cast()).iter().all(|code| *code == BwCode::NotInitialised));
    assert_eq!(collect(state, 1), BwCode::Ok);
}

#[test]
fn memory_that_is_wrong_is_refused() {
    let mut memory = Memory::new();
    let (own, model, length) = (memory.address(), FILE.as_ptr(), FILE.len());
    let mut state = null_mut();
    let place = &raw mut state;
    let start = |memory, size, model, place| call!(bw_start(memory, size, model, length, null_mut(), place));
    assert_eq!(start(null_mut(), BW_STATE_SIZE, model, place), BwCode::Null);
    assert_eq!(start(own, BW_STATE_SIZE, null(), place), BwCode::Null);
    assert_eq!(start(own, BW_STATE_SIZE, model, null_mut()), BwCode::Null);
    for byte in 1..BW_STATE_ALIGN {
        assert_eq!(start(own.wrapping_byte_add(byte), BW_STATE_SIZE, model, place), BwCode::Misaligned, "{byte}");
    }
    for size in [0, 1, bw_state_size() - 1] {
        assert_eq!(start(own, size, model, place), BwCode::MemoryTooSmall, "{size}");
    }
    assert!((0.9..=1.0).contains(&(bw_state_size() as f64 / BW_STATE_SIZE as f64)), "{}", bw_state_size());
    assert!(state.is_null());
    // What is no front end.
    let wrong = own.wrapping_byte_add(8).cast();
    assert_eq!(call!(bw_start(own, BW_STATE_SIZE, model, length, wrong, place)), BwCode::NotInitialised);
    assert_eq!(start(own, BW_STATE_SIZE, model, place), BwCode::Ok);
    assert_eq!(state.cast(), own);
}

#[test]
fn models_that_are_wrong_are_refused_and_change_nothing() {
    let mut memory = Memory::new();
    let state = memory.state(FILE).expect("good model");
    assert_eq!(collect(state, 10), BwCode::Ok);
    for length in 0..FILE.len() {
        let expected = if length < 4 { BwCode::NotAModel } else { BwCode::ModelTruncated };
        assert_eq!(memory.state(&FILE[..length]), Err(expected), "{length} bytes");
    }
    let changed = |place: usize, byte: u8| {
        let mut bytes = FILE.to_vec();
        bytes[place] = byte;
        bytes
    };
    assert_eq!(memory.state(&changed(0, b'X')), Err(BwCode::NotAModel));
    assert_eq!(memory.state(&changed(4, 1)), Err(BwCode::ModelVersion));
    assert_eq!(memory.state(&changed(6, 1)), Err(BwCode::ModelValue), "header flags");
    assert_eq!(memory.state(&changed(100, !FILE[100])), Err(BwCode::ModelChecksum));
    assert_eq!(memory.state(&changed(FILE.len() - 1, !FILE[FILE.len() - 1])), Err(BwCode::ModelChecksum));
    assert_eq!(memory.state(FILE), Err(BwCode::Busy), "it runs");
    assert_eq!(status(state).0, 10, "and goes on");
    let erased = [FILE, &[0xFF; 300]].concat();
    assert_eq!(memory.again(&erased), Ok(state), "the erased rest of a flash sector");
    assert_eq!(status(state).0, 0, "started again");
}

#[test]
fn behind_a_stop_every_function_refuses_the_state() {
    let mut memory = Memory::new();
    let state = memory.state(FILE).expect("good model");
    assert_eq!(call!(bw_stop(state)), BwCode::Ok);
    assert!(all(state).iter().all(|code| *code == BwCode::NotInitialised));
    assert_eq!(memory.state(FILE), Ok(state));
}

#[test]
fn a_model_that_is_too_large_is_refused() {
    mod large {
        use bearing_watch::plan::{Layout, Load, ShaftLayout};
        bearing_watch::plan! {
            pub struct Large;
            pub struct Sample with angle { current_a: "A", velocity_rad_s: "rad/s" }
            layout: Layout {
                shaft: Some(ShaftLayout {
                    current: current_a,
                    velocity: Some(velocity_rad_s),
                    load: Load::Unknown,
                    orders: 7,
                    harmonics: 1,
                    decimation: 1,
                }),
                features: 1,
                coordinates: 1,
                classes: 1,
                ..Layout::EMPTY
            }
        }
    }
    use bearing_watch::plan::Plan as _;
    let layout = large::Large.layout();
    assert_eq!(AnyModel::of(layout), None);
    // The header and the layout of such a model, with a good checksum: the layout alone decides.
    let regression = [layout.channels, 0];
    let shaft = [1, 0, 0xFF, 1, 0xFF, 0xFF, 0xFF, 7, 1];
    let rest = [0, 0, 1, 0, 1, 0, 0, 1, 0];
    let payload = [&regression[..], &shaft, &rest].concat();
    let mut bytes =
        [b"BWMD".as_slice(), &FILE[4..8], &(payload.len() as u32).to_le_bytes(), &[0; 4], &payload].concat();
    bytes.extend(crc(&bytes).to_le_bytes());
    assert_eq!(bearing_watch::model::layout(&bytes), Ok(layout));
    assert_eq!(Memory::new().state(&bytes), Err(BwCode::ModelDoesNotFit));
}

/// CRC-32 of zip and Ethernet.
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| if crc & 1 == 1 { (crc >> 1) ^ 0xEDB8_8320 } else { crc >> 1 })
    })
}

#[test]
fn samples_that_are_wrong_are_refused() {
    let mut memory = Memory::new();
    let state = memory.state(FILE).expect("good model");
    let (values, raw, mut faults) = (SAMPLE.as_ptr(), raw_for_c(&raw(0)), MaybeUninit::uninit());
    call!({
        assert_eq!(bw_sample(state, null(), 3, 0), BwCode::Null);
        assert_eq!(bw_sample(state, values.wrapping_byte_add(2), 3, 0), BwCode::Misaligned);
        assert_eq!(bw_sample(state, values, 2, 0), BwCode::WrongChannelCount);
        assert_eq!(bw_sample(state, [0.0; 4].as_ptr(), 4, 0), BwCode::WrongChannelCount);
        // A state without a front end.
        assert_eq!(bw_sample_raw(state, &raw, null(), 0), BwCode::OutOfRange);
        assert_eq!(bw_faults(state, faults.as_mut_ptr()), BwCode::OutOfRange);
        assert_eq!(bw_collect(state), BwCode::Ok, "nothing waits");
        assert_eq!(bw_sample(state, values, 3, 0), BwCode::Collect);
    });
    assert_eq!(status(state), (0, 0, 0));
}

#[test]
fn calls_out_of_order_are_harmless() {
    let mut memory = Memory::new();
    let state = memory.state(FILE).expect("good model");
    let (mut report, mut alarm) = (MaybeUninit::<BwReport>::uninit(), MaybeUninit::<BwAlarm>::uninit());
    let (mut values, mut count) = ([0.0; 8], 0_usize);
    let advance = || call!(bw_advance(state, null_mut(), null_mut()));
    call!({
        assert_eq!(advance(), BwCode::Idle, "nothing to solve");
        assert_eq!(bw_report(state, report.as_mut_ptr()), BwCode::NoReport);
        assert_eq!(bw_values(state, 0, values.as_mut_ptr(), 8, &raw mut count), BwCode::NoReport);
        assert_eq!(bw_end_run(state, null_mut(), 0, null_mut()), BwCode::Ok);
    });
    assert_eq!(collect(state, SEGMENT), BwCode::Segment);
    assert_eq!((collect(state, SEGMENT), status(state).2), (BwCode::Ok, 1), "the first one still waits");
    call!({
        assert_eq!(advance(), BwCode::Ok);
        assert_eq!(bw_report(state, report.as_mut_ptr()), BwCode::NoReport, "being solved");
        assert_eq!(bw_restart(state), BwCode::Ok);
    });
    assert_eq!(collect(state, SEGMENT), BwCode::Segment, "the next one can wait while this one is solved");
    let conclude = || support::conclude(state);
    call!({
        assert_eq!([conclude(), conclude(), conclude()], [BwCode::Report, BwCode::Report, BwCode::Idle]);
        assert_eq!(bw_report(state, report.as_mut_ptr()), BwCode::Ok);
        let report = report.assume_init();
        assert_eq!((report.segment, report.lost_segments, report.lost_samples), (2, 1, 0));
        assert_eq!(bw_deny(state), BwCode::Idle, "no alarm stands");
        assert_eq!(bw_reset(state), BwCode::Ok);
        assert_eq!(bw_report(state, null_mut()), BwCode::NoReport);
        assert_eq!(bw_alarm(state, alarm.as_mut_ptr()), BwCode::Ok);
        let alarm = alarm.assume_init();
        assert_eq!((alarm.raised, alarm.segments), (false, 0));
        assert_eq!(advance(), BwCode::Idle);
    });
}

#[test]
fn results_need_a_good_place() {
    let mut memory = Memory::new();
    let state = memory.state(FILE).expect("good model");
    assert_eq!(collect(state, SEGMENT), BwCode::Segment);
    let (mut values, mut count, wrong) = ([0.0_f32; 8], 0_usize, null_mut::<u8>().wrapping_add(1));
    let (at, number) = (values.as_mut_ptr(), &raw mut count);
    call!({
        assert_eq!(bw_advance(state, wrong.cast(), null_mut()), BwCode::Misaligned);
        assert_eq!(bw_advance(state, null_mut(), wrong.cast()), BwCode::Misaligned);
        assert_eq!(support::conclude(state), BwCode::Report);
        assert_eq!([bw_report(state, null_mut()), bw_alarm(state, null_mut())], [BwCode::Null; 2]);
        assert_eq!([bw_info(state, null_mut()), bw_status(state, null_mut())], [BwCode::Null; 2]);
        assert_eq!(bw_values(state, 0, null_mut(), 8, number), BwCode::Null);
        assert_eq!(bw_values(state, 0, at, 8, null_mut()), BwCode::Null);
        assert_eq!(bw_values(state, 0, at.wrapping_byte_add(1), 1, number), BwCode::Misaligned);
        let beyond = BwValues::Weight as i32 + 1;
        assert_eq!([-1, beyond].map(|kind| bw_values(state, kind, at, 8, number)), [BwCode::OutOfRange; 2]);
        assert_eq!(
            (bw_values(state, BwValues::Parameters as i32, at, 2, number), *number),
            (BwCode::BufferTooSmall, 5)
        );
        assert_eq!((bw_values(state, BwValues::Friction as i32, at, 8, number), *number), (BwCode::Ok, 0));
    });
    assert_eq!(values[2..], [0.0; 6], "nothing is written beyond the capacity");
}

#[test]
fn the_model_says_what_it_is() {
    let mut memory = Memory::new();
    let state = memory.state(FILE).expect("good model");
    let (mut info, mut name) = (MaybeUninit::<BwInfo>::uninit(), [1; 17]);
    let label = name.as_mut_ptr();
    call!({
        assert_eq!(bw_info(state, info.as_mut_ptr()), BwCode::Ok);
        let info = info.assume_init();
        assert_eq!((info.channels, info.classes, info.features, info.orders), (3, 3, 5, 0));
        assert_eq!((info.segment_samples, info.block_mean, info.needs_angle), (5000, 1, false));
        assert_eq!(bw_label(state, 0, label, 17), BwCode::Ok);
        assert_eq!(text(label), "healthy");
        assert_eq!((bw_label(state, 0, label, 7), bw_label(state, 0, label, 8)), (BwCode::BufferTooSmall, BwCode::Ok));
        assert_eq!(
            (bw_label(state, 3, label, 17), bw_label(state, 0, null_mut(), 17)),
            (BwCode::OutOfRange, BwCode::Null)
        );
        let channel = |place, name: &CStr, unit: &CStr| bw_check_channel(state, place, name.as_ptr(), unit.as_ptr());
        assert_eq!(channel(2, c"load_torque_nm", c"N·m"), BwCode::Ok);
        assert_eq!(
            [channel(2, c"load_torque", c"N·m"), channel(2, c"load_torque_nm", c"Nm")],
            [BwCode::ModelChannel; 2]
        );
        assert_eq!(channel(3, c"load_torque_nm", c"N·m"), BwCode::OutOfRange);
        assert_eq!(bw_check_channel(state, 0, null(), c"A".as_ptr()), BwCode::Null);
        assert_eq!(bw_check_channel(state, 0, c"current_a".as_ptr(), null()), BwCode::Null);
        assert_eq!(
            (bw_check_interval(state, 0.002), bw_check_interval(state, 0.0021)),
            (BwCode::Ok, BwCode::ModelInterval)
        );
        assert_eq!((bw_check_park(state, 2), bw_check_park(state, 0)), (BwCode::Ok, BwCode::OutOfRange));
    });
}

#[test]
fn a_saved_alarm_is_restored_and_other_bytes_are_refused() {
    let mut memory = Memory::new();
    let state = memory.state(FILE).expect("good model");
    for _ in 0..3 {
        assert_eq!(collect(state, SEGMENT), BwCode::Segment);
        assert_eq!(support::conclude(state), BwCode::Report);
    }
    let told = |state| {
        let mut alarm = MaybeUninit::<BwAlarm>::uninit();
        assert_eq!(call!(bw_alarm(state, alarm.as_mut_ptr())), BwCode::Ok);
        let BwAlarm { segments, undetermined, raised, score, .. } = call!(alarm.assume_init());
        (segments, undetermined, raised, score.to_bits())
    };
    let (mut bytes, mut size) = ([0xA5; 256], 0);
    let place = bytes.as_mut_ptr();
    call!({
        assert_eq!(bw_saved_size(state, &raw mut size), BwCode::Ok);
        assert_eq!(bw_saved_size(state, null_mut()), BwCode::Null);
        assert_eq!(bw_save(state, null_mut(), 256), BwCode::Null);
        assert_eq!(bw_save(state, place, size - 1), BwCode::BufferTooSmall);
    });
    assert_eq!(bytes, [0xA5; 256]);
    assert_eq!(call!(bw_save(state, place, 256)), BwCode::Ok);
    assert_eq!(bytes[size..], [0xA5; 256][size..], "nothing is written beyond the size");
    let before = told(state);
    assert_eq!(before.0, 3);
    // The end of the run writes the same, but for the run that has ended.
    call!({
        let (place, mut length) = ([0; 256].as_mut_ptr(), 0);
        assert_eq!(bw_end_run(state, place, size - 1, &raw mut length), BwCode::BufferTooSmall);
        assert_eq!(bw_end_run(state, place, 256, null_mut()), BwCode::Null);
        assert_eq!((bw_end_run(state, place, 256, &raw mut length), length), (BwCode::Ok, size));
    });
    let state = memory.again(FILE).expect("good model");
    assert_eq!(told(state).0, 0);
    call!({
        assert_eq!(bw_restore(state, null(), size), BwCode::Null);
        assert_eq!(bw_restore(state, bytes.as_ptr(), size - 1), BwCode::SavedState);
        assert_eq!(bw_restore(state, FILE.as_ptr(), FILE.len()), BwCode::SavedState);
    });
    assert_eq!(told(state).0, 0);
    assert_eq!(call!(bw_restore(state, bytes.as_ptr(), size)), BwCode::Ok);
    assert_eq!(told(state), before);
    // The id of another model, with the checksum that fits.
    bytes[12] ^= 1;
    let check = crc(&bytes[..size - 4]).to_le_bytes();
    bytes[size - 4..size].copy_from_slice(&check);
    assert_eq!(call!(bw_restore(state, bytes.as_ptr(), size)), BwCode::OtherModel);
}

/// The numbers that C programs are compiled with.
fn codes_of_the_header() -> Vec<i32> {
    let header = include_str!("../include/bearing_watch.h");
    let number =
        |line: &str| line.trim().strip_prefix("BW_CODE_")?.split_once(" = ")?.1.split_once(',')?.0.parse().ok();
    header.lines().filter_map(number).collect()
}

#[test]
fn every_code_of_the_header_has_a_text_of_its_own_and_no_other_number_has_one() {
    let (codes, unknown) = (codes_of_the_header(), text(bw_error_text(i32::MIN)));
    assert!(codes.contains(&(BwCode::Block as i32)) && codes.contains(&(BwCode::SignatureOlder as i32)), "{codes:?}");
    assert_eq!(unknown, "unknown code");
    for code in -200..200 {
        assert_eq!(text(bw_error_text(code)) != unknown, codes.contains(&code), "{code}");
    }
    let texts: std::collections::BTreeSet<_> = codes.iter().map(|code| text(bw_error_text(*code))).collect();
    assert_eq!(texts.len(), codes.len(), "{texts:?}");
}

#[test]
fn the_library_tells_its_version_and_turns_counts_into_angles() {
    assert_eq!(text(bw_version()), env!("CARGO_PKG_VERSION"));
    // A quarter of a turn of 2³² counts.
    assert_eq!(bw_angle(1024, 12), 1 << 30);
}

/// Without a plan the library has no model of its own.
#[test]
fn a_library_for_any_model_has_no_model_of_its_own() {
    let (mut memory, mut state) = (Memory::new(), null_mut());
    // SAFETY: the memory is there for the whole call.
    let code = unsafe { bw_start_own(memory.address(), BW_STATE_SIZE, 0x1234, null_mut(), &raw mut state) };
    assert_eq!((code, state), (BwCode::ModelDoesNotFit, null_mut()));
    // SAFETY: NULL is refused.
    assert_eq!(unsafe { bw_start_own(memory.address(), BW_STATE_SIZE, 0, null_mut(), null_mut()) }, BwCode::Null);
}
