//! Through the C functions the front end, the calibration and the check of the wiring give the bits of the Rust core.
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

use core::mem::MaybeUninit;
use core::ptr::{null, null_mut};

use bearing_watch::Angle;
use bearing_watch::drive::{
    Alignment, By, CalibrationError, CalibrationLimits, CleanSample, Factor, Faults, FrontEnd, FrontEndConstants,
    Imbalance, Lock, OffsetCalibration, PhaseCounts, Position, RawSample, WiringCheck, WiringFault, WiringLimits,
};
use bearing_watch_c::*;

use drive::{CONSTANTS, RATE_HZ, for_c, raw, raw_for_c};

/// Memory of an object, aligned to 8 bytes.
type Memory = [u64; BW_FRONT_END_SIZE / 8];

/// Calls a function on memory of the test.
macro_rules! call {
    ($($call:tt)*) => {
        // SAFETY: every pointer is that of memory of the test, which is initialised where it is read.
        unsafe { $($call)* }
    };
}

fn front_end(memory: &mut Memory, constants: &BwFrontEndConstants) -> *mut BwFrontEnd {
    let mut own = null_mut();
    let place = memory.as_mut_ptr().cast();
    assert_eq!(call!(bw_front_end_init(place, size_of::<Memory>(), constants, &raw mut own)), BwCode::Ok);
    own
}

fn push(own: *mut BwFrontEnd, raw: &RawSample<2>) -> Option<BwCleanSample> {
    let mut clean = MaybeUninit::uninit();
    match call!(bw_front_end_push(own, &raw_for_c(raw), raw.further.as_ptr(), 2, clean.as_mut_ptr())) {
        BwCode::Ok => None,
        code => {
            assert_eq!(code, BwCode::CleanSample);
            Some(call!(clean.assume_init()))
        }
    }
}

fn faults(own: *mut BwFrontEnd) -> BwFrontEndFaults {
    let mut faults = MaybeUninit::uninit();
    assert_eq!(call!(bw_front_end_faults(own, faults.as_mut_ptr())), BwCode::Ok);
    call!(faults.assume_init())
}

fn same_clean(c: Option<BwCleanSample>, rust: Option<CleanSample<2>>) {
    let bits = |values: [f32; 4]| values.map(f32::to_bits);
    let c = c.map(|own| {
        let [first, second, rest @ ..] = own.further;
        assert_eq!(rest, [0.0; 4]);
        let numbers = bits([own.current_a, own.velocity_rad_s, first, second]);
        (numbers, own.angle, own.found_late == 1, own.alignment)
    });
    let rust = rust.map(|own| {
        let [first, second] = own.further;
        let numbers = bits([own.current_a, own.velocity_rad_s, first, second]);
        (numbers, own.angle.bits(), own.found_late, own.alignment as u8)
    });
    assert_eq!(c, rust);
}

fn same_faults(c: &BwFrontEndFaults, rust: &Faults) {
    let imbalance = match rust.imbalance {
        None => (BwImbalance::None, 0.0),
        Some(Imbalance::Open(_)) => (BwImbalance::Open, 0.0),
        Some(Imbalance::Silent(_)) => (BwImbalance::Silent, 0.0),
        Some(Imbalance::Gain { error, .. }) => (BwImbalance::Gain, error),
        Some(Imbalance::Unnamed) => (BwImbalance::Unnamed, 0.0),
        Some(Imbalance::Offset { offset_a, .. }) => (BwImbalance::Offset, offset_a),
        Some(Imbalance::Misaligned) => (BwImbalance::Misaligned, 0.0),
        Some(Imbalance::Clipped(_)) => (BwImbalance::Clipped, 0.0),
        Some(Imbalance::HalfWave(_)) => (BwImbalance::HalfWave, 0.0),
    };
    let (position, resolver) = (rust.position, rust.position.resolver);
    assert_eq!((c.imbalance, c.gain_error), imbalance);
    assert_eq!((c.clear, c.unbalanced_windows, c.gaps), (rust.is_clear(), rust.unbalanced_windows, rust.gaps));
    assert_eq!((c.offsets_a, c.alignment), (rust.offsets_a, rust.alignment.into()));
    assert_eq!(
        [c.position_stale, c.position_slipped, c.position_unsteady, c.position_stuck_bits],
        [position.stale, position.slipped, position.unsteady_windows, position.stuck_bits]
    );
    assert_eq!(c.saturated, rust.currents.map(|own| own.saturated));
    assert_eq!(c.stuck, rust.currents.map(|own| own.stuck));
    assert_eq!(
        (c.position_missing, c.position_strayed, c.lock_losses),
        (position.missing, position.strayed, position.losses)
    );
    assert_eq!(
        (c.resolver_lost, c.resolver_too_high, c.resolver_mismatched),
        (resolver.lost, resolver.too_high, resolver.mismatched)
    );
    let lock = match rust.lock {
        Lock::Searching => BwLock::Searching,
        Lock::Found(_) => BwLock::Found,
        Lock::Settling(_) => BwLock::Settling,
        Lock::Locked => BwLock::Locked,
    };
    assert_eq!(c.lock, lock);
}

/// What the drive reads of two or three phases, by a converter of the angle or a resolver.
fn read(number: u32, resolver: bool, two: bool) -> RawSample<2> {
    let mut sample = raw(number);
    if let (PhaseCounts::Three([a, b, _]), true) = (sample.currents, two) {
        sample.currents = PhaseCounts::Two([a, b]);
    }
    if let (Position::Absolute(angle), true) = (sample.position, resolver) {
        let signals = angle.sin_cos();
        sample.position = Position::Resolver { sin: signals.sin, cos: signals.cos };
    }
    sample
}

/// Puts in faults by a random number; returns whether the interrupt is missed.
fn disturb(sample: &mut RawSample<2>, random: u32) -> bool {
    match (random >> 8) % 1500 {
        0 => sample.currents = PhaseCounts::Three([40, 65_100, 32_768]),
        1 => sample.position = Position::Missing,
        2 => sample.position = Position::Absolute(Angle::from_bits(random)),
        3 => sample.position = Position::Resolver { sin: f32::NAN, cos: 2.0 },
        4 => sample.position = Position::Resolver { sin: 1.0, cos: 2.0 },
        5 => sample.further = [f32::NAN, f32::INFINITY],
        6 => return true,
        _ => {}
    }
    // A broken sensor for a while, and a position that is lost.
    if let (PhaseCounts::Three([_, b, _]), 6000..9000) = (&mut sample.currents, sample.number) {
        *b = 32_760;
    }
    if (9500..9600).contains(&sample.number) {
        sample.position = Position::Missing;
    }
    false
}

/// A stream with every fault that there is, at random; returns the last fault counters.
fn compare<const FACTOR: usize>(resolver: bool, two: bool) -> Faults
where
    By<FACTOR>: Factor,
{
    let mut memory = [0; BW_FRONT_END_SIZE / 8];
    let mut rust = FrontEnd::<2, FACTOR>::new(&CONSTANTS).expect("good constants");
    let c = front_end(&mut memory, &for_c(&CONSTANTS, FACTOR as u16, 2));
    // Samples, and the number of the reading with the first one, from which on none is left out.
    let (mut random, mut clean, mut first) = (7_u32, 0, None);
    for number in 0..12_000 {
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let mut sample = read(number, resolver, two);
        // Behind the longest filters, the first sample needs so many readings without a fault.
        if number > 2000 && disturb(&mut sample, random) {
            continue;
        }
        let (own, other) = (push(c, &sample), rust.push(&sample));
        clean += usize::from(own.is_some());
        first = first.or(own.is_some().then_some(number as usize));
        same_clean(own, other);
        if number % 7 == 0 {
            same_faults(&faults(c), &rust.faults());
        }
    }
    let first = first.expect("a clean sample");
    // Readings that are missing shift the outputs, by at most one of them.
    assert!(first < 2000 && clean + 60 > (12_000 - first) / FACTOR, "by {FACTOR}: {clean} from {first} on");
    let last = rust.faults();
    same_faults(&faults(c), &last);
    assert_eq!(call!(bw_front_end_clear_faults(c)), BwCode::Ok);
    rust.clear_faults();
    same_faults(&faults(c), &rust.faults());
    last
}

#[test]
fn every_factor_gives_the_bits_of_rust_through_faults() {
    let all = [
        compare::<1>(false, false),
        compare::<2>(true, false),
        compare::<4>(false, true),
        compare::<8>(true, true),
        compare::<16>(false, false),
        compare::<32>(true, false),
        compare::<6>(false, true),
        compare::<12>(true, true),
        compare::<24>(false, false),
        compare::<48>(true, false),
        compare::<10>(false, true),
        compare::<20>(true, true),
        compare::<40>(false, false),
    ];
    let sum = |of: fn(&Faults) -> u32| all.iter().map(of).sum::<u32>();
    assert!(sum(|own| own.gaps) > 50 && sum(|own| own.unbalanced_windows) > 6);
    assert!(sum(|own| own.currents[0].saturated) > 50 && sum(|own| own.currents[1].stuck) > 1000);
    assert!(sum(|own| own.position.missing) > 1300 && sum(|own| own.position.losses) >= 13);
    assert!(sum(|own| own.position.strayed) > 20 && sum(|own| own.position.resolver.lost) > 20);
    assert!(sum(|own| own.position.resolver.too_high) > 20);
}

/// The faults of a drive whose readings are changed.
fn told(readings: u32, change: impl Fn(&mut RawSample<2>)) -> Faults {
    let mut memory = [0; BW_FRONT_END_SIZE / 8];
    let mut rust = FrontEnd::<2, 8>::new(&CONSTANTS).expect("good constants");
    let c = front_end(&mut memory, &for_c(&CONSTANTS, 8, 2));
    for number in 0..readings {
        let mut sample = raw(number);
        change(&mut sample);
        same_clean(push(c, &sample), rust.push(&sample));
        same_faults(&faults(c), &rust.faults());
    }
    rust.faults()
}

#[test]
fn stuck_bits_of_the_angle_and_the_alignment_are_those_of_rust() {
    let right = told(20_000, |_| ());
    assert_eq!((right.position.stuck_bits, right.alignment), (0, Alignment::Aligned));
    const BIT: u32 = 1 << 22;
    let stuck = told(20_000, |sample| {
        if let Position::Absolute(angle) = &mut sample.position {
            *angle = Angle::from_bits(angle.bits() & !BIT);
        }
    });
    assert_eq!(stuck.position.stuck_bits, BIT);
    let exchanged = told(20_000, |sample| {
        if let PhaseCounts::Three([a, b, _]) = &mut sample.currents {
            core::mem::swap(a, b);
        }
    });
    assert_eq!(exchanged.alignment, Alignment::Misaligned);
}

#[test]
fn the_library_has_filters_for_the_factors_of_the_core_only() {
    let place = [0_u64; BW_FRONT_END_SIZE / 8].as_mut_ptr();
    let refused = |factor| {
        let mut own = null_mut();
        let constants = for_c(&CONSTANTS, factor, 0);
        call!(bw_front_end_init(place.cast(), BW_FRONT_END_SIZE, &constants, &raw mut own)) == BwCode::FrontEndFactor
    };
    let taken: Vec<u16> = (0..100).filter(|factor| !refused(*factor)).collect();
    assert_eq!(taken, [1, 2, 4, 6, 8, 10, 12, 16, 20, 24, 32, 40, 48]);
}

#[test]
fn a_front_end_needs_no_further_channels() {
    let mut memory = [0; BW_FRONT_END_SIZE / 8];
    let c = front_end(&mut memory, &for_c(&CONSTANTS, 8, 0));
    let mut rust = FrontEnd::<0, 8>::new(&CONSTANTS).expect("good constants");
    for number in 0..500 {
        let RawSample { number, currents, position, .. } = raw(number);
        let other = rust.push(&RawSample { number, currents, position, further: [] });
        let mut clean = MaybeUninit::<BwCleanSample>::uninit();
        let code = call!(bw_front_end_push(c, &raw_for_c(&raw(number)), null(), 0, clean.as_mut_ptr()));
        assert_eq!(code == BwCode::CleanSample, other.is_some());
        if let Some(other) = other {
            let own = call!(clean.assume_init());
            assert_eq!(own.current_a.to_bits(), other.current_a.to_bits());
            assert_eq!(own.further, [0.0; BW_MAX_FURTHER]);
        }
    }
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
    let mut memory = [0; BW_FRONT_END_SIZE / 8];
    let own_constants = for_c(&CONSTANTS, 8, 2);
    let own = front_end(&mut memory, &own_constants);
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
    let mut rust = FrontEnd::<2, 8>::new(&CONSTANTS).expect("good constants");
    let mut rust_check = WiringCheck::new(CONSTANTS.frame, RATE_HZ, WIRING);
    for number in 0..20_000 {
        let mut sample = raw(number);
        change(&mut sample);
        let t = number as f32 / RATE_HZ;
        let velocity_rad_s = velocity * 40.0 * std::f32::consts::PI * (std::f32::consts::PI * t).cos();
        rust.check_wiring(&sample, velocity_rad_s, &mut rust_check);
        let code = call!(bw_front_end_check_wiring(own, &raw_for_c(&sample), velocity_rad_s, check));
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
