//! What builds of firmware, runs in the emulator and tests of pages need besides cargo: `xtask/setup.sh` fetches what is
//! missing, below the target directory.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::{child, workspace};

/// What the tests need besides firmware.
pub const ALL: [&str; 6] = ["c-compiler", "make", "cmake", "chromium", "python", "pip"];

fn script(action: &str, needs: &[&str]) -> Command {
    let mut script = Command::new("sh");
    script.arg(workspace::root().join("xtask/setup.sh")).arg(workspace::debian()).arg(action).args(needs);
    script
}

/// Returns when all of it is there.
pub fn ensure(needs: &[&str]) -> Result<()> {
    let status = child::lines(&mut script("ensure", needs), |line| eprintln!("{line}"))?;
    ensure!(status.success(), "something is missing (see above)");
    Ok(())
}

/// Whether an installed program serves, or one that was unpacked.
pub fn is_ready(need: &str) -> bool {
    child::works(&mut script("check", &[need]))
}

/// The folder of the C library for RISC-V, below that of `--picolibc-prefix`.
pub fn picolibc() -> PathBuf {
    let library = |prefix: &Path| prefix.join("usr/lib/picolibc/riscv64-unknown-elf");
    let unpacked = library(&workspace::debian().join("riscv"));
    if unpacked.is_dir() { unpacked } else { library(Path::new("/")) }
}

/// The wheel of pip that was unpacked.
pub fn pip() -> Option<PathBuf> {
    let folder = workspace::debian().join("pip/usr/share/python-wheels").read_dir().ok()?;
    let mut wheels = folder.filter_map(|entry| Some(entry.ok()?.path()));
    wheels.find(|path| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("pip-")))
}

/// A program of Debian's compiler: the one that was unpacked, else the installed one.
pub fn of_compiler(name: &str) -> PathBuf {
    let own = workspace::debian().join("compiler/bin").join(name);
    if own.is_file() { own } else { Path::new("/usr/bin").join(name) }
}

/// The Chromium that is there.
pub fn browser() -> Result<PathBuf> {
    ensure(&["chromium"])?;
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let folders: Vec<PathBuf> = env::split_paths(&child::search_path()).collect();
    let mut places = names.iter().flat_map(|name| folders.iter().map(move |folder| folder.join(name)));
    places.find(|place| place.is_file()).context("no Chromium on the search path")
}
