//! Command-line tests of `bearing-watch campaign --field`.

use crate::common::{refuse, run, succeed};
use crate::form::{fit, schema};
use serde_json::Value;

#[test]
fn a_row_without_a_usable_feature_is_reported_as_refused() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    let row = "campaign --field --draws 1 --only no-load-sensor --features inverse_kt_score";
    let output = run(dir, &format!("{row} --out counts.csv"));
    let (said, words) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success() && words.starts_with("No condition has a result: training refused"), "{words}");
    let reason = "none of the features exists without a load sensor";
    assert!(said.contains(&format!("no-load-sensor, gate, 1 of 1: {reason}")), "{said}");
    let csv = std::fs::read_to_string(dir.join("counts.csv")).expect("counts");
    let lines: Vec<&str> = csv.lines().collect();
    assert_eq!(lines[0], "row,draw,kind,column,counted,opposite,undetermined,refused");
    assert_eq!(lines[1..], [format!("no-load-sensor,0,detected,,,,,{reason}")]);
    let json: Value = serde_json::from_str(&succeed(dir, &format!("{row} --json"))).expect("JSON");
    fit(&schema("campaign-field"), &json);
    assert_eq!((json["draws"].as_u64(), json["healthy_training"].as_u64()), (Some(1), Some(150)));
    assert_eq!(json["rows"][0]["refused"][0]["reason"], reason);
    assert_eq!(json["columns"].as_array().map(Vec::len), Some(8));
}

#[test]
fn wrong_arguments_are_refused() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    refuse(dir, "campaign --field --only slipp", &["no row slipp; there are mix, temperature"]);
    refuse(dir, "campaign --field --features drag_scores", &["no drag_scores in this model"]);
    refuse(dir, "campaign --only slip", &["no row slip; there are standard, mix, amplitude-0.5"]);
    refuse(dir, "campaign --ema --only mix", &["cannot be used with"]);
    for other in ["--quick", "--traces 20", "--limits --report page.html"] {
        refuse(dir, &format!("campaign --field {other}"), &["cannot be used with"]);
    }
}
