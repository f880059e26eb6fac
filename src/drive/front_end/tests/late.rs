//! Faults that are found late, what a clearing leaves, and what the check of the wiring takes.

use super::*;
use crate::drive::WiringLimits;

/// The numbers of the samples with which a fault was found late, of raw samples that `change` has changed.
fn found_late(samples: u32, change: impl Fn(&mut RawSample<2>)) -> (Vec<u32>, Faults) {
    let mut front_end = FrontEnd::<2, 8>::new(&CONSTANTS).unwrap();
    let late = (0..samples).filter(|number| {
        let mut raw = Drive { passed_hz: 300.0 }.raw(*number, 0.0);
        change(&mut raw);
        front_end.push(&raw).is_some_and(|clean| clean.found_late)
    });
    (late.collect(), front_end.faults())
}

fn weaken(raw: &mut RawSample<2>) {
    if let PhaseCounts::Three([_, b, _]) = &mut raw.currents {
        *b = (0.8 * (f64::from(*b) - 32_768.0) + 32_768.0).round() as u16;
    }
}

#[test]
fn unequal_gains_of_a_resolver_are_found_late() {
    let resolver = |gain: f32| {
        found_late(6000, move |raw| {
            if let Position::Absolute(angle) = raw.position {
                let signals = angle.sin_cos();
                let sin = if raw.number < 3000 { signals.sin } else { gain * signals.sin };
                raw.position = Position::Resolver { sin, cos: signals.cos };
            }
        })
    };
    let (late, faults) = resolver(1.12);
    assert!(late.len() == 1 && (3000..4500).contains(&late[0]), "{late:?}");
    assert!(faults.position.resolver.mismatched > 1000 && faults.imbalance.is_none(), "{faults:?}");
    assert_eq!(resolver(1.0).0, []);
}

#[test]
fn a_stuck_converter_is_found_late() {
    let quiet = |stuck_from: u32| {
        found_late(3000, move |raw| {
            let counts = 32_760 + if raw.number < stuck_from { raw.number as u16 % 2 } else { 0 };
            raw.currents = PhaseCounts::Three([counts, 32_768 + raw.number as u16 % 3, 32_768 - raw.number as u16 % 5]);
            raw.position = Position::Absolute(Angle::ZERO);
        })
    };
    let (late, faults) = quiet(1000);
    // Windows of 200 samples.
    assert!(late.len() == 1 && (1200..1420).contains(&late[0]), "{late:?}");
    assert!(faults.currents[0].stuck > 1500, "{faults:?}");
    assert_eq!(quiet(3000).0, []);
}

#[test]
fn a_stuck_bit_is_found_late_and_ends_with_a_later_comparison() {
    let mut front_end = FrontEnd::<2, 8>::new(&CONSTANTS).unwrap();
    let (mut late, mut missing) = (0, 0);
    for number in 0..30_000 {
        let mut raw = Drive { passed_hz: 300.0 }.raw(number, 0.0);
        if let (Position::Absolute(angle), 3000..15_000) = (&mut raw.position, number) {
            *angle = Angle::from_bits(angle.bits() | 1 << 20);
        }
        let Some(clean) = front_end.push(&raw) else { continue };
        late += u32::from(clean.found_late);
        missing += u32::from(number > 9000 && clean.velocity_rad_s.is_nan());
        assert!(number < 24_000 || clean.velocity_rad_s.is_finite(), "{number}");
    }
    assert_eq!((late, front_end.faults().position.stuck_bits), (1, 1 << 20));
    assert!(missing > 700, "{missing}");
}

#[test]
fn a_fault_that_comes_back_is_found_late_again() {
    let (late, faults) = found_late(15_000, |raw| {
        if (2000..5000).contains(&raw.number) || (9000..12_000).contains(&raw.number) {
            weaken(raw);
        }
    });
    assert!(late.len() == 2 && late[0] > 2000 && (9000..11_000).contains(&late[1]), "{late:?}");
    assert!(faults.imbalance.is_none());
}

#[test]
fn what_is_wrong_now_stays_when_counts_are_cleared() {
    let mut front_end = FrontEnd::<2, 8>::new(&CONSTANTS).unwrap();
    for number in 0..5000 {
        let mut raw = Drive { passed_hz: 300.0 }.raw(number, 0.0);
        if number > 2000 {
            weaken(&mut raw);
        }
        front_end.push(&raw);
    }
    let before = front_end.faults();
    front_end.clear_faults();
    let after = front_end.faults();
    assert!(before.imbalance.is_some() && before.unbalanced_windows > 0 && !after.is_clear());
    assert_eq!((after.imbalance, after.lock, after.alignment), (before.imbalance, before.lock, before.alignment));
    assert_eq!((after.unbalanced_windows, after.last_imbalance), (0, None));
}

#[test]
fn what_the_check_of_the_wiring_takes_does_not_mix_with_what_follows() {
    let (drive, delay) = (Drive { passed_hz: 300.0 }, FrontEnd::<2, 8>::DELAY);
    for (first, last) in [(3000, 3001), (3001, 3300), (3002, 3503)] {
        let mut front_end = FrontEnd::<2, 8>::new(&CONSTANTS).unwrap();
        let limits = WiringLimits {
            least_current_a: 0.5,
            offset_rad: 0.1,
            delay_s: 1e-4,
            velocity_tolerance: 0.05,
            slowest_rad_s: 5.0,
        };
        let mut check = WiringCheck::new(CONSTANTS.frame, RATE_HZ as f32, limits);
        let (mut taken, mut good) = (Vec::new(), 0);
        for number in 0..6000 {
            let raw = drive.raw(number, 0.0);
            if (first..last).contains(&number) {
                front_end.check_wiring(&raw, f32::NAN, &mut check);
                continue;
            }
            taken.push(number);
            let Some(clean) = front_end.push(&raw) else { continue };
            if number > last && clean.current_a.is_finite() {
                let [current, velocity, angle, _] = drive.departures(&clean, taken[taken.len() - 1 - delay] as usize);
                assert!(current <= TOLERANCES[0] && velocity <= TOLERANCES[1] && angle <= TOLERANCES[2], "{number}");
                good += 1;
            }
        }
        assert!(good > 200, "{good}");
        assert_eq!(front_end.faults().gaps, 0);
    }
}

#[test]
fn numbers_that_wrap_are_no_gap() {
    let mut front_end = FrontEnd::<2, 8>::new(&CONSTANTS).unwrap();
    let mut good = 0;
    for k in 0..4000_u32 {
        let number = k.wrapping_sub(2000);
        let clean = front_end.push(&RawSample { number, ..Drive { passed_hz: 300.0 }.raw(k, 0.0) });
        good += u32::from(clean.is_some_and(|clean| clean.velocity_rad_s.is_finite()));
    }
    assert!(front_end.faults().is_clear() && good > 450, "{good}");
}

#[test]
fn a_velocity_is_not_that_of_readings_on_both_sides_of_a_gap() {
    let mut front_end = FrontEnd::<2, 8>::new(&CONSTANTS).unwrap();
    let mut lock_after = |number: u32| {
        front_end.push(&Drive { passed_hz: 300.0 }.raw(number, 0.0));
        front_end.faults().lock
    };
    assert!([0, 5, 9].map(&mut lock_after).iter().all(|lock| matches!(lock, Lock::Found(_))), "each is a first one");
    assert!(matches!(lock_after(10), Lock::Settling(_)));
}
