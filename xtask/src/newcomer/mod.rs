//! `cargo xtask newcomer`: the documents' way into firmware, step by step, in an empty crate and in an empty C project;
//! and the crate to copy. Each must end with the verdicts of the host, and a second run with an alarm.
//!
//! Folders are outside the checkout, since cargo would merge the configuration of the checkout with theirs.

pub mod blocks;
pub mod c;
pub mod crates;
pub mod outcome;

use std::env;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use anyhow::{Context, Result};

use crate::stages::Stages;
use crate::tally::Tally;
use crate::target::brief;
use crate::toolchain::Way;
use crate::{child, workspace};

/// Follows a document and returns the classes that the firmware prints.
type Walk = fn(Way) -> Result<String>;

/// The outcome with the time from the empty folder to the alarm.
pub fn timed(walk: impl FnOnce() -> Result<String>) -> Result<String> {
    let start = Instant::now();
    let outcome = walk()?;
    Ok(format!("{outcome}; {:.1} s", start.elapsed().as_secs_f64()))
}

/// Runs the checks and prints them; whether nothing failed.
pub fn run(way: Way) -> bool {
    let mut stages = Stages::default();
    stages.stage("newcomer", |tally| checks(tally, way));
    stages.end()
}

/// All walks.
pub fn checks(tally: &mut Tally, way: Way) {
    let crates: [(&str, Walk); 2] =
        [("the book in an empty crate", crates::by_book), ("the template, copied", crates::by_template)];
    for (title, walk) in crates {
        tally.check(title, brief(timed(|| walk(way))));
    }
    c::checks(tally, way);
}

/// An empty folder outside the checkout, which is removed at the end.
#[derive(Debug)]
pub struct Folder(PathBuf);

impl Folder {
    pub fn new(name: &str) -> Result<Self> {
        let path = env::temp_dir().join(format!("bearing-watch-newcomer-{}", std::process::id())).join(name);
        if path.exists() {
            fs::remove_dir_all(&path)?;
        }
        fs::create_dir_all(&path).with_context(|| format!("cannot create {}", path.display()))?;
        Ok(Self(path))
    }

    pub fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // What cannot be removed stays in the system's folder for temporary files.
        let _ = fs::remove_dir_all(&self.0);
        let _ = self.0.parent().map(fs::remove_dir);
    }
}

/// Runs the commands of a document in a folder, with `bearing-watch` on the search path.
fn commands(blocks: &[blocks::Block], folder: &Path, checkout: &Path) -> Result<()> {
    workspace::workbench()?;
    child::succeed(shell(blocks, folder, checkout)?.env("PATH", search_path()?))
}

/// The commands of a document, which copy from a checkout and call no program of this workspace.
pub fn shell(blocks: &[blocks::Block], folder: &Path, checkout: &Path) -> Result<Command> {
    let mut shell = Command::new("bash");
    shell.args(["-e", "-c", &blocks::named(blocks, blocks::COMMANDS)?.text]).current_dir(folder);
    shell.env("BEARING_WATCH", checkout);
    Ok(shell)
}

/// The search path with the programs that this workspace builds before all others.
fn search_path() -> Result<OsString> {
    let own = workspace::target_dir().join("debug");
    Ok(env::join_paths([own].into_iter().chain(env::split_paths(&child::search_path())))?)
}

/// Copies a folder with all folders in it.
pub fn copy(from: &Path, to: &Path) -> Result<()> {
    fs::create_dir_all(to)?;
    for entry in from.read_dir().with_context(|| format!("no folder {}", from.display()))? {
        let entry = entry?;
        let target = to.join(entry.file_name());
        if entry.file_type()?.is_dir() {
            copy(&entry.path(), &target)?;
        } else {
            fs::copy(entry.path(), target)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_empty_and_is_removed() -> Result<()> {
        let folder = Folder::new("test")?;
        let path = folder.path().to_owned();
        fs::write(path.join("file"), "x")?;
        let again = Folder::new("test")?;
        assert_eq!(again.path().read_dir()?.count(), 0);
        drop((folder, again));
        assert!(!path.exists());
        Ok(())
    }
}
