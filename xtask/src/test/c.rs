//! The C library in firmware that is written in C and in C++.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Result, ensure};

use super::pil;
use super::target::equal;
use crate::cargo::lines_of_example;
use crate::child;
use crate::cost::bounds;
use crate::firmware::board::DRIVE;
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

const C: &str = "c";
const CPP: &str = "c++";

/// What is built and compared: the model of the library for one plan, or none of the one for any model. Builds of one
/// library follow each other.
const BUILDS: [(Option<&str>, Example, &[&str]); 7] = [
    (None, SIGNED, &[C, CPP]),
    (None, ISR, &[C, CPP]),
    (None, DRIVE_OF_COUNTS, &[C, CPP]),
    (None, TELEMETRY, &[C, CPP]),
    (Some(RIG), ISR, &[C]),
    (Some(RIG), TELEMETRY, &[C]),
    (Some(ACTUATOR), DRIVE_OF_COUNTS, &[C]),
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
    let added = whole_drive(&library(way, Some(ACTUATOR), "", build::SMALLEST)?)?;
    println!("\na whole drive adds {added}, built for size");
    Ok(())
}

/// The checks of the library.
pub fn checks(tally: &mut Tally, way: Way) {
    let builds = BUILDS.iter().flat_map(|(plan, own, all)| all.iter().map(move |language| (*plan, *own, *language)));
    for (plan, own, language) in builds {
        let title = format!("{} as {language} with the library for {}", own.0, plan.unwrap_or("any model"));
        tally.check(&title, check(way, plan, own, language));
    }
    tally.check("what a whole drive adds to a program", actuator_library(way).and_then(|own| whole_drive(&own)));
    let outcome = library(way, Some(RIG), "", &[]).and_then(|library| Ok(script(&library, &["orders"])?.0));
    tally.check("a program has the same functions of newlib with the library, in any order", outcome);
}

/// The example links with the library, holds no call of the panic machinery, and
/// prints the lines of Rust. Returns their number and the bytes of the program.
fn check(way: Way, plan: Option<&str>, own: Example, language: &str) -> Result<String> {
    let (name, twin, model, features) = own;
    let library = library(way, plan, features, &[])?;
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

/// What the script `c-api/tests/chip/build.sh` prints, and the folder where it puts programs.
fn script(library: &Path, arguments: &[&str]) -> Result<(String, PathBuf)> {
    let out = target_dir().join("c").join(arguments[0]);
    let mut script = Command::new("sh");
    script.arg("c-api/tests/chip/build.sh").args([library, &out]).args(arguments);
    Ok((child::printed(script.current_dir(root()))?.concat(), out))
}

/// Compiles an example and links it with the library.
fn example(name: &str, model: &str, language: &str, library: &Path) -> Result<PathBuf> {
    let (_, folder) = script(library, &["example", name, model, language])?;
    Ok(folder.join(name))
}

/// The bytes of flash that a whole drive adds, if they are within their bound.
fn whole_drive(library: &Path) -> Result<String> {
    let (added, most) = (script(library, &["whole_drive"])?.0, bounds::number("drive_in_c")?);
    ensure!(added.parse::<u64>()? <= most, "{added} bytes of flash; {most} are allowed");
    Ok(format!("{added} bytes of flash"))
}
