//! Command-line tests of parts and training from them.

use super::common::{refuse, succeed};
use serde_json::Value;

const CHANNELS: &str = "--y current_a --u1 velocity_ref_rad_s --u2 load_torque_nm --order 2,1,1,1,1 --angle angle_rad \
    --velocity velocity_rad_s --load load_torque_nm --bearing 9,3,17,10";
const CLASSIFIER: &str = "--features drag_log,inverse_kt,order_outer --discriminant quadratic --unit drive --json";

fn json(text: &str) -> Value {
    serde_json::from_str(text).expect("JSON")
}

#[test]
fn a_model_from_parts_is_that_from_traces() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy,spall --count 36 --seed 31 --mix --out train");
    succeed(dir, "simulate --class healthy,spall --count 6 --seed 32 --mix --out test");
    let labels = std::fs::read_to_string(dir.join("train/labels.csv")).expect("labels");
    let with_drive = |(k, line): (usize, &str)| match k {
        0 => format!("{line},drive\n"),
        _ => format!("{line},d{:02}\n", (k - 1) % 36 / 2),
    };
    let all: Vec<String> = labels.lines().enumerate().map(with_drive).collect();
    std::fs::write(dir.join("train/labels.csv"), all.concat()).expect("writable");
    let features = |more: &str| {
        json(&succeed(dir, &format!("features --labels train/labels.csv {CHANNELS} --unit drive --json {more}")))
    };
    let whole = features("--out whole.parquet");
    assert_eq!((&whole["rows"], &whole["units_ascend"]), (&72.into(), &true.into()));
    // The same in two parts of drives in turn, with the plan of the first command.
    features("--plan whole.parquet --where drive!=d00 --out one.parquet");
    features("--plan whole.parquet --where drive=d00 --out two.parquet");
    let train = |from: &str| json(&succeed(dir, &format!("train-features {from} {CLASSIFIER} --model f.bwm")));
    let (once, twice) = (train("whole.parquet"), train("one.parquet two.parquet"));
    assert_eq!(once["fingerprint"], twice["fingerprint"]);
    let bytes = |from: &str| {
        train(from);
        std::fs::read(dir.join("f.bwm")).expect("a model")
    };
    assert!(bytes("whole.parquet") == bytes("two.parquet one.parquet"), "the same bytes");
    let direct = format!("train --labels train/labels.csv {CHANNELS} {CLASSIFIER} --model d.bwm");
    let direct = json(&succeed(dir, &direct));
    let number = |of: &Value, path: &str| of.pointer(path).and_then(Value::as_f64).expect("a number");
    // Errors of the friction count by class here, and by segment there; trends of runs are not found here.
    for (path, within) in [("/novelty/distance", 0.06), ("/novelty/next_run/degrees_of_freedom", 0.15)] {
        let (own, other) = (number(&once, path), number(&direct, path));
        assert!((own / other - 1.0).abs() < within, "{path}: {own} for {other}");
    }
    train("whole.parquet");
    let evaluate =
        |model: &str| json(&succeed(dir, &format!("evaluate --model {model} --labels test/labels.csv --json")));
    assert_eq!(evaluate("f.bwm")["confusion"], evaluate("d.bwm")["confusion"]);

    let fails = |arguments: &str, expected: &[&str]| refuse(dir, arguments, expected);
    let from = "train-features whole.parquet --model g.bwm";
    fails(&format!("{from} --unit rig"), &["--unit rig: the parts have drive as drives and runs"]);
    fails(&format!("{from} --covariates drag"), &["--covariates are fitted to segments, not to sums"]);
    fails(&format!("{from} --discriminant shrunk"), &["give --shrinkage"]);
    fails(&format!("{from} --classes worn"), &["no segment of class worn; there are healthy, spall"]);
    fails(&format!("{from} --features order_moon"), &["no order_moon in this model"]);
    fails("train-features train/labels.csv --model g.bwm", &["not readable as Parquet"]);
    let plan = "features --labels train/labels.csv --y current_a --u1 velocity_ref_rad_s --plan whole.parquet";
    fails(&format!("{plan} --order 2,1,0,1,1 --out x.parquet"), &["whole.parquet, plan: the channels of this command"]);
    fails(&format!("features --labels train/labels.csv {CHANNELS} --out x.csv"), &["name it .parquet"]);
}
