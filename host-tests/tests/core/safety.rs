//! Times after which the front end has named a fault, as `book/src/faults.md` promises them.

use std::fs;
use std::path::Path;

use bearing_watch::drive::FrontEnd;

use super::drive_faults::actuator::{FURTHER, MODEL};
use super::drive_faults::{FAULTS, constants, raw, trace};

/// Rows at which faults start: in motion and near a reversal.
const STARTS: [usize; 6] = [30_000, 37_777, 41_234, 52_345, 61_111, 70_003];
/// Control interval, ms.
const INTERVAL_MS: f64 = 0.1;

/// Cells of the row of a table that starts with `name`.
fn row(document: &str, name: &str) -> Vec<String> {
    let line = document.lines().find(|line| line.starts_with(&format!("| {name} |")));
    let line = line.unwrap_or_else(|| panic!("book/src/faults.md has no row {name}"));
    line.trim_matches('|').split('|').map(|cell| cell.trim().to_owned()).collect()
}

fn document() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../book/src/faults.md");
    let text = fs::read_to_string(path).expect("book/src/faults.md");
    let (_, tables) = text.split_once("## Faults with their times").expect("the heading");
    tables.to_owned()
}

#[test]
fn faults_are_named_within_the_documented_times() {
    let document = document();
    let traces = [trace(0xfa27, 0.025), trace(0xfa28, 0.035)];
    for fault in &FAULTS {
        let mut longest_ms = 0.0_f64;
        for trace in &traces {
            let constants = constants(trace);
            for start in STARTS {
                let mut front_end = FrontEnd::<FURTHER, 10>::new(&constants).expect("good constants");
                let rows = (0..trace.len()).find(|k| {
                    let mut sample = raw(trace, *k);
                    if *k >= start && !(fault.inject)(&mut sample, (k - start) as u32) {
                        return false;
                    }
                    let _clean = front_end.push(&sample);
                    *k >= start && (fault.named)(&front_end.faults())
                });
                let rows = rows.unwrap_or_else(|| panic!("{} is not named", fault.name)) - start + 1;
                longest_ms = longest_ms.max(rows as f64 * INTERVAL_MS);
            }
        }
        println!("{}: {longest_ms:.1} ms", fault.name);
        let cells = row(&document, fault.name);
        let promised_ms: f64 = cells[1].trim_end_matches(" ms").parse().expect("a time");
        // The document has the next larger one of round times.
        let fits = longest_ms <= promised_ms && promised_ms <= (2.5 * longest_ms).max(0.5);
        assert!(fits, "{}: {longest_ms} ms, book/src/faults.md has {promised_ms} ms", fault.name);
    }
}

#[test]
fn times_of_the_constants_are_documented() {
    let (document, sampling) = (document(), MODEL.constants().sampling);
    let constants = constants(&trace(0xfa27, 0.025));
    let milliseconds = |samples: u16| format!("{} ms", f64::from(samples) * INTERVAL_MS);
    let segment_s = f64::from(sampling.segment_samples) * f64::from(sampling.interval_s);
    for (name, expected) in [
        ("a segment", format!("{segment_s:.1} s")),
        ("samples of a stuck converter", milliseconds(constants.stuck_samples)),
        ("a window of the sum of the currents", milliseconds(constants.balance.window)),
        ("missing positions until the lock is lost", milliseconds(constants.tracking.lost_samples)),
        ("good positions until it is there again", milliseconds(constants.tracking.settle_samples)),
    ] {
        assert_eq!(row(&document, name)[2], expected, "{name}");
    }
}
