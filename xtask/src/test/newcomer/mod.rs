//! The documents' ways into firmware, step by step, in an empty crate and in an empty C project, by its Makefile as C
//! and as C++, and by its files for CMake; and the crate to copy. Each must end with the verdicts of the host, and a
//! second run with an alarm.

pub mod blocks;
mod folder;

use std::env;
use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, ensure};
use serde_json::Value;

use super::c;
use crate::cargo;
use crate::child;
use crate::firmware::board::DRIVE;
use crate::firmware::build::build_crate;
use crate::firmware::way::Way;
use crate::firmware::{elf, qemu};
use crate::report::Tally;
use crate::workspace::{root, target_dir};
use blocks::Blocks;

pub use folder::Folder;
use folder::copy;

/// The chapter that goes from an empty folder to firmware.
const CHAPTER: &str = "book/src/firmware.md";
/// The document of the C interface.
const README: &str = "c-api/README.md";
/// The recording of both documents' commands, and their model.
pub const TRACE: &str = "start.csv";
const MODEL: &str = "examples/support/actuator/model.bwm";
/// Where the document has the library in a checkout; the Debian way builds it elsewhere.
const LIBRARY: &str = "target/thumbv7em-none-eabihf/release/libbearing_watch.a";

/// What the C project has besides its main program and the files of the builders.
pub const FILES: [&str; 8] = [
    "board.c",
    "board.h",
    "recorded_drive.c",
    "recorded_drive.h",
    "rows.s",
    "stm32f405.ld",
    "model/model.h",
    "model/rows.bin",
];

/// A shell command that builds the C project of the documents, and the program that it makes. g++ links with the
/// library of C++, which its package does not have and the program does not need.
pub const BUILDERS: [(&str, &str, &str); 3] = [
    ("make", "make", "drive"),
    (
        "make as C++",
        "for name in stdc++ stdc++_nano; do echo '!<arch>' > lib$name.a; done; make 'CC=arm-none-eabi-g++ -L.'",
        "drive",
    ),
    ("CMake", "cmake -S . -B build && cmake --build build", "build/drive"),
];

/// All walks.
pub fn checks(tally: &mut Tally, way: Way) {
    tally.check("the book in an empty crate", by_book(way));
    tally.check("the template, copied", by_template(way));
    for (name, build, program) in BUILDERS {
        tally.check(&format!("README of the C interface, {name}"), by_readme(way, build, program));
    }
}

/// The chapter's blocks and commands in an empty folder.
fn by_book(way: Way) -> Result<String> {
    let folder = Folder::new("crate")?;
    let blocks = Blocks::of_document(CHAPTER)?;
    blocks.write(None, folder.path(), &root())?;
    commands(&blocks, folder.path(), &root())?;
    verdicts(way, folder.path())
}

/// The template as a user copies it, with the chapter's recording.
fn by_template(way: Way) -> Result<String> {
    let (folder, recorded) = (Folder::new("template")?, Folder::new("recorded")?);
    let blocks = Blocks::of_document(CHAPTER)?;
    copy(&["."], &root().join("template"), folder.path())?;
    blocks.write(Some(&["Cargo.toml"]), folder.path(), &root())?;
    commands(&blocks, recorded.path(), &root())?;
    for file in ["rows.bin", TRACE] {
        fs::copy(recorded.path().join(file), folder.path().join(file))?;
    }
    verdicts(way, folder.path())
}

/// Builds the crate of a folder and runs it twice as its configuration says.
fn verdicts(way: Way, folder: &Path) -> Result<String> {
    // The versions of the workspace, so that the outcome does not depend on the day.
    fs::copy(root().join("Cargo.lock"), folder.join("Cargo.lock"))?;
    let elf = build_crate(way, folder, "drive-monitor", None)?;
    let initialised = elf::sizes(&elf)?.initialised;
    ensure!(initialised == 0, "a static that starts with other bytes than zero takes flash, too");
    let configuration = fs::read_to_string(folder.join(".cargo/config.toml"))?;
    let runner = configuration.lines().find_map(|line| line.strip_prefix("runner = \"")).context("no runner")?;
    let run = || {
        let mut words = runner.trim_end_matches('"').split_whitespace();
        let mut command = Command::new(words.next().context("an empty runner")?);
        qemu::run_by(command.args(words).current_dir(folder), &elf)
    };
    outcome(CHAPTER, &folder.join(TRACE), &run()?, &run()?)
}

/// The project of the document, with a checkout after the library was built in it.
fn by_readme(way: Way, build: &str, program: &str) -> Result<String> {
    let (folder, checkout) = (Folder::new("project")?, Folder::new("checkout")?);
    let parts = ["c-api/include", "c-api/examples", "examples/support/actuator"];
    copy(&parts, &root(), checkout.path())?;
    let (library, built) = (checkout.path().join(LIBRARY), c::actuator_library(way)?);
    fs::create_dir_all(library.parent().context("no folder of the library")?)?;
    // What it needs, and that it has a model of its own.
    let plan = "bearing_watch_plan.h";
    fs::copy(built.with_file_name(plan), library.with_file_name(plan)).context("the library is not for one plan")?;
    fs::copy(built, library)?;
    write_project(folder.path(), checkout.path())?;
    child::succeed(Command::new("bash").args(["-e", "-c", build]).current_dir(folder.path()))?;
    of_program(README, folder.path(), &folder.path().join(TRACE), program)
}

/// The files of the document, with those that its commands copy from a checkout and record.
pub fn write_project(folder: &Path, checkout: &Path) -> Result<()> {
    let blocks = Blocks::of_document(README)?;
    blocks.write(None, folder, checkout)?;
    commands(&blocks, folder, checkout)
}

/// Runs the commands of a document in a folder, with `bearing-watch` on the search path.
fn commands(blocks: &Blocks, folder: &Path, checkout: &Path) -> Result<()> {
    cargo::workbench()?;
    let own = [target_dir().join("debug")];
    let path = env::join_paths(own.into_iter().chain(env::split_paths(&child::search_path())))?;
    child::succeed(blocks.commands(folder, checkout)?.env("PATH", path))
}

/// Runs a program of a folder in the emulator, twice.
pub fn of_program(document: &str, folder: &Path, trace: &Path, program: &str) -> Result<String> {
    let run = || qemu::run_in(folder, &folder.join(program), DRIVE);
    outcome(document, trace, &run()?, &run()?)
}

/// The classes of the first run must be those that `replay` prints for the recording; the second run goes on with the
/// state of the first one and ends with an alarm. The document quotes the first line of both.
fn outcome(document: &str, trace: &Path, first: &[String], second: &[String]) -> Result<String> {
    ensure!(second.iter().any(|line| line.ends_with(", ALARM")), "no alarm in the second run: {second:?}");
    let classes: Vec<String> = first.iter().map(|line| line.split(',').next().unwrap_or_default().to_owned()).collect();
    let outcome = same_classes(&replayed(MODEL, trace)?, &classes)?;
    let text = fs::read_to_string(root().join(document))?;
    for line in [first.first(), second.first()].into_iter().flatten() {
        ensure!(text.contains(&format!("`{line}`")), "{document} does not quote `{line}`");
    }
    Ok(format!("{outcome}, then ALARM"))
}

/// The classes that the host prints for a trace, by a model of the repository.
pub fn replayed(model: &str, trace: &Path) -> Result<Vec<String>> {
    let mut replay = cargo::workbench()?;
    replay.args(["replay", "--json", "--model"]).arg(root().join(model)).arg(trace);
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
