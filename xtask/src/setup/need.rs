//! What can be missing, the Debian packages that have it, and when an installed program serves.

use std::env;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::{unpacked, version};
use crate::board::DRIVE;
use crate::{child, toolchain};

/// Programs that are missing or there together.
pub struct Need {
    /// The folder of the unpacked packages.
    pub name: &'static str,
    /// What messages call it.
    pub title: &'static str,
    pub packages: &'static [&'static str],
    /// Programs of the unpacked packages, by their places; `*` stands for the end of a name.
    pub programs: &'static [&'static str],
    /// Links that the packages make when they are installed: place and target.
    pub links: &'static [(&'static str, &'static str)],
    /// Whether they are called by their names, and so have to be on the search path.
    pub by_name: bool,
    /// Whether what is on a search path serves; for what is not called by name, the unpacked or installed one.
    pub serves: fn(&OsStr) -> bool,
    /// Where there is no apt-get: a package of most other systems.
    elsewhere: &'static str,
}

/// Debian's compiler with the library's source, and the linker. `rustc-web` is Debian's own newer compiler; the one
/// named `rustc` is too old.
pub static COMPILER: Need = Need {
    name: "compiler",
    title: "Debian's compiler for chips",
    packages: &["rustc-web", "cargo-web", "rust-web-src", "lld-19"],
    programs: &["usr/bin/rustc", "usr/bin/rustdoc", "usr/bin/cargo", "usr/bin/ld.lld-19"],
    links: &[],
    by_name: false,
    serves: |_| {
        let minimum = version::numbers(env!("CARGO_PKG_RUST_VERSION"));
        version::is_at_least(Command::new(of_compiler("rustc")).arg("--version"), &minimum)
            && ["rustdoc", "cargo", "ld.lld-19"].iter().all(|name| of_compiler(name).is_file())
            && child::output(Command::new(of_compiler("rustc")).args(["--print", "sysroot"]))
                .is_some_and(|sysroot| Path::new(&sysroot).join("lib/rustlib/src/rust/library/core").is_dir())
    },
    elsewhere: "",
};

/// The emulator. 6.0 is the first version that has all boards.
pub static EMULATOR: Need = Need {
    name: "emulator",
    title: "the emulator QEMU",
    packages: &["qemu-system-arm"],
    programs: &["usr/bin/qemu-system-arm"],
    links: &[],
    by_name: true,
    serves: |path| version::is_at_least(called("qemu-system-arm", path).arg("--version"), &[6, 0]),
    elsewhere: "qemu",
};

/// The C compiler for the chip with its C library. 12 comes with the first linker that has all options.
pub static C_COMPILER: Need = Need {
    name: "c-compiler",
    title: "the C compiler for chips",
    packages: &["gcc-arm-none-eabi", "binutils-arm-none-eabi", "libnewlib-arm-none-eabi"],
    programs: &["usr/bin/arm-none-eabi-*"],
    links: &[("usr/lib/arm-none-eabi/lib", "newlib"), ("usr/lib/arm-none-eabi/include", "../../include/newlib")],
    by_name: true,
    serves: |path| {
        let compiler = || called("arm-none-eabi-gcc", path);
        // The place of a file that it does not have is the bare name.
        version::is_at_least(compiler().arg("-dumpversion"), &[12])
            && child::output(compiler().arg("-print-file-name=nano.specs")).is_some_and(|place| place != "nano.specs")
    },
    elsewhere: "gcc-arm-embedded",
};

/// C compiler, C library and emulator for [`RISCV`](crate::board::RISCV).
pub static RISCV: Need = Need {
    name: "riscv",
    title: "compiler and emulator for RISC-V",
    packages: &[
        "gcc-riscv64-unknown-elf",
        "binutils-riscv64-unknown-elf",
        "picolibc-riscv64-unknown-elf",
        "qemu-system-misc",
    ],
    programs: &["usr/bin/riscv64-unknown-elf-*", "usr/bin/qemu-system-riscv32"],
    links: &[],
    by_name: true,
    serves: |path| {
        child::works(called("riscv64-unknown-elf-gcc", path).arg("--version"))
            && child::works(called("qemu-system-riscv32", path).arg("--version"))
            && picolibc().is_dir()
    },
    elsewhere: "riscv-gnu-toolchain",
};

/// The folder of the C library for RISC-V, below that of `--picolibc-prefix`.
pub fn picolibc() -> PathBuf {
    let library = |prefix: &Path| prefix.join("lib/picolibc/riscv64-unknown-elf");
    let unpacked = library(&unpacked::root(&RISCV).join("usr"));
    if unpacked.is_dir() { unpacked } else { library(Path::new("/usr")) }
}

/// The browser of the tests of pages and of the pictures of documents.
pub static BROWSER: Need = Need {
    name: "browser",
    title: "Chromium",
    packages: &["chromium", "fonts-dejavu-core"],
    programs: &["usr/lib/chromium/chromium"],
    links: &[],
    by_name: true,
    serves: |path| browser(path).is_some(),
    elsewhere: "chromium",
};

/// Builds the C project of the documents.
pub static MAKE: Need = Need {
    name: "make",
    title: "make",
    packages: &["make"],
    programs: &["usr/bin/make"],
    links: &[],
    by_name: true,
    serves: |path| version::is_at_least(called("make", path).arg("--version"), &[3]),
    elsewhere: "make",
};

/// Builds it too; the version is the one that the project asks for.
pub static CMAKE: Need = Need {
    name: "cmake",
    title: "CMake",
    packages: &["cmake"],
    programs: &["usr/bin/cmake"],
    links: &[],
    by_name: true,
    serves: |path| version::is_at_least(called("cmake", path).arg("--version"), &[3, 22]),
    elsewhere: "cmake",
};

/// The version of LLVM that the compilers of this repository have.
pub const LLVM_VERSION: &str = "22";

/// Reads what tests have reached.
pub static LLVM: Need = Need {
    name: "llvm",
    title: "LLVM's tools",
    packages: &["llvm-22"],
    programs: &["usr/bin/llvm-cov-22", "usr/bin/llvm-profdata-22"],
    links: &[],
    by_name: true,
    serves: |path| {
        ["llvm-cov", "llvm-profdata"]
            .iter()
            .all(|name| child::works(called(&format!("{name}-{LLVM_VERSION}"), path).arg("--help")))
    },
    elsewhere: "llvm",
};

/// For the Python package, and for programs that PyPI has.
pub static PYTHON: Need = Need {
    name: "python",
    title: "Python",
    packages: &["python3"],
    programs: &["usr/bin/python3*"],
    links: &[],
    by_name: true,
    serves: |path| child::works(called("python3", path).args(["-c", "import venv"])),
    elsewhere: "python3",
};

/// The installer of Python's packages, which Debian has apart from Python.
pub static PIP: Need = Need {
    name: "pip",
    title: "pip",
    packages: &["python3-pip-whl"],
    programs: &[],
    links: &[],
    by_name: false,
    serves: |path| child::works(called("python3", path).args(["-c", "import ensurepip"])) || pip().is_some(),
    elsewhere: "python3-pip",
};

impl Need {
    /// What a user can do where it cannot be set up.
    pub fn remedy(&self) -> String {
        if self.name == COMPILER.name {
            return toolchain::rustup_command(DRIVE.target);
        }
        let installs = [
            ("apt-get", "sudo apt-get install", self.packages.join(" ")),
            ("brew", "brew install", self.elsewhere.to_owned()),
            ("dnf", "sudo dnf install", self.elsewhere.to_owned()),
        ];
        let program = installs.iter().find(|(program, ..)| child::on_path(program));
        program.map_or_else(
            || format!("install {} by the system's package manager", self.elsewhere),
            |(_, command, package)| format!("{command} {package}"),
        )
    }
}

/// A program of Debian's compiler: the one that was unpacked, else the installed one, by its place: rustup's come first
/// on most search paths.
pub fn of_compiler(name: &str) -> PathBuf {
    let own = unpacked::program(&COMPILER, name);
    if own.is_file() { own } else { Path::new("/usr/bin").join(name) }
}

/// A program that is looked for on a search path.
fn called(program: &str, path: &OsStr) -> Command {
    let mut command = Command::new(program);
    command.env("PATH", path);
    command
}

/// The name of a Chromium on a search path.
pub fn browser(path: &OsStr) -> Option<&'static str> {
    const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];
    NAMES.into_iter().find(|name| env::split_paths(path).any(|folder| folder.join(name).is_file()))
}

/// The wheel of pip that was unpacked.
pub fn pip() -> Option<PathBuf> {
    let folder = unpacked::root(&PIP).join("usr/share/python-wheels").read_dir().ok()?;
    let mut wheels = folder.filter_map(|entry| Some(entry.ok()?.path()));
    wheels.find(|path| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("pip-")))
}
