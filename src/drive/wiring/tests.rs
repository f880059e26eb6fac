use super::*;
use crate::signal::Park;

const RATE_HZ: f32 = 10_000.0;
const LIMITS: WiringLimits =
    WiringLimits { least_current_a: 0.5, offset_rad: 0.1, delay_s: 2e-5, velocity_tolerance: 0.05, slowest_rad_s: 5.0 };

/// A motor and how it is wired.
#[derive(Clone, Copy)]
struct Rig {
    /// Pole pairs of the motor; those of the frame are five.
    pole_pairs: f64,
    offset_rad: f64,
    delay_s: f64,
    current_a: f64,
    /// Largest angle from the start, rad.
    reach_rad: f64,
    /// Signs of phase order, angle and velocity.
    signs: [f64; 3],
    /// Of the velocity; no velocity if it is not a number.
    scale: f64,
}

const RIGHT: Rig =
    Rig { pole_pairs: 5.0, offset_rad: 0.0, delay_s: 0.0, current_a: 3.0, reach_rad: 9.0, signs: [1.0; 3], scale: 1.0 };

impl Rig {
    /// Two periods of to and fro at 2 Hz, the current in phase with the acceleration and the velocity.
    fn check(self) -> Result<Wiring, WiringFault> {
        let frame = RotorFrame { pole_pairs: 5, electrical_offset: Angle::from_radians(0.3), park: Park::Standard };
        let mut check = WiringCheck::new(frame, RATE_HZ, LIMITS);
        let [order, way, velocity_sign] = self.signs;
        for k in 0..10_000_u16 {
            let t = f64::from(k) / f64::from(RATE_HZ);
            let at = |t: f64| self.reach_rad * (4.0 * core::f64::consts::PI * t).sin();
            let slope = |t: f64| self.reach_rad * 4.0 * core::f64::consts::PI * (4.0 * core::f64::consts::PI * t).cos();
            let electrical = self.pole_pairs * at(t - self.delay_s) + 0.3 + self.offset_rad;
            let q = self.current_a * (4.0 * core::f64::consts::PI * t + 2.0).sin();
            let currents = AlphaBeta {
                alpha: (-q * electrical.sin()) as f32,
                beta: (order * q * electrical.cos()) as f32,
                zero: 0.0,
            };
            let shaft = Angle::from_radians((way * at(t)) as f32);
            check.push(currents, shaft, (velocity_sign * self.scale * slope(t)) as f32);
        }
        check.conclude()
    }
}

#[test]
fn a_right_wiring_has_no_fault() {
    let wiring = RIGHT.check().unwrap();
    assert!((wiring.coherence - 1.0).abs() < 1e-4 && wiring.offset_rad.abs() < 1e-4, "{wiring:?}");
    // The angle moved over the whole interval, at the end of which the velocity is sampled.
    assert!((wiring.velocity_ratio.unwrap() - 1.0).abs() < 1e-3 && wiring.delay_s.unwrap().abs() < 1e-7, "{wiring:?}");
}

#[test]
fn pole_pairs_that_fit_are_named() {
    for (pole_pairs, order, fits) in [(3.0, 1.0, 3), (16.0, 1.0, 16), (7.0, -1.0, -7)] {
        let rig = Rig { pole_pairs, signs: [order, 1.0, 1.0], ..RIGHT };
        assert_eq!(rig.check(), Err(WiringFault::PolePairs { fits }));
    }
    // Twenty pole pairs fit none of the numbers that are tried.
    let many = Rig { pole_pairs: 20.0, ..RIGHT }.check();
    assert!(matches!(many, Err(WiringFault::NotTurning { coherence }) if coherence < 0.5), "{many:?}");
}

#[test]
fn the_direction_that_differs_from_the_other_two_is_named() {
    use WiringFault::{AngleDirection, PhaseOrder, PhaseOrderOrAngle, VelocityDirection};
    let faults = [[-1.0, 1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, -1.0]].into_iter();
    for (signs, fault) in faults.zip([PhaseOrder, AngleDirection, VelocityDirection]) {
        assert_eq!(Rig { signs, ..RIGHT }.check(), Err(fault));
        // Reversed are the other two: the same to one who sees only the three.
        assert_eq!(Rig { signs: signs.map(|sign| -sign), ..RIGHT }.check(), Err(fault));
    }
    // An offset of the frame turns the sums, and does not hide the direction.
    assert_eq!(Rig { signs: [-1.0, 1.0, 1.0], offset_rad: 0.8, ..RIGHT }.check(), Err(PhaseOrder));
    let blind = Rig { signs: [-1.0, 1.0, 1.0], scale: f64::NAN, ..RIGHT };
    assert_eq!(blind.check(), Err(PhaseOrderOrAngle));
}

#[test]
fn offset_delay_and_rate_are_measured() {
    for error in [0.3, -0.3, 1.5, -1.5] {
        let outcome = Rig { offset_rad: error, delay_s: 1e-5, ..RIGHT }.check();
        let Err(WiringFault::Offset { error_rad }) = outcome else { panic!("{outcome:?}") };
        assert!((f64::from(error_rad) - error).abs() < 2e-3, "{error} {error_rad}");
    }
    for delay in [1e-4, -5e-5] {
        let outcome = Rig { delay_s: delay, ..RIGHT }.check();
        let Err(WiringFault::Delay { delay_s }) = outcome else { panic!("{outcome:?}") };
        // One delay for all speeds, weighted by the current at the mean one.
        assert!((f64::from(delay_s) / delay - 1.0).abs() < 0.2, "{delay} {delay_s}");
    }
    for scale in [0.5, 2.0, 9.549_3] {
        let outcome = Rig { scale, ..RIGHT }.check();
        let Err(WiringFault::RateOrUnit { ratio }) = outcome else { panic!("{outcome:?}") };
        assert!((f64::from(ratio) / scale - 1.0).abs() < 1e-3, "{scale} {ratio}");
    }
}

/// A check of `rig` while it runs: so many turns forward, of 400 samples each, and back at the end. The current pulls
/// once a turn, by a power of the cosine.
fn running_check(rig: Rig, [forward, back]: [u16; 2], power: i32) -> WiringCheck {
    let frame = RotorFrame { pole_pairs: 5, electrical_offset: Angle::ZERO, park: Park::Standard };
    let mut check = WiringCheck::new(frame, RATE_HZ, LIMITS);
    let ahead = (0..forward * 400).map(f64::from);
    for step in ahead.chain((0..back * 400).map(|k| f64::from(forward * 400 - k))) {
        let theta = core::f64::consts::TAU * step / 400.0;
        let (electrical, q) = (rig.pole_pairs * theta, rig.current_a * theta.cos().powi(power));
        let currents =
            AlphaBeta { alpha: (-q * electrical.sin()) as f32, beta: (q * electrical.cos()) as f32, zero: 0.0 };
        check.push(currents, Angle::from_radians(theta as f32), f32::NAN);
    }
    check
}

fn running(rig: Rig, turns: [u16; 2], power: i32) -> Result<Wiring, WiringFault> {
    running_check(rig, turns, power).conclude()
}

#[test]
fn a_delay_needs_motion_both_ways() {
    for back in [0, 1] {
        // A tenth of the motion is too little: an error of the offset would show as a delay.
        let wiring = running(RIGHT, [9, back], 0).unwrap();
        assert_eq!(wiring.delay_s, None, "{back}");
    }
    assert!(running(RIGHT, [6, 4], 0).unwrap().delay_s.is_some());
}

#[test]
fn a_load_at_one_place_of_the_turn_does_not_hide_wrong_pole_pairs() {
    // The squared current is cos⁶ θ over the turn: its part at twice the angle, by which a number of pole pairs that is
    // wrong by one coheres, is 3/4 of its mean.
    for (pole_pairs, fits) in [(4.0, 4), (6.0, 6)] {
        let rig = Rig { pole_pairs, ..RIGHT };
        assert_eq!(running(rig, [9, 0], 3), Err(WiringFault::PolePairs { fits }));
    }
    let right = running(RIGHT, [9, 0], 3).unwrap();
    assert!((right.coherence - 1.0).abs() < 1e-4, "{right:?}");
}

#[test]
fn without_motion_or_current_nothing_is_passed() {
    let small = Rig { reach_rad: 2.0, ..RIGHT }.check();
    assert!(matches!(small, Err(WiringFault::TooLittleMotion { sectors: 9..=13 })), "{small:?}");
    let weak = Rig { current_a: 0.5, ..RIGHT }.check();
    assert!(matches!(weak, Err(WiringFault::TooLittleCurrent { rms_a }) if (0.3..0.42).contains(&rms_a)), "{weak:?}");
    let frame = RotorFrame { pole_pairs: 5, electrical_offset: Angle::ZERO, park: Park::Standard };
    let mut none = WiringCheck::new(frame, RATE_HZ, LIMITS);
    assert_eq!(none.conclude(), Err(WiringFault::TooLittleMotion { sectors: 0 }));
    for _ in 0..1000 {
        none.push(AlphaBeta { alpha: f32::NAN, beta: 1.0, zero: 0.0 }, Angle::ZERO, 1.0);
        none.skip();
    }
    assert_eq!(none.conclude(), Err(WiringFault::TooLittleMotion { sectors: 0 }));
}

#[test]
fn limits_that_are_no_numbers_admit_nothing() {
    let with = |limits: WiringLimits| {
        let check = WiringCheck { limits, ..running_check(RIGHT, [6, 4], 0) };
        check.conclude()
    };
    assert!(with(LIMITS).is_ok());
    let nan = f32::NAN;
    assert!(matches!(with(WiringLimits { offset_rad: nan, ..LIMITS }), Err(WiringFault::Offset { .. })));
    assert!(matches!(with(WiringLimits { delay_s: nan, ..LIMITS }), Err(WiringFault::Delay { .. })));
    assert!(matches!(with(WiringLimits { least_current_a: nan, ..LIMITS }), Err(WiringFault::TooLittleCurrent { .. })));
}

#[test]
fn faults_have_words() {
    let text = std::format!("{}", WiringFault::PolePairs { fits: 4 });
    assert_eq!(text, WiringFault::PolePairs { fits: 4 }.message());
}

/// 1/8 turn, a block of the travel, is 64 samples.
#[test]
fn a_block_of_the_motion_with_a_missing_sample_is_left_out() {
    let gaps: [fn(&mut WiringCheck, Angle); 2] =
        [|check, _| check.skip(), |check, angle| check.push(AlphaBeta::default(), angle, f32::NAN)];
    for (gap, every) in gaps.into_iter().flat_map(|gap| [(gap, 60), (gap, 80)]) {
        let frame = RotorFrame { pole_pairs: 5, electrical_offset: Angle::ZERO, park: Park::Standard };
        let mut check = WiringCheck::new(frame, RATE_HZ, LIMITS);
        for k in 0..4000_u32 {
            let angle = Angle::from_counts(k, 9);
            if k % every == 0 {
                gap(&mut check, angle);
            } else {
                check.push(AlphaBeta::default(), angle, RATE_HZ * core::f32::consts::TAU / 512.0);
            }
        }
        let ratio = check.travel_sums.ratio(check.interval_s);
        assert_eq!(ratio.is_some(), every == 80);
        // A motion over the gap would be that of more samples than have a velocity.
        assert!(ratio.is_none_or(|ratio| (ratio - 1.0).abs() < 1e-3), "{ratio:?}");
    }
}
