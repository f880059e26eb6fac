//! Licence texts of what the C library contains: they go with it.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};
use serde_json::Value;

use crate::{child, workspace};

/// How the name of a file with a licence starts.
const STARTS: [&str; 5] = ["LICENSE", "LICENCE", "COPYING", "NOTICE", "UNLICENSE"];
/// The licence of a package that a user may take under the Apache licence, whose text has no name of an author.
const DUAL: &str = "license = \"MIT OR Apache-2.0\"";
/// The texts of the standard library, in the folder of the compiler.
const OF_RUST: &str = "share/doc/rust/COPYRIGHT-library.html";

/// Names in the archive and texts, of all packages that are compiled into the library and of the standard library.
pub fn files() -> Result<Vec<(String, Vec<u8>)>> {
    let mut files = Vec::new();
    for (package, folder) in packages()? {
        let texts = texts(&folder)?;
        ensure!(!texts.is_empty(), "{package} has no file with its licence");
        files.extend(texts.into_iter().map(|(name, text)| (format!("licenses/{package}/{name}"), text)));
    }
    let text = sysroot()?.join(OF_RUST);
    let text = fs::read(&text).with_context(|| format!("the compiler has no {}", text.display()))?;
    files.push(("licenses/rust-standard-library.html".to_owned(), text));
    Ok(files)
}

/// Names and texts of the licences in the folder of a package: beside its manifest, or in the folder that REUSE has.
fn texts(folder: &Path) -> Result<Vec<(String, Vec<u8>)>> {
    let mut found = Vec::new();
    let collected = folder.join("LICENSES");
    for (folder, all) in [(folder, false), (collected.as_path(), true)] {
        if !folder.is_dir() {
            continue;
        }
        for entry in folder.read_dir()? {
            let path = entry?.path();
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let is_licence = all || STARTS.iter().any(|start| name.to_uppercase().starts_with(start));
            if path.is_file() && is_licence {
                found.push((name, fs::read(&path)?));
            }
        }
    }
    if found.is_empty() && fs::read_to_string(folder.join("Cargo.toml"))?.contains(DUAL) {
        // A package of traits alone that forgot the texts: that of the second licence is the same for all.
        let text = fs::read(workspace::root().join("LICENSE-APACHE"))?;
        found.push(("LICENSE-APACHE".to_owned(), text));
    }
    Ok(found)
}

fn sysroot() -> Result<PathBuf> {
    let rustc = env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let path = child::output(Command::new(rustc).args(["--print", "sysroot"])).context("rustc names no sysroot")?;
    Ok(PathBuf::from(path))
}

/// Names with versions and folders of the packages of other projects in the library.
fn packages() -> Result<Vec<(String, PathBuf)>> {
    let arguments = ["tree", "--locked", "--package", "bearing-watch-c", "--edges", "normal,no-proc-macro"];
    let mut tree = workspace::cargo(&arguments);
    let tree = child::output(tree.args(["--prefix", "none", "--format", "{p}"])).context("cargo tree failed")?;
    let mut metadata = workspace::cargo(&["metadata", "--format-version", "1", "--locked"]);
    let metadata: Value = serde_json::from_str(&child::output(&mut metadata).context("cargo metadata failed")?)?;
    let mut packages = Vec::new();
    for package in metadata.get("packages").and_then(Value::as_array).context("no packages")? {
        let text = |key: &str| package.get(key).and_then(Value::as_str).unwrap_or_default();
        let line = format!("{} v{}", text("name"), text("version"));
        // Those of this workspace have a folder behind the version.
        if tree.lines().any(|own| own.trim_end_matches(" (*)") == line) {
            let folder = Path::new(text("manifest_path")).parent().context("a manifest in no folder")?;
            packages.push((line.replace(" v", "-"), folder.to_path_buf()));
        }
    }
    Ok(packages)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_package_of_the_library_has_its_licence() -> Result<()> {
        for (package, folder) in packages()? {
            assert!(!texts(&folder)?.is_empty(), "{package}");
        }
        Ok(())
    }

    #[test]
    fn the_library_contains_libm_and_nothing_of_the_workbench() -> Result<()> {
        let names: Vec<String> = packages()?.into_iter().map(|(name, _)| name).collect();
        assert!(names.iter().any(|name| name.starts_with("libm-")), "{names:?}");
        assert!(!names.iter().any(|name| name.starts_with("bearing-watch") || name.starts_with("clap")), "{names:?}");
        Ok(())
    }
}
