//! What can be missing, the Debian packages that have it, and when an installed program serves.

use std::env;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};

use crate::{child, workspace};

/// Programs that are missing or there together. Lists have spaces between their words.
pub struct Need {
    /// The folder of the unpacked packages.
    pub name: &'static str,
    /// What messages call it.
    pub title: &'static str,
    pub packages: &'static str,
    /// Programs of the unpacked packages, by their places.
    pub programs: &'static str,
    /// Links that the packages make when they are installed: `PLACE:TARGET`.
    pub links: &'static str,
    /// Whether they are called by their names, and so have to be on the search path.
    pub by_name: bool,
    /// Whether what is on a search path serves; for what is not called by name, the unpacked or installed one.
    pub serves: fn(&OsStr) -> bool,
    /// Where there is no apt-get: a package of most other systems.
    pub elsewhere: &'static str,
}

/// What one program needs that is called by its name.
const fn program(
    name: &'static str,
    title: &'static str,
    packages: &'static str,
    programs: &'static str,
    serves: fn(&OsStr) -> bool,
) -> Need {
    Need { name, title, packages, programs, links: "", by_name: true, serves, elsewhere: name }
}

/// What the tests need besides firmware.
pub const ALL: [&Need; 6] = [&C_COMPILER, &MAKE, &CMAKE, &BROWSER, &PYTHON, &PIP];

/// Debian's compiler with the library's source, and the linker. `rustc-web` is Debian's own newer compiler; the one
/// named `rustc` is too old.
pub static COMPILER: Need = Need {
    name: "compiler",
    title: "Debian's compiler for chips",
    packages: "rustc-web cargo-web rust-web-src lld-19",
    programs: "usr/bin/rustc usr/bin/rustdoc usr/bin/cargo usr/bin/ld.lld-19",
    links: "",
    by_name: false,
    serves: |_| {
        is_at_least(Command::new(of_compiler("rustc")).arg("--version"), &numbers(env!("CARGO_PKG_RUST_VERSION")))
            && ["rustdoc", "cargo", "ld.lld-19"].iter().all(|name| of_compiler(name).is_file())
            && child::output(Command::new(of_compiler("rustc")).args(["--print", "sysroot"]))
                .is_some_and(|sysroot| Path::new(&sysroot).join("lib/rustlib/src/rust/library/core").is_dir())
    },
    elsewhere: "rustup target add thumbv7em-none-eabihf",
};

/// The emulator. 6.0 is the first version that has all boards.
pub static EMULATOR: Need =
    program("qemu", "the emulator QEMU", "qemu-system-arm", "usr/bin/qemu-system-arm", |path| {
        is_at_least(called("qemu-system-arm", path).arg("--version"), &[6])
    });

/// The C compiler for the chip with its C library. 12 comes with the first linker that has all options.
pub static C_COMPILER: Need = Need {
    links: "usr/lib/arm-none-eabi/lib:newlib usr/lib/arm-none-eabi/include:../../include/newlib",
    elsewhere: "gcc-arm-embedded",
    ..program(
        "c-compiler",
        "the C compiler for chips",
        "gcc-arm-none-eabi binutils-arm-none-eabi libnewlib-arm-none-eabi",
        "usr/bin/arm-none-eabi-*",
        |path| {
            let compiler = || called("arm-none-eabi-gcc", path);
            // The place of a file that it does not have is the bare name.
            is_at_least(compiler().arg("-dumpversion"), &[12])
                && child::output(compiler().arg("-print-file-name=nano.specs")).is_some_and(|own| own != "nano.specs")
        },
    )
};

/// C compiler, C library and emulator for RISC-V.
pub static RISCV: Need = Need {
    elsewhere: "riscv-gnu-toolchain",
    ..program(
        "riscv",
        "compiler and emulator for RISC-V",
        "gcc-riscv64-unknown-elf binutils-riscv64-unknown-elf picolibc-riscv64-unknown-elf qemu-system-misc",
        "usr/bin/riscv64-unknown-elf-* usr/bin/qemu-system-riscv32",
        |path| {
            let programs = ["riscv64-unknown-elf-gcc", "qemu-system-riscv32"];
            programs.iter().all(|name| child::works(called(name, path).arg("--version"))) && picolibc().is_dir()
        },
    )
};

/// The folder of the C library for RISC-V, below that of `--picolibc-prefix`.
pub fn picolibc() -> PathBuf {
    let library = |prefix: &Path| prefix.join("lib/picolibc/riscv64-unknown-elf");
    let unpacked = library(&workspace::debian().join(RISCV.name).join("usr"));
    if unpacked.is_dir() { unpacked } else { library(Path::new("/usr")) }
}

/// The browser of the tests of pages and of the pictures of documents.
pub static BROWSER: Need =
    program("chromium", "Chromium", "chromium fonts-dejavu-core", "usr/lib/chromium/chromium", |path| {
        browser_on(path).is_some()
    });

/// Builds the C project of the documents.
pub static MAKE: Need =
    program("make", "make", "make", "usr/bin/make", |path| is_at_least(called("make", path).arg("--version"), &[3]));

/// Builds it too; the version is the one that the project asks for.
pub static CMAKE: Need = program("cmake", "CMake", "cmake", "usr/bin/cmake", |path| {
    is_at_least(called("cmake", path).arg("--version"), &[3, 22])
});

/// For the Python package, and for programs that PyPI has.
pub static PYTHON: Need = program("python3", "Python", "python3", "usr/bin/python3*", |path| {
    child::works(called("python3", path).args(["-c", "import venv"]))
});

/// The installer of Python's packages, which Debian has apart from Python.
pub static PIP: Need = Need {
    by_name: false,
    ..program("python3-pip", "pip", "python3-pip-whl", "", |path| {
        child::works(called("python3", path).args(["-c", "import ensurepip"])) || pip().is_some()
    })
};

/// The wheel of pip that was unpacked.
pub fn pip() -> Option<PathBuf> {
    let folder = workspace::debian().join(PIP.name).join("usr/share/python-wheels").read_dir().ok()?;
    let mut wheels = folder.filter_map(|entry| Some(entry.ok()?.path()));
    wheels.find(|path| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("pip-")))
}

/// A program of Debian's compiler: the one that was unpacked, else the installed one, by its place: rustup's come first
/// on most search paths.
pub fn of_compiler(name: &str) -> PathBuf {
    let own = workspace::debian().join(COMPILER.name).join("bin").join(name);
    if own.is_file() { own } else { Path::new("/usr/bin").join(name) }
}

/// The name of a Chromium that is there.
pub fn browser() -> Result<&'static str> {
    browser_on(&child::search_path()).context("no Chromium on the search path")
}

fn browser_on(path: &OsStr) -> Option<&'static str> {
    const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];
    NAMES.into_iter().find(|name| env::split_paths(path).any(|folder| folder.join(name).is_file()))
}

/// A program that is looked for on a search path.
fn called(program: &str, path: &OsStr) -> Command {
    let mut command = Command::new(program);
    command.env("PATH", path);
    command
}

/// Whether the command runs and the first version that it prints is not below this one.
fn is_at_least(command: &mut Command, minimum: &[u32]) -> bool {
    let text = child::output(command).unwrap_or_default();
    let words = text.split(|own: char| own.is_whitespace() || "(),".contains(own));
    words.map(numbers).find(|numbers| !numbers.is_empty()).is_some_and(|found| found.as_slice() >= minimum)
}

/// Numbers of a version, up to what is no number; none if it does not start with one.
fn numbers(version: &str) -> Vec<u32> {
    version.split('.').map_while(|part| part.parse().ok()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_program_that_is_missing_or_too_old_does_not_serve() {
        assert!(!is_at_least(&mut Command::new("no-such-program"), &[]));
        let prints = |version: &str, minimum: &[u32]| is_at_least(Command::new("echo").arg(version), minimum);
        assert!(prints("QEMU version 7.2.22 (Debian 1:7.2+dfsg)", &[7, 2, 22]) && !prints("cmake 3.9", &[3, 22]));
        assert!(prints("version 10.0", &[6, 0]) && !prints("no version", &[0]));
    }
}
