//! `cargo xtask pil`: a recording of raw counts through the whole drive, on the host and in the emulated chip.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};

use super::target::equal;
use crate::cargo::{self, cargo};
use crate::child;
use crate::firmware::board::DRIVE;
use crate::firmware::build::{self, build_with};
use crate::firmware::qemu;
use crate::firmware::way::Way;
use crate::report::Tally;
use crate::workspace::{root, target_dir};

/// The firmware that reads the rows.
const EXAMPLE: &str = "drive";

/// The binary model of the example, whose source it is built with anyway.
const MODEL: &str = "examples/support/actuator/model.bwm";

/// Runs the recording and prints the verdicts of `replay`, the lines of the chip, and what they cost. Fails if host and
/// chip differ in a bit.
pub fn run(way: Way, trace: &Path, model: &Path, source: &Path) -> Result<()> {
    let (lines, cost) = compare(way, trace, model, Some(source))?;
    lines.iter().chain(&cost).for_each(|line| println!("{line}"));
    println!("all {} lines equal those of the host", lines.len());
    Ok(())
}

/// A simulated recording through the example's model.
pub fn check(tally: &mut Tally, way: Way) {
    let outcome =
        simulated().and_then(|trace| compare(way, &trace, &root().join(MODEL), None)).and_then(|(lines, cost)| {
            ensure!(lines.iter().any(|line| line.contains("spall")), "no segment is called a spall: {lines:?}");
            Ok(format!("{} lines; {}", lines.len(), cost.join(", ")))
        });
    tally.check("raw recording through the whole drive", outcome);
}

/// A recording of a spall with a seed that the model was not trained with.
fn simulated() -> Result<PathBuf> {
    let folder = target_dir().join("pil/recording");
    let mut simulate = cargo::workbench()?;
    simulate.args(["simulate", "--rig", "ema", "--class", "spall", "--condition", "rit-mix", "--count", "1"]);
    child::succeed(simulate.args(["--seed", "2", "--out"]).arg(&folder))?;
    Ok(folder.join("ema_spall_rit-mix_2_000.csv"))
}

/// Writes the rows of the simulated recording for the example's model. Returns the folder where firmware reads them,
/// and the lines that the example prints on the host.
pub fn host_lines() -> Result<(PathBuf, Vec<String>)> {
    replayed(&simulated()?, &root().join(MODEL), None)
}

/// The same for a recording, a binary model, and the absolute path of the source that `train --rust` wrote with it.
fn replayed(trace: &Path, model: &Path, source: Option<&Path>) -> Result<(PathBuf, Vec<String>)> {
    let folder = target_dir().join("pil");
    fs::create_dir_all(&folder).with_context(|| format!("cannot create {}", folder.display()))?;
    let mut replay = cargo::workbench()?;
    replay.args(["replay", "--rows"]).arg(folder.join("rows.bin")).arg("--model").arg(model).arg(trace);
    child::succeed(&mut replay)?;
    let mut run = match source {
        Some(source) => {
            let mut cargo = cargo(&["run", "--quiet", "--example", EXAMPLE, "--manifest-path"]);
            cargo.arg(root().join("Cargo.toml")).env(build::MODEL, source);
            cargo
        }
        None => cargo::program("--example", EXAMPLE)?,
    };
    let lines = child::printed(run.current_dir(&folder)).context("on the host")?;
    Ok((folder, lines))
}

/// Lines of the firmware that equal those of the host, and those of its cost.
fn compare(way: Way, trace: &Path, model: &Path, source: Option<&Path>) -> Result<(Vec<String>, Vec<String>)> {
    let (folder, host) = replayed(trace, model, source)?;
    let elf = build_with(way, DRIVE, EXAMPLE, &[], source)?;
    let target = qemu::run_in(&folder, &elf, DRIVE)?;
    // What only the chip prints.
    let (cost, target): (Vec<String>, Vec<String>) = target.into_iter().partition(|line| line.starts_with("cost: "));
    equal(&host, &target)?;
    ensure!(host.len() > 1, "no segment was closed: {host:?}");
    Ok((target, cost))
}
