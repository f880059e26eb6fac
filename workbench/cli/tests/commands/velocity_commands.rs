//! Command-line tests of the velocity's source: its channel, or the differences of the angle.

use std::path::Path;

use crate::common::{refuse, succeed};

const TRAIN: &str = "train --y current_a --u1 velocity_ref_rad_s --u2 load_torque_nm --order 2,1,1,1,1 \
    --angle angle_rad --velocity velocity_rad_s --load load_torque_nm --orders outer=3.71794 --healthy healthy \
    --false-alarm 0.05 --features drag,order_outer --labels train/labels.csv";

/// The source that `command` exports.
fn exported_by(dir: &Path, command: &str) -> String {
    succeed(dir, &format!("{command} --model m.bwm --rust m.rs"));
    std::fs::read_to_string(dir.join("m.rs")).expect("source")
}

/// [`TRAIN`] of a drive without the channel.
fn without_velocity() -> String {
    TRAIN.replace("--velocity velocity_rad_s", "")
}

#[test]
fn the_source_is_chosen_or_given() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    // Steps of a degree are worse than the rig's velocity, those of 14 bits better.
    for (bits, best) in [(8, "channel"), (14, "angle")] {
        succeed(dir, &format!("simulate --class healthy --count 30 --seed 5 --mix --angle-bits {bits} --out train"));
        for (source, options) in [
            (best, ""),
            (best, "--velocity-from best"),
            ("channel", "--velocity-from channel"),
            ("angle", "--velocity-from angle"),
        ] {
            let exported = exported_by(dir, &format!("{TRAIN} {options}"));
            let of_channel = exported.contains("velocity: Some(velocity_rad_s),")
                && exported.contains("velocity_rad_s: \"rad/s\"")
                && exported.contains("velocity velocity_rad_s,");
            let of_angle = exported.contains("velocity: None,")
                && !exported.contains("velocity_rad_s: \"rad/s\"")
                && exported.contains("velocity the differences of the angle,");
            assert_eq!(
                (of_channel, of_angle),
                (source == "channel", source == "angle"),
                "{bits} {options}: {exported}"
            );
            let judged = succeed(dir, "evaluate --model m.bwm --labels train/labels.csv");
            assert!(judged.contains("healthy"), "{judged}");
        }
    }
    // A feature of the channel keeps it.
    let exported = exported_by(dir, &format!("{TRAIN} --covariates rms_velocity_rad_s"));
    assert!(exported.contains("velocity: Some(velocity_rad_s),"), "{exported}");
    // A drive that has no channel uses the angle.
    let of_angle = exported_by(dir, &format!("{TRAIN} --velocity-from angle"));
    assert_eq!(exported_by(dir, &without_velocity()), of_angle);
    // So it does with a trace that has no such column, also if the training set had one.
    let trace = std::fs::read_to_string(dir.join("train/healthy_mix_5_000.csv")).expect("trace");
    std::fs::write(dir.join("bare.csv"), trace.replace("velocity_rad_s", "other")).expect("writable");
    succeed(dir, "replay --model m.bwm bare.csv");
    exported_by(dir, TRAIN);
    let [of_bare, of_whole] = ["bare.csv", "train/healthy_mix_5_000.csv"]
        .map(|file| succeed(dir, &format!("replay --model m.bwm {file}")).split_once("  ").expect("id").1.to_string());
    assert_eq!(of_bare, of_whole);
}

/// The nominal J/Kt that `command` exports.
fn inertia(dir: &Path, command: &str) -> f64 {
    let exported = exported_by(dir, command);
    let (_, balance) = exported.split_once("balance: ").expect("a balance");
    let (_, nominal) = balance.split_once("nominal: [").expect("parameters");
    nominal.split(',').next().and_then(|first| first.trim().parse().ok()).expect("a number")
}

#[test]
fn without_a_load_the_reference_corrects_the_inertia() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy --count 80 --seed 5 --mix --angle-bits 14 --out train");
    let blind = TRAIN.replace("--load load_torque_nm", "");
    let (squares, instruments) =
        (inertia(dir, &blind), inertia(dir, &format!("{blind} --velocity-ref velocity_ref_rad_s")));
    println!("{squares} {instruments}");
    // 0.005 A s²/rad; the middle of 80 records has a deviation of 0.0006, 10 s keep a part of the bias, and 40 records
    // gave 0.0088.
    assert!(squares > 0.009 && (0.003..0.0085).contains(&instruments), "{squares} {instruments}");
    // The detector does not read the reference.
    let trace = std::fs::read_to_string(dir.join("train/healthy_mix_5_000.csv")).expect("trace");
    assert!(trace.contains("velocity_ref_rad_s"));
    let judged = succeed(dir, "replay --model m.bwm train/healthy_mix_5_000.csv");
    assert!(judged.contains("healthy"), "{judged}");
    // With a load it is of no use.
    let with = exported_by(dir, &format!("{TRAIN} --velocity-ref velocity_ref_rad_s"));
    assert_eq!(with, exported_by(dir, TRAIN));
}

#[test]
fn wrong_arguments_are_refused() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    refuse(dir, "simulate --class healthy --count 1 --angle-bits 40 --out t", &["angle_bits", "40"]);
    refuse(dir, &format!("{TRAIN} --velocity-from tacho --model m.bwm"), &["tacho", "best, channel, angle"]);
    let command = format!("{} --velocity-from channel --model m.bwm", without_velocity());
    refuse(dir, &command, &["--velocity-from channel needs the channel", "--velocity NAME"]);
}
