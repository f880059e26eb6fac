//! The Python package: a source distribution, the wheel that is built from it alone, and its way into an empty
//! environment, where its verdicts are those of the command line.

use std::process::Command;

use anyhow::{Context, Result};

use super::dist;
use crate::cargo;
use crate::child;
use crate::python::{MATURIN, pip, tool, venv};
use crate::test::newcomer::{Folder, replayed, same_classes};
use crate::workspace::{root, target_dir};

const NAME: &str = "bearing_watch-";
const MODEL: &str = "examples/support/standard_rig/model.bwm";

/// Makes both, installs the wheel and runs a detector on simulated traces of a good and of a bad bearing.
pub fn check() -> Result<String> {
    dist::remove(NAME, ".tar.gz")?;
    dist::remove(NAME, ".whl")?;
    child::succeed(tool(MATURIN, &["sdist", "--out"])?.arg(dist::folder()?).current_dir(root().join("python")))?;
    // Outside the checkout, whose configuration cargo would read.
    let folder = Folder::new("wheel")?;
    let mut tar = Command::new("tar");
    tar.arg("xf").arg(dist::find(NAME, ".tar.gz")?).args(["--strip-components", "1"]);
    child::succeed(tar.current_dir(folder.path()))?;
    // Not `--locked`: the distribution has the lock file of the whole workspace, of which cargo keeps what is wanted.
    let mut maturin = tool(MATURIN, &["build", "--release", "--strip", "--out"])?;
    maturin.arg(dist::folder()?).current_dir(folder.path());
    child::succeed(maturin.env("CARGO_TARGET_DIR", target_dir().join("release-wheel")))?;
    let python = venv(&folder.path().join("venv"), true)?;
    child::succeed(pip(&python, &[]).arg(dist::find(NAME, ".whl")?))?;
    let (mut host, mut own) = (Vec::new(), Vec::new());
    for class in ["healthy", "spall"] {
        let mut simulate = cargo::workbench()?;
        simulate.args(["simulate", "--rig", "dc", "--count", "1", "--seed", "7", "--class", class, "--out"]);
        child::succeed(simulate.arg(folder.path().join(class)))?;
        for entry in folder.path().join(class).read_dir()? {
            let trace = entry?.path();
            if trace.extension().is_some_and(|own| own == "csv") && !trace.ends_with("labels.csv") {
                host.extend(replayed(MODEL, &trace)?);
                let mut detector = Command::new(&python);
                detector.args(["-c", include_str!("wheel.py")]).arg(root().join(MODEL)).arg(&trace);
                own.extend(child::printed(detector.current_dir(folder.path())).context("the detector failed")?);
            }
        }
    }
    same_classes(&host, &own)
}
