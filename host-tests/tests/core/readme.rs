//! The firmware code of README.md, compiled as it stands there, and the object that it calls, on recordings of the
//! simulated actuator.

use bearing_watch::Monitor;
use bearing_watch::drive::{CleanSample, RawSample};
use bearing_watch::watch::Watch;
use host_tests::halves::Interrupt;
use rig::ema::{EmaCondition, EmaDefect, EmaScenario, EmaTrace, Race, simulate};
use rig::{DefectKind, trace_seed};

#[allow(dead_code, reason = "what `train` writes is for other programs, too")]
#[path = "../../../examples/support/actuator/model.rs"]
mod model;

mod monitor {
    include!(concat!(env!("OUT_DIR"), "/readme.rs"));
}

use model::{Drive, DriveFrontEnd, FRONT_END, FURTHER, MODEL, Reading};

/// Rows at 10 kHz that one segment takes: 2.4 s.
const SEGMENT_ROWS: usize = 24_000;

#[test]
fn counts_become_the_verdict_of_the_recording() {
    // As `replay` says of the same traces.
    for (kind, name, alarm) in [
        (DefectKind::Healthy, "healthy", false),
        (DefectKind::Spall, "spall", true),
        (DefectKind::Roughness, "roughness", true),
    ] {
        assert_eq!(verdicts(kind), [(name.to_owned(), false), (name.to_owned(), alarm)]);
    }
}

#[test]
fn the_code_of_the_readme_raises_the_alarm_of_the_book() {
    monitor::start().expect("constants of the example");
    let mut alarms = Vec::new();
    for reading in readings(&recording(DefectKind::Spall)) {
        if monitor::current_loop(reading) {
            monitor::below();
        }
        alarms.extend(monitor::main_loop());
    }
    assert_eq!(alarms, [false, true]);
}

/// Firmware rows = replay rows, bit for bit, whenever the drive starts, with a lower interrupt that comes late.
#[test]
fn the_rows_of_the_drive_are_those_of_its_recording_from_any_instant_on() {
    let recorded: Vec<Reading> = readings(&recording(DefectKind::Spall)).collect();
    for start in [0, 1, 7, 500, 12_345] {
        let watch: &'static Watch<Drive, DriveFrontEnd> = Box::leak(Box::default());
        watch.start(&MODEL, &FRONT_END).expect("constants of the example");
        let mut front_end = DriveFrontEnd::new(&FRONT_END).expect("constants of the example");
        let (mut interrupt, mut alone) = (Interrupt::new(&MODEL), Monitor::new(&MODEL));
        let (mut expected, mut reports) = (Vec::new(), Vec::new());
        for (k, reading) in recorded[start..].iter().enumerate() {
            let _collected_below = watch.sample(*reading);
            if k % 29 == 0 {
                watch.collect();
            }
            reports.extend(watch.advance(|now| now.report.clone()));
            let clean: Option<CleanSample<FURTHER>> = front_end.push(&RawSample::from(*reading));
            if let Some(mut segment) = clean.and_then(|clean| interrupt.collect(&clean.into())) {
                alone.take_from(&mut segment);
                expected.push(alone.complete().expect("a segment").report.clone());
            }
        }
        assert!(!expected.is_empty() && reports == expected, "from {start}: {} {}", reports.len(), expected.len());
    }
}

/// The classes of the segments of a recording whose seed is not that of training, and whether there is an alarm.
fn verdicts(kind: DefectKind) -> Vec<(String, bool)> {
    let watch: &'static Watch<Drive, DriveFrontEnd> = Box::leak(Box::default());
    watch.start(&MODEL, &FRONT_END).expect("constants of the example");
    let mut told = Vec::new();
    for reading in readings(&recording(kind)) {
        if watch.sample(reading) {
            watch.collect();
        }
        let tell = |now: bearing_watch::Conclusion<'_, Drive>| {
            (MODEL.verdict_name(now.report.verdict).to_owned(), now.alarm.is_some())
        };
        told.extend(watch.advance(tell));
    }
    let faults = watch.status().faults.expect("those of the last segment");
    assert!(faults.is_clear(), "{faults:?}");
    told
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
        position: Some(position[row] as u32),
        load_torque_nm: load[row] as f32,
        velocity_ref_rad_s: velocity[row] as f32,
    })
}
