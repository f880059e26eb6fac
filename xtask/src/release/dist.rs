//! The artefacts of a release: files of `target/dist`, and their table.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use sha2::{Digest, Sha256};

use crate::workspace;

/// The version of all packages.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The file of sums, which `sha256sum --check` reads.
const SUMS: &str = "SHA256SUMS";

/// The folder of artefacts.
pub fn folder() -> Result<PathBuf> {
    let folder = workspace::target_dir().join("dist");
    fs::create_dir_all(&folder).with_context(|| format!("cannot create {}", folder.display()))?;
    Ok(folder)
}

/// The artefacts whose names start and end so, sorted.
fn files(start: &str, end: &str) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for entry in folder()?.read_dir()? {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().into_owned();
        files.extend((name != SUMS && name.starts_with(start) && name.ends_with(end)).then(|| entry.path()));
    }
    files.sort();
    Ok(files)
}

/// Removes artefacts of earlier runs.
pub fn remove(start: &str, end: &str) -> Result<()> {
    files(start, end)?.iter().try_for_each(|file| Ok(fs::remove_file(file)?))
}

/// The one artefact whose name starts and ends so.
pub fn find(start: &str, end: &str) -> Result<PathBuf> {
    files(start, end)?.pop().with_context(|| format!("there is no {start}…{end} in target/dist"))
}

/// Name, bytes and SHA-256 of all artefacts, as a table; also writes the file of sums.
pub fn table() -> Result<String> {
    let (mut table, mut sums) = (format!("{:64} {:>10}  sha256\n", "artefact", "bytes"), String::new());
    for file in files("", "")? {
        let bytes = fs::read(&file).with_context(|| format!("cannot read {}", file.display()))?;
        let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let hash: String = Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect();
        let _string_grows = writeln!(table, "{name:64} {:>10}  {hash}", bytes.len());
        let _string_grows = writeln!(sums, "{hash}  {name}");
    }
    fs::write(folder()?.join(SUMS), sums)?;
    Ok(table)
}

/// A copy of the tree in a folder of `target`, whose workspace has these members besides the package of its root: for
/// programs that write beside manifests, or whose results other packages would change.
pub fn copy_of_tree(name: &str, members: &[String]) -> Result<PathBuf> {
    let (root, folder) = (workspace::root(), workspace::target_dir().join(name).join("source"));
    if folder.exists() {
        fs::remove_dir_all(&folder)?;
    }
    for name in crate::cargo::files()? {
        let to = folder.join(&name);
        fs::create_dir_all(to.parent().unwrap_or(&folder))?;
        fs::copy(root.join(&name), &to).with_context(|| format!("cannot copy {name}"))?;
    }
    set_members(&folder, members)?;
    Ok(folder)
}

/// Changes the members of a copy's workspace.
pub fn set_members(copy: &Path, members: &[String]) -> Result<()> {
    let text = fs::read_to_string(copy.join("Cargo.toml"))?;
    let line = |line: &str| match line.split_once(" = ").map(|(key, _)| key) {
        Some("members") => format!("members = {members:?}\n"),
        Some("default-members") => "default-members = [\".\"]\n".to_owned(),
        _ => format!("{line}\n"),
    };
    fs::write(copy.join("Cargo.toml"), text.lines().map(line).collect::<String>())?;
    // The versions of the tree, of which the members before may have kept some only.
    fs::copy(workspace::root().join("Cargo.lock"), copy.join("Cargo.lock"))?;
    Ok(())
}
