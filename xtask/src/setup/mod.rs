//! Makes ready what builds of firmware, runs in the emulator and tests of pages need, without root and without touching
//! the system: what is installed in a sufficient version serves, and what is missing is fetched as Debian packages and
//! unpacked below the target directory (`debian.sh`).

mod need;

use std::env;
use std::fs::{self, File};
use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};

use crate::{child, workspace};

pub use need::{ALL, C_COMPILER, CMAKE, COMPILER, EMULATOR, MAKE, Need, PIP, PYTHON, RISCV};
pub use need::{BROWSER, browser, of_compiler, picolibc, pip};

/// Returns when all of it is there. What cannot be had is an error before anything large is fetched.
pub fn ensure(needs: &[&'static Need]) -> Result<()> {
    let is_missing = |need: &&&'static Need| !is_ready(need);
    if needs.iter().all(|need| is_ready(need)) {
        return Ok(());
    }
    fs::create_dir_all(workspace::debian())?;
    // Another run may do the same; this one then waits.
    let lock = File::create(workspace::debian().join("lock"))?;
    lock.lock()?;
    let mut missing: Vec<&Need> = Vec::new();
    for need in needs.iter().filter(is_missing) {
        if missing.iter().all(|own| own.name != need.name) {
            missing.push(need);
        }
    }
    let remedy = |need: &Need| format!("{} cannot be set up; remedy:\n    {}", need.title, remedy(need));
    if let Some(first) = missing.first().filter(|_| !child::on_path("apt-get")) {
        bail!("{}\nreason: it is not installed, and there is no apt-get to fetch it", remedy(first));
    }
    script(&["update"])?;
    for need in &missing {
        script(&["plan", need.name, need.packages]).with_context(|| remedy(need))?;
    }
    for need in missing {
        eprintln!("fetching {}", need.title);
        script(&["unpack", need.name, need.packages, need.programs, need.links]).with_context(|| remedy(need))?;
        fs::write(stamp(need), stamped(need))?;
        link(need)?;
        let serves = need.serves(&child::search_path());
        ensure!(serves, "{}\nreason: the system's packages are too old, or do not run here", remedy(need));
    }
    Ok(())
}

fn script(arguments: &[&str]) -> Result<()> {
    let script = workspace::root().join("xtask/src/setup/debian.sh");
    child::succeed(Command::new("sh").arg(script).arg(workspace::debian()).args(arguments))
}

/// Written last: the packages and the place, which the scripts contain.
fn stamp(need: &Need) -> PathBuf {
    workspace::debian().join(need.name).join("complete")
}

/// The number counts the ways of unpacking: what was unpacked another way is unpacked again.
fn stamped(need: &Need) -> String {
    format!("3\n{}\n{}\n", need.packages, stamp(need).display())
}

/// Puts the programs on the search path, if they are called by name.
fn link(need: &Need) -> Result<()> {
    #[cfg(unix)]
    for entry in workspace::debian().join(need.name).join("bin").read_dir()?.filter(|_| need.name != COMPILER.name) {
        let name = entry?.file_name();
        let place = workspace::debian().join("bin").join(&name);
        let _ = fs::remove_file(&place);
        std::os::unix::fs::symlink(PathBuf::from("..").join(need.name).join("bin").join(name), place)?;
    }
    Ok(())
}

/// Whether an installed program serves, or one that was unpacked.
pub fn is_ready(need: &Need) -> bool {
    let unpacked = fs::read_to_string(stamp(need)).is_ok_and(|text| text == stamped(need));
    let path = if unpacked { child::search_path() } else { env::var_os("PATH").unwrap_or_default() };
    need.serves(&path)
}

/// What a user can do where a need cannot be set up.
fn remedy(need: &Need) -> String {
    let installs = [
        ("apt-get", "sudo apt-get install", need.packages),
        ("brew", "brew install", need.name),
        ("dnf", "sudo dnf install", need.name),
    ];
    let known = installs.iter().find(|(program, ..)| child::on_path(program));
    match known {
        _ if need.name == COMPILER.name => "rustup target add thumbv7em-none-eabihf".to_owned(),
        Some((_, command, package)) => format!("{command} {package}"),
        None => format!("install {} by the system's package manager", need.name),
    }
}
