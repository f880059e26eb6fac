//! The C library for RISC-V: the archive as a component of ESP-IDF. The example with interrupts runs in the emulator
//! and must print the bits of the host.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};

use super::user;
use crate::board::RISCV;
use crate::newcomer::Folder;
use crate::tally::Tally;
use crate::target::{brief, on_host};
use crate::toolchain::{self, Way};
use crate::{c_library, c_symbols, child, firmware, python, qemu, setup, workspace};

/// The stand-ins of ESP-IDF's functions, with the board.
const PROJECT: &str = "c-api/tests/riscv";
/// ESP-IDF's own packer of components.
const PACKER: &str = "idf-component-manager==3.1.2";

/// The library of this architecture, for the archive.
pub fn library(way: Way) -> Result<PathBuf> {
    if let Some(hindrance) = toolchain::hindrance(way, RISCV.target) {
        bail!("{hindrance}");
    }
    setup::ensure(&[&setup::RISCV])?;
    let library = firmware::build_c_library(way, RISCV, "", "")?;
    c_symbols::check(&library)?;
    Ok(library)
}

/// The archive in a project, and packed.
pub fn checks(tally: &mut Tally) {
    tally.check("the archive as a component of ESP-IDF, on RISC-V", brief(component()));
    let title = "the archive packed by ESP-IDF's component manager";
    match python::with_packages("esp-idf", &[PACKER]) {
        Ok(python) => tally.check(title, brief(packed(&python))),
        Err(reason) => tally.missing(title, &format!("{reason:#}")),
    }
}

fn component() -> Result<String> {
    let folder = Folder::new("esp-idf")?;
    user::unpacked(folder.path())?;
    let define = |name: &str, place: &Path| format!("-D{name}={}", place.display());
    let build = folder.path().join("build");
    let mut cmake = Command::new("cmake");
    cmake.arg("-S").arg(workspace::root().join(PROJECT)).arg("-B").arg(&build);
    cmake.arg(define("ARCHIVE", &folder.path().join(user::UNPACKED))).arg(define("PICOLIBC", &setup::picolibc()));
    child::succeed(&mut cmake)?;
    child::succeed(Command::new("cmake").arg("--build").arg(&build))?;
    let target = qemu::run_riscv(&build.join("isr"), RISCV.machine)?;
    Ok(format!("the {} lines of the host", c_library::compared(on_host("monitor")?, &target)?))
}

/// It reads the manifest and packs the files.
fn packed(python: &Path) -> Result<String> {
    let folder = Folder::new("esp-idf-pack")?;
    user::unpacked(folder.path())?;
    let mut pack = Command::new(python.with_file_name("compote"));
    pack.args(["component", "pack", "--name", user::UNPACKED, "--dest-dir"]).arg(folder.path().join("dist"));
    child::succeed(pack.current_dir(folder.path().join(user::UNPACKED)))?;
    let made = fs::read_dir(folder.path().join("dist"))?.next().context("nothing was packed")??;
    Ok(made.file_name().to_string_lossy().into_owned())
}
