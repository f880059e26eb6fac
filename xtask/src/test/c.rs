//! The C library in firmware that is written in C and in C++.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

use super::pil;
use super::target::equal;
use crate::cargo::lines_of_example;
use crate::child;
use crate::cost::bounds;
use crate::firmware::board::{DRIVE, DRIVE_FLAGS};
use crate::firmware::build::{self, c_library};
use crate::firmware::way::Way;
use crate::firmware::{elf, qemu};
use crate::report::Tally;
use crate::workspace::{root, target_dir};

/// Folders of models: of samples, with recorded traces; and of raw counts, with a front end.
const RIG: &str = "examples/support/standard_rig";
const ACTUATOR: &str = "examples/support/actuator";

/// What Rust prints of numbers that the C interface does not give: the variance of the residual and the covariance, and
/// the hash of all numbers.
const LEFT_OUT: [&str; 2] = ["variance ", "all numbers "];

/// An example, the Rust example that prints the same lines, its model, and features of the library.
type Example = (&'static str, &'static str, &'static str, &'static str);

const SIGNED: Example = ("signed", "signed", RIG, "signature");
const ISR: Example = ("isr", "monitor", RIG, "");
const DRIVE_OF_COUNTS: Example = ("drive", "drive", ACTUATOR, "");
const TELEMETRY: Example = ("telemetry", "telemetry", RIG, "");

const C: &[&str] = &["-std=c99"];
/// Without the library of C++, which the package of the compiler does not have.
const CPP: &[&str] = &["-x", "c++", "-std=c++17", "-nostdinc++", "-fno-exceptions", "-fno-rtti"];

/// What is built and compared: the model of the library for one plan, or none of the one for any model. Builds of one
/// library follow each other.
const BUILDS: [(Option<&str>, Example, &[&str]); 11] = [
    (None, SIGNED, C),
    (None, SIGNED, CPP),
    (None, ISR, C),
    (None, ISR, CPP),
    (None, DRIVE_OF_COUNTS, C),
    (None, DRIVE_OF_COUNTS, CPP),
    (None, TELEMETRY, C),
    (None, TELEMETRY, CPP),
    (Some(RIG), ISR, C),
    (Some(RIG), TELEMETRY, C),
    (Some(ACTUATOR), DRIVE_OF_COUNTS, C),
];

/// Programs that count instructions and bytes, and their models; the library is for one plan or for any model.
const MEASURED: [(Option<&str>, &str, &str); 6] = [
    (None, "measure", RIG),
    (None, "measure_telemetry", RIG),
    (None, "measure_front_end", ACTUATOR),
    (Some(RIG), "measure", RIG),
    (Some(RIG), "measure_telemetry", RIG),
    (Some(ACTUATOR), "measure_front_end", ACTUATOR),
];

fn library(way: Way, plan: Option<&str>, features: &str, settings: &[&str]) -> Result<PathBuf> {
    // Taken by the build of the package, in its folder.
    let plan = plan.map_or_else(String::new, |folder| format!("../{folder}/model.rs"));
    c_library((way, DRIVE), &plan, features, settings)
}

/// The library for the plan of the simulated actuator.
pub fn actuator_library(way: Way) -> Result<PathBuf> {
    library(way, Some(ACTUATOR), "", &[])
}

/// Prints what the library takes.
pub fn measure(way: Way) -> Result<()> {
    for (plan, name, model) in MEASURED {
        let lines = qemu::run(&example(name, model, C, &library(way, plan, "", &[])?)?, DRIVE)?;
        println!("\nlibrary for {}\n{}", plan.unwrap_or("any model"), lines.join("\n"));
    }
    let (added, ram) = whole_drive(&library(way, Some(ACTUATOR), "", build::SMALLEST)?)?;
    println!("\na whole drive adds {added} bytes of flash, built for size; it has {ram} of RAM");
    Ok(())
}

/// The checks of the library.
pub fn checks(tally: &mut Tally, way: Way) {
    for (plan, own, language) in BUILDS {
        let language_name = if language == C { "C" } else { "C++" };
        let title = format!("{} as {language_name} with the library for {}", own.0, plan.unwrap_or("any model"));
        tally.check(&title, check(way, plan, own, language));
    }
    tally.check("what a whole drive adds to a program", actuator_library(way).and_then(|own| bounded_drive(&own)));
    let outcome = library(way, Some(RIG), "", &[]).and_then(|library| orders(&library));
    tally.check("a program has the same functions of newlib with the library, in any order", outcome);
}

/// The library exports its interface only, and the example links with it, holds no call of the panic machinery, and
/// prints the lines of Rust. Returns their number and the bytes of the program.
fn check(way: Way, plan: Option<&str>, own: Example, language: &[&str]) -> Result<String> {
    let (name, twin, model, features) = own;
    let library = library(way, plan, features, &[])?;
    elf::ensure_exports(&library)?;
    let program = example(name, model, language, &library)?;
    // The crate that verifies indexes arrays, which the compiler cannot prove.
    if own != SIGNED {
        elf::ensure_no_panic(&program)?;
    }
    let rust = || anyhow::Ok((PathBuf::from("."), lines_of_example(twin)?));
    let (folder, host) = if own == DRIVE_OF_COUNTS { pil::host_lines()? } else { rust()? };
    let lines = compared(host, &qemu::run_in(&folder, &program, DRIVE)?)?;
    let sizes = elf::sizes(&program)?;
    Ok(format!("{lines}, {} bytes of flash, {} of RAM", sizes.flash, sizes.ram))
}

/// Compares the lines of Rust on the host, but for those that C does not print, with those of C.
pub fn compared(mut host: Vec<String>, target: &[String]) -> Result<String> {
    host.retain(|line| !LEFT_OUT.iter().any(|words| line.contains(words)));
    equal(&host, target)
}

/// A call of a compiler or linker for the drive's chip.
fn compiler(name: &str) -> Command {
    let mut compiler = Command::new(format!("arm-none-eabi-{name}"));
    compiler.args(DRIVE_FLAGS);
    compiler
}

/// Compiles a source of `c-api` for a library and a model.
fn compile(source: &str, (library, model): (&Path, &str), flags: &[&str], object: &Path) -> Result<()> {
    let mut gcc = compiler("gcc");
    gcc.args(["-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O2", "-ffunction-sections", "-fdata-sections"]);
    for include in ["c-api/include", model] {
        gcc.arg("-I").arg(root().join(include));
    }
    // The header of a library for one plan lies beside it.
    gcc.arg("-I").arg(library.parent().unwrap_or(library)).args(flags);
    child::succeed(gcc.arg("-c").arg(root().join("c-api").join(source)).arg("-o").arg(object))
}

/// A folder for objects and programs.
fn folder(name: &str) -> Result<PathBuf> {
    let folder = target_dir().join("c").join(name);
    fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
    Ok(folder)
}

const LINKED: [&str; 4] =
    ["--specs=nano.specs", "-Wl,--gc-sections", "-Wl,-z,noexecstack", "-Wl,--no-warn-rwx-segments"];
const MAP: &str = "c-api/examples/stm32f405.ld";

/// Compiles an example and links it with the library.
fn example(name: &str, model: &str, language: &[&str], library: &Path) -> Result<PathBuf> {
    let (folder, mut linker) = (folder("")?, compiler("gcc"));
    let data = if name == "signed" { "signed_model.s" } else { "held_out.s" };
    let main = format!("{name}.c");
    let mut sources = vec![(main.as_str(), language), ("board.c", C)];
    sources.extend((model == RIG).then_some((data, &[] as &[&str])));
    for (source, flags) in sources {
        let object = folder.join(source).with_extension("o");
        compile(&format!("examples/{source}"), (library, model), flags, &object)?;
        linker.arg(object);
    }
    let program = folder.join(name);
    // Output by semihosting.
    linker
        .args(LINKED)
        .args(["--specs=rdimon.specs", "-nostartfiles"])
        .arg("-T")
        .arg(root().join(MAP))
        .arg(library)
        .arg("-o")
        .arg(&program);
    child::succeed(&mut linker)?;
    Ok(program)
}

/// The bytes of flash that a whole drive adds, and its RAM.
fn whole_drive(library: &Path) -> Result<(u64, u64)> {
    let bare = Bare { name: "whole_drive", model: ACTUATOR, library, folder: folder("whole_drive")? };
    let alone = elf::sizes(&bare.alone()?)?.flash;
    let sizes = elf::sizes(&bare.link("gcc", &["PROGRAM", "-lm", "-lc", "LIBRARY"], &bare.compile(&[])?)?)?;
    Ok((sizes.flash - alone, sizes.ram))
}

/// The same in words, if it is within its bound.
fn bounded_drive(library: &Path) -> Result<String> {
    let ((added, ram), most) = (whole_drive(library)?, bounds::number("drive_in_c")?);
    ensure!(added <= most, "{added} bytes of flash; {most} are allowed");
    Ok(format!("{added} bytes of flash, {ram} of RAM"))
}

/// Functions that Rust brings along too.
const SHARED: [&str; 4] = ["sinf", "cosf", "memcpy", "__aeabi_dmul"];

/// The linkers, and what each gets; `LIBRARY` stands for the one that is checked.
const ORDERS: [(&str, &[&str]); 5] = [
    ("gcc", &["PROGRAM", "-lm", "-lc", "LIBRARY"]),
    ("gcc", &["PROGRAM", "LIBRARY", "-lm", "-lc"]),
    ("gcc", &["-Wl,--start-group", "LIBRARY", "-lm", "-lc", "PROGRAM", "-Wl,--end-group"]),
    ("g++", &["PROGRAM", "LIBRARY"]),
    ("g++", &["LIBRARY", "PROGRAM", "LIBRARY"]),
];

/// Links a program with the library in all [`ORDERS`]: its functions of the C library must be those that it has without
/// it. Returns the bytes of flash that the library adds.
fn orders(library: &Path) -> Result<String> {
    let bare = Bare { name: "beside_newlib", model: RIG, library, folder: folder("orders")? };
    let sizes = |program: &Path| -> Result<(BTreeMap<String, u64>, u64)> {
        Ok((elf::global_sizes(program, &SHARED)?, elf::sizes(program)?.flash))
    };
    let (expected, alone) = sizes(&bare.alone()?)?;
    ensure!(expected.len() == SHARED.len(), "the program has {expected:?} of {SHARED:?}");
    let (object, mut added) = (bare.compile(&[])?, Vec::new());
    for (linker, order) in ORDERS {
        let (linked, flash) = sizes(&bare.link(linker, order, &object)?)?;
        ensure!(linked == expected, "{linker} {}: {linked:?} instead of {expected:?}", order.join(" "));
        added.push(flash - alone);
    }
    let [least, most] = [added.iter().min(), added.iter().max()].map(|bytes| bytes.copied().unwrap_or_default());
    // Functions have other addresses, and steps between them other lengths.
    ensure!(least > 0 && most - least <= 64, "it adds {least} to {most} bytes");
    Ok(format!("{most} bytes of flash"))
}

/// A program of `c-api/tests/chip` without start-up code, whose size is compared with and without the library.
struct Bare<'a> {
    name: &'a str,
    model: &'a str,
    library: &'a Path,
    folder: PathBuf,
}

impl Bare<'_> {
    /// The program without the library.
    fn alone(&self) -> Result<PathBuf> {
        self.link("gcc", &["PROGRAM", "-lm", "-lc"], &self.compile(&["-DALONE"])?)
    }

    fn compile(&self, flags: &[&str]) -> Result<PathBuf> {
        let object = self.folder.join(format!("{}{}.o", self.name, flags.concat()));
        let source = format!("tests/chip/{}.c", self.name);
        compile(&source, (self.library, self.model), &[C, flags].concat(), &object)?;
        Ok(object)
    }

    fn link(&self, linker: &str, order: &[&str], object: &Path) -> Result<PathBuf> {
        // g++ links with the library of C++, which its package does not have and the program does not need.
        for empty in ["libstdc++.a", "libstdc++_nano.a"] {
            fs::write(self.folder.join(empty), "!<arch>\n")?;
        }
        let (program, mut command) = (self.folder.join("program"), compiler(linker));
        command.args(LINKED).args(["-nostartfiles", "-Wl,-e,main", "-L"]).arg(&self.folder);
        command.arg("-T").arg(root().join(MAP));
        for argument in order {
            match *argument {
                "PROGRAM" => command.arg(object),
                "LIBRARY" => command.arg(self.library),
                other => command.arg(other),
            };
        }
        child::succeed(command.arg("-o").arg(&program))?;
        Ok(program)
    }
}
