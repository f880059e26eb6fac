//! The loop against motions in f64.

#![expect(clippy::cast_sign_loss, reason = "counts of an angle are positive")]

use core::f64::consts::TAU as TURN;

use super::*;
use crate::drive::RotorFrame;
use crate::signal::{AlphaBeta, Park};

impl PositionTracker {
    /// The velocity ω̂ of the loop, rad/s; late by 2ζ/ωₙ.
    fn velocity_rad_s(&self) -> f32 {
        self.velocity as f32 * (RAD * self.rate_hz)
    }

    /// Ka (5), 1/s²: at an acceleration α the angle of the loop is α/Ka behind.
    fn acceleration_constant(&self) -> f32 {
        let [_, k2] = self.gains;
        k2 * RAD * self.rate_hz * self.rate_hz
    }
}

const RATE_HZ: f64 = 10_000.0;
const RESOLVER: ResolverLimits = ResolverLimits { low: 0.7, high: 1.3, mismatch: 0.1 };
/// ωₙ = 2π 146 rad/s.
const CONSTANTS: TrackingConstants = TrackingConstants {
    bandwidth_hz: 300.0,
    damping: 0.707,
    error_limit_rad: 0.1,
    lost_samples: 20,
    settle_samples: 20,
    resolver: RESOLVER,
};

/// Numbers in −1 … 1.
struct Noise(u32);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(self.0 >> 8) / 8_388_608.0 - 1.0
    }
}

/// 14 bits, with up to one count of noise.
fn converter(angle: f64, noise: &mut Noise) -> Position {
    let counts = (angle / TURN * 16_384.0 + noise.next()).floor();
    Position::Absolute(Angle::from_counts(counts.rem_euclid(16_384.0) as u32, 14))
}

/// Amplitude 1 with noise of 0.001, in steps of a 12-bit converter of ± 1.5.
fn resolver(angle: f64, noise: &mut Noise) -> Position {
    let mut step = |x: f64| (((x + 0.001 * noise.next()) * 1365.0).round() / 1365.0) as f32;
    Position::Resolver { sin: step(angle.sin()), cos: step(angle.cos()) }
}

/// The shorter way from a true angle to an angle, degrees.
fn departure_deg(angle: Angle, truth: f64) -> f64 {
    let turns = f64::from(angle.bits()) / 4_294_967_296.0 - truth / TURN;
    360.0 * (turns - turns.round())
}

type Sensor = fn(f64, &mut Noise) -> Position;
const SENSORS: [Sensor; 2] = [converter, resolver];

#[test]
fn the_gains_place_the_poles() {
    for (bandwidth_hz, damping) in [(5.0_f32, 0.5_f32), (300.0, 0.707), (1000.0, 1.0)] {
        let constants = TrackingConstants { bandwidth_hz, damping, ..CONSTANTS };
        let [k1, k2] = constants.gains(RATE_HZ as f32).map(f64::from);
        let (z, u) = (f64::from(damping), 1.0 + 2.0 * f64::from(damping).powi(2));
        let turn = TURN * f64::from(bandwidth_hz) / RATE_HZ / (u + (u * u + 1.0).sqrt()).sqrt();
        let (sum, product) = (2.0 * (-z * turn).exp() * (turn * (1.0 - z * z).sqrt()).cos(), (-2.0 * z * turn).exp());
        // z² − (2 − K₁) z + 1 − K₁ + K₂
        let (exact1, exact2) = (2.0 - sum, product + 1.0 - sum);
        assert!((k1 / exact1 - 1.0).abs() < 1e-5 && (k2 / exact2 - 1.0).abs() < 1e-5, "{k1} {exact1} {k2} {exact2}");
    }
}

/// Largest and mean departure of the loop's angle, degrees, in the last half of `samples` samples.
fn departures(sensor: Sensor, samples: usize, motion: impl Fn(f64) -> f64) -> (f64, f64, PositionTracker) {
    let (mut tracker, mut noise) = (PositionTracker::new(&CONSTANTS, RATE_HZ as f32), Noise(3));
    let (mut largest, mut sum) = (0.0_f64, 0.0);
    for k in 0..samples {
        let truth = motion(k as f64 / RATE_HZ);
        let tracked = tracker.push(&sensor(truth, &mut noise));
        if k >= samples / 2 {
            let departure = departure_deg(tracked.expect("locked").angle, truth);
            largest = largest.max(departure.abs());
            sum += departure;
        }
    }
    (largest, sum / (samples - samples / 2) as f64, tracker)
}

#[test]
fn at_constant_speed_the_angle_is_within_a_tenth_of_a_degree() {
    for sensor in SENSORS {
        for rpm in [0.0, 10.0, -60.0, 1000.0, -3000.0, 4572.0] {
            let velocity = rpm * TURN / 60.0;
            let (largest, _, tracker) = departures(sensor, 10_000, |t| 1.0 + velocity * t);
            std::println!("{rpm} rpm: {largest:.4}°, velocity {}", tracker.velocity_rad_s());
            assert!(largest <= 0.1, "{rpm} rpm: {largest}°");
            // Noise of 0.001 rad at K₂ = 0.008 moves the velocity by some 0.1 rad/s.
            assert!((f64::from(tracker.velocity_rad_s()) - velocity).abs() < 0.5);
            assert_eq!(tracker.faults(), PositionFaults::default());
        }
    }
}

#[test]
fn under_acceleration_the_angle_lags_by_the_acceleration_constant() {
    for sensor in SENSORS {
        for acceleration in [1000.0, -1000.0] {
            let start = if acceleration > 0.0 { -250.0 } else { 250.0 };
            let (largest, mean, tracker) = departures(sensor, 5000, |t| start * t + 0.5 * acceleration * t * t);
            let lag = -(acceleration / f64::from(tracker.acceleration_constant())).to_degrees();
            std::println!("{acceleration} rad/s²: largest {largest:.4}°, mean {mean:.4}°, α/Ka {lag:.4}°");
            assert!(largest <= 0.5, "{largest}°");
            // The converter floors: half a count is 0.011°.
            assert!((mean - lag).abs() < 0.015, "{mean} {lag}");
        }
    }
}

#[test]
fn the_angle_alone_moves_the_quadrature_current_by_a_fifth_of_a_percent_at_most() {
    let frame = RotorFrame { pole_pairs: 6, electrical_offset: Angle::ZERO, park: Park::Standard };
    for sensor in SENSORS {
        // From rest to full speed and back at ± 1000 rad/s², a second long.
        let motion = |t: f64| if t < 0.45 { 500.0 * t * t } else { 450.0 * t - 500.0 * (t - 0.45).powi(2) - 101.25 };
        let (mut tracker, mut noise, mut sum) = (PositionTracker::new(&CONSTANTS, RATE_HZ as f32), Noise(3), 0.0);
        let samples = 1000_i32..9000;
        for k in 0..samples.end {
            let truth = motion(f64::from(k) / RATE_HZ);
            let Some(tracked) = tracker.push(&sensor(truth, &mut noise)) else { continue };
            // A quadrature current of 10 A in the true frame.
            let (sin, cos) = (6.0 * truth).sin_cos();
            let stationary = AlphaBeta { alpha: (-10.0 * sin) as f32, beta: (10.0 * cos) as f32, zero: 0.0 };
            let current = frame.transform(stationary, tracked.angle);
            sum += if k < samples.start { 0.0 } else { (f64::from(current.q) - 10.0).powi(2) };
        }
        let part = (sum / samples.len() as f64).sqrt() / 10.0;
        std::println!("quadrature current: {:.3} % rms", 100.0 * part);
        // Lag of the loop: 6 α/Ka, of which the cosine is lost.
        let lost = 1.0 - (6.0 * 1000.0 / f64::from(tracker.gains[1] * RAD * tracker.rate_hz * tracker.rate_hz)).cos();
        assert!(part <= 0.002 && (0.8 * lost..1.3 * lost).contains(&part), "{part} for {lost}");
    }
}

#[test]
fn the_bandwidth_is_where_the_angle_has_lost_three_decibels() {
    for bandwidth_hz in [30.0_f32, 300.0] {
        let mut tracker = PositionTracker::new(&TrackingConstants { bandwidth_hz, ..CONSTANTS }, RATE_HZ as f32);
        let (mut re, mut im) = (0.0, 0.0);
        let period = (RATE_HZ / f64::from(bandwidth_hz)).round();
        for k in 0..20_000 {
            let (sin, cos) = (TURN * f64::from(k) / period).sin_cos();
            let angle = Angle::from_radians((0.01 * sin) as f32);
            if let Some(tracked) = tracker.push(&Position::Absolute(angle))
                && k >= 20_000 - 40 * period as i32
            {
                re += f64::from(tracked.angle.radians()) * sin;
                im += f64::from(tracked.angle.radians()) * cos;
            }
        }
        let gain = re.hypot(im) / (0.01 * 20.0 * period);
        std::println!("gain at {bandwidth_hz} Hz: {gain:.4}");
        // (4) holds for a continuous loop; the zero of the discrete one adds a few percent at 0.03 of the rate.
        assert!((gain - 0.5_f64.sqrt()).abs() < 0.05, "{gain}");
    }
}

#[test]
fn the_loop_locks_from_every_angle_at_every_speed() {
    let mut longest = 0;
    for sensor in SENSORS {
        for start in 0..64 {
            for velocity in [0.0, 50.0, -478.8, 478.8] {
                let (mut tracker, mut noise) = (PositionTracker::new(&CONSTANTS, RATE_HZ as f32), Noise(start + 1));
                let truth = |k: i32| TURN * f64::from(start) / 64.0 + velocity * f64::from(k) / RATE_HZ;
                let locked = (0..200).find(|k| tracker.push(&sensor(truth(*k), &mut noise)).is_some());
                longest = longest.max(locked.expect("locked within 20 ms"));
            }
        }
    }
    std::println!("longest time to lock: {longest} samples");
    // Two samples to find angle and velocity, twenty to settle, and one that is followed.
    assert!((22..=120).contains(&longest));
}

#[test]
fn the_measured_angle_is_the_reading() {
    let mut tracker = PositionTracker::new(&CONSTANTS, RATE_HZ as f32);
    let mut noise = Noise(1);
    for k in 0..2000_u32 {
        let reading = Angle::from_bits(k.wrapping_mul(3_000_000)).turned((5e6 * noise.next()) as i32);
        if let Some(tracked) = tracker.push(&Position::Absolute(reading)) {
            // The error has 24 bits of at most 2²³ counts.
            assert!(tracked.measured().since(reading).abs() <= 2);
        }
    }
    assert_eq!(tracker.lock(), Lock::Locked);
}

#[test]
fn one_wrong_reading_costs_one_sample() {
    let (mut tracker, mut noise) = (PositionTracker::new(&CONSTANTS, RATE_HZ as f32), Noise(9));
    for k in 0..3000 {
        let truth = 200.0 * f64::from(k) / RATE_HZ;
        let wrong = k >= 1000 && k % 100 == 0;
        let tracked = tracker.push(&converter(if wrong { truth + 2.0 } else { truth }, &mut noise));
        assert_eq!(tracked.is_some(), k >= 22 && !wrong, "sample {k}");
        assert!(tracked.is_none_or(|tracked| departure_deg(tracked.angle, truth).abs() < 0.1));
    }
    assert_eq!((tracker.faults().strayed, tracker.faults().losses), (20, 0));
}

#[test]
fn after_a_lost_sample_an_error_of_half_the_limit_strays() {
    // A step of 0.08 rad without a lost sample before it is followed, as a slip.
    for (lost, error_rad, followed) in [(false, 0.08, false), (true, 0.08, false), (true, 0.04, true)] {
        let (mut tracker, mut noise) = (PositionTracker::new(&CONSTANTS, RATE_HZ as f32), Noise(7));
        (0..100).for_each(|_| _ = tracker.push(&converter(1.0, &mut noise)));
        if lost {
            assert!(tracker.push(&Position::Missing).is_none());
        }
        let tracked = tracker.push(&converter(1.0 + error_rad, &mut noise));
        let PositionFaults { strayed, slipped, .. } = tracker.faults();
        assert_eq!(tracked.is_some(), followed, "{error_rad}");
        assert_eq!((strayed, slipped), (u32::from(lost && !followed), u32::from(!lost)), "{error_rad}");
    }
}

#[test]
fn a_wrong_first_reading_costs_few_samples() {
    // Two readings give a velocity, here one of up to half a turn a sample that the shaft does not have.
    let mut longest = 0;
    for sensor in SENSORS {
        for wrong in 0..64 {
            let (mut tracker, mut noise) = (PositionTracker::new(&CONSTANTS, RATE_HZ as f32), Noise(5));
            let wrong_reading = sensor(TURN * f64::from(wrong) / 64.0, &mut noise);
            let locked = (0..20_000).position(|k| {
                let reading = if k == 0 { wrong_reading } else { sensor(0.03 * f64::from(k), &mut noise) };
                tracker.push(&reading).is_some()
            });
            longest = longest.max(locked.expect("locked within 2 s"));
        }
    }
    std::println!("longest time to lock after a wrong first reading: {longest} samples");
    assert!((22..=150).contains(&longest), "{longest}");
}

#[test]
fn a_short_loss_is_bridged_and_a_long_one_found_again() {
    for (lost, losses) in [(19, 0), (20, 1), (3000, 1)] {
        let (mut tracker, mut noise) = (PositionTracker::new(&CONSTANTS, RATE_HZ as f32), Noise(4));
        let mut missing = 0;
        for k in 0..6000 {
            let t = f64::from(k) / RATE_HZ;
            let truth = 300.0 * t + 0.5 * (30.0 * t).sin();
            let position = match (k - 2000, k % 2) {
                (0.., 0) if k < 2000 + lost => Position::Resolver { sin: 0.1, cos: f32::NAN },
                (0.., _) if k < 2000 + lost => Position::Missing,
                _ => resolver(truth, &mut noise),
            };
            match tracker.push(&position) {
                Some(tracked) if k >= 100 => assert!(departure_deg(tracked.angle, truth).abs() < 0.5, "sample {k}"),
                None if k >= 100 => missing += 1,
                _ => {}
            }
        }
        let faults = tracker.faults();
        std::println!("{lost} samples lost: {missing} missing, {faults:?}");
        assert_eq!((faults.losses, tracker.lock()), (losses, Lock::Locked));
        assert_eq!(faults.missing + faults.resolver.lost, lost as u32);
        assert!(missing >= lost && missing <= lost + 100 * losses as i32, "{missing}");
        tracker.clear_faults();
        assert_eq!(tracker.faults(), PositionFaults::default());
    }
}

#[test]
fn samples_that_were_never_taken_are_passed_at_the_same_velocity() {
    for (gap, losses) in [(15, 0), (25, 1)] {
        let (mut tracker, mut noise) = (PositionTracker::new(&CONSTANTS, RATE_HZ as f32), Noise(4));
        let mut worst = 0.0_f64;
        for k in (0..2000).chain(2000 + gap..4000) {
            if k == 2000 + gap {
                tracker.skip(gap as u32);
            }
            let truth = 400.0 * f64::from(k) / RATE_HZ;
            if let Some(tracked) = tracker.push(&converter(truth, &mut noise)) {
                worst = if k > 100 { worst.max(departure_deg(tracked.angle, truth).abs()) } else { 0.0 };
            }
        }
        assert!(worst < 0.15, "{gap}: {worst}°");
        assert_eq!((tracker.faults().losses, tracker.lock()), (losses, Lock::Locked));
    }
}

#[test]
fn an_error_of_half_the_limit_settles_and_more_starts_to_settle_anew() {
    let mut tracker = PositionTracker::new(&CONSTANTS, RATE_HZ as f32);
    tracker.lock = Lock::Settling(5);
    let half = 0.5 * CONSTANTS.error_limit_rad;
    for (error, left) in [(half, 4), (-half, 3), (1.01 * half, 20), (half, 19)] {
        tracker.settle(error);
        assert_eq!(tracker.lock(), Lock::Settling(left), "{error}");
    }
}

/// A loop after two readings, from this angle and velocity as `libm::atan2f` gives them.
fn started_by_libm(readings: [&Position; 2], tracker: &PositionTracker) -> PositionTracker {
    let [first, second] = readings.map(|position| match *position {
        Position::Resolver { sin, cos } => Angle::from_radians(libm::atan2f(sin, cos)),
        _ => unreachable!("a resolver"),
    });
    let velocity = second.since(first);
    PositionTracker { angle: second.turned(velocity), velocity, ..tracker.clone() }
}

#[test]
fn the_start_of_a_resolver_is_that_of_a_full_arctangent() {
    let (mut loops, mut measured) = (0.0_f64, 0.0_f64);
    let rad = |counts: i32| (TURN * f64::from(counts) / 4_294_967_296.0).abs();
    for start in 0..256_u32 {
        for velocity in [0.0, 1.0, -50.0, 300.0, -478.8, 2000.0] {
            let mut noise = Noise(start + 1);
            let truth = |k: i32| TURN * f64::from(start) / 256.0 + velocity * f64::from(k) / RATE_HZ;
            let readings = core::array::from_fn::<_, 200, _>(|k| resolver(truth(k as i32), &mut noise));
            let [first, second, rest @ ..] = &readings;
            let mut coarse = PositionTracker::new(&CONSTANTS, RATE_HZ as f32);
            assert!(coarse.push(first).is_none() && coarse.push(second).is_none());
            let mut exact = started_by_libm([first, second], &coarse);
            for position in rest {
                let both = (coarse.push(position), exact.push(position));
                assert_eq!(coarse.lock(), exact.lock(), "{start} {velocity}");
                if let (Some(coarse), Some(exact)) = both {
                    loops = loops.max(rad(coarse.angle.since(exact.angle)));
                    measured = measured.max(rad(coarse.measured().since(exact.measured())));
                }
            }
            assert_eq!(coarse.lock(), Lock::Locked);
        }
    }
    std::println!("once locked: angle of the loop within {loops:.1e} rad, measured angle within {measured:.1e} rad");
    // An angle of 24 bits and two sines within 2e-7 make a reading uncertain by some 5e-7 rad, and the velocity, which
    // the loop adds up for a few samples, by twice that. Two coarse angles would move it by up to 5e-3 rad a sample.
    assert!((1e-7..=4e-6).contains(&loops), "{loops}");
    // The error (1) of the one angle has other roundings than that of the other: each has two sines within 2e-7.
    assert!((1e-8..=4e-7).contains(&measured), "{measured}");
}

/// Readings of 100 rad/s, as `change` leaves them; the number of those that the loop gives back behind the first 100.
fn steady(rad_s: f64, change: impl Fn(usize, f64) -> f64) -> (usize, PositionFaults) {
    let (mut tracker, mut noise) = (PositionTracker::new(&CONSTANTS, RATE_HZ as f32), Noise(11));
    let mut given = 0;
    for k in 0..10_340 {
        let reading = converter(change(k, rad_s * k as f64 / RATE_HZ), &mut noise);
        given += usize::from(tracker.push(&reading).is_some() && k >= 100);
    }
    (given, tracker.faults())
}

#[test]
fn a_steady_angle_has_no_fault_at_any_speed() {
    for rad_s in [0.0, 3.0, 40.0, 400.0, -90.0] {
        assert_eq!(steady(rad_s, |_, truth| truth), (10_240, PositionFaults::default()), "{rad_s}");
    }
    // To and fro, through rest.
    let swing = |k: usize, _| 2.0 * (30.0 * k as f64 / RATE_HZ).sin();
    assert_eq!(steady(0.0, swing), (10_240, PositionFaults::default()));
}

#[test]
fn readings_that_repeat_while_the_shaft_turns_are_missing() {
    for length in [1, 3, 10] {
        let (mut tracker, mut noise) = (PositionTracker::new(&CONSTANTS, RATE_HZ as f32), Noise(12));
        let (mut held, mut wrong) = (Position::Missing, 0);
        for k in 0..10_000_usize {
            let truth = 70.0 * k as f64 / RATE_HZ;
            let fresh = converter(truth, &mut noise);
            let stale = k >= 1000 && k % 100 < length;
            held = if stale { held } else { fresh };
            let tracked = tracker.push(&held);
            assert_eq!(tracked.is_some(), k >= 22 && !stale, "sample {k}");
            wrong += usize::from(tracked.is_some_and(|tracked| departure_deg(tracked.measured(), truth).abs() > 0.05));
        }
        // The loop goes on at its velocity. 14 bits and a count of noise are 0.044°.
        assert_eq!((wrong, tracker.faults().stale), (0, 90 * length as u32), "{length}");
        assert_eq!(tracker.faults().slipped, 0);
    }
}

#[test]
fn a_shaft_that_stops_is_found_again() {
    // From 400 rad/s within a sample.
    let (given, faults) = steady(400.0, |k, truth| truth.min(400.0 * 0.5).min(if k < 5000 { truth } else { 200.0 }));
    assert!(faults.stale < 25 && faults.losses <= 1 && given > 10_150, "{given} {faults:?}");
}

#[test]
fn a_slip_is_counted_and_costs_one_sample() {
    let slip = |k: usize, truth: f64| truth + TURN / 80.0 * (k / 2000).min(4) as f64;
    for rad_s in [0.0, 100.0, -100.0] {
        let (given, faults) = steady(rad_s, slip);
        assert_eq!((given, faults.slipped, faults.strayed, faults.losses), (10_236, 4, 0, 0), "{rad_s}");
    }
    // 0.02 rad are below a quarter of the limit.
    let small = |k: usize, truth: f64| truth + if k < 5000 { 0.0 } else { 0.02 };
    assert_eq!(steady(100.0, small).1, PositionFaults::default());
}

#[test]
fn angles_at_unequal_times_make_windows_unsteady() {
    let jitter = |part: f64, rad_s: f64| {
        let scattered = move |k: usize, truth: f64| {
            let state = (k as u32 ^ 0x5bd1).wrapping_mul(0x7feb_352d);
            let uniform = f64::from((state ^ state >> 15).wrapping_mul(0x846c_a68b)) / 2_147_483_648.0 - 1.0;
            truth + part * uniform * rad_s / RATE_HZ
        };
        steady(rad_s, scattered).1.unsteady_windows
    };
    // 0.6 uniform are 0.35 of an interval rms; of ten windows, the first may contain the search. At 3 rad/s the
    // quantisation is larger.
    assert!(jitter(0.6, 100.0) >= 9, "{}", jitter(0.6, 100.0));
    assert_eq!([jitter(0.1, 100.0), jitter(0.6, 3.0)], [0, 0]);
}
