//! Command-line tests of `demo-drive`: what it sends is what `listen` shows.

use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use crate::common::succeed;
use crate::form::{fit, schema};

fn drive(folder: &Path, lines: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_bearing-watch"));
    command.current_dir(folder).arg("demo-drive").stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("the command starts");
    child.stdin.take().expect("a pipe").write_all(lines.as_bytes()).expect("the command reads");
    child.wait_with_output().expect("the command ends")
}

#[test]
fn a_spall_raises_the_alarm_in_two_runs_and_a_stuck_sensor_leaves_no_verdict() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    let sent = drive(dir, "\nspall=0.5\nspall=0.5\nfault=stuck-angle\n");
    assert!(sent.status.success(), "{}", String::from_utf8_lossy(&sent.stderr));
    std::fs::write(dir.join("frames.bin"), sent.stdout).expect("writable");
    let text = succeed(dir, "listen frames.bin");
    for words in [
        "segment 2  healthy",
        "segment 3  novel",
        "ALARM at segment 6",
        "order has risen",
        "segment 8  undetermined: the angle stands",
        " 0 bad, 0 lost",
    ] {
        assert!(text.contains(words), "{words}\n{text}");
    }
    // The page as lines: a new one when the first samples come, then what changes.
    let lines = succeed(dir, "listen frames.bin --view - --json");
    let schema = schema("listen");
    let told: Vec<serde_json::Value> = lines.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    told.iter().for_each(|line| fit(&schema, line));
    let kinds: Vec<&str> = told.iter().filter_map(|line| line["kind"].as_str()).collect();
    assert_eq!(kinds[..4], ["page", "hello", "page", "report"]);
    assert_eq!(kinds.iter().filter(|kind| **kind == "report").count(), 8);
    assert!(kinds[4..].iter().all(|kind| ["news", "report", "end"].contains(kind)), "{kinds:?}");
    let last = told.iter().rfind(|line| line["kind"] == "news").expect("news");
    assert!(last["html"].as_str().is_some_and(|html| html.contains("ALARM: 3.718 order has risen")), "{last}");
}

#[test]
fn a_line_that_sets_nothing_ends_the_drive_with_its_number() {
    let folder = tempfile::tempdir().expect("folder");
    let sent = drive(folder.path(), "\nsize=2\n");
    let error = String::from_utf8_lossy(&sent.stderr);
    assert_eq!(sent.status.code(), Some(2), "{error}");
    assert!(error.contains("line 2: “size=2”: the names are spall, roughness, load"), "{error}");
}
