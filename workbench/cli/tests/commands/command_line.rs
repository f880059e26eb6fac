//! Command-line tests of the main workflow from files to files, and of one-line errors on invalid input.

use std::path::Path;

use crate::common::{refuse, run, succeed};

const SIGNALS: &str = "--y current_a --u1 velocity_ref_rad_s --u2 load_torque_nm";
const CLASSES: &str = "healthy,spall,roughness";

#[test]
fn the_main_job_from_files_to_files() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, &format!("simulate --rig dc --class {CLASSES} --count 8 --seed 1 --out train"));
    succeed(dir, "simulate --class healthy --count 4 --seed 2 --out test");
    succeed(dir, "simulate --class spall,roughness --count 4 --seed 2 --out test");
    let labels = std::fs::read_to_string(dir.join("test/labels.csv")).expect("labels");
    assert_eq!(labels.lines().count(), 13, "three classes merged into one file of labels\n{labels}");

    let train = format!("train --labels train/labels.csv {SIGNALS} --order 2,1,2,1,1 --model m.bwm");
    let said = succeed(dir, &format!("{train} --rust m.rs --c m.h --report m.html"));
    assert!(said.contains("8 healthy, 8 spall, 8 roughness"), "{said}");
    let source = std::fs::read_to_string(dir.join("m.rs")).expect("source");
    let sample = r#"pub struct Sample { current_a: "A", velocity_ref_rad_s: "rad/s", load_torque_nm: "N·m" }"#;
    assert!(source.contains(sample) && source.contains("pub static MODEL: Model<Drive>"), "{source}");
    let header = std::fs::read_to_string(dir.join("m.h")).expect("header");
    assert!(
        header.contains("BW_MODEL_CHANNEL_LOAD_TORQUE_NM = 2") && header.contains(" * Estimated by least squares"),
        "{header}"
    );
    let page = std::fs::read_to_string(dir.join("m.html")).expect("page");
    assert!(page.contains("class=\"plot\"") && page.contains("default-src 'none'"), "self-contained");

    let json: serde_json::Value =
        serde_json::from_str(&succeed(dir, "evaluate --model m.bwm --labels test/labels.csv --json --out v.csv"))
            .expect("JSON");
    assert_eq!(json["classes"], serde_json::json!(["healthy", "spall", "roughness"]));
    assert_eq!(json["confusion"], serde_json::json!([[4, 0, 0], [0, 4, 0], [0, 0, 4]]));
    for key in ["error_rate", "balanced_accuracy"] {
        let rate = &json[key];
        assert!(rate["low"].as_f64() <= rate["value"].as_f64() && rate["value"].as_f64() <= rate["high"].as_f64());
    }
    assert_eq!((json["error_rate"]["value"].as_f64(), json["trained_on"].as_u64()), (Some(0.0), Some(0)));
    assert_eq!(std::fs::read_to_string(dir.join("v.csv")).expect("verdicts").lines().count(), 13);

    let flattered = run(dir, "evaluate --model m.bwm --labels train/labels.csv");
    assert!(String::from_utf8_lossy(&flattered.stderr).contains("24 of 24 traces were trained on"));
    let replay = succeed(dir, "replay --model m.bwm test/spall_2_000.csv");
    assert!(replay.contains("0.000–10.000 s  spall"), "{replay}");
    // A second training produces the same bytes.
    let first = std::fs::read(dir.join("m.bwm")).expect("model");
    succeed(dir, &train);
    assert_eq!(std::fs::read(dir.join("m.bwm")).expect("model"), first);
}

#[test]
fn segments_projections_priors_and_costs() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, &format!("simulate --class {CLASSES} --count 10 --seed 3 --out t"));
    let train = format!("train --labels t/labels.csv {SIGNALS} --order 2,1,2,1,1 --model m.bwm");
    for options in [
        "--projection fisher",
        "--projection pca --variance 0.95 --features a,b,c,log_variance",
        "--projection pca-raw --components 2 --features a --discriminant quadratic",
        "--priors healthy=0.9,spall=0.05,roughness=0.05 --cost healthy:spall=50",
        "--block-mean 2 --offset",
        "--decimate 2",
        "--decimate 2 --block-mean 2 --classes spall,healthy",
        "--where seed=3 --train-where severity<=1 --json",
    ] {
        succeed(dir, &format!("{train} {options}"));
        succeed(dir, "replay --model m.bwm t/healthy_3_000.csv --json");
    }
    succeed(dir, &format!("{train} --segment 1250"));
    let json: serde_json::Value =
        serde_json::from_str(&succeed(dir, "evaluate --model m.bwm --labels t/labels.csv --per-segment --json"))
            .expect("JSON");
    // Trained on segments of the same length; with training on whole traces a quarter of the decisions would be wrong.
    assert!(json["error_rate"]["value"].as_f64().is_some_and(|error| error < 0.02), "{json}");
    succeed(dir, &format!("{train} --segment 2500"));
    let by_segment = succeed(dir, "evaluate --model m.bwm --labels t/labels.csv --per-segment");
    assert!(by_segment.contains("of 60,"), "two segments of each of thirty traces\n{by_segment}");
    let cautious = format!("{train} --features a --cost healthy:spall=1000,healthy:roughness=1000");
    succeed(dir, &cautious);
    let json: serde_json::Value =
        serde_json::from_str(&succeed(dir, "evaluate --model m.bwm --labels t/labels.csv --json")).expect("JSON");
    assert_eq!(json["confusion"][1][0].as_u64(), Some(0), "at this cost no spall is called healthy");
}

#[test]
fn identification_table() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy --count 2 --seed 4 --out t");
    let identify = format!("identify t {SIGNALS} --order 2,1,2,1,1 --offset");
    let table = succeed(dir, &format!("{identify} --method ls"));
    let mut lines = table.lines();
    assert_eq!(lines.next(), Some("trace,a1,a2,b1,c1,c2,offset,fit_percent,sd_a1,sd_a2,sd_b1,sd_c1,sd_c2,sd_offset"));
    assert!(lines.next().is_some_and(|line| line.starts_with("healthy_4_000.csv,")), "{table}");
    let json: serde_json::Value =
        serde_json::from_str(&succeed(dir, &format!("{identify} --method iv4 --json"))).expect("JSON");
    assert!(json[1]["fit_percent"].as_f64().is_some_and(|fit| (80.0..92.0).contains(&fit)), "{json}");
    // A sine excites too few frequencies to identify three lags; rounding in the file hides this from a rank test.
    let sine = run(dir, &format!("identify t {SIGNALS} --order 3,3,3,1,1"));
    let warning = String::from_utf8_lossy(&sine.stderr).into_owned();
    assert!(
        sine.status.success() && warning.contains("hardly determine") && warning.contains("b1, b2, b3"),
        "{warning}"
    );
    // The noise of the sensors colours the residuals of least squares; instruments allow for it.
    let told = String::from_utf8_lossy(&run(dir, &identify).stderr).into_owned();
    assert!(told.lines().count() == 1 && told.contains("residuals of 2 of 2 models are coloured"), "{told}");
    assert!(run(dir, &format!("{identify} --method iv")).stderr.is_empty(), "and nothing is said of a good model");
    for method in ["iv --passes 2", "sriv", "sm", "oe", "armax --noise-order 1"] {
        let json: serde_json::Value =
            serde_json::from_str(&succeed(dir, &format!("{identify} --method {method} --json"))).expect("JSON");
        assert!(json[0]["convergence"]["converged"].as_bool().is_some(), "{json}");
        assert!(json[0]["prediction_fit_percent"].as_f64().is_some_and(|fit| fit > 50.0), "{json}");
    }
    succeed(dir, &format!("{identify} --out params.csv"));
    assert_eq!(std::fs::read_to_string(dir.join("params.csv")).expect("table").trim_end(), table.trim_end());
}

/// Writes six short traces of two classes, in which y follows u1 and u2.
fn small_set(dir: &Path) {
    let mut labels = String::from("trace,class_name,run\n");
    let mut state = 1_u32;
    let mut noise = move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 8) / 16_777_216.0 - 0.5
    };
    for k in 0..6 {
        let mut rows = String::from("y,u1,u2\n");
        let mut y = 0.0;
        for _ in 0..60 {
            let (u1, u2) = (noise(), noise());
            rows.push_str(&format!("{y},{u1},{u2}\n"));
            y = 0.5 * y + u1 + 0.3 * u2 + 0.1 * noise();
        }
        std::fs::write(dir.join(format!("t{k}.csv")), rows).expect("writable");
        labels.push_str(&format!("t{k},{},{k}\n", if k < 3 { "good" } else { "bad" }));
    }
    std::fs::write(dir.join("labels.csv"), labels).expect("writable");
}

#[test]
fn bad_input_is_one_line_with_file_place_and_remedy() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    small_set(dir);
    let write = |name: &str, content: &str| std::fs::write(dir.join(name), content).expect("writable");
    write("ragged.csv", "y,u1,u2\n1,2,3\n1,2\n");
    write("words.csv", "y,u1,u2\n1,2,3\n1,two,3\n");
    write("nan.csv", "y,u1,u2\n1,2,NaN\n1,2,\n");
    write("inf.csv", "y,u1,u2\n1,2,inf\n");
    write("empty.csv", "");
    write("header.csv", "y,u1,u2\n");
    write("short.csv", "y,u1,u2\n1,2,3\n4,5,6\n");
    write("flat.csv", &format!("y,u1,u2\n{}", "1,2,3\n".repeat(50)));
    write("steady.csv", &format!("y,u1,u2\n{}", "1,2,3\n2,2,3\n4,2,3\n".repeat(20)));
    write("letters.csv", "y;u1;u2\n1,5;2;3\n1,5;2;x\n");
    write("huge.csv", "y,u1,u2\n1,2,1e300\n");
    write("backwards.csv", "t_s,y,u1,u2\n0,1,2,3\n-1,1,2,3\n");
    write("columns.csv", "y,u1\n1,2\n");
    let signals = "--y y --u1 u1 --u2 u2";
    let identify = |file: &str| format!("identify {file} {signals} --order 1,1,1,1,1 --out out.csv");
    refuse(dir, &identify("columns.csv"), &["columns.csv, header", "no column", "u2", "there are y, u1"]);
    refuse(dir, &identify("ragged.csv"), &["ragged.csv, line 3", "2 cells where the header has 3"]);
    refuse(dir, &identify("words.csv"), &["words.csv, line 3, column u1", "\"two\" is not a number"]);
    refuse(dir, &identify("nan.csv"), &["nan.csv, column u2", "no number in any row"]);
    refuse(dir, &identify("inf.csv"), &["inf.csv, column u2", "no number in any row"]);
    refuse(dir, &identify("empty.csv"), &["empty.csv, header"]);
    refuse(dir, &identify("header.csv"), &["header.csv", "no rows"]);
    refuse(dir, &identify("short.csv"), &["short.csv", "2 samples for 3 parameters", "record more"]);
    refuse(dir, &identify("flat.csv"), &["flat.csv", "the output is constant", "check --y"]);
    refuse(dir, &identify("steady.csv"), &["steady.csv", "do not excite parameter c1", "richer command"]);
    refuse(dir, &identify("letters.csv"), &["letters.csv, line 3, column u2: \"x\" is not a number"]);
    refuse(dir, &identify("huge.csv"), &["huge.csv, line 2, column u2", "no measured value"]);
    refuse(dir, &identify("backwards.csv"), &["backwards.csv, line 3, column t_s", "time runs backwards"]);
    refuse(dir, &identify("t0.csv").replace("out.csv", "t0.csv"), &["t0.csv is an input"]);
    refuse(dir, &identify("t0.csv").replace("out.csv", "no/out.csv"), &["there is no folder no"]);
    refuse(dir, &identify("t0.csv").replace("out.csv", "."), &["is a folder"]);
    refuse(dir, &identify("absent.csv"), &["absent.csv"]);
    refuse(dir, &identify("t0.csv t0.csv"), &["t0.csv", "comes twice"]);
    refuse(dir, &format!("identify t0.csv {signals} --order 1,1,1,1,1 --block-mean 0"), &["--block-mean"]);

    let train = format!("train --labels labels.csv {signals} --order 1,1,1,1,1 --model m.bwm --rust m.rs");
    refuse(dir, &format!("{train} --where run>10"), &["labels.csv, selection", "no row with run>10"]);
    refuse(dir, &format!("{train} --where run<3"), &["3 traces are too few for 3 features"]);
    refuse(dir, &format!("{train} --where run<4"), &["class bad has 1 training trace"]);
    refuse(dir, &format!("{train} --classes good,worse"), &["unknown class worse", "there are good, bad"]);
    refuse(dir, &format!("{train} --where speed=1"), &["labels.csv, header", "no column speed"]);
    refuse(
        dir,
        &format!("{train} --discriminant quadratic"),
        &["class good is singular", "3 traces are too few for 3 features", "at least 4"],
    );
    refuse(dir, &format!("{train} --features d"), &["no d in this model", "log_variance"]);
    refuse(dir, &format!("{train} --priors good=1"), &["says nothing of class bad"]);
    refuse(dir, &format!("{train} --cost good:worse=3"), &["unknown class worse"]);
    refuse(dir, &format!("{train} --segment 4"), &["--segment 4", "6 to 100000"]);
    refuse(dir, &format!("{train} --cost good:good=3"), &["a right decision costs nothing"]);
    refuse(dir, &format!("{train} --priors good=1,good=2,bad=1"), &["names good twice"]);
    refuse(dir, &format!("{train} --classes good,good"), &["names good twice"]);
    refuse(dir, &train.replace("m.rs", "m.bwm"), &["m.bwm is named for two outputs"]);
    refuse(dir, &train.replace("m.rs", "labels.csv"), &["labels.csv is an input"]);
    refuse(dir, &format!("{train} --train-where run<5 --test-where run>3"), &["t4", "make them disjoint"]);
    write("missing.csv", "trace,class_name\nt0,good\nt9,bad\n");
    refuse(dir, &train.replace("labels.csv", "missing.csv"), &["t9 is labelled, but there is no such trace"]);
    write("lacking.csv", "trace,class_name\nt0,good\ncolumns,bad\n");
    refuse(dir, &train.replace("labels.csv", "lacking.csv"), &["columns.csv, header", "no column", "u2"]);
    write("nolabel.csv", "trace,class\nt0,good\n");
    refuse(dir, &train.replace("labels.csv", "nolabel.csv"), &["nolabel.csv, header", "no column class_name"]);

    for (order, words) in [("0,0,0,1,1", "no terms"), ("1,1,1", "no order"), ("1,1,99,1,1", "above 32")] {
        refuse(dir, &format!("identify t0.csv {signals} --order {order}"), &["--order", words]);
    }
    refuse(dir, "identify t0.csv --order 1,1,1,1,1", &["required arguments", "--y", "--help"]);
    refuse(dir, "", &["a command is missing"]);
    refuse(dir, "simulate --class healthy,healthy --out s", &["names healthy twice"]);
    refuse(dir, "simulate --class spall --severity -1 --out s", &["severity", "negative"]);
    refuse(dir, "simulate --class spall --severity nan --out s", &["severity", "finite"]);
}

#[test]
fn bad_models_are_refused() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    small_set(dir);
    succeed(dir, "train --labels labels.csv --y y --u1 u1 --u2 u2 --order 1,1,1,1,1 --features a --model m.bwm");
    let good = std::fs::read(dir.join("m.bwm")).expect("model");
    let write = |name: &str, bytes: &[u8]| std::fs::write(dir.join(name), bytes).expect("writable");
    write("short.bwm", &good[..good.len() / 2]);
    let mut corrupt = good.clone();
    corrupt[40] ^= 1;
    write("corrupt.bwm", &corrupt);
    let mut newer = good.clone();
    newer[4] = 13;
    write("newer.bwm", &newer);
    write("text.bwm", b"trace,class_name\n");
    write("other.csv", b"trace,class_name\nt0,worn\n");
    let evaluate = |model: &str| format!("evaluate --model {model} --labels labels.csv --out v.csv");
    refuse(dir, &evaluate("short.bwm"), &["short.bwm", "truncated", "train it again"]);
    refuse(dir, &evaluate("corrupt.bwm"), &["corrupt.bwm", "corrupted"]);
    refuse(dir, &evaluate("newer.bwm"), &["newer.bwm", "newer format version 13", "reads 12", "update this program"]);
    refuse(dir, &evaluate("text.bwm"), &["text.bwm", "not a bearing-watch model"]);
    refuse(dir, &evaluate("absent.bwm"), &["absent.bwm"]);
    let other = "evaluate --model m.bwm --labels other.csv --out v.csv";
    refuse(dir, other, &["t0", "unknown class worn", "good, bad"]);
}

#[test]
fn another_sampling_rate_is_refused() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy,spall --count 4 --seed 5 --out t");
    let train = format!("train --labels t/labels.csv {SIGNALS} --order 1,1,1,1,1 --model m.bwm");
    succeed(dir, &train);
    let recorded = std::fs::read_to_string(dir.join("t/spall_5_001.csv")).expect("trace");
    let mut slower: Vec<&str> = recorded.lines().skip(1).step_by(5).collect();
    slower.insert(0, recorded.lines().next().expect("header"));
    std::fs::write(dir.join("slow.csv"), slower.join("\n")).expect("writable");
    refuse(dir, "replay --model m.bwm slow.csv", &["slow.csv", "every 0.01 s", "the model wants 0.002"]);
    std::fs::write(dir.join("t/spall_5_001.csv"), slower.join("\n")).expect("writable");
    refuse(dir, &train, &["spall_5_001.csv", "every 0.01 s", "train on one rate"]);
}
