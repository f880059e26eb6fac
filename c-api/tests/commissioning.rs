//! Through the C functions the calibration and the check of the wiring give the bits of the Rust core.
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

use core::mem::MaybeUninit;
use core::ptr::null_mut;

use bearing_watch::Angle;
use bearing_watch::drive::{
    CalibrationError, CalibrationLimits, FrontEnd, FrontEndConstants, OffsetCalibration, PhaseCounts, Position,
    RawSample, WiringCheck, WiringFault, WiringLimits,
};
use bearing_watch_c::*;

use drive::{CONSTANTS, RATE_HZ, for_c, raw, raw_for_c};
use support::{ACTUATOR, Memory};

/// Calls a function on memory of the test.
macro_rules! call {
    ($($call:tt)*) => {
        // SAFETY: every pointer is that of memory of the test, which is initialised where it is read.
        unsafe { $($call)* }
    };
}

#[test]
fn the_library_has_filters_for_the_factors_of_the_core_only() {
    let mut memory = [0_u64; BW_FRONT_END_SIZE / 8];
    let mut refused = |factor| {
        let mut own = null_mut();
        let (constants, place) = (for_c(&CONSTANTS, factor, 0), memory.as_mut_ptr());
        call!(bw_front_end_init(place.cast(), BW_FRONT_END_SIZE, &constants, &raw mut own)) == BwCode::FrontEndFactor
    };
    let taken: Vec<u16> = (0..100).filter(|factor| !refused(*factor)).collect();
    assert_eq!(taken, [1, 2, 4, 6, 8, 10, 12, 16, 20, 24, 32, 40, 48]);
}

/// Counts around the offsets, with a little noise.
fn standing(k: u16) -> PhaseCounts {
    PhaseCounts::Three([32_770 + k % 2, 32_741 + k % 3, 32_760 + k % 5])
}

/// Constants after a calibration in C and in Rust, or the refusals.
fn calibrated(
    limits: CalibrationLimits,
    samples: u16,
) -> (Result<BwFrontEndConstants, (BwCode, BwRefusedOffset)>, Result<FrontEndConstants, CalibrationError>) {
    let mut memory = [0_u64; BW_CALIBRATION_SIZE / 8];
    let mut own = null_mut();
    let for_calibration = BwCalibrationLimits {
        samples: limits.samples,
        lowest_offset_counts: limits.offset_counts[0],
        highest_offset_counts: limits.offset_counts[1],
        lowest_deviation_counts: limits.deviation_counts[0],
        highest_deviation_counts: limits.deviation_counts[1],
    };
    let place = memory.as_mut_ptr().cast();
    let code = call!(bw_calibration_init(place, BW_CALIBRATION_SIZE, &for_calibration, &raw mut own));
    assert_eq!(code, BwCode::Ok);
    let mut rust = OffsetCalibration::new(limits);
    for k in 0..samples {
        let counts = standing(k);
        let enough = if rust.push(&counts) { BwCode::EnoughSamples } else { BwCode::Ok };
        assert_eq!(call!(bw_calibration_push(own, counts.as_slice().as_ptr(), 3)), enough);
    }
    let (before, mut refused) = (for_c(&CONSTANTS, 8, 0), BwRefusedOffset { phase: 9, value: 0.0 });
    let mut constants = before;
    let c = match call!(bw_calibration_finish(own, &raw mut constants, &raw mut refused)) {
        BwCode::Ok => Ok(constants),
        code => {
            assert_eq!(constants, before);
            Err((code, refused))
        }
    };
    (c, rust.finish(CONSTANTS.sensors).map(|sensors| FrontEndConstants { sensors, ..CONSTANTS }))
}

#[test]
fn a_calibration_gives_the_offsets_of_rust_or_names_the_sensor() {
    let limits = CalibrationLimits { samples: 900, offset_counts: [32_668.0, 32_868.0], deviation_counts: [0.1, 8.0] };
    let (c, rust) = calibrated(limits, 1000);
    assert_eq!(c, Ok(for_c(&rust.expect("calibrated"), 8, 0)));
    assert!(c.is_ok_and(|own| (own.sensors[1].offset_counts - 32_742.0).abs() < 0.01));

    let (c, rust) = calibrated(limits, 899);
    assert_eq!(rust, Err(CalibrationError::TooFew { samples: 899 }));
    assert_eq!(c, Err((BwCode::CalibrationTooFew, BwRefusedOffset { phase: 0, value: 899.0 })));
    let (c, rust) = calibrated(CalibrationLimits { deviation_counts: [0.6, 8.0], ..limits }, 900);
    assert!(matches!(rust, Err(CalibrationError::Stuck { .. })));
    assert_eq!(c, Err((BwCode::CalibrationStuck, BwRefusedOffset { phase: 0, value: 0.0 })));
    let (c, rust) = calibrated(CalibrationLimits { deviation_counts: [0.1, 1.0], ..limits }, 900);
    let Err(CalibrationError::Noisy { deviation_counts, .. }) = rust else { panic!("{rust:?}") };
    assert_eq!(c, Err((BwCode::CalibrationNoisy, BwRefusedOffset { phase: 2, value: deviation_counts })));
    let (c, rust) = calibrated(CalibrationLimits { offset_counts: [32_750.0, 32_868.0], ..limits }, 900);
    let Err(CalibrationError::OutOfBand { offset_counts, .. }) = rust else { panic!("{rust:?}") };
    assert_eq!(c, Err((BwCode::CalibrationOutOfBand, BwRefusedOffset { phase: 1, value: offset_counts })));
}

const WIRING: WiringLimits =
    WiringLimits { least_current_a: 0.5, offset_rad: 0.1, delay_s: 1e-4, velocity_tolerance: 0.05, slowest_rad_s: 5.0 };

/// The wiring of changed samples in C and in Rust; the velocity is a factor times the true one.
fn wired(
    velocity: f32,
    change: impl Fn(&mut RawSample<2>),
) -> (BwWiring, Result<bearing_watch::drive::Wiring, WiringFault>) {
    let (mut memory, own_constants) = (Memory::new(), for_c(&CONSTANTS, 10, 2));
    let own = memory.drive(ACTUATOR, &own_constants).expect("a good model");
    let limits = BwWiringLimits {
        least_current_a: WIRING.least_current_a,
        offset_rad: WIRING.offset_rad,
        delay_s: WIRING.delay_s,
        velocity_tolerance: WIRING.velocity_tolerance,
        slowest_rad_s: WIRING.slowest_rad_s,
    };
    let (mut room, mut check) = ([0_u64; BW_WIRING_SIZE / 8], null_mut());
    let place = room.as_mut_ptr().cast();
    let code = call!(bw_wiring_init(place, BW_WIRING_SIZE, &own_constants, &limits, &raw mut check));
    assert_eq!(code, BwCode::Ok);
    let mut rust = FrontEnd::<2, 10>::new(&CONSTANTS).expect("good constants");
    let mut rust_check = WiringCheck::new(CONSTANTS.frame, RATE_HZ, WIRING);
    for number in 0..20_000 {
        let mut sample = raw(number);
        change(&mut sample);
        let t = number as f32 / RATE_HZ;
        let velocity_rad_s = velocity * 40.0 * std::f32::consts::PI * (std::f32::consts::PI * t).cos();
        rust.check_wiring(&sample, velocity_rad_s, &mut rust_check);
        let code = call!(bw_check_wiring(own, &raw_for_c(&sample), velocity_rad_s, check));
        assert_eq!(code, BwCode::Ok);
    }
    let mut wiring = MaybeUninit::uninit();
    assert_eq!(call!(bw_wiring_conclude(check, wiring.as_mut_ptr())), BwCode::Ok);
    (call!(wiring.assume_init()), rust_check.conclude())
}

#[test]
fn a_right_wiring_has_the_numbers_of_rust() {
    for velocity in [1.0, f32::NAN] {
        let (c, rust) = wired(velocity, |_| {});
        let rust = rust.expect("a right wiring");
        assert_eq!((c.fault, c.value.is_nan()), (BwWiringFault::None, true));
        assert_eq!((c.coherence, c.offset_rad), (rust.coherence, rust.offset_rad));
        assert_eq!(c.delay_s, rust.delay_s.expect("both ways"));
        assert_eq!(c.velocity_ratio.to_bits(), rust.velocity_ratio.unwrap_or(f32::NAN).to_bits());
    }
}

/// A fault of the wiring in C, its value, and the fault in Rust.
fn fault(velocity: f32, change: impl Fn(&mut RawSample<2>)) -> (BwWiringFault, f32, WiringFault) {
    let (c, rust) = wired(velocity, change);
    assert!(c.coherence.is_nan() && c.velocity_ratio.is_nan());
    (c.fault, c.value, rust.expect_err("a fault"))
}

#[test]
fn a_wrong_direction_is_named() {
    let exchange = |raw: &mut RawSample<2>| {
        if let PhaseCounts::Three([_, b, c]) = &mut raw.currents {
            core::mem::swap(b, c);
        }
    };
    let backward = |raw: &mut RawSample<2>| {
        if let Position::Absolute(angle) = raw.position {
            raw.position = Position::Absolute(angle.negated());
        }
    };
    let same = |(c, value, rust): (BwWiringFault, f32, WiringFault), expected| {
        assert!(value.is_nan());
        assert_eq!((c, rust), expected);
    };
    same(fault(1.0, exchange), (BwWiringFault::PhaseOrder, WiringFault::PhaseOrder));
    same(fault(f32::NAN, exchange), (BwWiringFault::PhaseOrderOrAngle, WiringFault::PhaseOrderOrAngle));
    same(fault(1.0, backward), (BwWiringFault::AngleDirection, WiringFault::AngleDirection));
    same(fault(-1.0, |_| {}), (BwWiringFault::VelocityDirection, WiringFault::VelocityDirection));
}

#[test]
fn other_faults_of_the_wiring_have_their_values() {
    let still = |raw: &mut RawSample<2>| raw.position = Position::Absolute(Angle::ZERO);
    let quiet = |raw: &mut RawSample<2>| {
        // A converter that repeats itself is stuck.
        let dither = raw.number as u16 % 2;
        raw.currents = PhaseCounts::Three([32_768, 32_760, 32_768].map(|counts| counts + dither));
    };
    let turned = |raw: &mut RawSample<2>| {
        if let Position::Absolute(angle) = raw.position {
            raw.position = Position::Absolute(angle.plus(Angle::from_radians(0.05)));
        }
    };
    let (c, ratio, rust) = fault(1.5, |_| {});
    assert_eq!((c, rust), (BwWiringFault::RateOrUnit, WiringFault::RateOrUnit { ratio }));
    let (c, error_rad, rust) = fault(1.0, turned);
    assert_eq!((c, rust), (BwWiringFault::Offset, WiringFault::Offset { error_rad }));
    let (c, sectors, rust) = fault(1.0, still);
    assert_eq!((c, rust), (BwWiringFault::TooLittleMotion, WiringFault::TooLittleMotion { sectors: sectors as u8 }));
    let (c, rms_a, rust) = fault(1.0, quiet);
    assert_eq!((c, rust), (BwWiringFault::TooLittleCurrent, WiringFault::TooLittleCurrent { rms_a }));
}
