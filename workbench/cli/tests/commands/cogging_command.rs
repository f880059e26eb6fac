//! Command-line tests of `bearing-watch grey-box cogging`.

use std::fmt::Write as _;
use std::path::Path;

use rig::field::Magnetics;
use rig::{Condition, Drive, Field, Scenario, simulate};
use serde_json::Value;

use crate::common::{refuse, rewrite_column, succeed};
use crate::form::{fit, schema};

/// Writes four slow recordings of one drive with cogging, ripple and unbalance.
fn recordings(folder: &Path, first: u64, slip_rad: f64) {
    std::fs::create_dir_all(folder).expect("a folder");
    for seed in first..first + 4 {
        let mixed = Condition::MIX.apply(Scenario::WITH_RESOLVER, seed);
        let scenario = Scenario {
            reference_amplitude_rad_s: 0.25 * mixed.reference_amplitude_rad_s,
            field: Field { magnetics: Some(Magnetics::FIELD), ..Field::NONE },
            drive: Some(Drive { set: 62, unit: 1, session: 0 }),
            ..mixed
        };
        let trace = simulate(&scenario, seed).expect("valid");
        let mut text = String::from("t_s,velocity_ref_rad_s,velocity_rad_s,current_a,load_torque_nm,angle_rad\n");
        for k in 0..trace.len() {
            let angle = (trace.angle_rad[k] + slip_rad).rem_euclid(std::f64::consts::TAU);
            let row = [
                trace.t_s[k],
                trace.velocity_ref_rad_s[k],
                trace.velocity_rad_s[k],
                trace.current_a[k],
                trace.load_torque_nm[k],
                angle,
            ];
            let _ = writeln!(text, "{}", row.map(|value| format!("{value:.6}")).join(","));
        }
        std::fs::write(folder.join(format!("slow_{seed}.csv")), text).expect("writable");
    }
}

#[test]
fn lines_map_and_change_of_recordings() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    recordings(&dir.join("before"), 0, 0.0);
    recordings(&dir.join("now"), 100, 0.1);
    let output = succeed(dir, "grey-box cogging before --out map.csv --report page.html --json");
    let value: Value = serde_json::from_str(&output).expect("JSON");
    fit(&schema("cogging"), &value);
    let lines = value["lines"].as_array().expect("a list");
    let torque = |order: u64| {
        let line = lines.iter().find(|line| line["order"] == order).expect("a line");
        [&line["torque_nm"]["amplitude"], &line["torque_nm"]["amplitude_interval"]]
            .map(|x| x.as_f64().expect("a number"))
    };
    let [unbalance, half] = torque(1);
    // Nominal 6 mN·m; twice the interval.
    assert!((unbalance - 6e-3).abs() < 2.0 * half && half < 1e-3, "{unbalance} {half}");
    assert!(torque(12)[0] > 3e-3 && value["change"].is_null());

    let map = std::fs::read_to_string(dir.join("map.csv")).expect("a map");
    let rows: Vec<Vec<f64>> =
        map.lines().skip(1).map(|row| row.split(',').map(|x| x.parse().expect("a number")).collect()).collect();
    assert!(map.starts_with("angle_rad,current_a,deviation_a\n") && rows.len() == 360);
    // The mean over a turn is zero but for the rounding of seven digits.
    assert!(rows.iter().map(|row| row[1]).sum::<f64>().abs() < 1e-4);
    // Of order 1 alone: 2/N Σ i cos, i sin times Kt.
    let sum = |of: fn(f64) -> f64| rows.iter().map(|row| row[1] * of(row[0])).sum::<f64>() / 180.0;
    let kt = value["torque_constant_nm_a"].as_f64().expect("a number");
    assert!((kt * sum(f64::cos).hypot(sum(f64::sin)) - unbalance).abs() < 1e-6);
    let page = std::fs::read_to_string(dir.join("page.html")).expect("a page");
    assert!(page.contains("Current against cogging and unbalance") && !page.contains("Not drawn"));

    let said = succeed(dir, "grey-box cogging now --since before --out map.c --format odrive");
    assert!(said.contains("the angle has slipped by 5.") && said.contains("order"), "{said}");
    let map = std::fs::read_to_string(dir.join("map.c")).expect("a map");
    assert!(map.contains("float cogging_map[3600] = {") && map.lines().count() == 3603);
    let said = succeed(dir, "grey-box cogging before --kt 0.05 --load load_torque_nm");
    assert!(said.contains("residual"), "{said}");
}

#[test]
fn what_is_not_usable_is_refused() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    recordings(&dir.join("runs"), 0, 0.0);
    refuse(dir, "grey-box cogging runs --angle integrate(velocity_rad_s)", &["an integral is not absolute"]);
    refuse(dir, "grey-box cogging runs --load none", &["--kt"]);
    refuse(dir, "grey-box cogging runs/slow_0.csv --angle phi_rad", &["phi_rad"]);
    // A shaft that stands still.
    rewrite_column(&dir.join("runs/slow_0.csv"), &dir.join("little.csv"), "angle_rad", |_| "0.5".into());
    refuse(dir, "grey-box cogging little.csv", &["the shaft makes 0.0 turns", "at least 10 turns"]);
    // Each record of this set is a drive of its own, with phases of its own.
    succeed(dir, "simulate --class healthy --condition cogging --count 6 --seed 5 --out drives");
    refuse(dir, "grey-box cogging drives", &["the angle is not absolute, or the drives differ: the line of order"]);
    succeed(dir, "simulate --class healthy --condition duty-one-way --count 3 --seed 5 --out one");
    refuse(dir, "grey-box cogging one", &["forward", "in each direction"]);
}
