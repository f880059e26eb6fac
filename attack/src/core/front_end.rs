//! Raw samples and counts of any bits, in any order of calls: clean samples are finite or missing, and the front end
//! recovers once its input is good.

use bearing_watch::drive::{
    BalanceLimits, By, CalibrationLimits, Factor, FrontEnd, FrontEndConstants, Lock, OffsetCalibration, PhaseCounts,
    PhaseSensor, Position, RawSample, ResolverLimits, RotorFrame, TrackingConstants, WiringCheck, WiringLimits,
};
use bearing_watch::{Angle, Park};

use crate::input::Input;
use crate::memory;
use crate::models::raw::{CONSTANTS, Motor, Sensors};

/// Samples of a window of the sum of three currents.
const WINDOW: u16 = 32;
/// Good samples after which the front end must have recovered: windows and times of the loop.
const GOOD: usize = 600;
/// The same in clean samples, for the filters.
const CLEAN: usize = 40;
/// Samples of an attack before it, so that a long input is not a slow one.
const SAMPLES: usize = 400;

/// Front ends by several factors.
pub fn attack(bytes: &[u8]) {
    memory::without_allocation(|| {
        let mut input = Input::new(bytes);
        match input.byte() % 4 {
            0 => run::<1>(&mut input),
            1 => run::<10>(&mut input),
            2 => run::<48>(&mut input),
            _ => run::<8>(&mut input),
        }
    });
}

fn run<const FACTOR: usize>(input: &mut Input<'_>)
where
    By<FACTOR>: Factor,
{
    let mut constants =
        FrontEndConstants { balance: BalanceLimits { window: WINDOW, ..CONSTANTS.balance }, ..CONSTANTS };
    let choice = input.byte() % 8;
    // A recovery takes more samples than all that is before it.
    let recovers = choice == 7;
    if choice < 2 {
        constants = any_constants(input);
    }
    let Ok(mut front_end) = FrontEnd::<1, FACTOR>::new(&constants) else { return };
    let sensors = if input.byte().is_multiple_of(2) { Sensors::Resolver } else { Sensors::Converter };
    let mut motor = Motor::<1>::new(sensors);
    let mut check = WiringCheck::new(constants.frame, constants.control_rate_hz, limits(input));
    let mut calibration = OffsetCalibration::new(CalibrationLimits {
        samples: u16::from(input.byte()),
        offset_counts: [input.number(), input.number()],
        deviation_counts: [input.number(), input.number()],
    });
    let mut left = SAMPLES;
    while !input.is_empty() && left > 0 {
        left -= 1;
        match input.byte() % 8 {
            0 | 1 => push(&mut front_end, &wild(input)),
            2 => {
                let raw = wild(input);
                for number in 0..some(input, &mut left) {
                    push(&mut front_end, &RawSample { number: raw.number.wrapping_add(number), ..raw });
                }
            }
            3 | 4 => (0..some(input, &mut left)).for_each(|_| push(&mut front_end, &motor.sample())),
            5 => {
                let raw = if input.byte().is_multiple_of(2) { wild(input) } else { motor.sample() };
                let velocity_rad_s = input.number();
                for _ in 0..some(input, &mut left) {
                    front_end.check_wiring(&raw, velocity_rad_s, &mut check);
                }
                conclude(&check);
            }
            6 => {
                let _enough = calibration.push(&counts(input));
                if let Ok(sensors) = calibration.finish(constants.sensors) {
                    assert!(sensors.iter().all(|sensor| sensor.offset_counts.is_finite()), "{sensors:?}");
                }
            }
            _ => front_end.clear_faults(),
        }
        let _faults = front_end.faults();
    }
    if recovers {
        recover(front_end, &mut motor);
    }
}

/// A number of samples.
fn some(input: &mut Input<'_>, left: &mut usize) -> u32 {
    let count = usize::from(input.byte()).min(*left);
    *left -= count;
    count as u32
}

/// The front end after good samples.
fn recover<const FACTOR: usize>(mut front_end: FrontEnd<1, FACTOR>, motor: &mut Motor<1>)
where
    By<FACTOR>: Factor,
{
    let mut last = None;
    for _ in 0..GOOD + CLEAN * FACTOR {
        last = front_end.push(&motor.sample()).or(last);
    }
    let faults = front_end.faults();
    let last = last.expect("clean samples");
    let good = last.current_a.is_finite() && last.velocity_rad_s.is_finite() && last.further[0].is_finite();
    assert!(good && faults.lock == Lock::Locked && faults.imbalance.is_none(), "{last:?} {faults:?}");
    // The motor of the samples turns at 300 rad/s.
    assert!((last.velocity_rad_s - 300.0).abs() < 15.0, "{last:?}");
}

fn push<const FACTOR: usize>(front_end: &mut FrontEnd<1, FACTOR>, raw: &RawSample<1>)
where
    By<FACTOR>: Factor,
{
    if let Some(clean) = front_end.push(raw) {
        // Infinite is neither measured nor missing.
        assert!(!clean.current_a.is_infinite() && !clean.velocity_rad_s.is_infinite(), "{clean:?}");
    }
}

fn conclude(check: &WiringCheck) {
    if let Ok(wiring) = check.conclude() {
        let all = [wiring.coherence, wiring.offset_rad].into_iter().chain(wiring.delay_s).chain(wiring.velocity_ratio);
        assert!(all.into_iter().all(f32::is_finite), "{wiring:?}");
    }
}

fn counts(input: &mut Input<'_>) -> PhaseCounts {
    let counts = [input.half(), input.half(), input.half()];
    match input.byte() % 5 {
        0 | 1 => PhaseCounts::Three(counts),
        2 => PhaseCounts::Quadrature(input.number()),
        _ => PhaseCounts::Two([counts[0], counts[1]]),
    }
}

/// A raw sample of any bits.
fn wild(input: &mut Input<'_>) -> RawSample<1> {
    let number = if input.byte().is_multiple_of(2) { input.word() } else { u32::from(input.byte()) };
    let position = match input.byte() % 4 {
        0 => Position::Missing,
        1 => Position::Absolute(Angle::from_bits(input.word())),
        _ => Position::Resolver { sin: input.number(), cos: input.number() },
    };
    RawSample { number, currents: counts(input), position, further: [input.number()] }
}

fn limits(input: &mut Input<'_>) -> WiringLimits {
    WiringLimits {
        least_current_a: input.number(),
        offset_rad: input.number(),
        delay_s: input.number(),
        velocity_tolerance: input.number(),
        slowest_rad_s: input.number(),
    }
}

/// Constants of any bits, some of which are good.
fn any_constants(input: &mut Input<'_>) -> FrontEndConstants {
    let mut constants = CONSTANTS;
    let mut either = |own: f32| if input.byte().is_multiple_of(2) { own } else { input.number() };
    let PhaseSensor { offset_counts, gain_a, usable } = CONSTANTS.sensors[0];
    let sensor = PhaseSensor { offset_counts: either(offset_counts), gain_a: either(gain_a), usable };
    constants.sensors = [sensor; 3];
    constants.control_rate_hz = either(constants.control_rate_hz);
    let BalanceLimits { noise_a, offset_a, gain_tolerance, window } = constants.balance;
    constants.balance = BalanceLimits {
        noise_a: either(noise_a),
        offset_a: either(offset_a),
        gain_tolerance: either(gain_tolerance),
        window,
    };
    let TrackingConstants { bandwidth_hz, damping, error_limit_rad, resolver, .. } = constants.tracking;
    let ResolverLimits { low, high, mismatch } = resolver;
    constants.tracking = TrackingConstants {
        bandwidth_hz: either(bandwidth_hz),
        damping: either(damping),
        error_limit_rad: either(error_limit_rad),
        resolver: ResolverLimits { low: either(low), high: either(high), mismatch: either(mismatch) },
        ..constants.tracking
    };
    let [stuck, window, lost, settle] = [input.half(), input.half(), input.half(), input.half()];
    (constants.stuck_samples, constants.balance.window) = (stuck, window);
    (constants.tracking.lost_samples, constants.tracking.settle_samples) = (lost, settle);
    let park = if input.byte().is_multiple_of(2) { Park::Standard } else { Park::Thesis };
    constants.frame = RotorFrame { pole_pairs: input.word(), electrical_offset: Angle::from_bits(input.word()), park };
    constants
}
