//! Two motors on one chip, each with a model of its own: one gives raw counts to a front end, the other one has signals
//! of its own.
//!
//! ```text
//! current loop of the first    WATCH of the actuator   sample, collect ─┐
//! current loop of the second   WATCH of the rig        sample, collect ─┼─► main loop: advance of both
//! ```
//!
//! Each model is a module that `bearing-watch train --rust` wrote, with its static `WATCH`: nothing is shared. The
//! second motor repeats recorded traces of the standard rig; the first one turns without a load. The program prints the
//! same lines on the host and on a board.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
mod support;

#[allow(dead_code, reason = "the recording has no further channels")]
#[path = "support/actuator/model.rs"]
mod actuator;
#[path = "support/standard_rig/mod.rs"]
mod standard_rig;

use bearing_watch::Angle;
use bearing_watch::watch::StartError;

use standard_rig::model as rig;

main!(run);

/// Readings of the first motor, at 10 kHz, in an interval of the second one.
const READINGS: u32 = 20;

fn run() {
    if let Err(error) = start() {
        return say!("start: {error}");
    }
    let mut number = 0;
    for sample in standard_rig::samples().take(5000) {
        // The interrupts of both current loops.
        for _ in 0..READINGS {
            if actuator::WATCH.sample(reading(number)) {
                actuator::WATCH.collect();
            }
            number += 1;
        }
        rig::WATCH.sample(sample);
        rig::WATCH.collect();
        main_loop();
    }
    (0..99).for_each(|_| main_loop());
    say!("{} and {} samples", actuator::WATCH.status().rows, rig::WATCH.status().rows);
}

fn start() -> Result<(), StartError> {
    actuator::WATCH.start(&actuator::MODEL, &actuator::FRONT_END)?;
    rig::WATCH.start(&rig::MODEL)
}

/// One step for each motor.
fn main_loop() {
    actuator::WATCH.advance(|now| {
        let verdict = actuator::MODEL.verdict_name(now.report.verdict);
        say!("first motor: {verdict}, {} rows, alarm: {}", now.report.rows, now.alarm.is_some());
    });
    rig::WATCH.advance(|now| {
        let verdict = rig::MODEL.verdict_name(now.report.verdict);
        say!("second motor: {verdict}, {} rows, alarm: {}", now.report.rows, now.alarm.is_some());
    });
}

/// What the converters of the first motor read: a turn in 1.4 s, and a current of 10 A that turns with it.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "counts of 12 bits")]
fn reading(number: u32) -> actuator::Reading {
    let shaft = Angle::from_bits(number.wrapping_mul(300_000));
    let turn = shaft.times(actuator::FRONT_END.frame.pole_pairs).sin_cos();
    let [b, c] = [0.866_025_4, -0.866_025_4].map(|half_root| 0.5 * turn.sin + half_root * turn.cos);
    let phases = [-turn.sin, b, c].map(|unit| (2048.0 + 400.0 * unit) as u16);
    let velocity_ref_rad_s = 4.4;
    actuator::Reading { number, phases, position: Some(shaft.bits() >> 18), load_torque_nm: 0.0, velocity_ref_rad_s }
}
