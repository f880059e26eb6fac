//! Command-line tests of how a bearing is given, and of words that are no known ones.

use std::path::Path;

use super::common::{refuse, run, succeed};

const TRAIN: &str = "train --labels runs/labels.csv --y current_a --u1 velocity_ref_rad_s --u2 load_torque_nm \
    --order 2,1,1,1,1 --angle angle_rad --velocity velocity_rad_s --load load_torque_nm --model m.bwm";

/// Standard error of a command that must succeed.
fn said(folder: &Path, arguments: &[&str]) -> String {
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_bearing-watch"));
    let output = command.current_dir(folder).args(arguments).output().expect("the command starts");
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code().is_some_and(|code| code < 2), "{arguments:?}\n{error}");
    error
}

fn words(line: &str) -> Vec<&str> {
    line.split_whitespace().collect()
}

fn recordings() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("folder");
    succeed(folder.path(), "simulate --class healthy,spall --count 12 --seed 5 --out runs");
    folder
}

const RAD: &str = "contact angle 0.1745 taken as rad (10 degrees); give degrees as data sheets do";

#[test]
fn an_angle_in_rad_is_said_once_in_each_command() {
    let folder = recordings();
    let dir = folder.path();
    let train = format!("{TRAIN} --features drag");
    let features = train.replace("train ", "features ").replace("--model m.bwm", "--out part.parquet");
    let replay = "replay --model m.bwm runs/healthy_5_000.csv --load-rating-n 13500 --bearing-load-n 1000";
    for command in [train.as_str(), &features.replace(" --features drag", ""), replay] {
        let of = |bearing: &str| said(dir, &words(&format!("{command} --bearing {bearing}")));
        assert_eq!(of("9,3,17,0.1745").matches(RAD).count(), 1, "{command}");
        assert!(!of("9,3,17,10").contains("taken as rad"), "{command}");
        let table = of("6205-2RS");
        assert_eq!(
            table.matches("6205-2RS: 9 balls of 7.94 mm on 39.04 mm, 0 degrees (SKF: CWRU").count(),
            1,
            "{table}"
        );
    }
    let text = "[data]\ntraces = [\"runs\"]\n[bearing]\nbearing = [9, 3, 17, 0.1745]\n";
    std::fs::write(dir.join("d.toml"), text).expect("write");
    assert_eq!(said(dir, &["audit", "d.toml"]).matches(RAD).count(), 1);
    std::fs::write(dir.join("d.toml"), text.replace("[9, 3, 17, 0.1745]", "6205")).expect("write");
    assert!(said(dir, &["audit", "d.toml"]).contains("6205: 9 balls of 7.94 mm"));
    // A designation of two words, and the same orders by numbers.
    let mut named = words(&train);
    named.extend(["--bearing", "NSK 6205 DDU/C3", "-v"]);
    let told = said(dir, &named);
    assert!(told.contains("(NSK: KAIST") && told.contains("bearing: 9 balls of 7.9 on 38.5"), "{told}");
}

#[test]
fn what_is_no_bearing_is_refused_with_what_to_give() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    for (bearing, expected) in [
        ("9,3,17,61", ["--bearing", "from 0 to 60 degrees, not 61"]),
        ("9,3,17,-5", ["--bearing", "from 0 to 60 degrees, not -5"]),
        ("2,3,17,10", ["--bearing", "whole one from 3 to 100, not 2"]),
        ("9,17,3,10", ["number of balls, ball diameter", "pitch diameter 3"]),
        ("6214", ["6214 is not in the table of published bearings: give four numbers", "BPFO and BPFI: --orders"]),
        ("7205B", ["7205B is not in the table of published bearings: give", "contact angle in degrees"]),
    ] {
        refuse(dir, &format!("{TRAIN} --bearing {bearing}"), &expected);
    }
    refuse(dir, &format!("{TRAIN} --orders outer=5.41,inner=3.58"), &["outer=5.41", "exchanged"]);
    std::fs::write(dir.join("d.toml"), "[bearing]\nslip = 0\nbearing = [9, 3, 17, 75]\n").expect("write");
    refuse(dir, "train d.toml --model m.bwm", &["d.toml, line 3", "from 0 to 60 degrees, not 75"]);
}

#[test]
fn unknown_words_are_answered_with_the_nearest_known_one() {
    let folder = recordings();
    let dir = folder.path();
    for (arguments, near) in [
        (
            TRAIN.replace("--y current_a", "--y curent_a"),
            "no column (or difference of columns) curent_a (did you mean current_a?); there are ",
        ),
        (TRAIN.replace("--load load_torque_nm", "--load load_torque"), "did you mean load_torque_nm?"),
        (
            format!("{TRAIN} --classes healthy,spal"),
            "unknown class spal in this selection (did you mean spall?); there are healthy, spall",
        ),
        (format!("{TRAIN} --healthy helthy"), "unknown class helthy (did you mean healthy?)"),
        (format!("{TRAIN} --features draag"), "no draag in this model (did you mean drag?)"),
        (format!("{TRAIN} --group clas_name"), "no column clas_name (did you mean class_name?)"),
        (TRAIN.replace("runs/labels.csv", "runs/label.csv"), "did you mean runs/labels.csv?"),
        (TRAIN.replace("runs/labels.csv", "run/labels.csv"), "there is no folder run"),
        ("replay --model m.bwm runs/healthy_5_00.csv".into(), ""),
        ("audit runs/healthy_5_00.csv".into(), "did you mean runs/healthy_5_000.csv?"),
        ("train drive.tml.toml --model m.bwm".into(), "drive.tml.toml"),
    ] {
        refuse(dir, &arguments, &[near]);
    }
    std::fs::write(dir.join("drive.toml"), "[chanels]\ny = \"current_a\"\n").expect("write");
    refuse(dir, "train --model m.bwm", &["no table [chanels]; did you mean channels?"]);
    refuse(dir, "train driv.toml --model m.bwm", &["driv.toml", "did you mean ./drive.toml?"]);
}

#[test]
fn the_help_of_train_leads_with_the_drive_file() {
    let folder = tempfile::tempdir().expect("folder");
    let help = String::from_utf8_lossy(&run(folder.path(), "train -h").stdout).into_owned();
    let lines: Vec<&str> = help.lines().collect();
    let usage = lines.iter().position(|line| line.starts_with("Usage:")).expect("a usage");
    assert!(usage < 4 && lines[usage].contains("bearing-watch train drive.toml --model"), "{help}");
    let options = lines.iter().position(|line| line.trim_start().starts_with('-')).expect("options");
    assert!(usage < options && lines[usage + 1].contains("--labels"), "{help}");
}
