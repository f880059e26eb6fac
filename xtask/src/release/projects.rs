//! The ways of `c-api/ARCHIVE.md` from the archive into empty projects: programs for the host, and firmware, by the
//! build systems that the archive has files for. Each must print the verdicts of Rust.

use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::Result;

use crate::cargo::lines_of_example;
use crate::child;
use crate::firmware::board::{DRIVE, RISCV};
use crate::firmware::qemu;
use crate::python::with_packages;
use crate::report::Tally;
use crate::test::newcomer::blocks::Blocks;
use crate::test::newcomer::{self, BUILDERS, Folder, same_classes};
use crate::test::{compared, verdicts};
use crate::workspace::{debian, root};

/// The document of the archive.
pub const DOCUMENT: &str = "c-api/ARCHIVE.md";

/// How the program of a project is run, and what its lines are compared with.
#[derive(Clone, Copy, Debug)]
enum Run {
    /// On the host, with the verdicts of the example `monitor`.
    OnHost,
    /// On the drive's chip, with the same.
    Sketch,
    /// On RISC-V, with all lines of that example.
    Riscv,
    /// On the drive's chip twice, with `replay` of the documents' recording.
    Twice,
}

/// A project: what it uses, packages of PyPI that it needs, a shell command that builds it beside the unpacked archive
/// and the files of the document, the folder where its program runs, the program, and how it runs.
type Project = (&'static str, &'static [&'static str], &'static str, &'static str, &'static str, Run);

const PROJECTS: [Project; 6] = [
    ("pkg-config", &[], "make", "", "records", Run::OnHost),
    (
        "CMake",
        &[],
        "cmake -S . -B build -D CMAKE_PREFIX_PATH=$PWD/bearing-watch && cmake --build build",
        "",
        "build/records",
        Run::OnHost,
    ),
    ("Zephyr", &["kconfiglib==14.1.0"], "sh $TESTS/zephyr/build.sh", "firmware", "build/drive", Run::Twice),
    (
        "PlatformIO",
        &["platformio==6.2.0", "scons==4.11.1"],
        "sh $TESTS/platformio/build.sh",
        "project",
        ".pio/build/drive/program",
        Run::Twice,
    ),
    ("the Arduino IDE", &[], "sh $TESTS/arduino/build.sh", "", "sketch", Run::Sketch),
    ("ESP-IDF", &["idf-component-manager==3.1.2"], "sh $TESTS/riscv/build.sh", "", "build/isr", Run::Riscv),
];

/// All projects, with the archive in a folder.
pub fn checks(tally: &mut Tally, dist: &Path) {
    let recorded = Folder::new("recorded");
    let recorded = recorded.and_then(|own| newcomer::write_project(own.path(), &root()).map(|()| own));
    let recorded = match recorded {
        Ok(recorded) => recorded,
        Err(reason) => return tally.check("the recording", Err::<&str, _>(reason)),
    };
    let trace = recorded.path().join(newcomer::TRACE);
    for (name, packages, build, folder, program, run) in PROJECTS {
        let title = format!("the archive in an empty project, {name}");
        match with_packages(&format!("for {name}").replace(' ', "-"), packages) {
            Ok(python) => tally.check(&title, walk((build, &python), folder, program, run, (dist, &trace))),
            Err(reason) => tally.missing(&title, &format!("{reason:#}")),
        }
    }
    for (name, build, program) in BUILDERS {
        let (title, here) = (format!("the archive in empty firmware, {name}"), Path::new(""));
        let build = format!("cp -r bearing-watch/firmware . && cd firmware && {build}");
        tally.check(&title, walk((&build, here), "firmware", program, Run::Twice, (dist, &trace)));
    }
}

/// Follows the commands of the document in an empty folder, builds the project, and runs its program.
fn walk(
    (build, python): (&str, &Path),
    place: &str,
    program: &str,
    run: Run,
    (dist, trace): (&Path, &Path),
) -> Result<String> {
    let (folder, blocks) = (Folder::new("project")?, Blocks::of_document(DOCUMENT)?);
    let packed = format!("bearing-watch-c-{}.tar.gz", env!("CARGO_PKG_VERSION"));
    fs::copy(dist.join(&packed), folder.path().join(packed))?;
    child::succeed(&mut blocks.commands(folder.path(), &root())?)?;
    blocks.write(None, folder.path(), &root())?;
    let mut shell = Command::new("bash");
    shell.args(["-e", "-c", build]).current_dir(folder.path()).env("PYTHON", python).env("CHECKOUT", root());
    shell.env("TESTS", root().join("c-api/tests")).env("DEBIAN", debian());
    child::succeed(&mut shell)?;
    let (place, monitor) = (folder.path().join(place), || lines_of_example("monitor"));
    match run {
        Run::OnHost => {
            let mut command = Command::new("bash");
            command.args(["-c", &format!("./{program} < held_out.bin")]).current_dir(place);
            same_classes(&verdicts(&monitor()?), &verdicts(&child::printed(&mut command)?))
        }
        Run::Sketch => same_classes(&verdicts(&monitor()?), &verdicts(&qemu::run(&place.join(program), DRIVE)?)),
        Run::Riscv => compared(monitor()?, &qemu::run(&place.join(program), RISCV)?),
        Run::Twice => newcomer::of_program(DOCUMENT, &place, trace, program),
    }
}
