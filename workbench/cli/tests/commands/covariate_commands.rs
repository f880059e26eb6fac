//! Covariates on the command line.

use super::common::{refuse, rewrite_column, succeed};
use serde_json::Value;

const TRAIN: &str = "train --healthy healthy --y current_a --u1 velocity_ref_rad_s --u2 load_torque_nm --order 2,1,2,1,1 \
    --angle angle_rad --velocity velocity_rad_s --load load_torque_nm --bearing 9,3,17,10 \
    --features viscous_log,inverse_kt --labels train/labels.csv";

fn json(text: &str) -> Value {
    serde_json::from_str(text).expect("JSON")
}

#[test]
fn a_temperature_explains_friction_and_its_range_is_kept() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy --count 40 --seed 31 --condition temperature --out train");
    succeed(dir, "simulate --class healthy --count 3 --seed 32 --condition temperature --out test");
    let train = format!("{TRAIN} --covariates mean_temperature_c --model m.bwm");
    let told = succeed(dir, &format!("{train} --rust m.rs"));
    assert!(told.contains("covariate mean_temperature_c: healthy range 2") && told.contains("inverse_kt: "), "{told}");
    assert!(told.contains("(mean_temperature_c − ") && told.contains(" % of its variance"), "{told}");
    let source = std::fs::read_to_string(dir.join("m.rs")).expect("source");
    assert!(
        source.contains("averaged: temperature_c.mask(),") && source.contains("Feature::ChannelMean(2)"),
        "{source}"
    );
    let numbers = json(&succeed(dir, &format!("{train} --json")));
    // ln B falls by ln(2.5/0.4) over 80 °C: −0.0229 a kelvin; 40 records tell it to 10 %.
    let slope = numbers["covariates"]["features"][0]["terms"][0]["linear"]["value"].as_f64().expect("a number");
    assert!((-0.032..-0.014).contains(&slope), "{slope}");
    // The same record, but the thermometer shows 60 °C more than the hottest one: nothing is left to decide by.
    let record = std::fs::read_dir(dir.join("test")).expect("folder").filter_map(Result::ok);
    let name = record.map(|own| own.file_name().into_string().expect("name")).find(|name| name.contains("_000"));
    let record = dir.join("test").join(name.expect("a record"));
    rewrite_column(&record, &dir.join("hot.csv"), "temperature_c", |_| "180".into());
    let said = succeed(dir, "replay --model m.bwm hot.csv");
    assert!(said.contains("covariate mean_temperature_c is outside the range"), "{said}");
    let replayed = json(&succeed(dir, "replay --model m.bwm hot.csv --json"));
    assert_eq!(replayed[0]["covariates_out_of_range"], serde_json::json!(["mean_temperature_c"]));
    assert_eq!(
        json(&succeed(dir, "evaluate --model m.bwm --labels test/labels.csv --json"))["covariates_out_of_range"],
        0
    );
}

#[test]
fn bad_covariates_are_refused() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy --count 12 --seed 33 --condition temperature --out train");
    let with = |more: &str| format!("{TRAIN} --model n.bwm {more}");
    refuse(dir, &with("--covariates mean_pressure_pa"), &["pressure_pa", "temperature_c"]);
    refuse(dir, &with("--covariates viscosity"), &["--covariates: no viscosity"]);
    refuse(dir, &with("--covariates a1"), &["a1 is a combination"]);
    refuse(dir, &with("--covariates rms_current_a --block-mean 2"), &["root mean square"]);
}
