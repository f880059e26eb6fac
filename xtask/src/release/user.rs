//! The ways of `c-api/ARCHIVE.md` from the archive into empty projects: programs for the host, and firmware. Each must
//! print the verdicts of Rust.

use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result};

use super::{archive, dist};
use crate::newcomer::{Folder, blocks, c, same_classes, shell};
use crate::tally::Tally;
use crate::target::{brief, on_host};
use crate::{child, log, workspace};

const DOCUMENT: &str = "c-api/ARCHIVE.md";
/// The files of the document that go into a project of firmware.
const OF_FIRMWARE: [&str; 2] = ["bearing_watch.mk", "cubemx.cmake"];

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
    for builder in &c::BUILDERS {
        let title = format!("the archive in empty firmware, {}", builder.program);
        tally.check(&title, brief(firmware(builder)));
    }
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

fn classes(lines: &[String]) -> Vec<String> {
    log::verdicts(lines).into_iter().map(ToOwned::to_owned).collect()
}

fn firmware(builder: &c::Builder) -> Result<String> {
    let folder = Folder::new(&format!("firmware-{}", builder.program))?;
    let blocks = unpacked(folder.path())?;
    c::write_project(folder.path(), &workspace::root())?;
    // These take the place of those that use a checkout.
    for name in OF_FIRMWARE {
        blocks::write(&[blocks::named(&blocks, name)?.clone()], folder.path(), &workspace::root())?;
    }
    c::verdicts(builder, folder.path())
}

/// Follows the commands of the document in a folder that has the archive; returns the document's files.
fn unpacked(folder: &Path) -> Result<Vec<blocks::Block>> {
    let archive = dist::find(archive::NAME, archive::ENDING)?;
    fs::copy(&archive, folder.join(archive.file_name().context("no name")?))?;
    let blocks = blocks::of_document(DOCUMENT)?;
    child::succeed(&mut shell(&blocks, folder, &workspace::root())?)?;
    Ok(blocks)
}
