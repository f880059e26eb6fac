//! The Python package: a source distribution, the wheel that is built from it alone, and its way into an empty
//! environment.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

use super::dist;
use crate::newcomer::Folder;
use crate::newcomer::outcome::{replayed, same_classes};
use crate::tally::Tally;
use crate::target::brief;
use crate::tools::MATURIN;
use crate::{child, python, workspace};

const SDIST: (&str, &str) = ("bearing_watch-", ".tar.gz");
const WHEEL: (&str, &str) = ("bearing_watch-", ".whl");
/// Prints the verdicts of a trace.
const PROGRAM: &str = include_str!("wheel.py");
const MODEL: &str = "examples/support/standard_rig/model.bwm";

/// Makes both, installs the wheel and runs a detector.
pub fn checks(tally: &mut Tally) {
    let made = sdist().and_then(|()| wheel());
    let there = made.is_ok();
    tally.check("source distribution, and the wheel from it", brief(made));
    if there {
        tally.check("the wheel in an empty environment", brief(run()));
    }
}

fn sdist() -> Result<()> {
    for file in [dist::find(SDIST.0, SDIST.1), dist::find(WHEEL.0, WHEEL.1)].into_iter().flatten() {
        fs::remove_file(file)?;
    }
    let mut maturin = MATURIN.command(&["sdist", "--out"])?;
    child::succeed(maturin.arg(dist::folder()?).current_dir(workspace::root().join("python")))
}

fn wheel() -> Result<String> {
    // Outside the checkout, whose configuration cargo would read.
    let folder = Folder::new("sdist")?;
    let mut tar = Command::new("tar");
    child::succeed(
        tar.arg("xf").arg(dist::find(SDIST.0, SDIST.1)?).args(["--strip-components", "1"]).current_dir(folder.path()),
    )?;
    // Not `--locked`: the distribution has the lock file of the whole workspace, of which cargo keeps what is wanted.
    let mut maturin = MATURIN.command(&["build", "--release", "--strip", "--out"])?;
    maturin.arg(dist::folder()?).current_dir(folder.path());
    child::succeed(maturin.env("CARGO_TARGET_DIR", workspace::target_dir().join("release-wheel")))?;
    let wheel = dist::find(WHEEL.0, WHEEL.1)?;
    Ok(wheel.file_name().unwrap_or_default().to_string_lossy().into_owned())
}

/// Installs the wheel with what it needs, and compares its verdicts with those of the command line.
fn run() -> Result<String> {
    let folder = Folder::new("wheel")?;
    let python = python::venv(&folder.path().join("venv"), true)?;
    let mut install = Command::new(&python);
    install.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]);
    child::succeed(install.arg(dist::find(WHEEL.0, WHEEL.1)?))?;
    let (mut host, mut own) = (Vec::new(), Vec::new());
    for trace in traces(folder.path())? {
        host.extend(replayed(MODEL, &trace)?);
        let mut detector = Command::new(&python);
        detector.args(["-c", PROGRAM]).arg(workspace::root().join(MODEL)).arg(&trace).current_dir(folder.path());
        own.extend(child::output(&mut detector).context("the detector failed")?.lines().map(ToOwned::to_owned));
    }
    same_classes(&host, &own)
}

/// Simulated traces of a good and of a bad bearing.
fn traces(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut traces = Vec::new();
    for class in ["healthy", "spall"] {
        let out = folder.join(class);
        let mut simulate = workspace::cargo(&["run", "--quiet", "--package", "bearing-watch-workbench", "--bin"]);
        simulate.args([
            "bearing-watch",
            "--",
            "simulate",
            "--rig",
            "dc",
            "--count",
            "1",
            "--seed",
            "7",
            "--class",
            class,
        ]);
        child::succeed(simulate.arg("--out").arg(&out))?;
        for entry in out.read_dir()? {
            let path = entry?.path();
            if path.extension().is_some_and(|own| own == "csv") && !path.ends_with("labels.csv") {
                traces.push(path);
            }
        }
    }
    ensure!(traces.len() == 2, "simulate wrote {traces:?}");
    Ok(traces)
}
