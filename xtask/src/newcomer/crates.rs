//! The ways of the book into a crate.

use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, ensure};

use super::outcome::Outcome;
use super::{Folder, blocks, commands, copy};
use crate::toolchain::Way;
use crate::{elf, firmware, qemu, workspace};

/// The chapter that goes from an empty folder to firmware.
pub const CHAPTER: &str = "book/src/firmware.md";
/// The package of both crates.
const PACKAGE: &str = "drive-monitor";
/// Where a crate says how it is run.
const CONFIGURATION: &str = ".cargo/config.toml";
/// The recording of the chapter's commands.
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
    blocks::write_named(&blocks, "Cargo.toml", folder.path())?;
    commands(&blocks, recorded.path(), &workspace::root())?;
    for file in ["rows.bin", TRACE] {
        fs::copy(recorded.path().join(file), folder.path().join(file))?;
    }
    verdicts(way, folder.path())
}

/// Builds the crate of a folder and runs it twice as its configuration says.
fn verdicts(way: Way, folder: &Path) -> Result<String> {
    // The versions of the workspace, so that the outcome does not depend on the day.
    fs::copy(workspace::root().join("Cargo.lock"), folder.join("Cargo.lock"))?;
    let elf = firmware::build_crate(way, folder, PACKAGE)?;
    ensure!(elf::initialised(&elf)? == 0, "a static that starts with other bytes than zero takes flash, too");
    let run = || qemu::run_by(runner(&fs::read_to_string(folder.join(CONFIGURATION))?)?.current_dir(folder), &elf);
    let outcome = Outcome { document: CHAPTER, code: &folder.join("src/main.rs"), trace: &folder.join(TRACE) };
    outcome.of(run()?, &run()?)
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
