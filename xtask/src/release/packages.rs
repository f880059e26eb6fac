//! The packages for crates.io. Cargo builds each from what is in its package and, for those that are not published yet,
//! from the packages of the others.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use serde_json::Value;

use super::{PUBLIC, VERSION, dist};
use crate::tally::Tally;
use crate::target::brief;
use crate::{child, workspace};

/// Makes and builds the packages.
pub fn checks(tally: &mut Tally) {
    tally.check("packages that are published", brief(public()));
    match brief(make()) {
        Ok(()) => PUBLIC.iter().for_each(|name| tally.check::<_, &str>(&format!("{name} is built alone"), Ok(""))),
        Err(reason) => tally.check::<&str, _>("cargo package", Err(reason)),
    }
}

fn make() -> Result<()> {
    let target = workspace::target_dir();
    let mut cargo = workspace::cargo(&["package", "--locked", "--allow-dirty", "--target-dir"]);
    cargo.arg(&target).env_remove("CARGO_TARGET_DIR");
    // As in the workspace's profile, which packages do not have: dependencies that are built already are used.
    cargo.envs([("CARGO_PROFILE_DEV_DEBUG", "false"), ("CARGO_PROFILE_DEV_LTO", "off")]);
    for name in PUBLIC {
        cargo.args(["--package", name]);
    }
    child::succeed(&mut cargo)?;
    dist::remove(&[".crate"])?;
    for name in PUBLIC {
        let file = format!("{name}-{VERSION}.crate");
        fs::copy(target.join("package").join(&file), dist::folder()?.join(&file))
            .with_context(|| format!("cargo made no {file}"))?;
    }
    Ok(())
}

/// Checks that the packages which cargo would publish are [`PUBLIC`], and that each has what crates.io and docs.rs use.
fn public() -> Result<String> {
    let mut cargo = workspace::cargo(&["metadata", "--format-version", "1", "--no-deps", "--locked"]);
    let metadata: Value = serde_json::from_str(&child::output(&mut cargo).context("cargo metadata failed")?)?;
    let packages = metadata.get("packages").and_then(Value::as_array).context("no packages")?;
    let mut names = Vec::new();
    for package in packages.iter().filter(|package| package.get("publish").is_none_or(Value::is_null)) {
        let name = package.get("name").and_then(Value::as_str).context("a package without a name")?;
        let missing = missing(package);
        anyhow::ensure!(missing.is_empty(), "{name} has no {}", missing.join(", "));
        names.push(name);
    }
    names.sort_unstable();
    anyhow::ensure!(names == PUBLIC, "published would be {}", names.join(", "));
    Ok(names.join(", "))
}

/// What a published package lacks.
fn missing(package: &Value) -> Vec<&'static str> {
    let folder = package.get("manifest_path").and_then(Value::as_str).map(Path::new).and_then(Path::parent);
    let is_file = |name: &str| folder.is_some_and(|folder| folder.join(name).is_file());
    let filled = |key: &str| {
        package.get(key).is_some_and(|value| match value {
            Value::Array(list) => !list.is_empty(),
            Value::String(text) => !text.is_empty(),
            _ => false,
        })
    };
    let mut missing: Vec<&str> = ["description", "license", "readme", "categories", "keywords", "rust_version"]
        .into_iter()
        .filter(|key| !filled(key))
        .collect();
    missing.extend(["LICENSE-MIT", "LICENSE-APACHE"].into_iter().filter(|name| !is_file(name)));
    if package.pointer("/metadata/docs/rs").is_none() {
        missing.push("metadata for docs.rs");
    }
    missing
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_published_packages_are_complete() -> Result<()> {
        public().map(|_| ())
    }

    #[test]
    fn what_is_missing_is_named() {
        let package = serde_json::json!({ "description": "x", "license": "MIT", "readme": "R", "keywords": [] });
        let missing = missing(&package);
        assert!(!missing.contains(&"description") && missing.contains(&"keywords"), "{missing:?}");
        assert!(missing.contains(&"LICENSE-MIT") && missing.contains(&"metadata for docs.rs"), "{missing:?}");
    }
}
