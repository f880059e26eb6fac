//! `cargo xtask python`: builds the Python package as a wheel, installs it, and runs its tests.
//!
//! The virtual environment is in the target directory; what it installs comes from the extra `test` of the package.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};

use crate::reports::Pytest;
use crate::setup::{self, script};
use crate::stages::Stages;
use crate::tally::Tally;
use crate::{child, workspace};

/// Runs the checks and prints them; whether nothing failed.
pub fn run() -> bool {
    let mut stages = Stages::default();
    stages.stage("Python", checks);
    stages.end()
}

/// The wheel, the tests of pytest, and the types.
pub fn checks(tally: &mut Tally) {
    let ready = match environment() {
        Ok(python) => python,
        Err(reason) => return tally.missing("Python package", &format!("{reason:#}")),
    };
    let program = match build(&ready) {
        Ok(program) => program,
        Err(reason) => return tally.check::<&str, _>("wheel of the Python package", Err(format!("{reason:#}"))),
    };
    tally.check::<_, &str>("wheel of the Python package", Ok(""));
    let (before, mut report) = (tally.failed, Pytest::default());
    // Not in the folder of the package, whose source would go before the installed wheel.
    let tests = package().join("tests");
    let mut pytest = python(&ready, &["-m", "pytest", "-rfEs", "-q", "-p", "no:cacheprovider"], &tests);
    let status = child::lines(pytest.env("BEARING_WATCH_PROGRAM", program), |line| {
        println!("{line}");
        report.read(line, tally);
    });
    match status {
        Ok(status) if status.success() || tally.failed > before => {}
        Ok(status) => tally.check::<&str, _>("pytest", Err(status.to_string())),
        Err(error) => tally.check::<&str, _>("pytest", Err(format!("{error:#}"))),
    }
    tally.check("types of the package", succeed(python(&ready, &["-m", "mypy"], &package())));
    let stubs = python(&ready, &["-m", "mypy.stubtest", "bearing_watch._core"], &tests);
    tally.check("types of the extension module", succeed(stubs));
}

/// Python of an environment with packages of PyPI, in a folder of the tools.
pub fn with_packages(folder: &str, packages: &[&str]) -> Result<PathBuf> {
    let python = venv(&workspace::target_dir().join("tools").join(folder), false)?;
    let mut install = Command::new(&python);
    install.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]).args(packages);
    child::succeed(&mut install).with_context(|| format!("{} cannot be installed", packages.join(" and ")))?;
    Ok(python)
}

/// The folder of the package.
fn package() -> PathBuf {
    workspace::root().join("python")
}

/// Python of the environment, in a folder.
fn python(program: &Path, arguments: &[&str], folder: &Path) -> Command {
    let mut command = Command::new(program);
    command.args(arguments).current_dir(folder);
    command
}

fn succeed(mut command: Command) -> Result<&'static str> {
    let status = child::lines(&mut command, |line| println!("{line}"))?;
    ensure!(status.success(), "{status}");
    Ok("")
}

/// Python of the virtual environment with what the tests need; it is made where it is missing.
fn environment() -> Result<PathBuf> {
    let folder = workspace::target_dir().join("python/venv");
    let program = folder.join("bin/python");
    let complete = folder.join("complete");
    let wanted = fs::read_to_string(package().join("pyproject.toml"))?;
    if fs::read_to_string(&complete).is_ok_and(|made| made == wanted) {
        return Ok(program);
    }
    venv(&folder, true)?;
    // Compiling what is hardly used costs more than it saves.
    let mut install = Command::new(&program);
    install.args([
        "-m",
        "pip",
        "install",
        "--quiet",
        "--no-compile",
        "--disable-pip-version-check",
        "maturin>=1.9.4,<2",
    ]);
    child::succeed(install.args(packages(&wanted)?)).context("the packages of the tests cannot be installed")?;
    fs::write(&complete, wanted)?;
    Ok(program)
}

/// Python of a virtual environment, which is made if it is missing or must be empty.
pub fn venv(folder: &Path, empty: bool) -> Result<PathBuf> {
    let program = folder.join("bin/python");
    if !empty && child::works(Command::new(&program).args(["-m", "pip", "--version"])) {
        return Ok(program);
    }
    setup::ensure(&[&setup::PYTHON, &setup::PIP])?;
    let mut venv = Command::new("python3");
    venv.args(["-m", "venv", "--clear"]).arg(folder);
    let Some(wheel) = setup::pip() else {
        child::succeed(&mut venv)?;
        return Ok(program);
    };
    // Python's own installer is missing, and the unpacked one is not at the place where Python looks for it.
    child::succeed(venv.arg("--without-pip"))?;
    // Of the environment's names for an unpacked Python, the one that is used finds its libraries.
    script::write_like(&setup::PYTHON, "python3", &folder.join("bin/python3"), &program)?;
    let mut install = Command::new(&program);
    install.env("PYTHONPATH", &wheel).args(["-m", "pip", "install", "--quiet", "--no-index"]);
    child::succeed(install.arg(&wheel))?;
    Ok(program)
}

/// The packages of the extra `test`, and those that the package itself needs.
fn packages(manifest: &str) -> Result<Vec<String>> {
    let list = |key: &str| {
        let (_, rest) = manifest.split_once(&format!("\n{key} = ["))?;
        let (inside, _) = rest.split_once(']')?;
        Some(inside.split('"').skip(1).step_by(2).map(String::from).collect::<Vec<_>>())
    };
    match (list("dependencies"), list("test")) {
        (Some(own), Some(tests)) => Ok([own, tests].concat()),
        _ => bail!("python/pyproject.toml has no list of dependencies, or no extra test"),
    }
}

/// Builds the wheel and installs it; returns the command line, built in the same profile.
fn build(program: &Path) -> Result<PathBuf> {
    let wheels = workspace::target_dir().join("python/wheels");
    if wheels.exists() {
        fs::remove_dir_all(&wheels)?;
    }
    let workbench = workspace::workbench()?;
    let before = workbenches()?;
    let arguments = ["-m", "maturin", "build", "--locked", "--profile", "dev", "--features", "of-workspace"];
    let mut maturin = python(program, &arguments, &package());
    child::succeed(maturin.arg("--out").arg(&wheels))?;
    // It takes minutes, and depends on the features of every dependency.
    if workbenches()? != before {
        println!("note: the workbench was compiled again; see `of-workspace` in python/Cargo.toml");
    }
    let wheel = fs::read_dir(&wheels)?.next().context("maturin wrote no wheel")??.path();
    let arguments = ["-m", "pip", "install", "--quiet", "--no-deps", "--force-reinstall"];
    let mut install = python(program, &arguments, &package());
    child::succeed(install.arg("--disable-pip-version-check").arg(&wheel))?;
    Ok(workbench.get_program().into())
}

/// Number of libraries of the workbench among the artefacts, one for each combination of features.
fn workbenches() -> Result<usize> {
    let names = fs::read_dir(workspace::target_dir().join("debug/deps"))?;
    let names = names.filter_map(|entry| Some(entry.ok()?.file_name().to_string_lossy().into_owned()));
    Ok(names.filter(|name| name.starts_with("libbearing_watch_model-") && name.ends_with(".rlib")).count())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packages_are_those_of_the_manifest() {
        let text = "[project]\ndependencies = [\"numpy>=1\"]\n[x]\ntest = [\n    \"mypy\",\n    \"pytest>=8\",\n]\n";
        assert_eq!(packages(text).expect("both lists"), ["numpy>=1", "mypy", "pytest>=8"]);
        assert!(packages("test = []").is_err());
    }
}
