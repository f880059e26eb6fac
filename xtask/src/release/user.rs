//! The ways of `c-api/ARCHIVE.md` from the archive into empty projects: programs for the host, and firmware. Each must
//! print the verdicts of Rust.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};

use super::{archive, arduino, dist, platformio, zephyr};
use crate::newcomer::outcome::{Outcome, same_classes};
use crate::newcomer::{Folder, blocks, c, copy, shell, timed};
use crate::tally::Tally;
use crate::target::{brief, on_host};
use crate::{child, log, workspace};

pub const DOCUMENT: &str = "c-api/ARCHIVE.md";
/// The files of the document that go into a project of firmware.
pub const OF_FIRMWARE: [&str; 2] = ["bearing_watch.mk", "cubemx.cmake"];
/// Where the document has the unpacked archive.
pub const UNPACKED: &str = "bearing-watch";

/// A shell command in the project, and the program that it makes.
const ON_HOST: [(&str, &str, &str); 2] = [
    ("pkg-config", "make", "records"),
    ("cmake", "cmake -S . -B build -D CMAKE_PREFIX_PATH=$PWD/bearing-watch && cmake --build build", "build/records"),
];

/// Programs for the host by make and by CMake, and firmware by both.
pub fn checks(tally: &mut Tally) {
    for (program, build, result) in ON_HOST {
        let title = format!("the archive in an empty project, {program}");
        if child::on_path(program) {
            tally.check(&title, brief(records(program, build, result)));
        } else {
            tally.missing(&title, "not installed");
        }
    }
    let recorded = match Recorded::new() {
        Ok(recorded) => recorded,
        Err(reason) => return tally.check::<&str, _>("the recording", Err(format!("{reason:#}"))),
    };
    for builder in &c::BUILDERS {
        tally.check(&builder.titled("the archive in empty firmware"), brief(timed(|| firmware(builder, &recorded))));
    }
    zephyr::checks(tally, &recorded);
    platformio::checks(tally, &recorded);
    tally.check("the sketch of the archive as the Arduino IDE builds it", brief(arduino::sketch()));
}

/// The recording whose rows are in the archive.
pub struct Recorded(Folder);

impl Recorded {
    fn new() -> Result<Self> {
        let folder = Folder::new("recorded")?;
        c::write_project(folder.path(), &workspace::root())?;
        Ok(Self(folder))
    }

    /// Runs a program of a folder in the emulator, twice. The classes must be those of the host.
    pub fn outcome(&self, code: &Path, folder: &Path, program: &str) -> Result<String> {
        Outcome { document: DOCUMENT, code, trace: &self.0.path().join(c::TRACE) }.of_program(folder, program)
    }
}

fn firmware(builder: &c::Builder, recorded: &Recorded) -> Result<String> {
    let folder = Folder::new("firmware")?;
    built(builder, &project(folder.path())?, recorded)
}

/// The archive in a folder, and a copy of its project beside it.
pub fn project(folder: &Path) -> Result<PathBuf> {
    unpacked(folder)?;
    let project = folder.join("firmware");
    copy(&folder.join(UNPACKED).join("firmware"), &project)?;
    Ok(project)
}

/// Builds a project and runs it.
pub fn built(builder: &c::Builder, project: &Path, recorded: &Recorded) -> Result<String> {
    builder.build(project)?;
    recorded.outcome(&project.join("main.c"), project, builder.result)
}

fn records(name: &str, build: &str, result: &str) -> Result<String> {
    let folder = Folder::new(name)?;
    let blocks = unpacked(folder.path())?;
    blocks::write(&blocks, folder.path(), &workspace::root())?;
    child::succeed(Command::new("bash").args(["-e", "-c", build]).current_dir(folder.path()))?;
    let mut program = Command::new("bash");
    program.args(["-c", &format!("./{result} < held_out.bin")]).current_dir(folder.path());
    let text = child::output(&mut program).context("the program failed")?;
    let own: Vec<String> = text.lines().map(ToOwned::to_owned).collect();
    same_classes(&classes(&on_host("monitor")?), &classes(&own))
}

/// The verdicts among lines of an example.
pub fn classes(lines: &[String]) -> Vec<String> {
    log::verdicts(lines).into_iter().map(ToOwned::to_owned).collect()
}

/// Follows the commands of the document in a folder that has the archive; returns the document's files.
pub fn unpacked(folder: &Path) -> Result<Vec<blocks::Block>> {
    let archive = dist::find(archive::NAME, archive::ENDING)?;
    fs::copy(&archive, folder.join(archive.file_name().context("no name")?))?;
    let blocks = blocks::of_document(DOCUMENT)?;
    child::succeed(&mut shell(&blocks, folder, &workspace::root())?)?;
    Ok(blocks)
}
