//! What can be missing, the Debian packages that have it, and when an installed program serves.

use std::env;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};

use crate::{child, workspace};

/// Programs that are missing or there together. Lists have spaces between their words.
pub struct Need {
    /// The folder of the unpacked packages, and where there is no apt-get a package of most other systems.
    pub name: &'static str,
    /// What messages call it.
    pub title: &'static str,
    pub packages: &'static str,
    /// Programs of the unpacked packages, by their places.
    pub programs: &'static str,
    /// Links that the packages make when they are installed: `PLACE:TARGET`.
    pub links: &'static str,
    /// A command of the shell that succeeds if it is there, `$DEBIAN` being the folder of unpacked packages, and the
    /// lowest version that it may print.
    check: &'static str,
    lowest: &'static [u32],
}

const fn need(name: &'static str, title: &'static str, packages: &'static str, programs: &'static str) -> Need {
    Need { name, title, packages, programs, links: "", check: "", lowest: &[] }
}

/// What the tests need besides firmware.
pub const ALL: [&Need; 6] = [&C_COMPILER, &MAKE, &CMAKE, &BROWSER, &PYTHON, &PIP];

/// Debian's compiler with the library's source, and the linker. `rustc-web` is Debian's own newer compiler; the one
/// named `rustc` is too old. Not looked for on the search path, where rustup's come first.
pub static COMPILER: Need = Need {
    check: "folder=$DEBIAN/compiler/bin; [ -d $folder ] || folder=/usr/bin
        $folder/rustc --version && [ -d $($folder/rustc --print sysroot)/lib/rustlib/src/rust/library/core ] &&
        [ -x $folder/rustdoc -a -x $folder/cargo -a -x $folder/ld.lld-19 ]",
    lowest: &[1, 89],
    ..need(
        "compiler",
        "Debian's compiler for chips",
        "rustc-web cargo-web rust-web-src lld-19",
        "usr/bin/rustc usr/bin/rustdoc usr/bin/cargo usr/bin/ld.lld-19",
    )
};

/// The emulator. 6.0 is the first version that has all boards.
pub static EMULATOR: Need = Need {
    check: "qemu-system-arm --version",
    lowest: &[6],
    ..need("qemu", "the emulator QEMU", "qemu-system-arm", "usr/bin/qemu-system-arm")
};

/// The C compiler for the chip with its C library. 12 comes with the first linker that has all options. The place of a
/// file that it does not have is the bare name.
pub static C_COMPILER: Need = Need {
    links: "usr/lib/arm-none-eabi/lib:newlib usr/lib/arm-none-eabi/include:../../include/newlib",
    check: "arm-none-eabi-gcc -dumpversion && [ $(arm-none-eabi-gcc -print-file-name=nano.specs) != nano.specs ]",
    lowest: &[12],
    ..need(
        "gcc-arm-embedded",
        "the C compiler for chips",
        "gcc-arm-none-eabi binutils-arm-none-eabi libnewlib-arm-none-eabi",
        "usr/bin/arm-none-eabi-*",
    )
};

/// C compiler, C library and emulator for RISC-V.
pub static RISCV: Need = Need {
    check: "qemu-system-riscv32 --version && riscv64-unknown-elf-gcc --version &&
        ls -d {$DEBIAN/riscv-gnu-toolchain,}/usr/lib/picolibc/riscv64-unknown-elf | grep -q .",
    ..need(
        "riscv-gnu-toolchain",
        "compiler and emulator for RISC-V",
        "gcc-riscv64-unknown-elf binutils-riscv64-unknown-elf picolibc-riscv64-unknown-elf qemu-system-misc",
        "usr/bin/riscv64-unknown-elf-* usr/bin/qemu-system-riscv32",
    )
};

/// The browser of the tests of pages and of the pictures of documents.
pub static BROWSER: Need = Need {
    check: "command -v chromium || command -v chromium-browser || command -v google-chrome",
    ..need("chromium", "Chromium", "chromium fonts-dejavu-core", "usr/lib/chromium/chromium")
};

/// Builds the C project of the documents.
pub static MAKE: Need = Need { check: "make --version", lowest: &[3], ..need("make", "make", "make", "usr/bin/make") };

/// Builds it too; the version is the one that the project asks for.
pub static CMAKE: Need =
    Need { check: "cmake --version", lowest: &[3, 22], ..need("cmake", "CMake", "cmake", "usr/bin/cmake") };

/// For the Python package, and for programs that PyPI has.
pub static PYTHON: Need =
    Need { check: "python3 -c 'import venv'", ..need("python3", "Python", "python3", "usr/bin/python3*") };

/// The installer of Python's packages, which Debian has apart from Python.
pub static PIP: Need = Need {
    check: "python3 -c 'import ensurepip' || ls $DEBIAN/python3-pip/usr/share/python-wheels/pip-*",
    ..need("python3-pip", "pip", "python3-pip-whl", "")
};

impl Need {
    /// Whether what is on a search path serves.
    pub fn serves(&self, path: &OsStr) -> bool {
        let mut shell = Command::new("bash");
        shell.args(["-c", self.check]).env("PATH", path).env("DEBIAN", workspace::debian());
        child::output(&mut shell).is_some_and(|text| is_at_least(&text, self.lowest))
    }
}

/// Whether the first version in a text is not below this one.
fn is_at_least(text: &str, lowest: &[u32]) -> bool {
    let words = text.split(|own: char| own.is_whitespace() || "(),".contains(own));
    let numbers = |word: &str| word.split('.').map_while(|part| part.parse().ok()).collect::<Vec<u32>>();
    let version = words.map(numbers).find(|numbers| !numbers.is_empty());
    lowest.is_empty() || version.is_some_and(|version| version.as_slice() >= lowest)
}

/// The folder of the C library for RISC-V, below that of `--picolibc-prefix`.
pub fn picolibc() -> PathBuf {
    let library = |prefix: &Path| prefix.join("usr/lib/picolibc/riscv64-unknown-elf");
    let unpacked = library(&workspace::debian().join(RISCV.name));
    if unpacked.is_dir() { unpacked } else { library(Path::new("/")) }
}

/// The wheel of pip that was unpacked.
pub fn pip() -> Option<PathBuf> {
    let folder = workspace::debian().join(PIP.name).join("usr/share/python-wheels").read_dir().ok()?;
    let mut wheels = folder.filter_map(|entry| Some(entry.ok()?.path()));
    wheels.find(|path| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("pip-")))
}

/// A program of Debian's compiler: the one that was unpacked, else the installed one.
pub fn of_compiler(name: &str) -> PathBuf {
    let own = workspace::debian().join(COMPILER.name).join("bin").join(name);
    if own.is_file() { own } else { Path::new("/usr/bin").join(name) }
}

/// The Chromium that is there.
pub fn browser() -> Result<PathBuf> {
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let folders: Vec<PathBuf> = env::split_paths(&child::search_path()).collect();
    let mut places = names.iter().flat_map(|name| folders.iter().map(move |folder| folder.join(name)));
    places.find(|place| place.is_file()).context("no Chromium on the search path")
}

#[test]
fn versions_compare_by_numbers() {
    assert!(is_at_least("QEMU version 7.2.22 (Debian 1:7.2+dfsg)", &[7, 2, 22]) && !is_at_least("cmake 3.9", &[3, 22]));
    assert!(is_at_least("version 10.0", &[6, 0]) && !is_at_least("no version", &[0]) && is_at_least("", &[]));
}
