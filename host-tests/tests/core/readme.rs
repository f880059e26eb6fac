//! The firmware code of README.md and that of the book, compiled as they stand there and run on recordings of the
//! simulated actuator.

use bearing_watch::drive::{PhaseCounts, RawSample};
use bearing_watch::{Detector, Monitor, Segment};
use rig::ema::{EmaCondition, EmaDefect, EmaScenario, EmaTrace, Race, simulate};
use rig::{DefectKind, trace_seed};

#[path = "../../../examples/support/actuator/model.rs"]
mod model;

/// The code that the book includes.
#[path = "../../../template/src/detector.rs"]
mod detector;

mod monitor {
    include!(concat!(env!("OUT_DIR"), "/readme.rs"));
}

use detector::{Place, Reading, interrupt, name, start, test};
use model::{DriveFrontEnd, FRONT_END, FURTHER, MODEL, position};

/// Rows at 10 kHz that one segment takes: 2.4 s.
const SEGMENT_ROWS: usize = 24_000;

#[test]
fn counts_become_the_verdict_of_the_recording() {
    // As `replay` says of the same traces.
    assert_eq!(verdicts(DefectKind::Healthy), [("healthy", false), ("healthy", false)]);
    assert_eq!(verdicts(DefectKind::Spall), [("spall", false), ("spall", true)]);
    assert_eq!(verdicts(DefectKind::Roughness), [("roughness", false), ("roughness", true)]);
}

#[test]
fn the_code_of_the_readme_gives_the_alarms_of_the_book() {
    for kind in [DefectKind::Healthy, DefectKind::Spall] {
        let mut inputs = DriveFrontEnd::new(&FRONT_END).expect("constants of the example");
        let (mut detector, mut main_loop) = (Detector::new(&MODEL), Monitor::new(&MODEL));
        let mut alarms = Vec::new();
        for reading in readings(&recording(kind)) {
            if let Some(segment) = monitor::interrupt(&mut inputs, &mut detector, &raw(&reading)) {
                alarms.push(monitor::conclude(&mut main_loop, segment));
            }
        }
        let expected: Vec<bool> = verdicts(kind).into_iter().map(|(_, alarm)| alarm).collect();
        assert_eq!(alarms, expected, "{kind:?}");
    }
}

fn raw(reading: &Reading) -> RawSample<FURTHER> {
    RawSample {
        number: reading.number,
        currents: PhaseCounts::Three(reading.phases),
        position: position(reading.position.into()),
        further: [reading.load_torque_nm, reading.velocity_ref_rad_s],
    }
}

/// The classes of the segments of a recording whose seed is not that of training, and whether there is an alarm.
fn verdicts(kind: DefectKind) -> Vec<(&'static str, bool)> {
    test().expect("the arithmetic of a host");
    let place = || -> Place { Box::leak(Box::new(Segment::new(&MODEL))) };
    let (mut sampler, mut monitor) = start(place(), place()).expect("constants of the example");
    let mut found = Vec::new();
    for reading in readings(&recording(kind)) {
        if let Some(place) = interrupt(&mut sampler, &reading) {
            let now = monitor.conclude_from(place);
            sampler.spare = Some(place);
            sampler.detector.adopt(now.report);
            found.push((name(now.report.verdict), now.alarm.is_some()));
        }
    }
    assert!(sampler.front_end.faults().is_clear(), "{:?}", sampler.front_end.faults());
    found
}

fn recording(kind: DefectKind) -> EmaTrace {
    let seed = trace_seed(2, kind, 0);
    let scenario = EmaCondition::named("rit-mix").expect("a known condition").scenario(seed);
    let defect = EmaDefect::of(kind, 1.0, Race::Inner);
    simulate(&EmaScenario { rows: 2 * SEGMENT_ROWS + 1_000, defect, ..scenario }, seed).expect("a valid scenario")
}

/// What the converters of the drive read.
fn readings(trace: &EmaTrace) -> impl Iterator<Item = Reading> {
    const { assert!(FURTHER == 2) };
    let columns = trace.recorded();
    let column = move |name: &str| {
        let found = columns.iter().find(|(column, _)| *column == name);
        found.map(|(_, values)| values.clone()).unwrap_or_else(|| panic!("no column {name}"))
    };
    let phases = ["phase_a_a", "phase_b_a", "phase_c_a"].map(&column);
    let [position, load, velocity] = ["resolver_counts", "load_torque_nm", "velocity_ref_rad_s"].map(&column);
    (0..position.len()).map(move |row| Reading {
        number: row as u32,
        phases: core::array::from_fn(|k| {
            let sensor = &FRONT_END.sensors[k];
            (phases[k][row] as f32 / sensor.gain_a + sensor.offset_counts).round() as u16
        }),
        position: position[row] as u16,
        load_torque_nm: load[row] as f32,
        velocity_ref_rad_s: velocity[row] as f32,
    })
}
