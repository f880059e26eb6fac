//! Command-line tests of `train` with all methods and memories, and of `replay` and `evaluate` with the trained models.

use std::path::Path;

use crate::common::{refuse, succeed};

fn signals(u1: &str, order: &str) -> String {
    format!("--y current_a --u1 {u1} --u2 load_torque_nm --order {order}")
}

fn traces(dir: &Path) -> String {
    succeed(dir, "simulate --class healthy,spall,roughness --count 5 --seed 5 --out t");
    format!("train --labels t/labels.csv {} --features a,b,log_variance", signals("velocity_ref_rad_s", "2,1,2,1,1"))
}

#[test]
fn methods_memories_and_guards() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    let train = format!("{} --model m.bwm --rust m.rs", traces(dir));
    for (options, words) in [
        ("--method ls", vec!["Method::LeastSquares", "Channel::within(", "nominal: [-"]),
        ("--method instruments", vec!["method: Method::Instruments", "memory: Memory::Segment"]),
        ("--method instruments --nominal roughness --segment 2500", vec!["segment_samples: 2500"]),
        ("--memory 0.9995", vec!["memory: Memory::Fading", "lambda: 0.9995, floor: 20.0"]),
        ("--memory 0.9999 --method instruments", vec!["Memory::Fading", "lambda: 0.9999, floor: 100.0"]),
        ("--method instruments --handover 50", vec!["handover: 50"]),
    ] {
        succeed(dir, &format!("{train} {options}"));
        let source = std::fs::read_to_string(dir.join("m.rs")).expect("source");
        assert!(words.iter().all(|word| source.contains(word)), "{options}\n{source}");
        let json = succeed(dir, "evaluate --model m.bwm --labels t/labels.csv --json");
        let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
        assert_eq!(json["error_rate"]["value"].as_f64(), Some(0.0), "{options}");
    }
    let json: serde_json::Value =
        serde_json::from_str(&succeed(dir, &format!("{train} --method instruments --json"))).expect("JSON");
    assert_eq!((&json["method"], &json["settle_samples"]), (&"instruments".into(), &100.into()));
}

/// A detector computes the difference model if a feature reads it, or if it is asked for; the rest has the same bits.
/// Recordings do not need the input that only this model takes.
#[test]
fn a_difference_model_that_no_feature_reads_does_not_run() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy,spall --condition mix --count 8 --seed 6 --out t");
    let shaft = "--angle angle_rad --velocity velocity_rad_s --load load_torque_nm --bearing 9,3,17,10";
    let train = format!("train --labels t/labels.csv {} {shaft}", signals("velocity_ref_rad_s", "2,1,2,1,1"));
    let trained = |options: &str| {
        let told = succeed(dir, &format!("{train} {options} --model m.bwm --rust m.rs"));
        let replayed = succeed(dir, "replay --model m.bwm t/spall_mix_6_003.csv --json");
        let source = std::fs::read_to_string(dir.join("m.rs")).expect("source");
        (told, source, serde_json::from_str::<serde_json::Value>(&replayed).expect("JSON")[0].take())
    };
    let (told, source, mut without) = trained("");
    assert!(told.contains("estimated by the torque balance; orders outer, inner; no feature reads"), "{told}");
    assert!(!source.contains("RegressionLayout") && !source.contains("velocity_ref_rad_s"), "{source}");
    assert!(without["parameters"].is_null() && without["variance"].is_null(), "{without}");
    let shorter = std::fs::read_to_string(dir.join("t/spall_mix_6_003.csv")).expect("trace");
    std::fs::write(dir.join("shorter.csv"), shorter.replace("velocity_ref_rad_s", "other")).expect("writable");
    let page = "replay --model m.bwm shorter.csv --report replay.html";
    assert!(succeed(dir, page).contains("spall  ["), "without the reference");
    let page = std::fs::read_to_string(dir.join("replay.html")).expect("page");
    assert!(page.contains("The detector estimates the torque balance; the orders outer, inner."), "what runs");
    let (told, source, mut with) = trained("--identify");
    assert!(told.contains("estimated by least squares") && source.contains("u1: velocity_ref_rad_s"), "{told}");
    assert!(with["parameters"]["a1"].is_number() && with["variance"].is_number(), "{with}");
    // The rows of a segment are those of the difference model, if there is one.
    for key in ["parameters", "variance", "rows"] {
        (with[key], without[key]) = Default::default();
    }
    assert_eq!(with, without);
    // A feature that reads it, or a mean of its input.
    for options in ["--features log_variance,drag", "--features drag,rms_velocity_ref_rad_s"] {
        let (_, source, _) = trained(options);
        assert!(source.contains("u1: velocity_ref_rad_s"), "{options}: {source}");
    }
}

#[test]
fn what_a_segment_was_denied_is_told() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    let train = traces(dir);
    succeed(dir, &format!("{train} --method instruments --saturation 12,100,5 --stuck 9 --model m.bwm"));
    let text = std::fs::read_to_string(dir.join("t/healthy_5_000.csv")).expect("trace");
    let place = text.lines().next().expect("header").split(',').position(|name| name == "current_a").expect("column");
    // The current is constant from row 1000 on, and outside the range of its sensor in rows 500 to 510.
    let changed = text.lines().enumerate().map(|(k, line)| {
        let mut cells: Vec<&str> = line.split(',').collect();
        match k {
            500..510 => cells[place] = "15",
            1000..1100 => cells[place] = "0.25",
            _ => {}
        }
        cells.join(",") + "\n"
    });
    std::fs::write(dir.join("stuck.csv"), changed.collect::<String>()).expect("writable");
    std::fs::write(dir.join("stuck_labels.csv"), "trace,class_name\nstuck,healthy\n").expect("writable");
    let line = succeed(dir, "replay --model m.bwm stuck.csv");
    for words in ["undetermined: the sensor of current_a is stuck", "10 samples saturated", "current_a stuck"] {
        assert!(line.contains(words), "{line}");
    }
    let json: serde_json::Value =
        serde_json::from_str(&succeed(dir, "replay --model m.bwm stuck.csv --json")).expect("JSON");
    assert_eq!((&json[0]["stuck"], &json[0]["saturated"]), (&serde_json::json!(["current_a"]), &10.into()));
    succeed(dir, "evaluate --model m.bwm stuck.csv --labels stuck_labels.csv --out v.csv");
    let table = std::fs::read_to_string(dir.join("v.csv")).expect("verdicts");
    let mut lines = table.lines();
    assert!(lines.next().is_some_and(|head| head.ends_with("rows,rejected,saturated,still,stuck")));
    assert!(lines.next().is_some_and(|row| row.ends_with(",0,10,0,current_a")), "{table}");
    std::fs::write(dir.join("sick.csv"), "trace,class_name\nstuck,healthy\nhealthy_5_001,healthy\n").expect("writable");
    let both = std::fs::read_to_string(dir.join("t/labels.csv")).expect("labels");
    let others: Vec<&str> = both.lines().filter(|line| line.contains("spall")).collect();
    let others: String = others.iter().map(|l| l.split(',').take(2).collect::<Vec<_>>().join(",") + "\n").collect();
    let labels = std::fs::read_to_string(dir.join("sick.csv")).expect("labels") + &others;
    std::fs::write(dir.join("sick.csv"), labels).expect("writable");
    let sick = train.replace("--labels t/labels.csv", "stuck.csv t --labels sick.csv");
    refuse(dir, &format!("{sick} --stuck 9 --model none.bwm"), &["trace stuck.csv", "is stuck"]);
}

#[test]
fn bad_options_are_one_line() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    let train = format!("{} --model none.bwm", traces(dir));
    for (options, words) in [
        ("--method iv", ["--method", "instruments"]),
        ("--nominal worse", ["unknown class worse", "there are healthy"]),
        ("--saturation 1,2", ["--saturation", "three magnitudes"]),
        ("--saturation 1,0,2", ["--saturation", "U1 is 0"]),
        ("--stuck 1", ["--stuck 1", "at least 2"]),
        ("--stuck few", ["--stuck", "invalid"]),
        ("--memory 1", ["--memory 1", "above 0.9000, at most 0.9999"]),
        ("--memory 0.1", ["--memory 0.1", "above 0.9000"]),
        ("--handover 1251", ["--handover 1251", "quarter of the segment of 5000"]),
        ("--segment 100001", ["--segment 100001", "to 100000"]),
        ("--saturation 0.001,100,5", ["trace healthy_5_000.csv", "samples saturated"]),
    ] {
        refuse(dir, &format!("{train} {options}"), &words);
    }
    let other = |order: &str, u1: &str| train.replace(&signals("velocity_ref_rad_s", "2,1,2,1,1"), &signals(u1, order));
    let moving_average = other("0,1,2,1,1", "velocity_ref_rad_s").replace("a,b,log", "b,log");
    refuse(dir, &format!("{moving_average} --method instruments"), &["1 to 4 output terms"]);
    // The current follows from the control error by an integrator, and with roughness the estimated pole may be
    // slightly above or below one: the estimates are accepted in both cases.
    let error = other("2,2,2,1,1", "velocity_ref_rad_s-velocity_rad_s").replace("none.bwm", "m.bwm");
    succeed(dir, &format!("{error} --method instruments"));
}
