//! `cargo xtask peers`: the workbench and other programs on the same traces, in one run, one table.
//!
//! Python's live in a virtual environment in the target directory, pinned by `peers/requirements.txt`; oxictl is built
//! there as a program of its own.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::{child, field_peers, workspace};

/// Installs, measures, prints; whether every ratio asked for is met, and the detector is nowhere behind a plain
/// program.
pub fn run() -> Result<bool> {
    let (text, met) = measure()?;
    print!("{text}");
    let (text, quick) = reading()?;
    print!("\n{text}");
    let (text, ahead) = field_peers::measure(None)?;
    print!("\n{text}");
    Ok(met && quick && ahead)
}

/// Reads a recording of a million rows with the workbench, pandas and pyarrow. Returns the table, and whether every
/// ratio asked for is met.
pub fn reading() -> Result<(String, bool)> {
    let folder = folder().join("data");
    fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let python = python_with_packages()?;
    let build = ["build", "--release", "--quiet", "--package", "bearing-watch-workbench", "--example", "reading"];
    child::succeed(&mut workspace::cargo(&build))?;
    let program = workspace::target_dir().join("release/examples/reading");
    let mut script = Command::new(python);
    script.arg(scripts().join("reading.py")).arg(&folder).arg(program);
    let mut text = String::new();
    let status = child::lines(&mut script, |line| text = format!("{text}{line}\n"))?;
    Ok((text, status.success()))
}

/// Installs and measures. Returns the text to print, and whether every ratio asked for is met.
pub fn measure() -> Result<(String, bool)> {
    let folder = folder();
    let data = folder.join("data");
    fs::create_dir_all(&data).with_context(|| format!("cannot make {}", data.display()))?;
    let scripts = scripts();
    let python = python_with_packages()?;
    let ours = |what: &str| {
        let program = ["run", "--release", "--quiet", "--package", "bearing-watch-workbench", "--example", "peers"];
        let mut cargo = workspace::cargo(&program);
        cargo.args(["--", what]).arg(&data);
        cargo
    };
    child::succeed(&mut ours("write"))?;
    let rust = folder.join("rust.json");
    keep(&mut ours("time"), &rust)?;
    let manifest = scripts.join("oxictl/Cargo.toml");
    let mut cargo = workspace::cargo(&["run", "--release", "--quiet", "--manifest-path"]);
    cargo.arg(manifest).arg("--target-dir").arg(folder.join("oxictl")).arg("--").arg(&data);
    let oxictl = folder.join("oxictl.json");
    keep(&mut cargo, &oxictl)?;
    let mut script = Command::new(&python);
    script.arg(scripts.join("peers.py")).arg(&data).args([&rust, &oxictl]);
    let mut text = String::new();
    let status = child::lines(&mut script, |line| text = format!("{text}{line}\n"))?;
    Ok((text, status.success()))
}

/// Where peers are installed.
pub fn folder() -> PathBuf {
    workspace::target_dir().join("peers")
}

/// The peers' scripts.
pub fn scripts() -> PathBuf {
    workspace::root().join("xtask/peers")
}

/// The Python of the peers' virtual environment with the packages of the peers' scripts.
pub fn python_with_packages() -> Result<PathBuf> {
    let python = python()?;
    if !child::works(Command::new(&python).args(["-c", "import numpy, pandas, pyarrow, scipy, sippy_unipi"])) {
        let install = ["-m", "pip", "install", "--quiet", "--requirement"];
        child::succeed(Command::new(&python).args(install).arg(scripts().join("requirements.txt")))?;
    }
    Ok(python)
}

/// The Python of the peers' virtual environment, which is made where it lacks.
pub fn python() -> Result<PathBuf> {
    let venv = folder().join("venv");
    let python = venv.join("bin/python");
    if !child::works(Command::new(&python).args(["-m", "pip", "--version"])) {
        ensure!(child::on_path("python3"), "python3 is not installed");
        child::succeed(Command::new("python3").args(["-m", "venv"]).arg(&venv))?;
    }
    Ok(python)
}

/// Puts what a program prints into a file.
pub fn keep(command: &mut Command, path: &Path) -> Result<()> {
    let mut text = String::new();
    let status = child::lines(command, |line| text += line)?;
    ensure!(status.success(), "the program for {} failed ({status})", path.display());
    fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
}
