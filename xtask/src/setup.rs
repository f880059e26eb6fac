//! Makes the machine ready for firmware: installs Debian packages where it may, and otherwise
//! tells the exact command.

use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, bail};

use crate::board::DRIVE;
use crate::toolchain::{self, COMPILER, Way, installed};
use crate::{child, qemu};

const EMULATOR: &str = "qemu-system-arm";

/// Returns when everything is there that building and running this way need.
pub fn ensure(way: Way) -> Result<()> {
    if way == Way::Rustup && !toolchain::rustup_target_installed(DRIVE.target) {
        // Left to the user: it changes their toolchain.
        bail!("the target {} is not installed; run\n    {}", DRIVE.target, toolchain::rustup_command(DRIVE.target));
    }
    let mut wanted = Vec::new();
    if way == Way::Debian {
        wanted.extend(COMPILER.into_iter().filter(|package| !installed(package)));
    }
    if !child::on_path(qemu::PROGRAM) {
        wanted.push(EMULATOR);
    }
    if wanted.is_empty() { Ok(()) } else { install(&wanted).with_context(|| missing(way, &wanted)) }
}

/// Returns when the C compiler for the chip and its C library are there.
pub fn ensure_c() -> Result<()> {
    ensure_program("arm-none-eabi-gcc", &["gcc-arm-none-eabi", "libnewlib-arm-none-eabi"])
}

/// Returns when a program is there that these Debian packages have.
pub fn ensure_program(program: &str, packages: &[&str]) -> Result<()> {
    if child::on_path(program) {
        return Ok(());
    }
    let list = packages.join(" ");
    install(packages).with_context(|| {
        format!("{program} is not installed; on Debian\n    sudo apt-get install --yes {list}\nreason")
    })
}

/// Installs Debian packages, where the system allows it.
pub fn install_packages(packages: &[&str]) -> Result<()> {
    install(packages)
}

/// Returns the name of a Chromium that is there, for the tests of pages and the pictures of documents.
pub fn ensure_chromium() -> Result<&'static str> {
    const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];
    if let Some(name) = NAMES.into_iter().find(|name| child::on_path(name)) {
        return Ok(name);
    }
    ensure_program(NAMES[0], &[NAMES[0]]).map(|()| NAMES[0])
}

/// What the user is told when installing fails or is not allowed.
fn missing(way: Way, wanted: &[&str]) -> String {
    let list = wanted.join(" ");
    let mut text = format!("missing: {list}; install by\n    ");
    text += &if child::on_path("apt-get") {
        format!("sudo apt-get update && sudo apt-get install --yes {list}")
    } else if way == Way::Debian {
        format!("{} (and choose the other way: --way rustup)", toolchain::rustup_command(DRIVE.target))
    } else if child::on_path("brew") {
        "brew install qemu".to_owned()
    } else {
        format!("your system's package manager: QEMU with the program {}", qemu::PROGRAM)
    };
    if way == Way::Debian && child::on_path("rustup") {
        text += &format!("\nor do without Debian's compiler:\n    {}", toolchain::rustup_command(DRIVE.target));
    }
    text + "\nreason"
}

fn install(packages: &[&str]) -> Result<()> {
    if !child::on_path("apt-get") {
        bail!("no apt-get on this machine");
    }
    let Some(rights) = rights() else {
        bail!("neither root nor sudo without a password");
    };
    eprintln!("installing {}", packages.join(" "));
    // An old list names package versions that the mirror no longer has.
    child::succeed(apt(rights).arg("update"))?;
    let mut install = apt(rights);
    install.args(["install", "--yes", "--no-install-recommends"]);
    // A user's machine loses no package: Debian's compilers exclude each other, and a backport of `qemu-utils` excludes
    // the emulator. A machine of continuous integration is there for this run.
    if std::env::var_os("CI").is_none() {
        install.arg("--no-remove");
    }
    child::succeed(install.args(packages))
}

/// How this process may install.
#[derive(Clone, Copy)]
enum Rights {
    Root,
    Sudo,
}

fn rights() -> Option<Rights> {
    if child::output(Command::new("id").arg("-u")).is_some_and(|id| id == "0") {
        Some(Rights::Root)
    } else if child::works(Command::new("sudo").args(["-n", "true"])) {
        Some(Rights::Sudo)
    } else {
        None
    }
}

/// `apt-get` that asks nothing.
fn apt(rights: Rights) -> Command {
    let mut command = match rights {
        Rights::Root => Command::new("env"),
        Rights::Sudo => Command::new("sudo"),
    };
    if matches!(rights, Rights::Sudo) {
        command.args(["-n", "env"]);
    }
    command.args(["DEBIAN_FRONTEND=noninteractive", "apt-get", "--quiet"]);
    command
}

/// Debian's compiler, cargo and documentation tool, by their place: rustup's come first on most
/// search paths.
pub fn debian_program(name: &str) -> std::path::PathBuf {
    Path::new("/usr/bin").join(name)
}
