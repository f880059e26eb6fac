//! Command-line tests of `bearing-watch structure`.

use std::path::Path;
use std::process::{Command, Output};

fn run(folder: &Path, arguments: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_bearing-watch"));
    command.current_dir(folder).args(arguments.split_whitespace()).output().expect("the command starts")
}

const SIGNALS: &str = "--y current_a --u1 velocity_ref_rad_s-velocity_rad_s --u2 load_torque_nm";

fn traces(folder: &Path) {
    let output = run(folder, "simulate --class healthy --count 3 --seed 1 --out train");
    assert!(output.status.success());
}

#[test]
fn a_search_from_files_to_page_and_json() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    traces(dir);
    std::fs::create_dir(dir.join("held")).expect("folder");
    std::fs::rename(dir.join("train/healthy_1_002.csv"), dir.join("held/healthy_1_002.csv")).expect("moved");
    let command = format!("structure train held {SIGNALS} --max 2,2,2,2,2 --compare 3,1,1,1,1 --json --report p.html");
    let output = run(dir, &command);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let structures = json["structures"].as_array().expect("a list");
    assert_eq!(structures.len(), 32);
    assert!(structures.iter().all(|s| s["rows"].as_u64() >= Some(2 * 4990)), "both traces are estimated on");
    let fits = structures.iter().filter_map(|s| s["fit_percent"].as_f64());
    let best = fits.fold(f64::NEG_INFINITY, f64::max);
    assert_eq!(json["best_fit"]["fit_percent"].as_f64(), Some(best));
    assert_eq!(json["compare"]["order"], serde_json::json!([3, 1, 1, 1, 1]), "a pick outside the grid");
    assert!(json["compare"]["place_by_fit"].as_u64() >= Some(1));
    let page = std::fs::read_to_string(dir.join("p.html")).expect("page");
    for words in ["Free-run fit on the validation traces", "Least AIC and MDL", "your pick"] {
        assert!(page.contains(words) && !page.contains("Not drawn"), "{words}");
    }

    let output = run(dir, &format!("structure train held {SIGNALS} --max 2,1,2,1,1 --method iv4 --compare 2,1,2,1,1"));
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && said.contains("your pick is"), "{said}");
}

#[test]
fn bad_input_is_one_line() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    traces(dir);
    let one = "structure train/healthy_1_000.csv train/healthy_1_001.csv";
    for (arguments, expected) in [
        (format!("{one} {SIGNALS} --max 0,4,4,3,3"), "no na from 1 to 0"),
        (format!("{one} {SIGNALS} --max 4,4,4,3,0"), "no nkc from 1 to 0"),
        (format!("{one} {SIGNALS} --max 4,4,4"), "write na,nb,nc,nkb,nkc"),
        (format!("{one} {SIGNALS} --max 32,32,32,32,32"), "lower --max"),
        (format!("{one} {SIGNALS} --max 2,2,2,1,1 --block-mean 1000"), "record more or lower --max"),
        (format!("{one} --y current_a --u1 nothing --u2 load_torque_nm --max 2,2,2,1,1"), "nothing"),
        (format!("{one} {SIGNALS} --max 1,1,1,1,1 --report absent/p.html"), "absent"),
    ] {
        let output = run(dir, &arguments);
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments}\n{error}");
        assert_eq!(error.trim_end().lines().count(), 1, "{arguments}\n{error}");
        assert!(error.contains(expected) && output.stdout.is_empty(), "{arguments}\n{error}");
    }
}
