//! Faults of the drive's electronics, injected into the raw counts of the drive of the examples.

use bearing_watch::Angle;
use bearing_watch::drive::{
    BalanceLimits, Faults, FrontEndConstants, Imbalance, Phase, PhaseCounts, Position, RawSample,
};
use rig::ema::{EmaScenario, EmaTrace, simulate};

/// Written by `bearing-watch train --front-end … --rust`.
#[allow(dead_code, reason = "the position is made here")]
pub mod actuator {
    include!("../../../../examples/support/actuator/model.rs");
}
use actuator::{FRONT_END, FURTHER, position};

/// A raw sample of the drive.
pub type Raw = RawSample<FURTHER>;

/// Rows of a record, one a control interval of 0.1 ms: four segments and a half.
pub const ROWS: usize = 112_000;
/// Counts at no current.
pub const ZERO: u16 = 2048;
/// A fault in the row with this number, which is counted from the start of the fault. `false` takes the row away.
pub type Inject = fn(&mut Raw, u32) -> bool;

/// A fault of the electronics.
#[derive(Clone, Copy, Debug)]
pub struct Fault {
    pub name: &'static str,
    pub inject: Inject,
    /// Whether the front end has named it.
    pub named: fn(&Faults) -> bool,
}

/// A number that hardly depends on the one before, of 32 bits.
pub fn scattered(k: u32) -> u32 {
    let mixed = (k ^ k >> 16).wrapping_mul(0x7feb_352d);
    let mixed = (mixed ^ mixed >> 15).wrapping_mul(0x846c_a68b);
    mixed ^ mixed >> 16
}

/// The counts of a sample with three.
pub fn counts(raw: &mut Raw) -> &mut [u16; 3] {
    match &mut raw.currents {
        PhaseCounts::Three(counts) => counts,
        PhaseCounts::Quadrature(_) | PhaseCounts::Two(_) => panic!("three sensors"),
    }
}

/// Counts of a current `scale` times as large.
fn scaled(counts: u16, scale: f32) -> u16 {
    (f32::from(ZERO) + scale * (f32::from(counts) - f32::from(ZERO))).round() as u16
}

/// 1/512 turn, 12 mrad: below the steps that are slips.
const STUCK_BIT: u32 = 1 << 23;
/// The faults.
pub const FAULTS: [Fault; 11] = [
    Fault {
        name: "phase c open",
        inject: |raw, k| {
            let [a, b, c] = counts(raw);
            let half = (i32::from(*a) - i32::from(*b)) / 2;
            let around = |by: i32| (i32::from(ZERO) + by) as u16;
            (*a, *b, *c) = (around(half), around(-half), around((scattered(k) % 7) as i32 - 3));
            true
        },
        named: |faults| matches!(faults.imbalance, Some(Imbalance::Open(Phase::C) | Imbalance::Silent(Phase::C))),
    },
    Fault {
        name: "gain of phase b + 20 %",
        inject: |raw, _| {
            let [_, b, _] = counts(raw);
            *b = scaled(*b, 1.2);
            true
        },
        named: |faults| matches!(faults.imbalance, Some(Imbalance::Gain { phase: Phase::B, error }) if (error - 0.2).abs() < 0.02),
    },
    Fault {
        name: "no reading of the converter",
        inject: |raw, _| {
            raw.position = Position::Missing;
            true
        },
        named: |faults| faults.position.missing > 0 && faults.position.losses > 0,
    },
    Fault {
        name: "resolver without excitation",
        inject: |raw, k| {
            raw.position = Position::Resolver { sin: 0.01, cos: 0.001 * (k % 7) as f32 };
            true
        },
        named: |faults| faults.position.resolver.lost > 0 && faults.position.losses > 0,
    },
    Fault {
        name: "converter of phase a stuck",
        inject: |raw, _| {
            counts(raw)[0] = 2100;
            true
        },
        named: |faults| faults.currents[0].stuck > 0,
    },
    Fault {
        name: "converter of phase a saturated",
        inject: |raw, _| {
            counts(raw)[0] = 4095;
            true
        },
        named: |faults| faults.currents[0].saturated > 0,
    },
    Fault {
        name: "bursts in the currents",
        inject: |raw, k| {
            if k % 100 < 5 {
                let bits = scattered(k);
                *counts(raw) = [bits & 0xfff, bits >> 8 & 0xfff, bits >> 16 & 0xfff].map(|bits| bits as u16);
            }
            true
        },
        named: |faults| faults.unbalanced_windows > 0 || faults.currents.iter().any(|phase| phase.saturated > 0),
    },
    Fault {
        name: "bursts in the angle",
        inject: |raw, k| {
            if k % 100 < 5 {
                raw.position = Position::Absolute(Angle::from_bits(scattered(k)));
            }
            true
        },
        named: |faults| faults.position.strayed > 0,
    },
    Fault {
        name: "phase b without negative half waves",
        inject: |raw, _| {
            let [_, b, _] = counts(raw);
            *b = (*b).max(ZERO);
            true
        },
        named: |faults| faults.imbalance == Some(Imbalance::HalfWave(Phase::B)),
    },
    Fault {
        name: "a bit of the angle always set",
        inject: |raw, _| {
            if let Position::Absolute(angle) = raw.position {
                raw.position = Position::Absolute(Angle::from_bits(angle.bits() | STUCK_BIT));
            }
            true
        },
        named: |faults| faults.position.stuck_bits == STUCK_BIT,
    },
    Fault { name: "missed interrupts", inject: |_, k| k % 2000 >= 30, named: |faults| faults.gaps > 0 },
];

/// A record of a healthy actuator with a seed that its model was not trained with.
pub fn trace(seed: u64, amplitude_m: f64) -> EmaTrace {
    simulate(&EmaScenario { rows: ROWS, amplitude_m, ..EmaScenario::RIT }, seed).expect("simulates")
}

/// The front end with calibrated offsets, so that only the noise of the three sensors is left in their sum.
pub fn constants(trace: &EmaTrace) -> FrontEndConstants {
    let mut own = FrontEndConstants { stuck_samples: 200, ..FRONT_END };
    // Three sensors with a noise of 0.25 A.
    own.balance = BalanceLimits { noise_a: 0.45, offset_a: 0.9, gain_tolerance: 0.02, window: 128 };
    let phases = [&trace.phase_a_a, &trace.phase_b_a, &trace.phase_c_a];
    for (sensor, phase) in own.sensors.iter_mut().zip(phases) {
        sensor.offset_counts = f32::from(ZERO) + phase.iter().sum::<f64>() as f32 / phase.len() as f32 / 0.025;
    }
    own
}

pub fn raw(trace: &EmaTrace, k: usize) -> Raw {
    let counts = |current_a: f64| (f64::from(ZERO) + current_a / 0.025).round() as u16;
    RawSample {
        number: k as u32,
        currents: PhaseCounts::Three([trace.phase_a_a[k], trace.phase_b_a[k], trace.phase_c_a[k]].map(counts)),
        position: position(trace.resolver_counts[k]),
        further: [trace.load_torque_nm[k] as f32, trace.velocity_ref_rad_s[k] as f32],
    }
}
