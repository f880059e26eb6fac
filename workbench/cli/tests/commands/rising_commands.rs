//! Command-line tests of features that a defect only raises, and of orders next to those of the rotor.

use super::common::{refuse, run, succeed};
use serde_json::Value;

const TRAIN: &str = "train --y current_a --u1 velocity_ref_rad_s --u2 load_torque_nm --order 2,1,1,1,1 \
    --angle angle_rad --velocity velocity_rad_s --load load_torque_nm --false-alarm 0.01 \
    --features viscous_log,inverse_kt --model m.bwm";

#[test]
fn a_rising_feature_is_judged_both_ways() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy --count 40 --seed 5 --mix --out low");
    succeed(dir, "simulate --class roughness --severity 0.25 --count 40 --seed 6 --mix --out high");
    // Part of the other class's records that the gate of one class calls novel.
    let novel = |own: &str, class: &str, other: &str, options: &str| {
        let told = succeed(dir, &format!("{TRAIN} --healthy {class} --labels {own}/labels.csv {options} --rust m.rs"));
        let exported = std::fs::read_to_string(dir.join("m.rs")).expect("source");
        let rises = !options.is_empty();
        let says = "or by one of viscous_log alone";
        assert_eq!((told.contains(says), exported.contains("rising: 1,")), (rises, rises), "{told}");
        // Too much and too little are told apart.
        let replayed = succeed(dir, &format!("replay --model m.bwm {other} --json"));
        let segments: Vec<Value> = serde_json::from_str(&replayed).expect("JSON");
        let novel = segments.iter().filter(|own| own["verdict"] == "novel");
        let falls = novel.clone().filter(|own| own["most"]["falls"] == true).count();
        (novel.count(), falls)
    };
    let both = ["", "--rising viscous_log"];
    // A quarter of the roughness is five times the viscous friction.
    assert_eq!(both.map(|options| novel("low", "healthy", "high", options).0), [40, 40]);
    // A belt that came off lowers friction likewise.
    assert_eq!(novel("high", "roughness", "low", both[0]).0, 40);
    assert_eq!(novel("high", "roughness", "low", both[1]), (40, 40));
}

#[test]
fn what_cannot_rise_is_refused() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy --count 12 --seed 7 --out train");
    let train = |more: &str| format!("{TRAIN} --healthy healthy --labels train/labels.csv {more}");
    refuse(dir, &train("--rising drag"), &["--rising: drag is none of the features viscous_log, inverse_kt"]);
    refuse(dir, &train("--rising viscous_log --projection pca"), &["--projection none"]);
}

#[test]
fn an_order_next_to_one_of_the_rotor_is_told() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy --count 12 --seed 8 --out train");
    let warning = |options: &str| {
        let output = run(dir, &format!("{TRAIN} --healthy healthy --labels train/labels.csv {options}"));
        assert!(output.status.success());
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let told = "order near of 4.0300 cannot be told from cogging, unbalance and errors of the angle at order 4: ";
    assert!(
        warning("--orders near=4.03,far=3.5")
            .contains(&format!("{told}with slips of up to 2.20 % no record tells them apart; --slip 0.00"))
    );
    assert!(warning("--orders near=4.03,far=3.5 --slip 0").contains(&format!("{told}records of ")));
    assert!(!warning("--orders far=3.5").contains("cannot be told"));
}
