//! The stages on this machine: format, lints, documentation, tests of Rust, and the Python package.

use std::env;
use std::fs;
use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::cargo::{self, cargo};
use crate::python;
use crate::report::{Libtest, Pytest, Tally};
use crate::{child, workspace};

/// Success without a note, since the program has printed its own lines.
fn silent(command: &mut Command) -> Result<&'static str> {
    let status = child::lines(command, |line| println!("{line}"))?;
    ensure!(status.success(), "{status}");
    Ok("")
}

pub fn format(tally: &mut Tally) {
    for manifest in ["Cargo.toml", "frameworks/Cargo.toml", "template/Cargo.toml"] {
        let mut cargo = cargo(&["fmt", "--all", "--check", "--manifest-path", manifest]);
        tally.check(&format!("cargo fmt, {manifest}"), silent(&mut cargo));
    }
}

pub fn lints(tally: &mut Tally) {
    let mut cargo = cargo(&["clippy", "--workspace", "--all-targets", "--all-features"]);
    tally.check("cargo clippy", silent(cargo.args(["--", "--deny", "warnings"])));
}

pub fn documentation(tally: &mut Tally) {
    // With the features of the lints, whose metadata of dependencies it uses again.
    let mut cargo = cargo(&["doc", "--workspace", "--no-deps", "--all-features"]);
    let flags = env::var("RUSTDOCFLAGS").unwrap_or_default();
    tally.check("cargo doc", silent(cargo.env("RUSTDOCFLAGS", format!("{flags} -Dwarnings"))));
    tally.check("mdbook", python::book().map(|_| ""));
}

/// With overflow and debug checks on; the development profile is optimised, since the numeric tests simulate minutes
/// of drive time. What passing tests print is shown: their figures, and which data they had to do without. Without the
/// examples, which have no tests: clippy has read them, and those that are needed are built later.
pub fn tests(tally: &mut Tally, kinds: &[&str]) {
    for kind in kinds {
        let mut cargo = cargo(&["test", "--workspace", kind, "--no-fail-fast", "--", "--show-output"]);
        let (before, mut report) = (tally.failed, Libtest::default());
        let status = child::lines(&mut cargo, |line| {
            println!("{line}");
            report.read(line, tally);
        });
        // The tests that failed are counted already.
        if !matches!(&status, Ok(status) if status.success() || tally.failed > before) {
            let outcome = status.and_then(|status| Err::<&str, _>(anyhow::anyhow!("{status}")));
            tally.check(&format!("cargo test {kind}"), outcome);
        }
    }
}

/// The Python package as a wheel, its types, and its tests.
pub fn python(tally: &mut Tally) {
    let (before, mut report) = (tally.failed, Pytest::default());
    let outcome = environment().and_then(|python| {
        let mut script = Command::new("sh");
        script.arg("xtask/python.sh").current_dir(workspace::root()).env("PYTHON", python);
        script.env("TARGET", workspace::target_dir()).env("PROGRAM", cargo::workbench()?.get_program());
        child::lines(&mut script, |line| {
            println!("{line}");
            report.read(line, tally);
        })
    });
    match outcome {
        Ok(status) if status.success() => tally.check("wheel and types of the Python package", Ok("")),
        // The tests that failed are counted already.
        Ok(_) if tally.failed > before => {}
        Ok(status) => tally.check("wheel and types of the Python package", Err::<&str, _>(anyhow::anyhow!("{status}"))),
        Err(reason) => tally.missing("Python package", &format!("{reason:#}")),
    }
}

/// Python of a virtual environment with what the package and its tests need.
fn environment() -> Result<PathBuf> {
    let manifest: toml::Table = fs::read_to_string(workspace::root().join("python/pyproject.toml"))?.parse()?;
    let project = manifest.get("project").context("pyproject.toml has no project")?;
    let lists = [project.get("dependencies"), project.get("optional-dependencies").and_then(|all| all.get("test"))];
    let packages = lists.into_iter().flatten().filter_map(toml::Value::as_array).flatten();
    let packages = packages.filter_map(toml::Value::as_str).chain(["maturin>=1.9.4,<2"]);
    python::with_packages("of-package", &packages.collect::<Vec<_>>())
}
