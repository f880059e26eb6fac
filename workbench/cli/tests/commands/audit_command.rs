//! Command-line tests of `audit`.

use super::common::{refuse, run, succeed};
use serde_json::Value;

#[test]
fn sound_recordings_have_no_findings_and_damaged_ones_name_theirs() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy --count 3 --seed 5 --out runs");
    let told = succeed(dir, "audit runs");
    assert!(told.contains("nothing found") && told.contains("rate: 500.0000 rows a second"), "{told}");
    assert!(told.contains("lines of orders, median of 3 traces"), "{told}");
    // A copy with three decimals, a held sensor, and a lost second.
    let text = std::fs::read_to_string(dir.join("runs/healthy_5_000.csv")).expect("a trace");
    let (head, rows) = text.split_once('\n').expect("a heading");
    let rounded = |line: &str| {
        let cell = |cell: &str| format!("{:.5}", cell.parse::<f64>().expect("a number"));
        line.split(',').map(cell).collect::<Vec<_>>().join(",") + "\n"
    };
    let place = head.split(',').position(|name| name == "load_torque_nm").expect("the load");
    let held = |(k, line): (usize, &str)| {
        let mut cells: Vec<&str> = line.split(',').collect();
        if (1000..1100).contains(&k) {
            cells[place] = "0.5";
        }
        cells.join(",") + "\n"
    };
    let write = |name: &str, rows: String| std::fs::write(dir.join(name), format!("{head}\n{rows}")).expect("writable");
    write("runs/copy.csv", rows.lines().map(rounded).collect());
    write("runs/held.csv", rows.lines().enumerate().skip(300).map(held).collect());
    write(
        "runs/gap.csv",
        rows.lines().skip(100).take(900).chain(rows.lines().skip(1500)).map(|l| format!("{l}\n")).collect(),
    );
    let output = run(dir, "audit runs --json");
    assert_eq!(output.status.code(), Some(1));
    let found: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let has = |what: &str, trace: &str| {
        let mut all = found["findings"].as_array().expect("a list").iter();
        all.any(|own| own["finding"].as_str().is_some_and(|text| text.contains(what)) && own["traces"][0] == trace)
    };
    assert!(has("the same recording as", "healthy_5_000") || has("the same recording as", "copy"), "{found:#}");
    assert!(has("column load_torque_nm: held in 2.1 %", "held"), "{found:#}");
    assert!(has("gaps in time, up to 501 steps", "gap"), "{found:#}");
    refuse(dir, "audit nothing", &["nothing"]);
    refuse(dir, "audit runs --false-alarm 2", &["give a rate from"]);
}

/// What friction could show, and sets that differ in more than the defect.
#[test]
fn excitation_and_sessions_are_told() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy,roughness --count 6 --seed 8 --out runs");
    let found: Value = serde_json::from_str(&succeed(dir, "audit --labels runs/labels.csv --json")).expect("JSON");
    let terms = found["friction"].as_array().expect("terms");
    let of = |name: &str| terms.iter().find(|own| own["term"] == name).expect("excited");
    let viscous = of("viscous friction");
    assert_eq!((&viscous["determined"], &viscous["healthy_traces"]), (&12.into(), &6.into()));
    let number = |key: &str| viscous[key].as_f64().expect("a number");
    assert!(0.0 < number("smallest_by_noise") && number("own_part") < 0.5, "{viscous}");
    assert!(of("load")["own_part"].as_f64().expect("a number") > 0.9);
    // Roughness was recorded by another logger: a row in two.
    for k in 0..6 {
        let path = dir.join(format!("runs/roughness_8_00{k}.csv"));
        let text = std::fs::read_to_string(&path).expect("a trace");
        let rows: Vec<&str> = text.lines().collect();
        let kept = rows.iter().take(1).chain(rows.iter().skip(1).step_by(2)).map(|row| format!("{row}\n"));
        std::fs::write(&path, kept.collect::<String>()).expect("writable");
    }
    let output = run(dir, "audit --labels runs/labels.csv");
    let told = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(1));
    assert!(told.contains("classes healthy and roughness differ in the rate (500.0000 and 250.0000)"), "{told}");
    assert!(told.contains("differ in the number of rows") && told.contains("a model could tell sessions"), "{told}");
    let one = succeed(dir, "audit --labels runs/labels.csv --where class_name=healthy");
    assert!(one.starts_with("6 traces") && one.contains("nothing found"), "{one}");
}
