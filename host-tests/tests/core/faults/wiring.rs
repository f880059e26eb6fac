//! The check of the wiring on the simulated actuator: phase currents and resolver counts through the front end, every
//! fault alone and in pairs.

use std::f64::consts::TAU;

use bearing_watch::Angle;
use bearing_watch::drive::{
    BalanceLimits, FrontEnd, FrontEndConstants, PhaseCounts, PhaseSensor, Position, RawSample, Wiring, WiringCheck,
    WiringFault, WiringLimits,
};
use rig::ema::{EmaScenario, EmaTrace, Logging, simulate};

use super::electronics::actuator::FRONT_END;

/// Control rate of the actuator.
const RATE_HZ: f32 = 12_000.0;
const LIMITS: WiringLimits =
    WiringLimits { least_current_a: 1.0, offset_rad: 0.1, delay_s: 1e-4, velocity_tolerance: 0.1, slowest_rad_s: 20.0 };
/// 16 bits, 5 mA.
const SENSOR: PhaseSensor = PhaseSensor { offset_counts: 32_768.0, gain_a: 0.005, usable: [100, 65_000] };

/// What the drive is told, and how it is wired.
#[derive(Clone, Debug)]
struct Drive {
    constants: FrontEndConstants,
    /// The sensor on each phase.
    phases: [usize; 3],
    angle_reversed: bool,
    /// rad/s of a unit of the velocity.
    velocity: f64,
    /// Samples by which the currents are late.
    late: usize,
}

impl Drive {
    fn right() -> Self {
        let constants = FrontEndConstants {
            control_rate_hz: RATE_HZ,
            sensors: [SENSOR; 3],
            balance: BalanceLimits { noise_a: 1.0, offset_a: 2.0, gain_tolerance: 0.05, window: 320 },
            ..FRONT_END
        };
        Self { constants, phases: [0, 1, 2], angle_reversed: false, velocity: 1.0, late: 0 }
    }

    fn check(&self, trace: &EmaTrace) -> Result<Wiring, WiringFault> {
        let mut front_end = FrontEnd::<0, 8>::new(&self.constants).expect("good constants");
        let mut check = WiringCheck::new(self.constants.frame, self.constants.control_rate_hz, LIMITS);
        let phases = [&trace.phase_a_a, &trace.phase_b_a, &trace.phase_c_a];
        for k in self.late..trace.len() {
            let counts = self.phases.map(|phase| (32_768.0 + phases[phase][k - self.late] / 0.005).round() as u16);
            let angle = Angle::from_counts(trace.resolver_counts[k], 14);
            let angle = if self.angle_reversed { angle.negated() } else { angle };
            let (number, position) = (k as u32, Position::Absolute(angle));
            let raw = RawSample { number, currents: PhaseCounts::Three(counts), position, further: [] };
            let velocity = (trace.velocity_rad_s[k] * self.velocity) as f32;
            front_end.check_wiring(&raw, velocity, &mut check);
        }
        check.conclude()
    }
}

/// A fault: how it is made, and whether a finding names it.
type Fault = (&'static str, fn(&mut Drive), fn(&WiringFault) -> bool);

const ORDER: fn(&WiringFault) -> bool = |fault| match fault {
    WiringFault::PhaseOrder => true,
    WiringFault::PolePairs { fits } => *fits < 0,
    _ => false,
};
const OFFSET: fn(&WiringFault) -> bool = |fault| matches!(fault, WiringFault::Offset { .. });
const RATE: fn(&WiringFault) -> bool = |fault| matches!(fault, WiringFault::RateOrUnit { .. });

const FAULTS: [Fault; 10] = [
    ("two phases exchanged", |drive| drive.phases.swap(1, 2), ORDER),
    ("angle reversed", |drive| drive.angle_reversed = true, |fault| *fault == WiringFault::AngleDirection),
    ("velocity reversed", |drive| drive.velocity *= -1.0, |fault| *fault == WiringFault::VelocityDirection),
    (
        "five pole pairs instead of six",
        |drive| drive.constants.frame.pole_pairs = 5,
        |fault| matches!(fault, WiringFault::PolePairs { fits: 6 | -6 }),
    ),
    ("electrical offset", |drive| drive.constants.frame.electrical_offset = Angle::from_radians(0.4), OFFSET),
    ("all phases one further", |drive| drive.phases.rotate_left(1), OFFSET),
    ("currents late by 0.5 ms", |drive| drive.late = 6, |fault| matches!(fault, WiringFault::Delay { .. })),
    ("half the control rate", |drive| drive.constants.control_rate_hz = 0.5 * RATE_HZ, RATE),
    ("twice the control rate", |drive| drive.constants.control_rate_hz = 2.0 * RATE_HZ, RATE),
    ("velocity in rpm", |drive| drive.velocity *= 60.0 / TAU, RATE),
];

/// A second of the healthy actuator at its control rate.
fn trace(seed: u64) -> EmaTrace {
    let scenario = EmaScenario { logging: Logging { every: 1, hold: 1 }, rows: 12_000, ..EmaScenario::STANDARD };
    simulate(&scenario, seed).expect("simulates")
}

#[test]
fn a_right_wiring_passes() {
    for seed in [3, 4] {
        let wiring = Drive::right().check(&trace(seed)).expect("right");
        println!("{wiring:?}");
        // Noise of 0.25 A a phase takes 0.08 A² of several A², and errors of gain and offset turn the vector by 1 %.
        assert!((0.9..1.01).contains(&wiring.coherence) && wiring.offset_rad.abs() < 0.03, "{wiring:?}");
        let (delay, ratio) = (wiring.delay_s.expect("both ways"), wiring.velocity_ratio.expect("a velocity"));
        assert!(delay.abs() < 5e-5 && (ratio - 1.0).abs() < 0.01, "{wiring:?}");
    }
}

#[test]
fn each_fault_is_named() {
    let trace = trace(5);
    for (name, make, named) in FAULTS {
        let mut drive = Drive::right();
        make(&mut drive);
        let found = drive.check(&trace).expect_err(name);
        println!("{name}: {found:?}");
        assert!(named(&found), "{name}: {found:?}");
    }
}

#[test]
fn a_shaft_at_rest_is_not_passed() {
    let mut trace = trace(6);
    trace.resolver_counts.fill(1000);
    let found = Drive::right().check(&trace);
    assert!(matches!(found, Err(WiringFault::TooLittleMotion { sectors: 0 })), "{found:?}");
}

/// One of the two is named. If two of the three directions are reversed, they agree with each other, and the third is
/// named.
#[test]
fn of_two_faults_one_is_named() {
    let trace = trace(7);
    for (k, (first, make_first, named_first)) in FAULTS.into_iter().enumerate() {
        for (other, (second, make_second, named_second)) in FAULTS.into_iter().enumerate().skip(k + 1) {
            let mut drive = Drive::right();
            make_first(&mut drive);
            make_second(&mut drive);
            let found = drive.check(&trace).expect_err(first);
            let (_, _, third) = FAULTS[3 - (k + other).min(3)];
            let odd = other <= 2 && third(&found);
            assert!(odd || named_first(&found) || named_second(&found), "{first}, {second}: {found:?}");
        }
    }
}
