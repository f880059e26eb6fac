//! Command-line tests of formats, formulas of columns, and resampling.

use super::common::{refuse, run, succeed};

const TRAIN: &str = "train --y current_a --u1 velocity_ref_rad_s-velocity_rad_s --u2 load_torque_nm --order 2,2,2,1,1 \
    --labels csv/labels.csv";

#[test]
fn a_model_does_not_depend_on_the_format_of_its_traces() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy,spall --count 6 --seed 5 --out csv");
    succeed(dir, &format!("{TRAIN} --model csv.bwm"));
    let model = |format: &str| std::fs::read(dir.join(format!("{format}.bwm"))).expect("a model");
    for format in ["mat", "parquet", "arrow", "npz", "tsv", "csv.gz", "txt.zst"] {
        std::fs::create_dir(dir.join(format)).expect("a folder");
        let told = succeed(dir, &format!("convert csv --format {format} --out {format}"));
        assert!(told.contains("12 traces"), "labels are not a trace: {told}");
        succeed(dir, &format!("{TRAIN} {format} --model {format}.bwm"));
        assert_eq!(model(format), model("csv"), "{format}");
    }
}

#[test]
fn formulas_and_units_are_those_of_the_columns() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    let rows: String = (0..400).map(|k| format!("{};{},5;{};{}\n", k * 10, 300 + k % 7, k % 3, k * k % 11)).collect();
    std::fs::write(dir.join("log.csv"), format!("Time [ms];speed_rpm;i [mA];load\n{rows}")).expect("writable");
    let columns = "velocity_rad_s=(speed_rpm)rad/s,turns=integrate(speed_rpm)turn,current_a=(i [mA])A";
    let arguments = ["convert", "log.csv", "--columns", columns, "--out", "out.csv"];
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_bearing-watch"));
    let output = command.current_dir(dir).args(arguments).output().expect("the command starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = std::fs::read_to_string(dir.join("out.csv")).expect("written");
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("t_s,velocity_rad_s,turns,current_a"));
    let row: Vec<f64> = lines.nth(1).expect("a row").split(',').map(|cell| cell.parse().expect("a number")).collect();
    // 300.5 and 301.5 rpm over 10 ms.
    let expected = [0.01, 301.5 * std::f64::consts::TAU / 60.0, 301.0 / 60.0 * 0.01, 0.001];
    assert!(row.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-12), "{row:?}");
    // The same formula as a channel of another command.
    let identify = "identify log.csv --y speed_rpm --u1 3-2*load --u2 integrate(load) --order 1,1,1,1,1";
    assert!(succeed(dir, identify).contains("log.csv"));
    refuse(dir, "convert log.csv --columns v=speed --out x.csv", &["log.csv, header: no column", "speed_rpm"]);
    refuse(dir, "convert log.csv --out x.xls", &["x.xls: give a name that ends with .csv"]);
    refuse(dir, "convert log.csv --time clock --out x.csv", &["no column clock for the time"]);
    refuse(dir, "convert log.csv --out log.csv", &["is an input"]);
}

#[test]
fn resampling_tells_gaps_and_refuses_higher_rates() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    let time = |k: i32| f64::from(k) * 0.004 + if k < 300 { 0.0 } else { 1.0 };
    let rows: String = (0..500).map(|k| format!("{},{}\n", time(k), k % 5)).collect();
    std::fs::write(dir.join("log.csv"), format!("t_s,i\n{rows}")).expect("writable");
    std::fs::create_dir(dir.join("out")).expect("a folder");
    let output = run(dir, "convert log.csv --to-hz 50 --format parquet --out out");
    let warned = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && warned.contains("gap of 1.004"), "{warned}");
    succeed(dir, "convert out/log_2.parquet --out second.csv");
    let text = std::fs::read_to_string(dir.join("second.csv")).expect("written");
    let rows: Vec<&str> = text.lines().collect();
    assert!(rows[0] == "t_s,i" && rows[1].starts_with("2.2,") && rows[2].starts_with("2.22"), "{rows:?}");
    // 200 rows of 4 ms.
    assert!((39..=41).contains(&(rows.len() - 1)), "{} rows", rows.len());
    refuse(dir, "convert log.csv --to-hz 400 --out x.csv", &["trace log: 500 rows at about 250.00 a second"]);
    refuse(dir, "convert log.csv --to-hz 50 --time none --out x.csv", &["no time column"]);
    let several = run(dir, "convert log.csv --to-hz 50 --out x.csv");
    assert!(
        String::from_utf8_lossy(&several.stderr).contains("one file for several traces") && !dir.join("x.csv").exists()
    );
    succeed(dir, "convert log.csv --to-hz 50 --out fresh");
    assert!(dir.join("fresh/log_2.csv").is_file());
    refuse(dir, "convert log.csv --to-hz 0 --out x.csv", &["give a number above 0"]);
}
