//! `cargo xtask peers`: the workbench and other programs on the same traces, in one run, one table.
//!
//! The others live in a virtual environment in the target directory; `peers/requirements.txt` pins them.

use std::fs;
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::{child, workspace};

/// Installs, measures, prints; whether every ratio asked for is met.
pub fn run() -> Result<bool> {
    let folder = workspace::target_dir().join("peers");
    let (venv, data) = (folder.join("venv"), folder.join("data"));
    fs::create_dir_all(&data).with_context(|| format!("cannot make {}", data.display()))?;
    let scripts = workspace::root().join("xtask/peers");
    let python = venv.join("bin/python");
    if !child::works(Command::new(&python).args(["-c", "import numpy, scipy, sippy_unipi"])) {
        ensure!(child::on_path("python3"), "python3 is not installed");
        child::succeed(Command::new("python3").args(["-m", "venv"]).arg(&venv))?;
        let install = ["-m", "pip", "install", "--quiet", "--requirement"];
        child::succeed(Command::new(&python).args(install).arg(scripts.join("requirements.txt")))?;
    }
    let ours = |what: &str| {
        let program = ["run", "--release", "--quiet", "--package", "bearing-watch-workbench", "--example", "peers"];
        let mut cargo = workspace::cargo(&program);
        cargo.args(["--", what]).arg(&data);
        cargo
    };
    child::succeed(&mut ours("write"))?;
    let figures = child::output(&mut ours("time")).context("the workbench's half failed")?;
    let rust = folder.join("rust.json");
    fs::write(&rust, figures).with_context(|| format!("cannot write {}", rust.display()))?;
    let mut script = Command::new(&python);
    script.arg(scripts.join("peers.py")).arg(&data).arg(&rust);
    Ok(child::lines(&mut script, |line| println!("{line}"))?.success())
}
