//! Licence texts of what the C library contains: they go with it.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use serde_json::Value;

use crate::cargo::{cargo, rustc};
use crate::child;
use crate::workspace::root;

/// How the name of a file with a licence starts.
const STARTS: [&str; 5] = ["LICENSE", "LICENCE", "COPYING", "NOTICE", "UNLICENSE"];
/// The licence of a package that a user may take under the Apache licence, whose text has no name of an author.
const DUAL: &str = "license = \"MIT OR Apache-2.0\"";

/// Names in the archive and texts, of all packages that are compiled into the library and of the standard library.
pub fn files() -> Result<Vec<(String, Vec<u8>)>> {
    let mut tree = cargo(&["tree", "--locked", "--package", "bearing-watch-c", "--edges", "normal,no-proc-macro"]);
    let tree = child::output(tree.args(["--prefix", "none", "--format", "{p}"])).context("cargo tree failed")?;
    let metadata = child::output(&mut cargo(&["metadata", "--format-version", "1", "--locked"]));
    let metadata: Value = serde_json::from_str(&metadata.context("cargo metadata failed")?)?;
    let mut files = Vec::new();
    for package in metadata["packages"].as_array().context("no packages")? {
        let text = |key: &str| package[key].as_str().unwrap_or_default();
        let (name, version) = (text("name"), text("version"));
        // Those of this workspace have a folder behind the version.
        if tree.lines().any(|own| own.trim_end_matches(" (*)") == format!("{name} v{version}")) {
            let texts = texts(Path::new(text("manifest_path")).parent().context("a manifest in no folder")?)?;
            ensure!(!texts.is_empty(), "{name} has no file with its licence");
            files.extend(texts.into_iter().map(|(own, text)| (format!("licenses/{name}-{version}/{own}"), text)));
        }
    }
    let text = Path::new(&rustc()?.1).join("share/doc/rust/COPYRIGHT-library.html");
    let text = fs::read(&text).with_context(|| format!("the compiler has no {}", text.display()))?;
    files.push(("licenses/rust-standard-library.html".to_owned(), text));
    Ok(files)
}

/// Names and texts of the licences in the folder of a package: beside its manifest, or in the folder that REUSE has.
fn texts(package: &Path) -> Result<Vec<(String, Vec<u8>)>> {
    let mut found = Vec::new();
    for folder in [package.to_path_buf(), package.join("LICENSES")].iter().filter(|folder| folder.is_dir()) {
        for entry in folder.read_dir()? {
            let path = entry?.path();
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let starts = STARTS.iter().any(|start| name.to_uppercase().starts_with(start));
            if path.is_file() && (folder != package || starts) {
                found.push((name, fs::read(&path)?));
            }
        }
    }
    if found.is_empty() && fs::read_to_string(package.join("Cargo.toml"))?.contains(DUAL) {
        // A package of traits alone that forgot the texts: that of the second licence is the same for all.
        found.push(("LICENSE-APACHE".to_owned(), fs::read(root().join("LICENSE-APACHE"))?));
    }
    Ok(found)
}
