//! Command-line tests of `listen`: an alarm by runs says what has risen, by how much and since when.

#[path = "../../../../target-tests/examples/support/directed.rs"]
mod directed;
#[path = "../../../../target-tests/examples/support/directed_reports.rs"]
mod directed_reports;
#[path = "../../../../target-tests/examples/support/law.rs"]
mod law;

use std::path::Path;

use bearing_watch::telemetry::{Encoder, SegmentFrame, Source};
use serde_json::{Value, json};

use super::listen_command::{contents, framed};
use crate::common::succeed;
use crate::form::{fit, schema};

/// A hello and reports, of which the third feature rises from segment 61 on; each run has six segments of 0.6 s.
fn frames() -> Vec<Vec<u8>> {
    let mut encoder = Encoder::new(&directed::MODEL, Source::default());
    let mut buffer = [0; 512];
    let mut frames = vec![encoder.hello(&mut buffer).expect("fits").to_vec()];
    directed_reports::run(|report, evidence| {
        frames.push(encoder.report(report, evidence, &mut buffer).expect("fits").to_vec());
    });
    frames
}

fn listened(dir: &Path, frames: &[Vec<u8>], options: &str) -> String {
    std::fs::write(dir.join("frames.bin"), frames.concat()).expect("writable");
    succeed(dir, &format!("listen frames.bin {options}"))
}

fn alarms(text: &str) -> Vec<&str> {
    text.lines().filter(|line| line.starts_with("ALARM")).collect()
}

#[test]
fn the_line_of_an_alarm_names_what_has_risen() {
    let folder = tempfile::tempdir().expect("folder");
    let text = listened(folder.path(), &frames(), "");
    let [alarm] = alarms(&text)[..] else { panic!("{text}") };
    // A rise by 6 of segments with the variances 1 and 1/4: N = 6/1.25, and s² = 0.1 + 1/N = 0.308.
    assert_eq!(
        alarm,
        "ALARM at segment 72, after 43.2 s of segments: mean c has risen. It is 10.8 standard deviations of runs above \
         what is usual for this drive, since segment 61; mean a, mean b, mean d and mean e are as usual."
    );
    let book = include_str!("../../../../book/src/firmware.md").split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(book.contains(alarm), "the book has this line");
}

#[test]
fn values_have_the_contributions_of_all_directions() {
    let folder = tempfile::tempdir().expect("folder");
    let text = listened(folder.path(), &frames(), "--json");
    let values: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    let schema = schema("listen");
    values.iter().for_each(|line| fit(&schema, line));
    let report = |segment: usize| &values[segment];
    assert_eq!((&report(71)["segment"], &report(71)["alarm"]), (&json!(71), &Value::Null));
    let alarm = &report(72)["alarm"];
    assert_eq!([&alarm["segment"], &alarm["since"]], [72, 61], "{alarm}");
    assert!((alarm["after_s"].as_f64().expect("a time") - 43.2).abs() < 1e-9, "{alarm}");
    let directions = report(72)["directions"].as_array().expect("directions");
    let names: Vec<&Value> = directions.iter().map(|one| &one["direction"]).collect();
    assert_eq!((names.len(), names[2]), (5, &alarm["cause"]));
    assert_eq!((&directions[2]["deviations"], &directions[2]["since"]), (&alarm["deviations"], &alarm["since"]));
    assert!(directions[0]["deviations"].as_f64().expect("a number").abs() < 1.0, "{directions:?}");
}

#[test]
fn frames_of_other_versions_are_refused() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    for version in [1, 2, 4] {
        let other = frames().into_iter().map(|frame| {
            let mut content = contents(&frame);
            content[0] = version;
            framed(content)
        });
        std::fs::write(dir.join("other.bin"), other.collect::<Vec<_>>().concat()).expect("writable");
        let told = "85 frames of another format version; use the workbench of that version";
        crate::common::refuse(dir, "listen other.bin", &[told]);
    }
}

#[test]
fn the_line_of_an_alarm_over_can_names_what_has_risen_too() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    let mut log = String::new();
    directed_reports::run(|report, evidence| {
        let bytes = SegmentFrame::of(&directed::MODEL, report, evidence).to_bytes();
        let digits: String = bytes.iter().map(|byte| format!("{byte:02X}")).collect();
        log += &format!("({}.5) can0 123#{digits}\n", evidence.segments().0);
    });
    std::fs::write(dir.join("bus.log"), &log).expect("writable");
    let text = succeed(dir, "listen bus.log --can-id 0x123");
    let [alarm] = alarms(&text)[..] else { panic!("{text}") };
    assert!(alarm.starts_with("ALARM at segment 72, 72.500 s: coordinate 3 has risen. It is "), "{alarm}");
    assert!(alarm.ends_with(" standard deviations of runs above what is usual for this drive."), "{alarm}");
    // The last step of the signal.
    let most = log.lines().last().expect("a frame").split_once('#').expect("data").1;
    std::fs::write(dir.join("most.log"), format!("(1.0) can0 123#{}FF{}\n", &most[..10], &most[12..]))
        .expect("writable");
    assert!(succeed(dir, "listen most.log --can-id 0x123").contains("It is at least 63.8 standard deviations"));
}
