//! What builds of firmware, runs in the emulator and tests of pages need besides cargo: `xtask/setup.sh` fetches what
//! is missing, below the target directory.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Result, ensure};

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

/// The folder of Debian's C library for WebAssembly: the one that was unpacked, else the installed one.
pub fn library_of_wasm() -> Option<PathBuf> {
    let places = [workspace::debian().join("wasm"), PathBuf::from("/")];
    places.into_iter().map(|place| place.join("usr/lib/wasm32-wasi")).find(|folder| folder.join("libc.a").is_file())
}

/// A program of Debian's compiler: the one that was unpacked, else the installed one.
pub fn of_compiler(name: &str) -> PathBuf {
    let own = workspace::debian().join("compiler/bin").join(name);
    if own.is_file() { own } else { Path::new("/usr/bin").join(name) }
}
