//! The chain against a motor in f64.

#![expect(clippy::cast_sign_loss, reason = "counts are positive, and an angle wraps")]

use core::f64::consts::TAU as TURN;
use std::vec::Vec;

use super::*;
use crate::drive::{BalanceLimits, Phase, PhaseSensor, ResolverLimits, TrackingConstants};
use crate::signal::Park;

mod late;

const RATE_HZ: f64 = 10_000.0;
/// 16 bits, 1 mA.
const SENSOR: PhaseSensor = PhaseSensor { offset_counts: 32_768.0, gain_a: 0.001, usable: [100, 65_000] };
const CONSTANTS: FrontEndConstants = FrontEndConstants {
    control_rate_hz: RATE_HZ as f32,
    sensors: [SENSOR; 3],
    stuck_samples: 200,
    balance: BalanceLimits { noise_a: 0.02, offset_a: 0.04, gain_tolerance: 0.02, window: 160 },
    tracking: TrackingConstants {
        bandwidth_hz: 300.0,
        damping: 0.707,
        error_limit_rad: 0.1,
        lost_samples: 20,
        settle_samples: 20,
        resolver: ResolverLimits { low: 0.7, high: 1.3, mismatch: 0.1 },
    },
    frame: RotorFrame { pole_pairs: 6, electrical_offset: Angle::from_bits(0x1234_5678), park: Park::Standard },
};

/// The signals of a drive, at a time in s.
#[derive(Clone, Copy)]
struct Drive {
    /// Frequency of a component that passes, Hz.
    passed_hz: f64,
}

impl Drive {
    fn angle(t: f64) -> f64 {
        1.0 + 120.0 * t - 30.0 * t * t + 0.8 * (TURN * 7.0 * t).sin()
    }

    fn velocity(t: f64) -> f64 {
        120.0 - 60.0 * t + 0.8 * TURN * 7.0 * (TURN * 7.0 * t).cos()
    }

    fn current(self, t: f64) -> f64 {
        4.0 + 2.0 * (TURN * 11.0 * t).sin() + (TURN * self.passed_hz * t).sin()
    }

    fn further(self, t: f64) -> [f64; 2] {
        [3.0 * (TURN * self.passed_hz * t).cos(), 1.0 + 0.5 * (TURN * 3.0 * t).sin()]
    }

    /// What the drive reads; `stopped_a` of 2.1 kHz is added to the current.
    fn raw(self, number: u32, stopped_a: f64) -> RawSample<2> {
        let t = f64::from(number) / RATE_HZ;
        let (angle, q) = (Self::angle(t), self.current(t) + stopped_a * (TURN * 2100.0 * t).sin());
        let electrical = 6.0 * angle + f64::from(0x1234_5678) / 4_294_967_296.0 * TURN;
        // A vector 90° ahead of the magnet axis.
        let phase = |k: f64| (32_768.0 - 1000.0 * q * (electrical - k * TURN / 3.0).sin()).round() as u16;
        let position = Position::Absolute(Angle::from_bits((angle / TURN * 4_294_967_296.0) as i64 as u32));
        let further = self.further(t).map(|x| x as f32);
        RawSample { number, currents: PhaseCounts::Three([0.0, 1.0, 2.0].map(phase)), position, further }
    }

    /// Largest departures of a clean sample at an instant: current, velocity, angle and further channels.
    fn departures(self, clean: &CleanSample<2>, number: usize) -> [f64; 4] {
        let t = number as f64 / RATE_HZ;
        let turns = f64::from(clean.angle.bits()) / 4_294_967_296.0 - Self::angle(t) / TURN;
        let [first, second] = [0, 1].map(|k| (f64::from(clean.further[k]) - self.further(t)[k]).abs());
        [
            (f64::from(clean.current_a) - self.current(t)).abs(),
            (f64::from(clean.velocity_rad_s) - Self::velocity(t)).abs(),
            TURN * (turns - turns.round()).abs(),
            if first.is_nan() { first } else { first.max(second) },
        ]
    }
}

/// Current: 0.3 mA of rounding a phase; the loop's 0.1° lag turns the current by 0.6°, 0.0004 A of 7; 3·10⁻⁴ of 1 A
/// for the pass band; 1.5·10⁻⁴ A that leaks. Velocity: the gain of (3) at 7 Hz, 1e-5 of 35 rad/s. Angle: 24 bits of
/// its error, and 3·10⁻⁴ of 0.002 rad. A sample of delay would be 0.1 A, 0.15 rad/s, 0.01 rad and 0.3.
const TOLERANCES: [f64; 4] = [3e-3, 5e-3, 2e-5, 2e-3];

#[test]
fn the_sample_of_an_output_is_known_before_it() {
    fn at<const FACTOR: usize>()
    where
        By<FACTOR>: Factor,
    {
        let mut front_end = FrontEnd::<2, FACTOR>::new(&CONSTANTS).unwrap();
        let drive = Drive { passed_hz: 1.0 };
        // A gap does not move the outputs, whether they are complete or not.
        front_end.held_back = 0;
        let mut outputs = 0;
        for number in (0..40 * FACTOR as u32).filter(|number| *number != 21 * FACTOR as u32 + 1) {
            let expected = front_end.to_centre % FACTOR as u16 == FrontEnd::<2, FACTOR>::OUTPUT;
            let output = front_end.push(&drive.raw(number, 0.0)).is_some();
            assert!(expected || !output, "by {FACTOR}: {number}");
            outputs += u32::from(output);
        }
        assert!(outputs > 5, "by {FACTOR}: {outputs}");
    }
    at::<1>();
    at::<2>();
    at::<6>();
    at::<8>();
    at::<10>();
    at::<24>();
    at::<40>();
}

fn aligned<const FACTOR: usize>()
where
    By<FACTOR>: Factor,
{
    let mut front_end = FrontEnd::<2, FACTOR>::new(&CONSTANTS).unwrap();
    let factor = FrontEnd::<2, FACTOR>::FACTOR;
    let drive = Drive { passed_hz: 0.25 * RATE_HZ / factor as f64 };
    let (mut worst, mut outputs) = ([0.0_f64; 4], 0);
    for number in 0..40_000 {
        let Some(clean) = front_end.push(&drive.raw(number, if factor > 4 { 1.5 } else { 0.0 })) else { continue };
        outputs += 1;
        if number as usize > 2 * FrontEnd::<2, FACTOR>::DELAY + 100 {
            let departures = drive.departures(&clean, number as usize - FrontEnd::<2, FACTOR>::DELAY);
            worst.iter_mut().zip(departures).for_each(|(w, d)| *w = if d > *w || d.is_nan() { d } else { *w });
        }
    }
    std::println!("by {factor}: A, rad/s, rad, further {worst:?}");
    assert!(worst.iter().zip(TOLERANCES).all(|(worst, most)| *worst <= most), "by {factor}: {worst:?}");
    assert!((40_000 / factor - outputs) < 40, "by {factor}: {outputs} outputs");
    assert!(front_end.faults().is_clear(), "{:?}", front_end.faults());
}

#[test]
fn all_channels_are_those_of_one_instant() {
    aligned::<1>();
    aligned::<2>();
    aligned::<4>();
    aligned::<8>();
    aligned::<16>();
    aligned::<32>();
    aligned::<6>();
    aligned::<12>();
    aligned::<24>();
    aligned::<48>();
    aligned::<10>();
    aligned::<20>();
    aligned::<40>();
}

/// The clean samples by 8 of raw samples that `change` has changed, with the number of the instant of each; all that is
/// not missing must be true.
fn cleaned(samples: u32, mut change: impl FnMut(&mut RawSample<2>)) -> (Vec<(u32, CleanSample<2>)>, Faults) {
    let mut front_end = FrontEnd::<2, 8>::new(&CONSTANTS).unwrap();
    let (drive, delay) = (Drive { passed_hz: 300.0 }, FrontEnd::<2, 8>::DELAY);
    let (mut taken, mut outputs) = (Vec::new(), Vec::new());
    for number in 0..samples {
        let mut raw = drive.raw(number, 0.0);
        change(&mut raw);
        if raw.number == u32::MAX {
            continue; // a missed interrupt
        }
        taken.push(number);
        let Some(clean) = front_end.push(&raw) else { continue };
        let instant = taken[taken.len() - 1 - delay];
        let departures = drive.departures(&clean, instant as usize);
        for (k, departure) in departures.iter().enumerate() {
            let lost = !departure.is_finite() || (k == 2 && clean.velocity_rad_s.is_nan());
            assert!(lost || *departure <= TOLERANCES[k], "sample {instant}, channel {k}: {departure}");
        }
        outputs.push((instant, clean));
    }
    (outputs, front_end.faults())
}

/// Instants of the first and last missing samples of each channel after the start.
fn missing(outputs: &[(u32, CleanSample<2>)]) -> [Option<(u32, u32)>; 3] {
    let channels: [fn(&CleanSample<2>) -> f32; 3] = [|c| c.current_a, |c| c.velocity_rad_s, |c| c.further[1]];
    channels.map(|channel| {
        let lost = || outputs.iter().filter(|(at, c)| *at > 200 && channel(c).is_nan()).map(|(at, _)| *at);
        Some((lost().next()?, lost().next_back()?))
    })
}

/// Whether samples are missing around an instant only, by half of the taps.
fn around(lost: Option<(u32, u32)>, from: u32, to: u32) -> bool {
    lost.is_some_and(|(first, last)| first >= from - 122 && first <= from && last >= to && last <= to + 122)
}

#[test]
fn a_saturated_phase_costs_the_current_and_nothing_else() {
    let (outputs, faults) = cleaned(6000, |raw| {
        if raw.number == 3000 {
            raw.currents = PhaseCounts::Three([40, 32_768, 32_768]);
        }
    });
    let [current, velocity, further] = missing(&outputs);
    assert!(around(current, 3000, 3000) && velocity.is_none() && further.is_none(), "{current:?}");
    assert!(faults.currents[0].saturated == 1 && !faults.is_clear());
    assert_eq!(faults.position, PositionFaults::default());
}

#[test]
fn without_an_angle_there_is_no_current_and_no_velocity() {
    for lost in [1, 500] {
        let (outputs, faults) = cleaned(8000, |raw| {
            if (3000..3000 + lost).contains(&raw.number) {
                raw.position = Position::Missing;
            }
        });
        let [current, velocity, further] = missing(&outputs);
        let relock = if lost > 20 { 22 } else { 0 };
        assert!(around(current, 3000, 2999 + lost + relock) && further.is_none(), "{current:?}");
        assert!(around(velocity, 3000, 2999 + lost + relock), "{velocity:?}");
        assert_eq!((faults.position.missing, faults.lock), (lost, Lock::Locked));
    }
}

#[test]
fn a_further_channel_is_missing_alone() {
    let (outputs, faults) = cleaned(6000, |raw| {
        if raw.number == 3000 {
            raw.further[1] = f32::NAN;
        }
    });
    let [current, velocity, further] = missing(&outputs);
    assert!(around(further, 3000, 3000) && current.is_none() && velocity.is_none());
    assert!(faults.is_clear() && outputs.iter().skip(5).all(|(_, clean)| clean.further[0].is_finite()));
}

#[test]
fn missed_interrupts_spoil_all_channels_until_the_filters_are_new() {
    // Every other tap of the first filter is zero: a gap behind an even and behind an odd sample.
    for (start, gap) in [1, 3, 8, 100].into_iter().flat_map(|gap| [(3000, gap), (3001, gap)]) {
        let (outputs, faults) = cleaned(8000, |raw| {
            if (start..start + gap).contains(&raw.number) {
                raw.number = u32::MAX;
            }
        });
        for lost in missing(&outputs) {
            // A lock that is lost takes 22 samples to return.
            assert!(around(lost, start - 1, start + gap + if gap >= 20 { 22 } else { 2 }), "{start} {gap}: {lost:?}");
        }
        assert_eq!((faults.gaps, faults.lock), (1, Lock::Locked));
        assert_eq!(faults.position.losses, u32::from(gap >= 20));
    }
}

#[test]
fn no_sample_is_wrong_whatever_fails() {
    let mut state = 11_u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        state >> 8
    };
    let (outputs, faults) = cleaned(60_000, |raw| match next() % 3000 {
        0 => raw.currents = PhaseCounts::Three([next() as u16 % 99, 32_768, 32_768]),
        1 => raw.position = Position::Missing,
        2 => {
            // A quarter to three quarters of a turn off: an error below the limit cannot be told from motion.
            if let Position::Absolute(angle) = &mut raw.position {
                *angle = angle.plus(Angle::from_bits((1 << 30) + (next() << 7)));
            }
        }
        3 => raw.further = [f32::INFINITY, f32::NAN],
        4 => raw.number = u32::MAX,
        5 => raw.position = Position::Resolver { sin: f32::NAN, cos: 1.0 },
        _ => {}
    });
    let good = outputs.iter().filter(|(_, clean)| clean.current_a.is_finite()).count();
    std::println!("{good} of {} currents are good: {faults:?}", outputs.len());
    assert!(good > outputs.len() / 2 && good < outputs.len() && faults.gaps > 5 && faults.position.strayed > 5);
}

#[test]
fn a_wrong_gain_is_named_and_stops_the_current_until_it_is_right() {
    let mut front_end = FrontEnd::<2, 8>::new(&CONSTANTS).unwrap();
    let drive = Drive { passed_hz: 300.0 };
    let (mut seen, mut found_late) = (None, 0);
    for number in 0..10_000 {
        let mut raw = drive.raw(number, 0.0);
        if let PhaseCounts::Three([_, b, _]) = &mut raw.currents
            && (2000..5000).contains(&number)
        {
            *b = (0.8 * (f64::from(*b) - 32_768.0) + 32_768.0).round() as u16;
        }
        let clean = front_end.push(&raw);
        if let Some(clean) = clean
            && (4200..5000).contains(&number)
        {
            assert!(clean.current_a.is_nan() && clean.velocity_rad_s.is_finite());
            seen = front_end.faults().imbalance;
        }
        assert!(number < 7600 || clean.is_none_or(|clean| clean.current_a.is_finite()));
        found_late += u32::from(clean.is_some_and(|clean| clean.found_late));
    }
    assert_eq!(found_late, 1, "told once, as what was taken before is discarded once");
    assert!(matches!(seen, Some(Imbalance::Gain { phase: Phase::B, error }) if (error + 0.2).abs() < 0.01), "{seen:?}");
    assert!(front_end.faults().unbalanced_windows > 2 && front_end.faults().imbalance.is_none());
    front_end.clear_faults();
    assert!(front_end.faults().is_clear());
}

#[test]
fn constants_out_of_range_are_refused_by_name() {
    let refused = |change: fn(&mut FrontEndConstants)| {
        let mut constants = CONSTANTS;
        change(&mut constants);
        FrontEnd::<0, 8>::new(&constants).err()
    };
    assert_eq!(refused(|_| {}), None);
    assert_eq!(refused(|c| c.control_rate_hz = f32::NAN), Some(FrontEndError::ControlRate));
    assert_eq!(refused(|c| c.sensors[1].gain_a = 0.0), Some(FrontEndError::Sensor));
    assert_eq!(refused(|c| c.sensors[2].usable = [5, 5]), Some(FrontEndError::Sensor));
    assert_eq!(refused(|c| c.balance.window = 3), Some(FrontEndError::Balance));
    assert_eq!(refused(|c| c.tracking.bandwidth_hz = 1001.0), Some(FrontEndError::Tracking));
    assert_eq!(refused(|c| c.tracking.settle_samples = 0), Some(FrontEndError::Tracking));
    assert_eq!(refused(|c| c.tracking.resolver.high = 0.7), Some(FrontEndError::Resolver));
    assert_eq!(refused(|c| c.frame.pole_pairs = 0), Some(FrontEndError::PolePairs));
}

#[test]
fn a_quadrature_current_of_the_drive_passes_the_filters_with_the_angle() {
    let mut front_end = FrontEnd::<2, 8>::new(&CONSTANTS).unwrap();
    let (drive, delay) = (Drive { passed_hz: 300.0 }, FrontEnd::<2, 8>::DELAY as u32);
    let (mut missing, mut outputs) = (0, 0);
    for number in 0..20_000 {
        let current_a = match number {
            9000 => f32::NAN,
            9001 => f32::INFINITY,
            _ => drive.current(f64::from(number) / RATE_HZ) as f32,
        };
        let raw = RawSample { currents: PhaseCounts::Quadrature(current_a), ..drive.raw(number, 0.0) };
        let Some(clean) = front_end.push(&raw) else { continue };
        outputs += 1;
        let departures = drive.departures(&clean, (number - delay) as usize);
        if clean.current_a.is_nan() {
            missing += 1;
            assert!((9000..9300).contains(&number) && departures[1] <= TOLERANCES[1], "{number}: {departures:?}");
        } else if number > 2 * delay + 100 {
            assert!(departures.iter().zip(TOLERANCES).all(|(departure, most)| *departure <= most), "{departures:?}");
        }
    }
    assert!((10..40).contains(&missing) && outputs > 2400, "{missing} {outputs}");
    assert!(
        front_end.faults().is_clear() && front_end.faults().alignment == Alignment::Unknown,
        "{:?}",
        front_end.faults()
    );
}

#[test]
fn the_first_sample_is_complete_unless_none_is_for_two_seconds() {
    let drive = Drive { passed_hz: 300.0 };
    let first = |known_from: u32, position: bool| {
        let mut front_end = FrontEnd::<2, 8>::new(&CONSTANTS).unwrap();
        let outputs = (0..50_000).filter_map(|number| {
            let mut raw = drive.raw(number, 0.0);
            match number < known_from {
                true if position => raw.position = Position::Missing,
                true => raw.currents = PhaseCounts::Three([1, 2, 3]),
                false => {}
            }
            front_end.push(&raw).map(|clean| (number, clean))
        });
        let (number, clean) = outputs.take(1).next().expect("an output");
        (number, (clean.current_a + clean.velocity_rad_s).is_finite())
    };
    for position in [true, false] {
        for known_from in [0, 1, 977, 15_000] {
            let (number, complete) = first(known_from, position);
            assert!(complete && (known_from + 22..known_from + 300).contains(&number), "{known_from}: {number}");
        }
        // Of 10 kHz, and the filters.
        let (number, complete) = first(60_000, position);
        assert!(!complete && (20_000..20_300).contains(&number), "{number}");
    }
}

#[test]
fn the_third_angle_gives_the_first_velocity() {
    let mut front_end = FrontEnd::<2, 1>::new(&CONSTANTS).unwrap();
    front_end.held_back = 0;
    let drive = Drive { passed_hz: 300.0 };
    let clean: Vec<_> = (0..60).filter_map(|number| front_end.push(&drive.raw(number, 0.0))).collect();
    let first = |known: fn(&CleanSample<2>) -> bool| clean.iter().position(known);
    let (current, velocity) =
        (first(|clean| clean.current_a.is_finite()), first(|clean| clean.velocity_rad_s.is_finite()));
    // The current waits for one angle more, the velocity at its instant needs the angles before and after.
    assert_eq!(velocity, current.map(|current| current + 1));
}
