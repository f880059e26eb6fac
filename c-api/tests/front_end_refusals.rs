//! Wrong pointers, memory, constants and samples of the front end, the calibration and the check of the wiring are
//! refused by their codes.
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

#[path = "support/drive.rs"]
mod drive;
#[allow(dead_code, reason = "other tests use the rest")]
mod support;

use core::ffi::{CStr, c_void};
use core::mem::MaybeUninit;
use core::ptr::{null, null_mut};

use bearing_watch_c::*;

use drive::{CONSTANTS, for_c, raw, raw_for_c};
use support::ACTUATOR;

/// Calls a function on memory of the test.
macro_rules! call {
    ($($call:tt)*) => {
        // SAFETY: every pointer is NULL, misaligned, or that of memory of the test.
        unsafe { $($call)* }
    };
}

const SIZE: usize = BW_FRONT_END_SIZE;
const CALIBRATION: BwCalibrationLimits = BwCalibrationLimits {
    samples: 2,
    lowest_offset_counts: 0.0,
    highest_offset_counts: 65_535.0,
    lowest_deviation_counts: 0.0,
    highest_deviation_counts: 100.0,
};
const WIRING: BwWiringLimits = BwWiringLimits {
    least_current_a: 0.5,
    offset_rad: 0.1,
    delay_s: 1e-4,
    velocity_tolerance: 0.05,
    slowest_rad_s: 5.0,
};

/// Memory of an object, aligned to 8 bytes and one element larger than needed.
fn memory() -> Vec<u64> {
    vec![0; SIZE / 8 + 1]
}

fn constants() -> BwFrontEndConstants {
    for_c(&CONSTANTS, 10, 2)
}

fn front_end(memory: &mut [u64], constants: &BwFrontEndConstants) -> Result<*mut BwFrontEnd, BwCode> {
    let mut own = null_mut();
    match call!(bw_front_end_init(memory.as_mut_ptr().cast(), SIZE, constants, &raw mut own)) {
        BwCode::Ok => Ok(own),
        code => Err(code),
    }
}

/// What every function says to this object.
fn all(object: *mut c_void) -> Vec<BwCode> {
    let (sample, mut wiring, mut state) = (raw_for_c(&raw(0)), MaybeUninit::uninit(), null_mut());
    let (mut own, mut refused) = (constants(), BwRefusedOffset { phase: 0, value: 0.0 });
    let (mut memory, mut place) = (support::Memory::new(), support::Memory::new());
    let good = memory.drive(ACTUATOR, &own).expect("a drive");
    let (first, length, place) = (ACTUATOR.as_ptr(), ACTUATOR.len(), place.address());
    call!(vec![
        if object.is_null() {
            BwCode::Null // a drive without a front end
        } else {
            bw_start(place, BW_STATE_SIZE, first, length, object.cast(), &raw mut state)
        },
        bw_check_wiring(good, &sample, 0.0, object.cast()),
        bw_wiring_conclude(object.cast(), wiring.as_mut_ptr()),
        bw_calibration_push(object.cast(), [0; 3].as_ptr(), 3),
        bw_calibration_finish(object.cast(), &raw mut own, &raw mut refused),
    ])
}

#[test]
fn every_function_refuses_what_is_not_its_object() {
    let mut memory = memory();
    let address: *mut c_void = memory.as_mut_ptr().cast();
    assert!(all(null_mut()).iter().all(|code| *code == BwCode::Null));
    assert!(all(address.wrapping_byte_add(1)).iter().all(|code| *code == BwCode::Misaligned));
    assert!(all(address).iter().all(|code| *code == BwCode::NotInitialised));
    let mut other = vec![0_u64; SIZE / 8 + 1];
    front_end(&mut other, &constants()).expect("a front end");
    memory.copy_from_slice(&other);
    assert!(all(address).iter().all(|code| *code == BwCode::NotInitialised), "a copy");
    // A front end is neither a calibration nor a check, and the other way round; and it is that of one state.
    let codes = all(other.as_mut_ptr().cast());
    assert_eq!((codes[0], &codes[1..]), (BwCode::Ok, &[BwCode::NotInitialised; 4][..]));
    assert_eq!(all(other.as_mut_ptr().cast())[0], BwCode::NotInitialised);
    let mut calibration = null_mut();
    call!(bw_calibration_init(address, SIZE, &CALIBRATION, &raw mut calibration));
    let codes = all(address);
    assert_eq!(
        (&codes[..3], &codes[3..]),
        (&[BwCode::NotInitialised; 3][..], &[BwCode::Ok, BwCode::CalibrationTooFew][..])
    );
}

/// What a function that makes an object in memory says, with the address that it is to write.
type Init = fn(*mut c_void, usize, *mut c_void) -> BwCode;

#[test]
fn memory_that_is_wrong_is_refused() {
    let inits: [(Init, usize, usize); 3] = [
        (
            |memory, size, place| call!(bw_front_end_init(memory, size, &constants(), place.cast())),
            SIZE,
            bw_front_end_size(),
        ),
        (
            |memory, size, place| call!(bw_calibration_init(memory, size, &CALIBRATION, place.cast())),
            BW_CALIBRATION_SIZE,
            BW_CALIBRATION_SIZE / 2,
        ),
        (
            |memory, size, place| call!(bw_wiring_init(memory, size, &constants(), &WIRING, place.cast())),
            BW_WIRING_SIZE,
            BW_WIRING_SIZE / 2,
        ),
    ];
    for (init, size, least) in inits {
        let mut memory = memory();
        let own: *mut c_void = memory.as_mut_ptr().cast();
        let mut object: *mut c_void = null_mut();
        let place: *mut c_void = (&raw mut object).cast();
        assert_eq!([init(null_mut(), size, place), init(own, size, null_mut())], [BwCode::Null; 2]);
        for byte in 1..BW_STATE_ALIGN {
            assert_eq!(init(own.wrapping_byte_add(byte), size, place), BwCode::Misaligned, "{byte}");
        }
        for size in [0, 1, least - 1] {
            assert_eq!(init(own, size, place), BwCode::MemoryTooSmall, "{size}");
        }
        assert!(object.is_null() && memory.iter().all(|word| *word == 0), "nothing is written");
        assert_eq!((init(own, size, place), object), (BwCode::Ok, own));
    }
    assert!((0.9..=1.0).contains(&(bw_front_end_size() as f64 / SIZE as f64)), "{}", bw_front_end_size());
}

#[test]
fn constants_out_of_range_are_refused_by_name() {
    let refused = |change: fn(&mut BwFrontEndConstants)| {
        let mut own = constants();
        change(&mut own);
        let (mut memory, mut check) = (memory(), null_mut());
        let place = memory.as_mut_ptr().cast();
        let wiring = call!(bw_wiring_init(place, SIZE, &own, &WIRING, &raw mut check));
        let code = front_end(&mut memory, &own).err();
        let of_filters = matches!(code, Some(BwCode::FrontEndFactor | BwCode::FrontEndFurther));
        assert!(of_filters || wiring == code.unwrap_or(BwCode::Ok), "{wiring:?} {code:?}");
        code
    };
    assert_eq!(refused(|_| {}), None);
    assert_eq!(refused(|c| c.control_rate_hz = f32::NAN), Some(BwCode::FrontEndControlRate));
    assert_eq!(refused(|c| c.sensors[1].gain_a = 0.0), Some(BwCode::FrontEndSensor));
    assert_eq!(refused(|c| c.sensors[2].lowest_counts = 65_000), Some(BwCode::FrontEndSensor));
    assert_eq!(refused(|c| c.balance_window_samples = 3), Some(BwCode::FrontEndBalance));
    assert_eq!(refused(|c| c.tracking_bandwidth_hz = 1001.0), Some(BwCode::FrontEndTracking));
    assert_eq!(refused(|c| c.tracking_settle_samples = 0), Some(BwCode::FrontEndTracking));
    assert_eq!(refused(|c| c.resolver_highest_amplitude = 0.7), Some(BwCode::FrontEndResolver));
    assert_eq!(refused(|c| c.pole_pairs = 0), Some(BwCode::FrontEndPolePairs));
    assert_eq!(refused(|c| c.park = 0), Some(BwCode::OutOfRange));
    assert_eq!(refused(|c| c.park = 3), Some(BwCode::OutOfRange));
    assert_eq!(refused(|c| c.factor = 5), Some(BwCode::FrontEndFactor));
    assert_eq!(refused(|c| c.further = BW_MAX_FURTHER as u16), None);
    assert_eq!(refused(|c| c.further = BW_MAX_FURTHER as u16 + 1), Some(BwCode::FrontEndFurther));
    let (mut memory, mut own) = (memory(), null_mut());
    assert_eq!(call!(bw_front_end_init(memory.as_mut_ptr().cast(), SIZE, null(), &raw mut own)), BwCode::Null);
}

#[test]
fn samples_that_are_wrong_are_refused() {
    let mut memory = support::Memory::new();
    let own = memory.drive(ACTUATOR, &constants()).expect("a drive");
    let (sample, further) = (raw_for_c(&raw(0)), [0.0_f32; 4]);
    let values = further.as_ptr();
    let first: *const BwRawSample = &raw const sample;
    call!({
        assert_eq!(bw_sample_raw(own, null(), values, 2), BwCode::Null);
        assert_eq!(bw_sample_raw(own, first.wrapping_byte_add(2), values, 2), BwCode::Misaligned);
        assert_eq!(bw_sample_raw(own, first, null(), 2), BwCode::Null);
        assert_eq!(bw_sample_raw(own, first, values.wrapping_byte_add(1), 2), BwCode::Misaligned);
        for count in [0, 1, 3, usize::MAX] {
            assert_eq!(bw_sample_raw(own, first, values, count), BwCode::WrongChannelCount);
        }
        for phases in [0, 4, 255] {
            let sample = BwRawSample { phases, ..sample };
            assert_eq!(bw_sample_raw(own, &sample, values, 2), BwCode::OutOfRange);
        }
        let sample = BwRawSample { position: 3, ..sample };
        assert_eq!(bw_sample_raw(own, &sample, values, 2), BwCode::OutOfRange);
        assert_eq!(bw_sample(own, values, 4, 0), BwCode::OutOfRange, "signals of the drive's own");
        assert_eq!(bw_faults(own, null_mut()), BwCode::Null);
        let mut faults = MaybeUninit::<BwFrontEndFaults>::uninit();
        assert_eq!(bw_faults(own, faults.as_mut_ptr()), BwCode::Ok);
        let faults = faults.assume_init();
        assert_eq!((faults.lock, faults.gaps), (BwLock::Searching, 0), "no sample was taken");
        assert_eq!(bw_sample_raw(own, first, values, 2), BwCode::Collect, "the first call tests the arithmetic");
        let next = BwRawSample { number: 1, ..raw_for_c(&raw(1)) };
        assert_eq!(bw_sample_raw(own, &next, values, 2), BwCode::Ok);
    });
}

#[test]
fn a_calibration_refuses_wrong_counts_and_places() {
    let (mut memory, mut own, counts) = (memory(), null_mut(), [2000_u16; 3]);
    let (mut constants, mut refused) = (constants(), BwRefusedOffset { phase: 0, value: 0.0 });
    let place = memory.as_mut_ptr().cast();
    call!({
        assert_eq!(bw_calibration_init(place, SIZE, null(), &raw mut own), BwCode::Null);
        assert_eq!(bw_calibration_init(place, SIZE, &CALIBRATION, &raw mut own), BwCode::Ok);
        assert_eq!(bw_calibration_push(own, null(), 3), BwCode::Null);
        assert_eq!(bw_calibration_push(own, counts.as_ptr().wrapping_byte_add(1), 2), BwCode::Misaligned);
        assert_eq!(bw_calibration_push(own, counts.as_ptr(), 1), BwCode::OutOfRange);
        assert_eq!(bw_calibration_push(own, counts.as_ptr(), 0), BwCode::OutOfRange);
        assert_eq!(
            [bw_calibration_push(own, counts.as_ptr(), 2), bw_calibration_push(own, counts.as_ptr(), 2)],
            [BwCode::Ok, BwCode::EnoughSamples]
        );
        assert_eq!(bw_calibration_finish(own, null_mut(), &raw mut refused), BwCode::Null);
        assert_eq!(bw_calibration_finish(own, &raw mut constants, null_mut()), BwCode::Null);
        assert_eq!(bw_calibration_finish(own, &raw mut constants, &raw mut refused), BwCode::Ok);
    });
    let offsets = constants.sensors.map(|own| own.offset_counts);
    assert_eq!(offsets, [2000.0, 2000.0, CONSTANTS.sensors[2].offset_counts], "the third was not sampled");
}

#[test]
fn a_front_end_that_differs_from_training_is_refused() {
    let mut memory = support::Memory::new();
    let mut start = |change: fn(&mut BwFrontEndConstants)| {
        let mut own = constants();
        change(&mut own);
        memory.drive(ACTUATOR, &own).err()
    };
    assert_eq!(start(|own| own.factor = 12), Some(BwCode::ModelInterval));
    assert_eq!(start(|own| own.control_rate_hz = 10_200.0), Some(BwCode::ModelInterval));
    assert_eq!(start(|own| own.pole_pairs = 0), Some(BwCode::FrontEndPolePairs));
    assert_eq!(start(|own| own.park = 7), Some(BwCode::OutOfRange));
    assert_eq!(start(|own| own.park = 2), Some(BwCode::ModelPark));
    assert_eq!(start(|own| own.further = 3), Some(BwCode::FrontEndFurther));
    // And with right constants.
    assert_eq!(start(|_| {}), None);
}

#[test]
fn every_fault_of_the_wiring_has_its_text() {
    // SAFETY: the library gives texts that end in a zero byte and live as long as the program.
    let text = |fault| unsafe { CStr::from_ptr(bw_wiring_text(fault)) }.to_str().expect("text");
    let texts: std::collections::BTreeSet<_> = (0..13).map(text).collect();
    assert_eq!((texts.len(), texts.contains("unknown fault")), (13, false), "{texts:?}");
    assert_eq!([text(-1), text(13)], ["unknown fault"; 2]);
}
