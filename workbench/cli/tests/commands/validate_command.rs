//! Command-line tests of `bearing-watch validate`.

use std::path::Path;
use std::process::{Command, Output};

const SIGNALS: &str = "--y current_a --u1 velocity_ref_rad_s-velocity_rad_s --u2 load_torque_nm --order 2,2,2,1,1";

fn run(folder: &Path, arguments: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_bearing-watch"));
    command.current_dir(folder).args(arguments.split_whitespace()).output().expect("the command starts")
}

#[test]
fn text_json_and_page_say_the_same() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    assert!(run(dir, "simulate --class healthy --count 2 --seed 1 --out t").status.success());
    let text = run(dir, &format!("validate t {SIGNALS} --method iv4 --report m.html"));
    let said = String::from_utf8_lossy(&text.stdout).into_owned();
    assert!(text.status.success() && said.contains("0 of 2 models pass the independence test"), "{said}");

    let json = run(dir, &format!("validate t {SIGNALS} --method iv4 --json"));
    let json: serde_json::Value = serde_json::from_slice(&json.stdout).expect("JSON");
    let first = &json[0]["independence"];
    assert_eq!(first["passed"], false);
    assert!(said.contains(&format!("{} of {} lags outside", first["outside"], first["tested"])), "{said}\n{first}");
    assert_eq!(json[0]["cross_correlation_u1"]["lag"].as_array().map(Vec::len), Some(51));
    assert_eq!(json[0]["poles"].as_array().map(Vec::len), Some(2));

    let page = std::fs::read_to_string(dir.join("m.html")).expect("page");
    for words in ["Poles and zeros with 3σ regions", "with u2", "Frequency response from u1", "estimated by iv4"] {
        assert!(page.contains(words), "{words}");
    }
    assert!(page.matches("class=\"plot\"").count() >= 7, "figures");
}

#[test]
fn bad_input_is_one_line() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    let rows: String = (0..90).map(|t| format!("{},{},{}\n", t * t % 17, t * t % 13, t * t * t % 19)).collect();
    std::fs::write(dir.join("s.csv"), format!("y,a,b\n{rows}")).expect("written");
    for (arguments, words) in [
        ("validate s.csv --y y --u1 a --u2 b --order 1,1,1,1,1", "too few for a residual test over 25 lags"),
        ("validate s.csv --y y --u1 a --u2 b --order 1,1,1,1,1 --lags 0", "--lags"),
    ] {
        let output = run(dir, arguments);
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!((output.status.code(), error.trim_end().lines().count()), (Some(2), 1), "{error}");
        assert!(error.contains(words), "{error}");
    }
}

/// A model is written by `identify`, and tested on a trace that it has not seen.
#[test]
fn a_model_is_tested_on_another_trace() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    assert!(run(dir, "simulate --class healthy,roughness --count 2 --seed 3 --out t").status.success());
    let said = |arguments: &str| {
        let output = run(dir, arguments);
        let [out, err] = [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text).into_owned());
        (output.status.code(), out, err)
    };
    let (_, model, warned) = said(&format!("identify t/healthy_3_000.csv {SIGNALS} --json"));
    assert!(warned.contains("the residuals of 1 of 1 models are coloured") && warned.contains("--robust"), "{warned}");
    std::fs::write(dir.join("m.json"), model).expect("writable");
    let fit = |arguments: &str| {
        let (_, out, err) = said(&format!("validate {arguments} {SIGNALS} --json"));
        let json: serde_json::Value = serde_json::from_str(&out).expect(&err);
        json[0]["simulation_fit_percent"].as_f64().expect("a number")
    };
    let (own, healthy, rough) = (
        fit("t/healthy_3_000.csv"),
        fit("t/healthy_3_001.csv --params m.json"),
        fit("t/roughness_3_000.csv --params m.json"),
    );
    assert!(healthy > own - 3.0 && rough < healthy - 3.0, "{own} {healthy} {rough}");
    said(&format!("identify t {SIGNALS} --out all.csv"));
    let (code, _, error) = said(&format!("validate t/healthy_3_001.csv --params all.csv {SIGNALS}"));
    assert!(code == Some(2) && error.contains("4 models; name one by --params-of, e.g. healthy_3_000"), "{error}");
    let one = "validate t/healthy_3_001.csv --params all.csv --params-of healthy_3_000";
    let (_, out, warned) = said(&format!("{one} {SIGNALS}"));
    assert!(out.contains("independence") && warned.contains("no covariance"), "{out} {warned}");
    let (code, _, error) = said(&format!("{one} {}", SIGNALS.replace("2,2,2,1,1", "2,3,2,1,1")));
    assert!(code == Some(2) && error.contains("the model lacks b3"), "{error}");
}

/// Instruments from the command, and standard deviations that allow for coloured residuals.
#[test]
fn the_noise_of_the_loop_is_allowed_for() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    assert!(run(dir, "simulate --class healthy --count 1 --seed 4 --out t").status.success());
    let found = |method: &str| {
        let output = run(dir, &format!("identify t {} {method} --json", SIGNALS.replace("2,2,2,1,1", "1,1,1,1,1")));
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        (json[0]["parameters"]["a1"].as_f64().expect("a1"), json[0]["sd"]["a1"].as_f64().expect("a1"))
    };
    let (plain, robust, command) =
        (found("--method ls"), found("--robust"), found("--method iv-command --instruments velocity_ref_rad_s"));
    assert!((plain.0 - robust.0).abs() < f64::EPSILON && robust.1 > 1.2 * plain.1, "{plain:?} {robust:?}");
    assert!((command.0 - plain.0).abs() > 3.0 * plain.1, "least squares is biased: {command:?} {plain:?}");
    for (arguments, words) in [
        ("--method iv-command", "--instruments"),
        ("--instruments velocity_ref_rad_s", "goes with --method iv-command"),
        ("--robust --method oe", "--robust goes with --method ls"),
    ] {
        let output = run(dir, &format!("identify t {SIGNALS} {arguments}"));
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && error.contains(words), "{error}");
    }
}
