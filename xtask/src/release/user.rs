//! The ways of `c-api/ARCHIVE.md` from the archive into empty projects: programs for the host, and firmware. Each must
//! print the verdicts of Rust.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use anyhow::{Context, Result, ensure};

use super::{archive, dist};
use crate::newcomer::{Folder, blocks, c, same_classes, shell};
use crate::tally::Tally;
use crate::target::{brief, on_host};
use crate::{child, log, python, workspace};

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
    tally.check("the archive as a module of Zephyr", brief(zephyr()));
    let title = "the archive as a library of PlatformIO";
    match platformio() {
        Ok(python) => tally.check(title, brief(packed(&python))),
        Err(reason) => tally.missing(title, &format!("{reason:#}")),
    }
}

/// The functions of Zephyr that the module calls, for the program `drive`, and the module.
const ZEPHYR: &str = "
add_executable(${CMAKE_PROJECT_NAME} main.c detector.c board.c held_out.s)
target_include_directories(${CMAKE_PROJECT_NAME} PRIVATE model)
function(zephyr_include_directories)
    target_include_directories(${CMAKE_PROJECT_NAME} PRIVATE ${ARGV})
endfunction()
function(zephyr_link_libraries)
    target_link_libraries(${CMAKE_PROJECT_NAME} m c ${ARGV})
endfunction()
set(CONFIG_BEARING_WATCH y)
add_subdirectory(bearing-watch/zephyr zephyr-module)
";

/// The project of the interface's document by CMake, in which the module takes the place of the library.
fn zephyr() -> Result<String> {
    let folder = Folder::new("firmware-zephyr")?;
    unpacked(folder.path())?;
    c::write_project(folder.path(), &workspace::root())?;
    let file = folder.path().join("CMakeLists.txt");
    let text = fs::read_to_string(&file)?;
    let (settings, _) = text.split_once("add_executable(").context("the project has no program")?;
    fs::write(&file, format!("{settings}{ZEPHYR}"))?;
    let [_, cmake] = &c::BUILDERS;
    c::verdicts(cmake, folder.path())
}

/// The version of PlatformIO, and what it says where it cannot have the list of licences.
const PLATFORMIO: &str = "platformio==6.2.0";
const NO_LICENCES: &str = "{'license': ['Could not load SPDX licenses for validation']}";

/// Python of an environment with PlatformIO.
fn platformio() -> Result<PathBuf> {
    let python = python::venv(&workspace::target_dir().join("tools/platformio"), false)?;
    let mut install = Command::new(&python);
    install.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", PLATFORMIO]);
    child::succeed(&mut install).context("PlatformIO cannot be installed")?;
    Ok(python)
}

/// PlatformIO's own packer reads the manifest and takes the files.
fn packed(python: &Path) -> Result<&'static str> {
    let folder = Folder::new("platformio")?;
    unpacked(folder.path())?;
    let pack = || {
        let mut pack = Command::new(python);
        pack.args(["-m", "platformio", "pkg", "pack", "bearing-watch"]).current_dir(folder.path());
        child::captured(pack.env("PLATFORMIO_CORE_DIR", folder.path().join("core")))
    };
    let text = |output: Output| String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
    let outcome = pack()?;
    if outcome.status.success() {
        return Ok("packed");
    }
    let said = text(outcome);
    ensure!(said.contains(NO_LICENCES), "{said}");
    // Of all fields, this one alone was not right: the others are checked without it.
    let manifest = folder.path().join("bearing-watch/library.json");
    let all = fs::read_to_string(&manifest)?;
    let others: Vec<&str> = all.lines().filter(|line| !line.trim_start().starts_with("\"license\"")).collect();
    ensure!(others.len() + 1 == all.lines().count(), "the manifest has no line with its licence");
    fs::write(manifest, others.join("\n"))?;
    let outcome = pack()?;
    ensure!(outcome.status.success(), "{}", text(outcome));
    Ok("packed, with its licence unchecked: no access to the list of licences")
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
