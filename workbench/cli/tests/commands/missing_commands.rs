//! Command-line tests of recordings in which samples are missing: dropped rows, empty rows, words.

use std::path::Path;

use serde_json::Value;

use crate::common::{refuse, run, succeed};

const TRAIN: &str = "train --y current_a --u1 velocity_ref_rad_s --u2 load_torque_nm --order 2,1,1,1,1 \
    --angle angle_rad --velocity velocity_rad_s --load load_torque_nm --orders outer=3.71794 --healthy healthy \
    --false-alarm 0.05 --features drag,order_outer";

/// One row in a hundred, by chance; neither the first nor the last ones.
fn is_lost(row: usize) -> bool {
    let mixed = (row as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    (5..4990).contains(&row) && (mixed ^ (mixed >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 32 < (1 << 32) / 100
}

/// Copies the traces and labels of a folder with other rows; a row is that of the number behind the heading.
fn copy(from: &Path, to: &Path, row: &dyn Fn(usize, &str) -> Option<String>) {
    std::fs::create_dir_all(to).expect("a folder");
    for entry in std::fs::read_dir(from).expect("a folder") {
        let path = entry.expect("an entry").path();
        let name = path.file_name().expect("a name");
        let text = std::fs::read_to_string(&path).expect("a text");
        let (head, rows) = text.split_once('\n').expect("a heading");
        let is_labels = name == "labels.csv";
        let of = |(k, line): (usize, &str)| if is_labels { Some(line.to_string()) } else { row(k, line) };
        let rows: Vec<String> = rows.lines().enumerate().filter_map(of).collect();
        std::fs::write(to.join(name), format!("{head}\n{}\n", rows.join("\n"))).expect("writable");
    }
}

fn drop(from: &Path, to: &Path) {
    copy(from, to, &|k, line| (!is_lost(k)).then(|| line.to_string()));
}

/// The time is there, and nothing else.
fn empty(from: &Path, to: &Path) {
    copy(from, to, &|k, line| {
        let words = ["NaN", "", "null", "inf"];
        let cells = || line.split(',').skip(1).enumerate().map(|(place, _)| words[(k + place) % words.len()]);
        let time = line.split(',').next().unwrap_or_default();
        Some(if is_lost(k) { std::iter::once(time).chain(cells()).collect::<Vec<_>>().join(",") } else { line.into() })
    });
}

fn json(dir: &Path, command: &str) -> Value {
    serde_json::from_str(&succeed(dir, command)).expect("JSON")
}

/// Distances of the segments.
fn distances(replayed: &Value) -> Vec<f64> {
    let all = replayed.as_array().expect("a list").iter();
    all.map(|segment| segment["distance"].as_f64().expect("a distance")).collect()
}

#[test]
fn dropped_and_empty_rows_give_the_same_model_and_verdicts_near_those_of_all_rows() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy --count 30 --seed 5 --mix --out train");
    succeed(dir, "simulate --class spall --severity 0.125 --count 10 --seed 9 --mix --out other");
    for (kind, lose) in [("dropped", drop as fn(&Path, &Path)), ("empty", empty)] {
        for set in ["train", "other"] {
            lose(&dir.join(set), &dir.join(format!("{set}_{kind}")));
        }
    }
    let lost = (0..5000).filter(|row| is_lost(*row)).count();
    assert!((40..60).contains(&lost), "{lost}");
    let train = |kind: &str| succeed(dir, &format!("{TRAIN} --labels train{kind}/labels.csv --model m{kind}.bwm"));
    let (whole, dropped, emptied) = (train(""), train("_dropped"), train("_empty"));
    let words = format!("30 of 30 traces: {:.2} % of rows missing", lost as f64 / 50.0);
    assert!(!whole.contains("missing") && dropped.contains(&words) && emptied.contains(&words), "{dropped}{emptied}");
    assert!(dropped.contains("by gaps in the time), treated as missing") && emptied.contains("without a number"));
    let bytes = |kind: &str| std::fs::read(dir.join(format!("m{kind}.bwm"))).expect("a model");
    assert!(bytes("_dropped") == bytes("_empty"), "to the last bit");
    // The traces of another set, by the model of whole ones.
    let replay = |kind: &str, options: &str| {
        let mut found = json(dir, &format!("replay --model m.bwm other{kind} --json {options}"));
        let missing: Vec<Value> =
            found.as_array_mut().expect("a list").iter_mut().map(|own| own["missing_samples"].take()).collect();
        (found, missing)
    };
    let ((all, none), (some, by_time), (others, by_row)) =
        (replay("", ""), replay("_dropped", ""), replay("_empty", ""));
    assert_eq!(some, others);
    assert_eq!(
        (&none[0]["missing"], &by_time[0]["dropped"], &by_row[0]["empty"]),
        (&0.into(), &lost.into(), &lost.into())
    );
    // Around a missing sample the residual of the shaft pauses, which costs 15 % of the distance. Rows that are taken
    // as if none were missing jump in angle and time: their angle contradicts the velocity, and there is no verdict.
    let uniform = |k: usize, line: &str| {
        let (_, cells) = line.split_once(',').expect("cells");
        Some(format!("{:.3},{cells}", 0.002 * k as f64))
    };
    copy(&dir.join("other_dropped"), &dir.join("other_joined"), &uniform);
    let sum = |own: &Value| distances(own).iter().sum::<f64>();
    let filled = sum(&some) / sum(&all);
    println!("distance with 1 % of rows missing {filled:.3} of that of all rows");
    assert!((0.8..0.95).contains(&filled), "{filled}");
    let joined = replay("_joined", "").0;
    assert!(joined.as_array().expect("a list").iter().all(|own| own["verdict"] == "undetermined"), "{joined}");
    let novel = |own: &Value| own.as_array().expect("a list").iter().filter(|one| one["verdict"] == "novel").count();
    assert_eq!((novel(&all), novel(&some)), (10, 10));
    let evaluated = json(dir, "evaluate --model m.bwm --labels train_dropped/labels.csv --json");
    assert_eq!(evaluated["missing_samples"]["dropped"], 30 * lost);
    assert!(succeed(dir, "evaluate --model m.bwm --labels train_dropped/labels.csv").contains(&words));
    // An audit that finds something fails.
    let audit = |set: &str| String::from_utf8_lossy(&run(dir, &format!("audit {set}")).stdout).into_owned();
    let audited = audit("train_dropped");
    assert!(audited.contains(&words) && audited.contains("gaps in time"), "{audited}");
    let audited = audit("train_empty");
    assert!(audited.contains(&words) && audited.contains("column current_a: no number in"), "{audited}");
    succeed(dir, "replay --model m.bwm other_dropped --report page.html");
    let page = std::fs::read_to_string(dir.join("page.html")).expect("a page");
    assert!(page.contains("of rows missing"), "the page says it");
}

#[test]
fn a_trace_that_lacks_too_much_is_named_with_its_reason() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy --count 30 --seed 5 --mix --out train");
    succeed(dir, &format!("{TRAIN} --labels train/labels.csv --model m.bwm"));
    copy(&dir.join("train"), &dir.join("half"), &|k, line| {
        let time = line.split(',').next().unwrap_or_default();
        Some(if matches!(k % 5, 0 | 3) { format!("{time},,,,,,") } else { line.into() })
    });
    let said = succeed(dir, "replay --model m.bwm half/healthy_mix_5_000.csv");
    assert!(said.contains("40.00 % of rows missing (2000 of 5000: 2000 without a number"), "{said}");
    assert!(said.contains("undetermined: "), "{said}");
    succeed(dir, "evaluate --model m.bwm --labels half/labels.csv --out v.csv");
    let table = std::fs::read_to_string(dir.join("v.csv")).expect("verdicts");
    assert_eq!(table.matches(",undetermined,").count(), 30, "{table}");
}

#[test]
fn batch_methods_leave_out_rows_or_say_why_not() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy --count 1 --seed 5 --out whole");
    drop(&dir.join("whole"), &dir.join("dropped"));
    let signals = "--y current_a --u1 velocity_ref_rad_s-velocity_rad_s --u2 load_torque_nm --order 2,2,2,1,1";
    let identify = |set: &str, method: &str| format!("identify {set}/healthy_5_000.csv {signals} --method {method}");
    let parameter = |set: &str| {
        let found = json(dir, &(identify(set, "ls") + " --json"));
        let number = |key: &str| found[0][key]["a1"].as_f64().expect("a number");
        (number("parameters"), number("sd"), found[0]["rows"].as_u64().expect("rows"))
    };
    let ((whole, deviation, rows), (dropped, _, fewer)) = (parameter("whole"), parameter("dropped"));
    // Each missing sample is in three rows; the estimates differ by what 3 % of the rows change, 0.2 deviations.
    assert!((100..=180).contains(&(rows - fewer)) && (whole - dropped).abs() < deviation, "{whole} {dropped} {fewer}");
    let told = String::from_utf8_lossy(&run(dir, &identify("dropped", "ls")).stderr).into_owned();
    assert!(told.contains("of rows missing"), "{told}");
    for method in ["iv", "iv4", "sriv", "sm", "oe", "armax"] {
        refuse(dir, &identify("dropped", method), &["trace healthy_5_000.csv: y misses", "--method ls"]);
    }
    let of_set = |command: &str| format!("{command} dropped/healthy_5_000.csv {signals}");
    refuse(dir, &of_set("validate"), &["rows missing (", "this method needs every sample"]);
    refuse(dir, &of_set("identify --decimate 20"), &["no sample is left by --block-mean and --decimate"]);
    let structure =
        "structure dropped dropped --y current_a --u1 velocity_ref_rad_s --u2 load_torque_nm --max 2,2,2,1,1";
    refuse(dir, structure, &["rows missing (", "this method needs every sample"]);
    let grey = "grey-box motor dropped/healthy_5_000.csv";
    refuse(dir, grey, &["rows missing (", "this method needs every sample"]);
    // A whole channel is refused as ever.
    copy(&dir.join("whole"), &dir.join("no_load"), &|_, line| {
        let mut cells: Vec<&str> = line.split(',').collect();
        cells[4] = "";
        Some(cells.join(","))
    });
    refuse(dir, &identify("no_load", "ls"), &["column load_torque_nm: no number in any row"]);
}
