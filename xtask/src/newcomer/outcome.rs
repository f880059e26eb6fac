//! What the firmware of a walk has printed, against the host and against the document that was followed.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use serde_json::Value;

use crate::board::DRIVE;
use crate::{child, qemu, workspace};

/// The model of the documents.
const MODEL: &str = "examples/support/actuator/model.bwm";

/// What the lines of the firmware are compared with.
pub struct Outcome<'a> {
    /// The document, which must quote the first line of both runs.
    pub document: &'a str,
    /// What a user writes.
    pub code: &'a Path,
    /// The recording.
    pub trace: &'a Path,
}

impl Outcome<'_> {
    /// Runs a program of a folder in the emulator, twice.
    pub fn of_program(&self, folder: &Path, program: &str) -> Result<String> {
        let run = || qemu::run_in(folder, &folder.join(program), DRIVE.machine, qemu::Echo::Off);
        self.of(run()?, &run()?)
    }

    /// The classes of the first run must be those that `replay` prints for the recording; the second run goes on with
    /// the state of the first one and ends with an alarm.
    pub fn of(&self, first: Vec<String>, second: &[String]) -> Result<String> {
        ensure!(second.iter().any(|line| line.ends_with(", ALARM")), "no alarm in the second run: {second:?}");
        let class = |line: &String| line.split(',').next().unwrap_or_default().to_owned();
        let classes: Vec<String> = first.iter().map(class).collect();
        let outcome = same_classes(&replayed(MODEL, self.trace)?, &classes)?;
        let document = fs::read_to_string(workspace::root().join(self.document))?;
        for line in [first.first(), second.first()].into_iter().flatten() {
            ensure!(document.contains(&format!("`{line}`")), "{} does not quote `{line}`", self.document);
        }
        let text = fs::read_to_string(self.code)?;
        let (lines, names) = (code(&text).count(), names(&text).len());
        Ok(format!(
            "{outcome}, then ALARM; {lines} lines of code beside what a board has, {names} names of the library"
        ))
    }
}

/// The classes that the host prints for a trace, by a model of the repository.
pub fn replayed(model: &str, trace: &Path) -> Result<Vec<String>> {
    let mut replay = workspace::workbench()?;
    replay.args(["replay", "--json", "--model"]).arg(workspace::root().join(model)).arg(trace);
    let text = child::output(&mut replay).context("replay failed")?;
    let segments: Vec<Value> = serde_json::from_str(&text).context("replay printed no list")?;
    let verdict = |segment: &Value| segment.get("verdict").and_then(Value::as_str).map(ToOwned::to_owned);
    segments.iter().map(|segment| verdict(segment).context("a segment has no verdict")).collect()
}

/// Compares classes; both sides must have some, and a verdict in each segment.
pub fn same_classes(host: &[String], target: &[String]) -> Result<String> {
    ensure!(!host.is_empty() && host.iter().all(|class| class != "undetermined"), "no verdict on the host: {host:?}");
    ensure!(host == target, "host {host:?}, firmware {target:?}");
    Ok(target.join(", "))
}

/// Lines that are neither empty nor a comment.
fn code(text: &str) -> impl Iterator<Item = &str> {
    let comment = |line: &str| ["//", "/*"].iter().any(|start| line.starts_with(start));
    text.lines().map(str::trim).filter(move |line| !line.is_empty() && !comment(line))
}

/// The names that a user of the library has to know: those with its prefix in C; in Rust what `model.rs` has in
/// capitals, and its functions.
fn names(text: &str) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    for word in code(text).flat_map(|line| line.split(|c: char| !(c.is_ascii_alphanumeric() || "_.".contains(c)))) {
        let (first, second) = word.split_once('.').unwrap_or((word, ""));
        if ["bw_", "BW_", "Bw"].iter().any(|prefix| first.starts_with(prefix)) {
            names.insert(first.to_owned());
        }
        if ["WATCH", "MODEL", "FRONT_END"].contains(&first) {
            names.insert(first.to_owned());
            if !second.is_empty() {
                names.insert(word.to_owned());
            }
        }
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_classes_are_required_on_both_sides() {
        let some = ["spall".to_owned()];
        assert!(same_classes(&some, &some).is_ok());
        assert!(same_classes(&some, &[]).is_err() && same_classes(&[], &[]).is_err());
        let none = ["undetermined".to_owned()];
        assert!(same_classes(&some, &none).is_err() && same_classes(&none, &none).is_err());
    }

    #[test]
    fn comments_and_other_names_do_not_count() {
        let c = "/* bw_none */\n// Bw\nBwDrive drive;\nbw_drive_sample(&drive);\nbw_drive_sample(&drive); printf();\n";
        assert_eq!(code(c).count(), 3);
        assert_eq!(names(c).into_iter().collect::<Vec<_>>(), ["BwDrive", "bw_drive_sample"]);
        let rust = "/// WATCH.none()\nWATCH.collect();\nWATCH.start(&MODEL)";
        assert_eq!(names(rust).into_iter().collect::<Vec<_>>(), ["MODEL", "WATCH", "WATCH.collect", "WATCH.start"]);
    }
}
