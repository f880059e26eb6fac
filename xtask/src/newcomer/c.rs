//! The way of c-api/README.md into an empty C project, by its Makefile and by its files for CMake.

use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result};

use super::{Folder, blocks, copy, same_classes, shell};
use crate::board::DRIVE;
use crate::tally::Tally;
use crate::target::{brief, on_host};
use crate::toolchain::Way;
use crate::{c_library, child, log, qemu, workspace};

const README: &str = "c-api/README.md";
/// What the project takes of a checkout.
const PARTS: [&str; 3] = ["c-api/include", "c-api/examples", "examples/support/standard_rig"];
/// Where the document has the library in a checkout; the Debian way builds it elsewhere.
const LIBRARY: &str = "target/thumbv7em-none-eabihf/release/libbearing_watch.a";

/// The header that is made with a library for one plan.
const PLAN: &str = "bearing_watch_plan.h";

/// A program that builds the project.
pub struct Builder {
    title: &'static str,
    pub program: &'static str,
    /// The arguments of each call.
    calls: &'static [&'static [&'static str]],
    /// What they build.
    result: &'static str,
}

pub const BUILDERS: [Builder; 2] = [
    Builder { title: "README of the C interface, make", program: "make", calls: &[&[]], result: "drive" },
    Builder {
        title: "README of the C interface, CMake",
        program: "cmake",
        calls: &[&["-S", ".", "-B", "build"], &["--build", "build"]],
        result: "build/drive",
    },
];

/// Both builds must print the classes of the Rust example on the host.
pub fn checks(tally: &mut Tally, way: Way) {
    for builder in &BUILDERS {
        tally.check(builder.title, brief(walk(way, builder)));
    }
}

fn walk(way: Way, builder: &Builder) -> Result<String> {
    let (folder, checkout) = (Folder::new(builder.program)?, Folder::new("checkout")?);
    fill(checkout.path(), way)?;
    write_project(folder.path(), checkout.path())?;
    verdicts(builder, folder.path())
}

/// The files of the document, with those that its commands copy from a checkout.
pub fn write_project(folder: &Path, checkout: &Path) -> Result<()> {
    let blocks = blocks::of_document(README)?;
    blocks::write(&blocks, folder, checkout)?;
    child::succeed(&mut shell(&blocks, folder, checkout)?)
}

/// Builds the project and runs it in the emulator. The classes must be those of the Rust example on the host.
pub fn verdicts(builder: &Builder, folder: &Path) -> Result<String> {
    for arguments in builder.calls {
        child::succeed(Command::new(builder.program).args(*arguments).current_dir(folder))?;
    }
    let target = qemu::run(&folder.join(builder.result), DRIVE.machine, qemu::Echo::Off)?;
    let host: Vec<String> = log::verdicts(&on_host("monitor")?).into_iter().map(ToOwned::to_owned).collect();
    same_classes(&host, &target)
}

/// A checkout after the library was built in it.
fn fill(checkout: &Path, way: Way) -> Result<()> {
    for part in PARTS {
        copy(&workspace::root().join(part), &checkout.join(part))?;
    }
    let library = checkout.join(LIBRARY);
    fs::create_dir_all(library.parent().context("no folder of the library")?)?;
    let built = c_library::of_example(way)?;
    // What it needs, and that it has a model of its own.
    fs::copy(built.with_file_name(PLAN), library.with_file_name(PLAN))?;
    fs::copy(built, library)?;
    Ok(())
}
