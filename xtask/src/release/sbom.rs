//! Bills of materials (CycloneDX): the packages that each published crate is built from; of the core with all features.
//!
//! The wheel contains its own, which maturin writes.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use serde_json::Value;

use super::{PUBLIC, VERSION, copy, dist};
use crate::child;
use crate::tally::Tally;
use crate::target::brief;
use crate::tools::CYCLONEDX;

const ENDING: &str = ".cdx.json";

/// One bill for each published crate.
pub fn checks(tally: &mut Tally) {
    match brief(dist::remove(&[ENDING]).and_then(|()| copy::of_tree("sbom"))) {
        Ok(source) => {
            for name in PUBLIC {
                tally.check(&format!("bill of materials of {name}"), brief(make(&source, name)));
            }
        }
        Err(reason) => tally.check::<&str, _>("bills of materials", Err(reason)),
    }
}

/// Calls the tool in a workspace of this package alone: others would turn on more features of what both use.
fn make(source: &Path, name: &str) -> Result<String> {
    let (folder, stem) = (source.join(folder_of(name)), format!("{name}-{VERSION}"));
    copy::keep_only(source, &folder_of(name))?;
    let mut tool = CYCLONEDX.command(&["cyclonedx", "--format", "json", "--spec-version", "1.5", "--target", "all"])?;
    tool.args(["--no-build-deps", "--override-filename", &stem]);
    // Of the core, which is in every workspace as its root, others take some only.
    if name == PUBLIC[0] {
        tool.arg("--all-features");
    }
    child::succeed(tool.arg("--manifest-path").arg(folder.join("Cargo.toml")).current_dir(source))?;
    let text = fs::read_to_string(folder.join(format!("{stem}.json"))).context("the tool wrote no bill")?;
    let count = components(&text)?;
    // References contain the place of the copy.
    let text = text.replace(&*source.to_string_lossy(), "/bearing-watch");
    fs::write(dist::folder()?.join(format!("{stem}{ENDING}")), text)?;
    Ok(format!("{count} packages"))
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
fn folder_of(name: &str) -> String {
    match name.strip_prefix("bearing-watch-") {
        None => ".".into(),
        Some("c") => "c-api".into(),
        Some("workbench") => "workbench/cli".into(),
        Some(library) => format!("workbench/{library}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspace;

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
