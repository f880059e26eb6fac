//! The ways of the book into a crate.

use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, ensure};
use serde_json::Value;

use super::{Folder, blocks, commands, copy, same_classes};
use crate::toolchain::Way;
use crate::{child, elf, firmware, qemu, workspace};

/// The chapter that goes from an empty folder to firmware.
pub const CHAPTER: &str = "book/src/firmware.md";
/// The package of both crates.
const PACKAGE: &str = "drive-monitor";
/// Where a crate says how it is run.
const CONFIGURATION: &str = ".cargo/config.toml";
/// The model and the recording of the chapter's commands.
const MODEL: &str = "examples/support/actuator/model.bwm";
const TRACE: &str = "start.csv";

/// The chapter's blocks and commands in an empty folder.
pub fn by_book(way: Way) -> Result<String> {
    let folder = Folder::new("crate")?;
    let blocks = blocks::of_document(CHAPTER)?;
    blocks::write(&blocks, folder.path(), &workspace::root())?;
    commands(&blocks, folder.path(), &workspace::root())?;
    verdicts(way, folder.path())
}

/// The template as a user copies it, with the chapter's recording.
pub fn by_template(way: Way) -> Result<String> {
    let (folder, recorded) = (Folder::new("template")?, Folder::new("recorded")?);
    let blocks = blocks::of_document(CHAPTER)?;
    copy(&workspace::root().join("template"), folder.path())?;
    blocks::write(&[blocks::named(&blocks, "Cargo.toml")?.clone()], folder.path(), &workspace::root())?;
    commands(&blocks, recorded.path(), &workspace::root())?;
    for file in ["rows.bin", TRACE] {
        fs::copy(recorded.path().join(file), folder.path().join(file))?;
    }
    verdicts(way, folder.path())
}

/// Builds the crate of a folder and runs it twice as its configuration says. The classes must be those that `replay`
/// prints for the same recording, the second run goes on with the state of the first one and ends with an alarm, and the
/// chapter must quote the first line of both.
fn verdicts(way: Way, folder: &Path) -> Result<String> {
    // The versions of the workspace, so that the outcome does not depend on the day.
    fs::copy(workspace::root().join("Cargo.lock"), folder.join("Cargo.lock"))?;
    let elf = firmware::build_crate(way, folder, PACKAGE)?;
    ensure!(elf::initialised(&elf)? == 0, "a static that starts with other bytes than zero takes flash, too");
    let run = || qemu::run_by(runner(&fs::read_to_string(folder.join(CONFIGURATION))?)?.current_dir(folder), &elf);
    let (lines, again) = (run()?, run()?);
    ensure!(again.iter().any(|line| line.ends_with(", ALARM")), "no alarm in the second run: {again:?}");
    let classes: Vec<String> = lines.iter().map(|line| line.split(',').next().unwrap_or_default().to_owned()).collect();
    let outcome = same_classes(&replayed(MODEL, &folder.join(TRACE))?, &classes)?;
    let chapter = fs::read_to_string(workspace::root().join(CHAPTER))?;
    for line in [lines.first(), again.first()] {
        let quoted = line.map(|line| format!("`{line}`")).unwrap_or_default();
        ensure!(chapter.contains(&quoted), "{CHAPTER} does not quote {quoted}");
    }
    let code = lines_of_code(&fs::read_to_string(folder.join("src/main.rs"))?);
    Ok(format!("{outcome}; {code} lines of code beside what a board has"))
}

/// Lines that are neither empty nor a comment.
fn lines_of_code(text: &str) -> usize {
    text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with("//")).count()
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

/// The command of the configuration's line `runner = "…"`.
fn runner(configuration: &str) -> Result<Command> {
    let line = configuration.lines().find_map(|line| line.strip_prefix("runner = \"")).context("no runner")?;
    let mut words = line.trim_end_matches('"').split_whitespace();
    let mut command = Command::new(words.next().context("an empty runner")?);
    command.args(words);
    Ok(command)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_runner_is_the_line_that_is_no_comment() -> Result<()> {
        let command = runner("[target.x]\n# For a board: runner = \"probe-rs run\"\nrunner = \"qemu -kernel\"\n")?;
        assert_eq!(command.get_program(), "qemu");
        assert_eq!(command.get_args().collect::<Vec<_>>(), ["-kernel"]);
        assert!(runner("[build]\n").is_err());
        Ok(())
    }
}
