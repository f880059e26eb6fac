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
    assert!(page.matches("<svg").count() > 10 && !page.contains("http"), "self-contained");
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
