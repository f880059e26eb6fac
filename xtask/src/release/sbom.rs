//! Bills of materials (CycloneDX): the packages that each published crate is built from, with all features.
//!
//! The wheel contains its own, which maturin writes.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use serde_json::Value;

use super::{PUBLIC, VERSION, dist};
use crate::tally::Tally;
use crate::target::brief;
use crate::tools::CYCLONEDX;
use crate::{child, workspace};

const ENDING: &str = ".cdx.json";

/// One bill for each published crate.
pub fn checks(tally: &mut Tally) {
    if let Err(reason) = dist::remove(&[ENDING]) {
        return tally.check::<&str, _>("old bills", Err(format!("{reason:#}")));
    }
    for name in PUBLIC {
        tally.check(&format!("bill of materials of {name}"), brief(make(name)));
    }
}

fn make(name: &str) -> Result<String> {
    let folder = workspace::root().join(folder_of(name));
    let stem = format!("{name}-{VERSION}");
    let written = written_by(&folder, &stem)?;
    let text = fs::read_to_string(&written)?;
    let count = components(&text)?;
    fs::write(dist::folder()?.join(format!("{stem}{ENDING}")), text)?;
    fs::remove_file(&written)?;
    Ok(format!("{count} packages"))
}

/// Calls the tool, which writes beside the manifest of each package of the workspace; keeps the one of this folder.
fn written_by(folder: &Path, stem: &str) -> Result<PathBuf> {
    let mut tool = CYCLONEDX.command(&["cyclonedx", "--format", "json", "--spec-version", "1.5", "--describe"])?;
    tool.args(["crate", "--all-features", "--target", "all", "--no-build-deps", "--override-filename", stem]);
    child::succeed(tool.arg("--manifest-path").arg(folder.join("Cargo.toml")))?;
    Ok(folder.join(format!("{stem}.json")))
}

/// The number of packages that a bill names; it must have its format's name, and its versions.
fn components(text: &str) -> Result<usize> {
    let bill: Value = serde_json::from_str(text).context("no JSON")?;
    ensure!(bill.get("bomFormat").and_then(Value::as_str) == Some("CycloneDX"), "not of CycloneDX");
    let list = bill.get("components").and_then(Value::as_array).context("no components")?;
    ensure!(!list.is_empty(), "no components");
    for component in list {
        ensure!(component.get("version").is_some() && component.get("purl").is_some(), "incomplete: {component}");
    }
    Ok(list.len())
}

/// The folder of a published package.
fn folder_of(name: &str) -> &'static str {
    match name {
        "bearing-watch-c" => "c-api",
        "bearing-watch-workbench" => "workbench",
        _ => ".",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bill_has_packages_with_versions() {
        let bill = |inner: &str| format!("{{\"bomFormat\": \"CycloneDX\", \"components\": [{inner}]}}");
        assert_eq!(components(&bill("{\"version\": \"1\", \"purl\": \"pkg:cargo/x@1\"}")).ok(), Some(1));
        assert!(components(&bill("")).is_err() && components(&bill("{\"version\": \"1\"}")).is_err());
        assert!(components("{\"components\": []}").is_err());
    }

    #[test]
    fn folders_have_these_packages() -> Result<()> {
        for name in PUBLIC {
            let manifest = fs::read_to_string(workspace::root().join(folder_of(name)).join("Cargo.toml"))?;
            assert!(manifest.contains(&format!("\nname = \"{name}\"\n")), "{name}");
        }
        Ok(())
    }
}
