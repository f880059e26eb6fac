//! Command-line tests of rates by run and unit, breakdowns, and negative controls.

use std::fmt::Write as _;
use std::path::Path;

use serde_json::Value;

use super::common::{refuse, succeed};

const TRAIN: &str = "train --y current_a --u1 velocity_ref_rad_s-velocity_rad_s --u2 load_torque_nm \
    --order 2,2,2,1,1 --healthy healthy --false-alarm 0.35 --model m.bwm";

fn json(text: &str) -> Value {
    serde_json::from_str(text).expect("JSON")
}

/// Labels with columns: six runs of four traces a class; odd runs of unit A, even ones of unit B; sessions that
/// alternate within a run.
fn label(dir: &Path) {
    let labels = std::fs::read_to_string(dir.join("runs/labels.csv")).expect("labels");
    let mut text = String::from("trace,class_name,run,unit,session\n");
    let mut seen = std::collections::HashMap::new();
    for row in labels.lines().skip(1) {
        let cells: Vec<&str> = row.split(',').collect();
        let k = seen.entry(cells[1]).or_insert(0);
        let (run, unit, session) = (*k / 4 + 1, if *k / 4 % 2 == 0 { "A" } else { "B" }, *k % 2);
        writeln!(text, "{},{},{run},{unit},{session}", cells[0], cells[1]).expect("a string");
        *k += 1;
    }
    std::fs::write(dir.join("runs/labels.csv"), text).expect("writable");
}

#[test]
fn rates_count_runs_and_units() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy,spall,roughness --count 24 --seed 11 --out runs");
    label(dir);
    let labels = "--labels runs/labels.csv";
    succeed(
        dir,
        &format!("{TRAIN} --features a {labels} --classes healthy,roughness --group run --train-where run<=4"),
    );

    let evaluate = format!("evaluate --model m.bwm {labels} --where run>4");
    let plain = json(&succeed(dir, &format!("{evaluate} --json")));
    let by_run = format!("{evaluate} --group run --by unit,session --controls session,run --control-classes spall");
    let found = json(&succeed(dir, &format!("{by_run} --json")));
    let width = |of: &Value| of["high"].as_f64().expect("a number") - of["low"].as_f64().expect("a number");
    assert_eq!(plain["error_rate"]["value"], found["error_rate"]["value"]);
    assert!(width(&found["error_rate"]) > 1.5 * width(&plain["error_rate"]), "2 runs, not 16 traces: {found}");
    // Roughness is told from healthy traces: 1 of the 70² exchanges within two runs of 4 + 4 is as good.
    let chance = &found["chance"];
    assert!(chance["p"].as_f64().expect("p") < 0.002 && chance["exchanged"] == "within runs", "{found}");
    // A run is a unit of the ROC areas; spall was not trained, and its score is the surprise.
    let areas = found["roc_areas"].as_array().expect("areas");
    let of = |class: &str| areas.iter().find(|area| area["class"] == class).unwrap_or_else(|| panic!("{class}"));
    let (roughness, spall) = (of("roughness"), of("spall"));
    assert!(roughness["score"] == "log-odds" && spall["score"] == "surprise", "{areas:?}");
    assert!(roughness["within"]["value"] == 1.0 && roughness["units"] == 2, "{roughness}");
    // Two units that are separated are two decisions.
    assert!(roughness["within"]["low"].as_f64().is_some_and(|low| (0.3..0.4).contains(&low)), "{roughness}");
    assert!(plain["roc_areas"][0]["within"].is_object(), "by the runs of the training: {plain}");
    let units = found["by"]["unit"].as_array().expect("values");
    assert_eq!(units.iter().map(|row| row["traces"].as_u64()).collect::<Vec<_>>(), [Some(12), Some(12)]);
    assert!(units.iter().all(|row| row["right"]["roughness"]["value"] == 1.0), "{units:?}");
    // A class without a defect that is called novel counts against the model.
    assert!(found["controls_not_called_healthy"]["spall"]["value"].is_number());
    let [session, run] = [0, 1].map(|k| &found["controls"][k]);
    assert!(session["p"].as_f64().expect("p") > 0.01 && session["exchanged"] == "within runs", "{session}");
    assert!(run["p"].is_null(), "two runs of one value each: {run}");
    let told = succeed(dir, &by_run);
    let area = "roughness against healthy by log-odds: 1.000 [0.342, 1.000] within 2 units, 1.000";
    for line in
        [area, "intervals count values of run", "right by unit", "spall, negative control", "nothing to compare"]
    {
        assert!(told.contains(line), "{line} in {told}");
    }
    let all = json(&succeed(dir, &format!("evaluate --model m.bwm {labels} --group run --json")));
    let features = all["features_by_run"]["healthy"].as_array().expect("features");
    assert!(features.len() == 2 && features.iter().all(|row| row["runs"] == 6), "{features:?}");
    refuse(dir, &format!("{evaluate} --control-classes roughness"), &["roughness is no class", "not trained on"]);
    refuse(dir, &format!("{evaluate} --by rum"), &["no column rum"]);
}

#[test]
fn training_and_test_share_no_unit() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy,spall --count 24 --seed 12 --out runs");
    label(dir);
    let train = format!("{TRAIN} --features a1 --labels runs/labels.csv --group run --unit unit");
    let shared = format!("{train} --train-where run<=4 --test-where run>4");
    refuse(dir, &shared, &["unit A is both in training and in test", "leave out --unit"]);
    let told = succeed(dir, &format!("{train} --train-where unit=A --test-where unit=B"));
    assert!(told.contains("B/2 ") && told.contains("B/6 "), "runs are those of their unit: {told}");
    // The model knows its units.
    let evaluate = "evaluate --model m.bwm --labels runs/labels.csv";
    refuse(dir, &format!("{evaluate} --unit unit"), &["unit A is both in training and in test"]);
    succeed(dir, &format!("{evaluate} --unit unit --test-where unit=B"));
    // With one unit nothing can be held out.
    let alone = succeed(dir, &format!("{train} --train-where unit=A"));
    assert!(alone.contains("not cross-validated") && alone.contains("of one unit"), "{alone}");
}

/// Labels of other names than those of the traces are told as such.
#[test]
fn labels_of_other_traces_are_named_as_the_cause() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy --count 3 --seed 14 --out runs");
    std::fs::write(dir.join("labels.csv"), "trace,class_name\nrun_1,healthy\nrun_2,healthy\n").expect("writable");
    let train = format!("{TRAIN} --features a1 --labels labels.csv runs");
    refuse(dir, &train, &["runs: no trace that the labels select; compare their column trace"]);
}

/// A copy under another name was trained on, and another recording of a name was not.
#[test]
fn training_traces_are_known_by_their_content() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy,spall --count 4 --seed 12 --out runs");
    succeed(dir, &format!("{TRAIN} --features a1 --labels runs/labels.csv"));
    succeed(dir, "simulate --class healthy,spall --count 4 --seed 13 --out other");
    std::fs::create_dir(dir.join("mixed")).expect("a folder");
    let mut labels = String::from("trace,class_name\n");
    for k in 0..4 {
        // Two copies, and two recordings that have the names of training traces.
        let (from, to) = match k {
            0 | 1 => (format!("runs/healthy_12_00{k}.csv"), format!("copy_{k}")),
            _ => (format!("other/healthy_13_00{k}.csv"), format!("healthy_12_00{k}")),
        };
        std::fs::copy(dir.join(from), dir.join(format!("mixed/{to}.csv"))).expect("copied");
        labels += &format!("{to},healthy\n");
    }
    std::fs::write(dir.join("mixed/labels.csv"), labels).expect("written");
    let output = crate::common::run(dir, "evaluate --model m.bwm --labels mixed/labels.csv");
    let warnings = String::from_utf8_lossy(&output.stderr);
    assert!(warnings.contains("2 of 4 traces were trained on: the rates flatter the model"), "{warnings}");
}

/// A spreadsheet computes a cell that begins like a formula.
#[test]
fn tables_have_no_formulas() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy,spall --count 4 --seed 12 --out runs");
    let formula = "=HYPERLINK(1)";
    for (k, name) in [(0, formula), (1, "@x"), (2, "+x"), (3, "-x")] {
        std::fs::rename(dir.join(format!("runs/healthy_12_00{k}.csv")), dir.join(format!("runs/{name}.csv")))
            .expect("moved");
        let labels = std::fs::read_to_string(dir.join("runs/labels.csv")).expect("labels");
        std::fs::write(dir.join("runs/labels.csv"), labels.replace(&format!("healthy_12_00{k}"), name))
            .expect("written");
    }
    succeed(dir, &format!("{TRAIN} --features a1 --labels runs/labels.csv"));
    succeed(dir, "evaluate --model m.bwm --labels runs/labels.csv --out out.csv");
    succeed(
        dir,
        "identify runs --y current_a --u1 velocity_rad_s --u2 load_torque_nm --order 2,1,1,1,1 --out params.csv",
    );
    for table in ["out.csv", "params.csv"] {
        let text = std::fs::read_to_string(dir.join(table)).expect("a table");
        assert!(text.contains(&format!("\n'{formula}")), "{table}: {text}");
        let cells = text.lines().flat_map(|line| line.split(',')).map(|cell| cell.trim_matches('"'));
        let formulas: Vec<&str> = cells.filter(|cell| cell.starts_with(['=', '+', '-', '@'])).collect();
        assert!(formulas.iter().all(|cell| cell.parse::<f64>().is_ok()), "{table}: {formulas:?}");
    }
}

/// The core has 16 bytes of a name, files have all of it.
#[test]
fn names_of_classes_have_any_length() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy,spall,roughness --count 12 --seed 12 --out runs");
    let labels = std::fs::read_to_string(dir.join("runs/labels.csv")).expect("labels");
    let labels = labels.replace(",spall,", ",spall-and-roughness,").replace(",roughness,", ",spall-and-roughnesses,");
    std::fs::write(dir.join("runs/labels.csv"), labels).expect("written");
    let train = format!("{TRAIN} --features a,b,c --labels runs/labels.csv --rust m.rs --c m.h");
    let output = crate::common::run(dir, &train);
    let warnings = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{warnings}");
    assert!(warnings.contains("class spall-and-roughness is spall-and-r~"), "{warnings}");
    let found = json(&succeed(dir, "evaluate --model m.bwm --labels runs/labels.csv --json"));
    let classes: Vec<&str> = found["classes"].as_array().expect("a list").iter().filter_map(Value::as_str).collect();
    assert!(classes.len() == 3 && classes[1] != classes[2], "{classes:?}");
    assert!(classes[1..].iter().all(|name| name.starts_with("spall-and-r~") && name.len() == 16), "{classes:?}");
    let decided: u64 = (0..3).map(|k| found["confusion"][k][k].as_u64().expect("a count")).sum();
    assert!(decided > 20, "of 36: {found}");
}
