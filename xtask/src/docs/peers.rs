//! The workbench and other programs on the same traces: tables of times and accuracies. Python's live in a virtual
//! environment, pinned by `xtask/peers/requirements.txt`; oxictl is built as a program of its own.

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result};

use crate::cargo::cargo;
use crate::child;
use crate::python::with_packages;
use crate::workspace::{root, target_dir};

/// Where data are, and what programs print.
fn data() -> Result<PathBuf> {
    let folder = target_dir().join("peers/data");
    fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
    Ok(folder)
}

/// A call of a script, with the packages that it needs.
fn script(name: &str) -> Result<Command> {
    let scripts = root().join("xtask/peers");
    let python = with_packages("peers", &["--requirement", &scripts.join("requirements.txt").to_string_lossy()])?;
    let mut script = Command::new(python);
    script.arg(scripts.join(name)).arg(data()?);
    Ok(script)
}

/// What a script prints. It fails where a ratio that is asked for is missed, and says so.
fn printed(script: &mut Command) -> Result<String> {
    let mut text = String::new();
    let status = child::lines(script, |line| text = format!("{text}{line}\n"))?;
    if !status.success() {
        eprintln!("a ratio that is asked for is missed ({status})");
    }
    Ok(text)
}

/// Reads a recording of a million rows with the workbench, pandas and pyarrow.
pub fn reading() -> Result<String> {
    let build = ["build", "--release", "--quiet", "--package", "bearing-watch-workbench", "--example", "reading"];
    child::succeed(&mut cargo(&build))?;
    printed(script("reading.py")?.arg(target_dir().join("release/examples/reading")))
}

/// Identifies systems with the workbench, numpy, sippy and oxictl.
pub fn identification() -> Result<String> {
    let folder = data()?;
    let run = |what: &[&str]| {
        let mut cargo = cargo(&["run", "--release", "--quiet"]);
        cargo.args(what).arg(&folder);
        cargo
    };
    let keep = |command: &mut Command, name: &str| {
        let (text, path) = (child::printed(command)?.concat(), folder.with_file_name(name));
        fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))?;
        anyhow::Ok(path)
    };
    let ours = ["--package", "bearing-watch-workbench", "--example", "peers", "--"];
    child::succeed(&mut run(&[ours.as_slice(), &["write"]].concat()))?;
    let ours = keep(&mut run(&[ours.as_slice(), &["time"]].concat()), "rust.json")?;
    let mut oxictl = run(&["--manifest-path", "xtask/peers/oxictl/Cargo.toml", "--"]);
    let oxictl = keep(oxictl.env("CARGO_TARGET_DIR", target_dir().join("peers/oxictl")), "oxictl.json")?;
    printed(script("peers.py")?.args([ours, oxictl]))
}
