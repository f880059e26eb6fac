//! `cargo xtask c`: the C library in firmware that is written in C and in C++.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::board::{DRIVE, DRIVE_FLAGS};
use crate::stages::Stages;
use crate::tally::Tally;
use crate::toolchain::Way;
use crate::{c_link, c_symbols, child, elf, firmware, pil, qemu, target, workspace};

/// What Rust prints of numbers that the C interface does not give: the variance of the residual and the covariance, and
/// the hash of all numbers.
const LEFT_OUT: [&str; 2] = ["variance ", "all numbers "];

const COMPILER: &str = "arm-none-eabi-gcc";
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
            Self::C => &["-std=c99"],
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
    /// The exported plan of this model.
    Exported(Model),
}

impl Plan {
    fn file(self) -> String {
        match self {
            Self::Any => String::new(),
            Self::Exported(model) => format!("../{}/model.rs", model.folder()),
        }
    }

    const fn name(self) -> &'static str {
        match self {
            Self::Any => "any model",
            Self::Exported(_) => "one plan",
        }
    }
}

/// A model with its recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Model {
    /// Of samples, with recorded traces.
    StandardRig,
    /// Of raw counts: it has a front end.
    Actuator,
}

impl Model {
    const fn folder(self) -> &'static str {
        match self {
            Self::StandardRig => "examples/support/standard_rig",
            Self::Actuator => "examples/support/actuator",
        }
    }
}

/// An example, which prints the lines of a Rust example, [`Self::twin`], but for [`LEFT_OUT`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Example {
    Isr,
    Drive,
    Telemetry,
    Signed,
}

impl Example {
    const fn model(self) -> Model {
        match self {
            Self::Isr | Self::Telemetry | Self::Signed => Model::StandardRig,
            Self::Drive => Model::Actuator,
        }
    }

    const fn name(self) -> &'static str {
        match self {
            Self::Isr => "isr",
            Self::Drive => "drive",
            Self::Telemetry => "telemetry",
            Self::Signed => "signed",
        }
    }

    /// The features of the library.
    const fn features(self) -> &'static str {
        match self {
            Self::Signed => "signature",
            Self::Isr | Self::Drive | Self::Telemetry => "",
        }
    }

    const fn twin(self) -> &'static str {
        match self {
            Self::Isr => "monitor",
            Self::Drive => "drive",
            Self::Telemetry => "telemetry",
            Self::Signed => "signed",
        }
    }

    /// Where the program runs, and the lines of its twin on the host.
    fn on_host(self) -> Result<(PathBuf, Vec<String>)> {
        match self {
            Self::Drive => pil::host_lines(),
            Self::Isr | Self::Telemetry | Self::Signed => Ok((PathBuf::from("."), target::on_host(self.twin())?)),
        }
    }
}

/// What is built and compared: builds of one library follow each other.
const BUILDS: [(Plan, Example, Language); 11] = [
    (Plan::Any, Example::Signed, Language::C),
    (Plan::Any, Example::Signed, Language::Cpp),
    (Plan::Any, Example::Isr, Language::C),
    (Plan::Any, Example::Isr, Language::Cpp),
    (Plan::Any, Example::Drive, Language::C),
    (Plan::Any, Example::Drive, Language::Cpp),
    (Plan::Any, Example::Telemetry, Language::C),
    (Plan::Any, Example::Telemetry, Language::Cpp),
    (Plan::Exported(Model::StandardRig), Example::Isr, Language::C),
    (Plan::Exported(Model::StandardRig), Example::Telemetry, Language::C),
    (Plan::Exported(Model::Actuator), Example::Drive, Language::C),
];

/// A program that counts instructions and bytes, and its model.
type Measure = (&'static str, Model);

const DETECTOR: Measure = ("measure", Model::StandardRig);
const TELEMETRY: Measure = ("measure_telemetry", Model::StandardRig);
const FRONT_END: Measure = ("measure_front_end", Model::Actuator);

/// What is measured.
const MEASURED: [(Plan, &[Measure]); 3] = [
    (Plan::Any, &[DETECTOR, TELEMETRY, FRONT_END]),
    (Plan::Exported(Model::StandardRig), &[DETECTOR, TELEMETRY]),
    (Plan::Exported(Model::Actuator), &[FRONT_END]),
];

/// Runs all checks and prints them, and what the library takes; whether nothing failed.
pub fn run(way: Way) -> Result<bool> {
    let mut stages = Stages::default();
    stages.stage("C library", |tally| checks(tally, way));
    for (plan, programs) in MEASURED {
        println!("\nlibrary for {}", plan.name());
        let library = firmware::build_c_library(way, DRIVE, &plan.file(), "")?;
        for (name, model) in programs {
            let program = build(name, *model, Language::C, &library)?;
            qemu::run(&program, DRIVE.machine, qemu::Echo::On)?;
        }
    }
    println!("\nlibrary for one plan, built for size");
    let (_, words) = c_link::whole_drive(&of_actuator_for_size(way)?)?;
    println!("a whole drive adds {words}");
    Ok(stages.end())
}

/// The checks of the library.
pub fn checks(tally: &mut Tally, way: Way) {
    for (plan, example, language) in BUILDS {
        let title = format!("{} as {} with the library for {}", example.name(), language.name(), plan.name());
        tally.check(&title, target::brief(check(way, plan, example, language)));
    }
    let outcome = of_actuator(way).and_then(|library| c_link::bounded_drive(&library));
    tally.check("what a whole drive adds to a program", target::brief(outcome));
    let outcome = of_example(way).and_then(|library| c_link::orders(&library));
    tally.check("a program has the same functions of newlib with the library, in any order", target::brief(outcome));
}

/// The library exports its interface only, and the example links with it, holds no call of the panic machinery,
/// and prints the lines of Rust. Returns their number and the bytes of the program.
fn check(way: Way, plan: Plan, example: Example, language: Language) -> Result<String> {
    let library = firmware::build_c_library(way, DRIVE, &plan.file(), example.features())?;
    c_symbols::check(&library)?;
    let program = build(example.name(), example.model(), language, &library)?;
    let panics = elf::symbols_with(&program, "core9panicking")?;
    // The crate that verifies indexes arrays, which the compiler cannot prove.
    ensure!(panics.is_empty() || example == Example::Signed, "it calls {}", panics.join(", "));
    let lines = same_lines(&program, example)?;
    let sizes = elf::sizes(&program)?;
    Ok(format!("{lines} lines, {} bytes of flash, {} of RAM", sizes.flash, sizes.ram))
}

/// The library for the plan of the standard rig.
fn of_example(way: Way) -> Result<PathBuf> {
    firmware::build_c_library(way, DRIVE, &Plan::Exported(Model::StandardRig).file(), "")
}

/// The library for the plan of the simulated actuator.
pub fn of_actuator(way: Way) -> Result<PathBuf> {
    firmware::build_c_library(way, DRIVE, &Plan::Exported(Model::Actuator).file(), "")
}

fn of_actuator_for_size(way: Way) -> Result<PathBuf> {
    firmware::build_smallest_c_library(way, DRIVE, &Plan::Exported(Model::Actuator).file())
}

/// Where objects and programs are put.
fn folder() -> PathBuf {
    workspace::target_dir().join("c")
}

/// Compares the lines of a program with those of its twin; returns their number.
fn same_lines(program: &Path, example: Example) -> Result<usize> {
    let (folder, host) = example.on_host()?;
    compared(host, &qemu::run_in(&folder, program, DRIVE.machine, qemu::Echo::Off)?)
}

/// Compares the lines of Rust on the host, but for [`LEFT_OUT`], with those of C; returns their number.
pub fn compared(mut host: Vec<String>, target: &[String]) -> Result<usize> {
    host.retain(|line| !LEFT_OUT.iter().any(|words| line.contains(words)));
    for (number, (host, target)) in host.iter().zip(target).enumerate() {
        ensure!(host == target, "line {}: Rust `{host}`, C `{target}`", number + 1);
    }
    ensure!(host.len() == target.len(), "{} lines of Rust, {} of C", host.len(), target.len());
    ensure!(!host.is_empty(), "neither printed anything");
    Ok(host.len())
}

/// Compiles an example and links it with the library.
fn build(name: &str, model: Model, language: Language, library: &Path) -> Result<PathBuf> {
    let (root, folder) = (workspace::root(), folder());
    std::fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let examples = root.join("c-api/examples");
    // The header of a library for one plan lies beside it.
    let beside = library.parent().unwrap_or(&folder).to_path_buf();
    let includes = [root.join("c-api/include"), root.join(model.folder()), beside];
    let mut sources = vec![(format!("{name}.c"), language.flags()), ("board.c".to_owned(), Language::C.flags())];
    if model == Model::StandardRig {
        let data = if name == "signed" { "signed_model.s" } else { "held_out.s" };
        sources.push((data.to_owned(), &[]));
    }
    let mut objects = Vec::new();
    for (source, flags) in sources {
        let object = folder.join(&source).with_extension("o");
        let mut compiler = Command::new(COMPILER);
        compiler.args(DRIVE_FLAGS).args(WARNINGS).args(["-O2", "-ffunction-sections", "-fdata-sections"]);
        for include in &includes {
            compiler.arg("-I").arg(include);
        }
        child::succeed(compiler.args(flags).arg("-c").arg(examples.join(&source)).arg("-o").arg(&object))?;
        objects.push(object);
    }
    let program = folder.join(name);
    let mut linker = Command::new(COMPILER);
    linker.args(DRIVE_FLAGS).args(LIBRARIES).args([
        "-Wl,--gc-sections",
        "-Wl,-z,noexecstack",
        "-Wl,--no-warn-rwx-segments",
    ]);
    linker.arg("-T").arg(examples.join("stm32f405.ld")).args(objects).arg(library).arg("-o").arg(&program);
    child::succeed(&mut linker)?;
    Ok(program)
}
