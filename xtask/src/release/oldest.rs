//! What the manifests promise of old versions: the lowest versions of the dependencies, and of the compiler.

use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};
use serde_json::Value;

use super::{PUBLIC, copy};
use crate::tally::Tally;
use crate::target::brief;
use crate::{child, tools, workspace};

/// Lowest versions of dependencies, then that of the compiler.
pub fn checks(tally: &mut Tally) {
    let copied = copy::of_tree("oldest").and_then(|folder| resolve(&folder).map(|()| folder));
    match &copied {
        Ok(folder) => {
            for name in PUBLIC {
                let outcome = check(folder, name);
                tally.check(&format!("{name} with the lowest versions of its dependencies"), brief(outcome));
            }
        }
        Err(reason) => tally.check::<&str, _>("lowest versions", Err(format!("{reason:#}"))),
    }
    tally.check("compilers that the dependencies promise", brief(promised()));
    compiler(tally);
}

/// Writes the lock file with the lowest versions. The option is one of nightly; the variable admits it, and only for
/// this: the packages are built without.
fn resolve(folder: &Path) -> Result<()> {
    let lock = folder.join("Cargo.lock");
    fs::remove_file(&lock)?;
    let mut cargo = workspace::cargo(&["generate-lockfile", "-Z", "direct-minimal-versions"]);
    child::succeed(cargo.current_dir(folder).env("RUSTC_BOOTSTRAP", "1"))?;
    ensure!(lock.is_file(), "cargo wrote no {}", lock.display());
    Ok(())
}

fn check(folder: &Path, name: &str) -> Result<String> {
    let mut cargo = workspace::cargo(&["check", "--locked", "--all-features", "--package", name]);
    let target = workspace::target_dir().join("oldest/target");
    child::succeed(cargo.current_dir(folder).env("CARGO_TARGET_DIR", target))?;
    Ok(String::new())
}

/// The compiler version that the packages promise.
fn rust_version() -> Result<String> {
    let manifest = fs::read_to_string(workspace::root().join("Cargo.toml"))?;
    let line = manifest.lines().find_map(|line| line.strip_prefix("rust-version = \"")).context("no rust-version")?;
    Ok(line.trim_end_matches('"').to_owned())
}

/// No dependency of a published package asks for a newer compiler than the packages promise. What they use of the
/// standard library itself is a lint of clippy (`incompatible_msrv`).
fn promised() -> Result<String> {
    let own = rust_version()?;
    let mut cargo = workspace::cargo(&["metadata", "--format-version", "1", "--all-features", "--locked"]);
    let metadata: Value = serde_json::from_str(&child::output(&mut cargo).context("cargo metadata failed")?)?;
    let packages = metadata.get("packages").and_then(Value::as_array).context("no packages")?;
    let mut newer = Vec::new();
    for package in packages {
        let wanted = package.get("rust_version").and_then(Value::as_str).unwrap_or_default();
        if numbers(wanted) > numbers(&own) {
            newer.push(format!("{} ({wanted})", package.get("name").and_then(Value::as_str).unwrap_or_default()));
        }
    }
    ensure!(newer.is_empty(), "above {own}: {}", newer.join(", "));
    Ok(format!("none of {} is above {own}", packages.len()))
}

/// Major, minor, patch.
fn numbers(version: &str) -> Vec<u32> {
    let mut numbers: Vec<u32> = version.split('.').map(|number| number.parse().unwrap_or(0)).collect();
    numbers.resize(3, 0);
    numbers
}

/// Builds the packages by the promised compiler, if rustup has it; nothing is downloaded.
fn compiler(tally: &mut Tally) {
    let version = match rust_version() {
        Ok(version) => version,
        Err(reason) => return tally.check::<&str, _>("lowest compiler", Err(format!("{reason:#}"))),
    };
    let title = format!("the packages by rustc {version}");
    match tools::toolchain(&version) {
        Some(folder) => tally.check(&title, brief(by_compiler(&folder, &version))),
        None => tally.missing(&title, &format!("not installed (rustup toolchain install {version} --profile minimal)")),
    }
}

fn by_compiler(toolchain: &Path, version: &str) -> Result<&'static str> {
    let programs = toolchain.join("bin");
    let text = child::output(Command::new(programs.join("rustc")).arg("--version")).unwrap_or_default();
    if !text.starts_with(&format!("rustc {version}")) {
        bail!("{} is {text}", toolchain.display());
    }
    let mut cargo = Command::new(programs.join("cargo"));
    cargo.args(["check", "--locked", "--all-features"]).current_dir(workspace::root());
    for name in PUBLIC {
        cargo.args(["--package", name]);
    }
    cargo.env("RUSTC", programs.join("rustc")).env_remove("RUSTUP_TOOLCHAIN").env_remove("LD_LIBRARY_PATH");
    child::succeed(cargo.env("CARGO_TARGET_DIR", workspace::target_dir().join("oldest/compiler")))?;
    Ok("")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_compare_by_numbers() {
        assert!(numbers("1.100") > numbers("1.89.1") && numbers("1.89.0") == numbers("1.89"));
        assert!(numbers("") < numbers("1.0"));
    }

    #[test]
    fn the_promised_compiler_is_a_version() -> Result<()> {
        assert!(numbers(&rust_version()?) > numbers("1.0"));
        Ok(())
    }
}
