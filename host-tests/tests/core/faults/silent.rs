//! Faults of the electronics that leave signals plausible, on both rigs, healthy and with a spall, with and without a
//! load sensor: none of them leaves a verdict without a flag. The table of the book names these tests.

use std::fs;
use std::path::Path;

use bearing_watch::drive::{Alignment, Imbalance};
use bearing_watch::{Implausible, Reason, Verdict};

use super::electronics::scattered;
use super::rigs::{COUNTS, Clean, Drive, Fault, KINDS, drives, front_end, judge, loaded_record, watch};

/// 1/64 turn.
const SLIP: u32 = 256;

#[test]
fn without_a_fault_there_is_a_verdict_and_no_flag() {
    for drive in drives() {
        drive.all(&|_, _, _| (), |name, verdict, faults| {
            assert_eq!(verdict, Verdict::Class(0), "{name}");
            assert!(
                faults.is_clear() && faults.alignment == Alignment::Aligned && faults.offsets_a == [0.0; 3],
                "{name}: {faults:?}"
            );
        });
    }
}

#[test]
fn exchanged_phases_and_a_reversed_angle_have_no_verdict() {
    let faults: [(&str, &Fault<'_>); 2] = [
        ("phases exchanged", &|_, phases, _| phases.swap(1, 2)),
        ("angle reversed", &|_, _, counts| *counts = (16_384 - *counts) % 16_384),
    ];
    for drive in drives() {
        for (fault, inject) in faults {
            drive.all(inject, |name, verdict, faults| {
                assert_eq!(faults.imbalance, Some(Imbalance::Misaligned), "{fault}, {name}");
                assert!(matches!(verdict, Verdict::Undetermined(_)), "{fault}, {name}: {verdict:?}");
                assert!(faults.alignment == Alignment::Misaligned && !faults.is_clear(), "{fault}, {name}");
            });
        }
    }
}

/// The drive's own transform: its currents have the opposite sign, or velocity and angle have.
#[test]
fn a_sign_without_a_load_is_found_where_the_motion_explains_the_current() {
    for drive in drives() {
        let model = drive.trained(false);
        for kind in KINDS {
            let (mut samples, _) = drive.clean(kind, 7, &|_, _, _| ());
            let right = judge(&model, &samples);
            for sample in &mut samples {
                sample.values[0] = -sample.values[0];
            }
            let (verdict, _, orders) = judge(&model, &samples);
            println!("{}, {kind:?}: {verdict:?}, orders {:?} {orders:?}", drive.name, right.2);
            let refused = verdict == Verdict::Undetermined(Reason::Implausible(Implausible::Sign));
            // The load of the DC motor is most of its current; the bearing orders do not depend on the sign.
            assert!(refused || drive.name == "DC motor", "{}, {kind:?}: {verdict:?}", drive.name);
            for (own, other) in right.2.iter().zip(&orders).filter(|_| !refused) {
                assert!((own - other).abs() < 0.15 * own.abs() + 0.01, "{}: {own} {other}", drive.name);
            }
        }
    }
}

#[test]
fn an_offset_is_removed_and_beyond_its_limit_refused() {
    for drive in drives() {
        drive.all(&|_, phases, _| phases[0] += 0.5, |name, verdict, faults| {
            println!("{name}: {:?}", faults.offsets_a);
            assert_eq!((verdict, faults.imbalance), (Verdict::Class(0), None), "{name}");
            let [a, b, c] = faults.offsets_a;
            // Down to 0.2 σ and three deviations of the last windows, and with the rig's own offsets of 0.1 A.
            assert!((0.2..0.6).contains(&a) && b.abs() < 0.15 && c.abs() < 0.15, "{name}: {:?}", faults.offsets_a);
        });
        drive.all(&|_, phases, _| phases[0] += 2.0, |name, verdict, faults| {
            assert!(matches!(faults.imbalance, Some(Imbalance::Offset { .. })), "{name}: {faults:?}");
            assert!(matches!(verdict, Verdict::Undetermined(_)), "{name}: {verdict:?}");
        });
    }
}

#[test]
fn slips_of_the_angle_are_counted() {
    for drive in drives() {
        for slips in [1, 20] {
            let every = 8_000 / slips;
            let inject = |k: usize, _: &mut [f64; 3], counts: &mut u32| {
                let done = (k / every.min(200)).min(slips) as u32 * u32::from(k >= 200);
                *counts = (*counts + done * SLIP) % 16_384;
            };
            drive.all(&inject, |name, _, faults| {
                // A step during the search for the angle, or while the shaft is at rest and turns back, may pass.
                let least = (slips as u32).saturating_sub(4).max(1);
                assert!(faults.position.slipped + faults.position.strayed >= least, "{name}, {slips}: {faults:?}");
                assert!(!faults.is_clear(), "{name}");
            });
        }
    }
}

/// Instants of the angle that scatter by up to 0.6 of an interval about those of the currents.
#[test]
fn angles_at_unequal_times_are_counted() {
    let [drive, _] = drives();
    for kind in KINDS {
        let rows = (drive.record)(kind, 7);
        let inject = |k: usize, _: &mut [f64; 3], counts: &mut u32| {
            if k > 0 && k + 1 < rows.len() {
                let late = 0.6 * (f64::from(scattered(k as u32)) / 2_147_483_648.0 - 1.0);
                let turns = rows[k].turns + 0.5 * late * (rows[k + 1].turns - rows[k - 1].turns);
                *counts = (turns.rem_euclid(1.0) * COUNTS) as u32;
            }
        };
        let (_, faults) = drive.clean(kind, 7, &inject);
        println!("{kind:?}: {:?}", faults.position);
        assert!(faults.position.unsteady_windows > 5 && !faults.is_clear(), "{kind:?}: {faults:?}");
    }
}

/// All gains, or the scale of the load, changed by a fifth: neither a verdict nor a defect, whatever the bearing is.
#[test]
fn gains_and_loads_that_are_wrong_by_a_fifth_are_named() {
    let [springs, dc_motor] = drives();
    let loaded = Drive {
        name: "actuator under a load sine",
        constants: front_end(12_000.0, 300.0, 0.45),
        record: loaded_record,
        watch: watch::<12>,
        ..springs
    };
    for drive in [loaded, dc_motor] {
        let model = drive.trained(true);
        for kind in KINDS {
            let (samples, _) = drive.clean(kind, 7, &|_, _, _| ());
            for [current, load] in [[1.2, 1.0], [0.8, 1.0], [1.0, 1.2], [1.0, 0.8]] {
                let scale = |own: &Clean| {
                    let [i, w, t] = own.values;
                    Clean { values: [i * current, w, t * load], ..*own }
                };
                let scaled: Vec<Clean> = samples.iter().map(scale).collect();
                let (verdict, friction, _) = judge(&model, &scaled);
                println!("{}, {kind:?}, {current} {load}: {verdict:?} {:?}", drive.name, friction.load);
                let named = verdict == Verdict::Undetermined(Reason::Implausible(Implausible::TorqueConstant));
                assert!(named, "{}, {kind:?}, {current} {load}: {verdict:?}", drive.name);
            }
        }
    }
}

#[test]
fn every_row_of_the_book_names_a_requirement_or_a_limit() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = fs::read_to_string(root.join("../book/src/faults.md")).expect("the page");
    // Generated tables are compared with the test that prints them.
    let by_hand = page.split("## What a segment says").next().unwrap_or_default();
    let rows: Vec<&str> =
        by_hand.lines().filter(|line| line.starts_with("| ") && !line.starts_with("| fault ")).collect();
    assert!(rows.len() >= 15, "{}", rows.len());
    for row in rows {
        let cell = row.trim_end_matches(" |").rsplit(" | ").next().unwrap_or_default();
        // `cargo xtask trace` looks the requirements up.
        assert!(cell.contains("REQ-") || cell.contains("*limit*"), "{row}");
    }
}
