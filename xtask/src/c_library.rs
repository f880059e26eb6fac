//! `cargo xtask c`: the C library in firmware that is written in C and in C++.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::board::DRIVE;
use crate::tally::{Stages, Tally};
use crate::toolchain::Way;
use crate::{child, elf, firmware, qemu, setup, target, workspace};

/// The example, which prints the lines of the Rust example [`TWIN`] but for [`LEFT_OUT`].
const EXAMPLE: &str = "isr";
const TWIN: &str = "monitor";
/// The variance of the residual and the covariance.
const LEFT_OUT: &str = "variance ";

const COMPILER: &str = "arm-none-eabi-gcc";
/// The chip of [`DRIVE`].
const CHIP: [&str; 4] = ["-mcpu=cortex-m4", "-mthumb", "-mfpu=fpv4-sp-d16", "-mfloat-abi=hard"];
const WARNINGS: [&str; 4] = ["-Wall", "-Wextra", "-Wpedantic", "-Werror"];
/// Of newlib: its small variant, and output by semihosting.
const LIBRARIES: [&str; 3] = ["--specs=nano.specs", "--specs=rdimon.specs", "-nostartfiles"];

/// A language as which the example is compiled. The same source is both.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Language {
    C,
    Cpp,
}

impl Language {
    const fn flags(self) -> &'static [&'static str] {
        match self {
            Self::C => &["-std=c11"],
            // Without the library of C++, which the package of the compiler does not have.
            Self::Cpp => &["-x", "c++", "-std=c++17", "-nostdinc++", "-fno-exceptions", "-fno-rtti"],
        }
    }

    const fn name(self) -> &'static str {
        match self {
            Self::C => "C",
            Self::Cpp => "C++",
        }
    }
}

/// What the library is built for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Plan {
    /// Every model up to fixed sizes.
    Any,
    /// The exported plan of the example's model.
    Exported,
}

impl Plan {
    const fn file(self) -> &'static str {
        match self {
            Self::Any => "",
            Self::Exported => "../examples/support/standard_rig/model.rs",
        }
    }

    const fn name(self) -> &'static str {
        match self {
            Self::Any => "any model",
            Self::Exported => "one plan",
        }
    }
}

/// What is built and compared.
const BUILDS: [(Plan, Language); 3] =
    [(Plan::Any, Language::C), (Plan::Any, Language::Cpp), (Plan::Exported, Language::C)];

/// Runs all checks and prints them, and what the library takes; whether nothing failed.
pub fn run(way: Way) -> Result<bool> {
    setup::ensure_c()?;
    let mut stages = Stages::default();
    stages.stage("C library", |tally| checks(tally, Some(way)));
    for plan in [Plan::Any, Plan::Exported] {
        println!("\nlibrary for {}", plan.name());
        let library = firmware::build_c_library(way, DRIVE, plan.file())?;
        qemu::run(&build("measure", Language::C, &library)?, DRIVE.machine, qemu::Echo::On)?;
    }
    let total = stages.total();
    println!("\n{total}");
    Ok(total.failed == 0)
}

/// The checks of the library; without firmware tools they are skipped.
pub fn checks(tally: &mut Tally, way: Option<Way>) {
    let ready = way.ok_or_else(|| target::NO_TOOLS.to_owned());
    let ready = ready.and_then(|way| setup::ensure_c().map(|()| way).map_err(|error| format!("{error:#}")));
    for (plan, language) in BUILDS {
        let title = format!("isr as {} with the library for {}", language.name(), plan.name());
        match &ready {
            Ok(way) => tally.check(&title, target::brief(check(*way, plan, language))),
            Err(reason) => tally.skip(&title, reason),
        }
    }
}

/// The library replaces no function of a C library, and the example links with it, holds no call of the panic machinery,
/// and prints the lines of Rust. Returns their number and the bytes of the program.
fn check(way: Way, plan: Plan, language: Language) -> Result<String> {
    let library = firmware::build_c_library(way, DRIVE, plan.file())?;
    symbols(&library)?;
    let program = build(EXAMPLE, language, &library)?;
    let panics = elf::symbols_with(&program, "core9panicking")?;
    ensure!(panics.is_empty(), "it calls {}", panics.join(", "));
    let lines = same_lines(&program)?;
    let sizes = elf::sizes(&program)?;
    Ok(format!("{lines} lines, {} bytes of flash, {} of RAM", sizes.flash, sizes.ram))
}

/// The library for the plan of the examples' model, the last one that [`checks`] builds.
pub fn of_example(way: Way) -> Result<PathBuf> {
    firmware::build_c_library(way, DRIVE, Plan::Exported.file())
}

/// Where objects and programs are put.
fn folder() -> PathBuf {
    workspace::target_dir().join("c")
}

/// All strong symbols are the interface's, or have a name that no C source can have or would choose.
fn symbols(library: &Path) -> Result<()> {
    let names = elf::strong_symbols(library)?;
    let (own, others): (Vec<_>, Vec<_>) = names.into_iter().partition(|name| name.starts_with("bw_"));
    let foreign: Vec<_> = others.into_iter().filter(|name| !is_mangled(name)).collect();
    ensure!(own.iter().any(|name| name == "bw_init"), "no bw_init among {own:?}");
    ensure!(foreign.is_empty(), "it defines {}", foreign.join(", "));
    Ok(())
}

/// Whether it is a name that the Rust compiler made.
fn is_mangled(name: &str) -> bool {
    ["_ZN", "_R", "anon."].iter().any(|start| name.starts_with(start)) || name.contains(".llvm.")
}

/// Compares the lines of a program with those of [`TWIN`]; returns their number.
fn same_lines(program: &Path) -> Result<usize> {
    let target = qemu::run(program, DRIVE.machine, qemu::Echo::Off)?;
    let mut host = target::on_host(TWIN)?;
    host.retain(|line| !line.contains(LEFT_OUT));
    for (number, (host, target)) in host.iter().zip(&target).enumerate() {
        ensure!(host == target, "line {}: Rust `{host}`, C `{target}`", number + 1);
    }
    ensure!(host.len() == target.len(), "{} lines of Rust, {} of C", host.len(), target.len());
    ensure!(!host.is_empty(), "neither printed anything");
    Ok(host.len())
}

/// Compiles an example and links it with the library.
fn build(example: &str, language: Language, library: &Path) -> Result<PathBuf> {
    let (root, folder) = (workspace::root(), folder());
    std::fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let examples = root.join("c-api/examples");
    let includes = [root.join("c-api/include"), root.join("examples/support/standard_rig")];
    let mut objects = Vec::new();
    for (source, flags) in [
        (format!("{example}.c"), language.flags()),
        ("board.c".to_owned(), Language::C.flags()),
        ("held_out.s".to_owned(), &[]),
    ] {
        let object = folder.join(&source).with_extension("o");
        let mut compiler = Command::new(COMPILER);
        compiler.args(CHIP).args(WARNINGS).args(["-O2", "-ffunction-sections", "-fdata-sections"]);
        for include in &includes {
            compiler.arg("-I").arg(include);
        }
        child::succeed(compiler.args(flags).arg("-c").arg(examples.join(&source)).arg("-o").arg(&object))?;
        objects.push(object);
    }
    let program = folder.join(example);
    let mut linker = Command::new(COMPILER);
    linker.args(CHIP).args(LIBRARIES).args(["-Wl,--gc-sections", "-Wl,-z,noexecstack", "-Wl,--no-warn-rwx-segments"]);
    linker.arg("-T").arg(examples.join("stm32f405.ld")).args(objects).arg(library).arg("-o").arg(&program);
    child::succeed(&mut linker)?;
    Ok(program)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_names_of_the_compiler_are_mangled() {
        assert!(is_mangled("_RNvCs_4core") && is_mangled("_ZN4core9panicking5panicE") && is_mangled("anon.1.llvm.2"));
        assert!(!is_mangled("sqrtf") && !is_mangled("memcpy") && !is_mangled("__aeabi_memcpy"));
    }
}
