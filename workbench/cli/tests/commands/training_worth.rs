//! Quality of a model in `train` and `evaluate`: shrinkage, ranking, scores, and the effect of priors and costs.

use std::path::Path;

use crate::common::{refuse, succeed};
use serde_json::Value;

/// Faults too small for reliable decisions, under changing conditions.
const TRAIN: &str =
    "train --labels t/labels.csv --y current_a --u1 velocity_ref_rad_s --u2 load_torque_nm --order 2,1,2,1,1";

fn json(dir: &Path, arguments: &str) -> Value {
    serde_json::from_str(&succeed(dir, arguments)).expect("JSON")
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

#[test]
fn shrinkage_ranking_and_scores() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy,spall,roughness --count 12 --seed 6 --severity 0.25 --mix --out t");
    let arguments = format!("{TRAIN} --discriminant shrunk --rank --model m.bwm");
    let report = json(dir, &format!("{arguments} --json --report r.html"));
    let (lambda, gamma) = (number(&report["shrinkage"]["lambda"]), number(&report["shrinkage"]["gamma"]));
    assert!((0.0..=1.0).contains(&lambda) && (0.0..=1.0).contains(&gamma), "{report}");
    let scores = &report["cross_validated"];
    let (low, value, high) = (
        number(&scores["brier_score"]["low"]),
        number(&scores["brier_score"]["value"]),
        number(&scores["brier_score"]["high"]),
    );
    assert!(low < value && value < high && scores["rows"] == 36, "{scores}");
    // Equal priors of three classes: ln 3.
    assert!((number(&scores["log_score"]["prior"]) - 3_f64.ln()).abs() < 1e-9, "{scores}");
    let ranked = report["ranking"]["features"].as_array().expect("features");
    let mut names: Vec<&str> = ranked.iter().filter_map(|feature| feature["name"].as_str()).collect();
    names.sort_unstable();
    assert_eq!(names, ["a1", "a2", "b1", "c1", "c2", "log_variance"]);
    let page = std::fs::read_to_string(dir.join("r.html")).expect("page");
    for heading in ["Calibration, cross-validated", "Ranking of the features", "Shrinkage of the covariances"] {
        assert!(page.contains(heading), "{heading}");
    }
    let text = succeed(dir, &arguments);
    assert!(
        text.contains(&format!("shrunk by λ = {lambda}, γ = {gamma}")) && text.contains("gain among all"),
        "{text}"
    );

    // Folds by a column of the labels; it must exist and have at least two values in each class.
    let labels = std::fs::read_to_string(dir.join("t/labels.csv")).expect("labels");
    let with = |run: fn(usize) -> usize| {
        let rows = labels.lines().enumerate().map(|(k, line)| match k {
            0 => format!("{line},run\n"),
            _ => format!("{line},{}\n", run(k - 1)),
        });
        std::fs::write(dir.join("t/labels.csv"), rows.collect::<String>()).expect("writable");
    };
    with(|k| k % 4);
    let grouped = json(dir, &format!("{arguments} --group run --json"));
    assert_eq!(grouped["ranking"]["folds"], 4, "{}", grouped["ranking"]);
    let plain = format!("{TRAIN} --model none.bwm");
    refuse(dir, &format!("{plain} --group rum"), &["no column rum"]);
    refuse(dir, &format!("{plain} --folds 1"), &["--folds 1", "at least 2"]);
    with(|k| k / 12);
    refuse(dir, &format!("{plain} --group run --discriminant shrunk"), &["class healthy are of one group"]);
    let told = succeed(dir, &format!("{TRAIN} --group run --model m.bwm"));
    assert!(told.contains("not cross-validated: ") && told.contains("of one group"), "{told}");
}

/// Decision and posteriors of every trace.
fn verdicts(dir: &Path, options: &str) -> Vec<(String, f64, f64)> {
    succeed(dir, &format!("{TRAIN} --features a --model m.bwm {options}"));
    succeed(dir, "evaluate --model m.bwm --labels t/labels.csv --out v.csv");
    let text = std::fs::read_to_string(dir.join("v.csv")).expect("verdicts");
    let rows = text.lines().skip(1).map(|line| {
        let cells: Vec<&str> = line.split(',').collect();
        (cells[3].to_string(), cells[4].parse().expect("posterior"), cells[5].parse().expect("posterior"))
    });
    rows.collect()
}

#[test]
fn priors_and_costs_decide_where_theory_says() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy,spall --count 15 --seed 8 --severity 0.5 --out t");
    let plain = verdicts(dir, "");
    let dear = verdicts(dir, "--cost healthy:spall=50");
    let rare = verdicts(dir, "--priors healthy=0.98,spall=0.02");
    let alarms = |rows: &[(String, f64, f64)]| rows.iter().filter(|(decided, ..)| decided == "spall").count();
    assert!(alarms(&rare) < alarms(&plain) && alarms(&plain) < alarms(&dear), "the classes overlap");
    for ((plain, dear), rare) in plain.iter().zip(&dear).zip(&rare) {
        assert_eq!(plain.0 == "spall", plain.2 > plain.1);
        // Costs do not change the posterior; the decision is spall if P > 1/51.
        assert!((plain.2 - dear.2).abs() < 1e-6 && (dear.0 == "spall") == (dear.2 > 1.0 / 51.0), "{dear:?}");
        // Priors multiply the odds by 0.02/0.98; posteriors are printed with about seven digits.
        let odds = (plain.2 / plain.1, rare.2 / rare.1 * 49.0);
        assert!((odds.0 / odds.1 - 1.0).abs() < 1e-3, "{odds:?}");
    }
    let json = json(dir, "evaluate --model m.bwm --labels t/labels.csv --json");
    let mean = |of: &dyn Fn(f64, f64, usize) -> f64| {
        let each = rare.iter().enumerate().map(|(k, (_, healthy, spall))| of(*healthy, *spall, usize::from(k >= 15)));
        each.sum::<f64>() / rare.len() as f64
    };
    let log = mean(&|healthy, spall, truth| -[healthy, spall][truth].ln());
    let brier = mean(&|healthy, spall, truth| {
        if truth == 1 { healthy.powi(2) + (spall - 1.0).powi(2) } else { spall.powi(2) + (healthy - 1.0).powi(2) }
    });
    // The verdict table contains the posteriors in single precision.
    assert!((number(&json["log_score"]["value"]) - log).abs() < 1e-5, "{json} {log}");
    assert!((number(&json["brier_score"]["value"]) - brier).abs() < 1e-5, "{json} {brier}");
    let prior = 0.5 * (-0.98_f64.ln() - 0.02_f64.ln());
    assert!((number(&json["log_score"]["prior"]) - prior).abs() < 1e-5, "{json} {prior}");
}
