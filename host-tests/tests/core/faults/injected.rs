//! Faults of the drive's electronics, alone and in pairs, in the raw counts of a healthy actuator: front end, detector
//! and alarm of the drive's example behind them. Times until a fault is named are those of `book/src/faults.md`.

use std::fs;
use std::path::Path;

use bearing_watch::drive::{FrontEnd, FrontEndConstants, Imbalance};
use bearing_watch::{Detector, Evidence, Report, Verdict};
use rig::ema::EmaTrace;

use super::electronics::actuator::{Drive, FURTHER, MODEL};
use super::electronics::{FAULTS, Fault, constants, raw, trace};

/// Rows of a fault.
const LENGTH: usize = 36_000;
/// Rows of a segment.
const SEGMENT: usize = 24_000;

/// What a drive reports of a record.
struct Outcome {
    verdicts: Vec<Verdict>,
    /// Whether each fault was named within a segment.
    named: Vec<bool>,
    alarm: bool,
    withdrawn: usize,
    /// Whether the currents do not turn with the rotor at the end.
    misaligned: bool,
}

fn watch(trace: &EmaTrace, constants: &FrontEndConstants, start: usize, faults: &[&Fault]) -> Outcome {
    let mut front_end = FrontEnd::<FURTHER, 10>::new(constants).expect("good constants");
    let mut detector = Detector::<Drive>::new(&MODEL);
    let mut evidence = Evidence::new(&MODEL);
    let mut outcome =
        Outcome { verdicts: vec![], named: vec![false; faults.len()], alarm: false, withdrawn: 0, misaligned: false };
    let mut started = false;
    // Each report is kept until the next segment has closed.
    let mut held: Option<Report<Drive>> = None;
    let mut judge = |outcome: &mut Outcome, report: Option<Report<Drive>>| {
        let Some(report) = report else { return };
        outcome.alarm |= evidence.observe(report.decision.as_ref()).is_some();
        outcome.verdicts.push(report.verdict);
    };
    for k in 0..trace.len() {
        let mut sample = raw(trace, k);
        let faulty = (start..start + LENGTH).contains(&k);
        let since = k.wrapping_sub(start) as u32;
        if faulty && !faults.iter().all(|fault| (fault.inject)(&mut sample, since)) {
            continue;
        }
        let clean = front_end.push(&sample);
        if faulty && k < start + SEGMENT {
            let found = front_end.faults();
            outcome.named.iter_mut().zip(faults).for_each(|(named, fault)| *named |= (fault.named)(&found));
        }
        let Some(clean) = clean else { continue };
        if clean.found_late {
            outcome.withdrawn += usize::from(detector.is_in_first_half() && held.take().is_some());
            detector.discard();
        }
        started |= clean.velocity_rad_s.is_finite();
        if started && let Some(report) = detector.step(&clean.into()) {
            judge(&mut outcome, held.replace(report));
        }
    }
    judge(&mut outcome, held);
    outcome.misaligned = front_end.faults().imbalance == Some(Imbalance::Misaligned);
    outcome
}

/// Whether a verdict is one that a healthy drive may have: healthy, or none.
fn right(verdict: &Verdict) -> bool {
    matches!(verdict, Verdict::Class(0) | Verdict::Undetermined(_))
}

/// The two records, with rather small and with large currents: 3.4 and 4.8 A rms.
fn traces() -> [EmaTrace; 2] {
    [trace(0xfa17, 0.025), trace(0xfa18, 0.035)]
}

#[test]
fn a_fault_is_named_within_a_segment_and_never_becomes_a_defect() {
    for trace in traces() {
        let constants = constants(&trace);
        let whole = watch(&trace, &constants, 0, &[]);
        assert_eq!(whole.verdicts, [Verdict::Class(0); 4]);
        for fault in &FAULTS {
            // Over a segment, down to 50 ms before its end: what is wrong before it is found is in the next one.
            for start in (24_000..48_000).step_by(4_000).chain([47_900]) {
                let outcome = watch(&trace, &constants, start, &[fault]);
                let Outcome { verdicts, named, alarm, .. } = &outcome;
                assert_eq!(*named, [true], "{} at {start}", fault.name);
                assert!(verdicts.iter().all(right) && !alarm, "{} at {start}: {verdicts:?}", fault.name);
                if start + LENGTH < 3 * SEGMENT {
                    assert_eq!(verdicts.last(), Some(&Verdict::Class(0)), "{} at {start}", fault.name);
                }
                assert_eq!(verdicts.len() + outcome.withdrawn, 4);
            }
        }
    }
}

#[test]
fn of_two_faults_one_is_named_and_they_never_become_a_defect() {
    let mut both = 0;
    for trace in traces() {
        let constants = constants(&trace);
        for (k, one) in FAULTS.iter().enumerate() {
            for other in &FAULTS[k + 1..] {
                for start in [28_000, 36_000, 44_000] {
                    let Outcome { verdicts, named, alarm, .. } = watch(&trace, &constants, start, &[one, other]);
                    let names = format!("{} with {} at {start}", one.name, other.name);
                    assert!(named.contains(&true), "{names}");
                    assert!(verdicts.iter().all(right) && !alarm, "{names}: {verdicts:?}");
                    both += usize::from(named == [true; 2]);
                }
            }
        }
    }
    println!("both named in {both} of {} pairs", 55 * 6);
    // A phase that reads nothing hides its gain, and without an angle the currents are not compared.
    assert!((150..330).contains(&both), "{both}");
}

#[test]
fn wrong_pole_pairs_and_phase_order_have_no_verdict_alone_and_with_any_fault() {
    for trace in traces() {
        let right = constants(&trace);
        for (pole_pairs, order) in [(5, [0, 1, 2]), (7, [0, 1, 2]), (6, [0, 2, 1]), (6, [1, 0, 2])] {
            let mut own = right;
            own.frame.pole_pairs = pole_pairs;
            own.sensors = order.map(|phase| right.sensors[phase]);
            let mut wired = trace.clone();
            let phases = [&trace.phase_a_a, &trace.phase_b_a, &trace.phase_c_a];
            [wired.phase_a_a, wired.phase_b_a, wired.phase_c_a] = order.map(|phase| phases[phase].clone());
            let alone = watch(&wired, &own, 0, &[]);
            let none = alone.verdicts.iter().all(|verdict| matches!(verdict, Verdict::Undetermined(_)));
            assert!(none && alone.misaligned, "{pole_pairs} pole pairs, phases {order:?}: {:?}", alone.verdicts);
            for fault in &FAULTS {
                let Outcome { verdicts, alarm, .. } = watch(&wired, &own, 36_000, &[fault]);
                let none = verdicts.iter().all(|verdict| matches!(verdict, Verdict::Undetermined(_)));
                assert!(none && !alarm, "{} with {pole_pairs}, {order:?}: {verdicts:?}", fault.name);
            }
        }
    }
}

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
