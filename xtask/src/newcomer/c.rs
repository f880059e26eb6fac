//! The way of c-api/README.md into an empty C project, by its Makefile as C and as C++, and by its files for CMake.

use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, ensure};

use super::outcome::Outcome;
use super::{Folder, blocks, commands, copy, timed};
use crate::board::DRIVE_FLAGS;
use crate::tally::Tally;
use crate::target::brief;
use crate::toolchain::Way;
use crate::{c_library, child, workspace};

const README: &str = "c-api/README.md";
/// What the project takes of a checkout.
const PARTS: [&str; 3] = ["c-api/include", "c-api/examples", "examples/support/actuator"];
/// The recording of the document's commands.
pub const TRACE: &str = "start.csv";
/// Where the document has the library in a checkout; the Debian way builds it elsewhere.
const LIBRARY: &str = "target/thumbv7em-none-eabihf/release/libbearing_watch.a";

/// The header that is made with a library for one plan.
const PLAN: &str = "bearing_watch_plan.h";

/// What the project has besides its main program and the files of the builders.
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

/// A program that builds the project.
pub struct Builder {
    title: &'static str,
    program: &'static str,
    /// The arguments of each call.
    calls: &'static [&'static [&'static str]],
    /// What they build.
    pub result: &'static str,
}

pub const BUILDERS: [Builder; 3] = [
    Builder { title: "make", program: "make", calls: &[&[]], result: "drive" },
    // g++ links with the library of C++, which its package does not have and the program does not need.
    Builder { title: "make as C++", program: "make", calls: &[&["CC=arm-none-eabi-g++ -L."]], result: "drive" },
    Builder {
        title: "CMake",
        program: "cmake",
        calls: &[&["-S", ".", "-B", "build"], &["--build", "build"]],
        result: "build/drive",
    },
];

/// All builds must print the classes of the host, and go on to the alarm.
pub fn checks(tally: &mut Tally, way: Way) {
    for builder in &BUILDERS {
        tally.check(&builder.titled("README of the C interface"), brief(timed(|| walk(way, builder))));
    }
    tally.check("README of the C interface, samples of the drive's own", brief(own_samples()));
}

fn walk(way: Way, builder: &Builder) -> Result<String> {
    let (folder, checkout) = (Folder::new("project")?, Folder::new("checkout")?);
    fill(checkout.path(), way)?;
    write_project(folder.path(), checkout.path())?;
    builder.build(folder.path())?;
    let [code, trace] = ["main.c", TRACE].map(|file| folder.path().join(file));
    Outcome { document: README, code: &code, trace: &trace }.of_program(folder.path(), builder.result)
}

/// The files of the document, with those that its commands copy from a checkout and record.
pub fn write_project(folder: &Path, checkout: &Path) -> Result<()> {
    let blocks = blocks::of_document(README)?;
    blocks::write(&blocks, folder, checkout)?;
    commands(&blocks, folder, checkout)
}

impl Builder {
    /// The name of a check.
    pub fn titled(&self, way: &str) -> String {
        format!("{way}, {}", self.title)
    }

    /// Builds the project of a folder.
    pub fn build(&self, folder: &Path) -> Result<()> {
        for empty in ["libstdc++.a", "libstdc++_nano.a"] {
            fs::write(folder.join(empty), "!<arch>\n")?;
        }
        self.calls
            .iter()
            .try_for_each(|arguments| child::succeed(Command::new(self.program).args(*arguments).current_dir(folder)))
    }
}

/// The program for a drive with samples of its own compiles with the model of such a drive.
fn own_samples() -> Result<&'static str> {
    let folder = Folder::new("own-samples")?;
    blocks::write_named(&blocks::of_document(README)?, "detector.c", folder.path())?;
    let mut compiler = Command::new("arm-none-eabi-gcc");
    compiler.args(DRIVE_FLAGS).args(["-std=c99", "-Wall", "-Wextra", "-Werror", "-fsyntax-only"]);
    for include in ["c-api/include", "c-api/tests/chip", "examples/support/standard_rig"] {
        compiler.arg("-I").arg(workspace::root().join(include));
    }
    child::succeed(compiler.arg(folder.path().join("detector.c")))?;
    Ok("it compiles")
}

/// A checkout after the library was built in it.
fn fill(checkout: &Path, way: Way) -> Result<()> {
    for part in PARTS {
        copy(&workspace::root().join(part), &checkout.join(part))?;
    }
    let library = checkout.join(LIBRARY);
    fs::create_dir_all(library.parent().context("no folder of the library")?)?;
    let built = c_library::of_actuator(way)?;
    // What it needs, and that it has a model of its own.
    let plan = built.with_file_name(PLAN);
    ensure!(plan.exists(), "the library is not for one plan");
    fs::copy(plan, library.with_file_name(PLAN))?;
    fs::copy(built, library)?;
    Ok(())
}
