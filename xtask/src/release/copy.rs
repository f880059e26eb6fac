//! A copy of the tree whose workspace has the published packages only, for programs that write beside manifests, or
//! whose results the other packages would change.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use crate::workspace;

/// The folders of the published packages besides the root.
const PUBLISHED: [&str; 8] = [
    "c-api",
    "workbench/cli",
    "workbench/fleet",
    "workbench/model",
    "workbench/pages",
    "workbench/rig",
    "workbench/studies",
    "workbench/traces",
];

/// Copies all files that git has or would add into a folder of `target`.
pub fn of_tree(name: &str) -> Result<PathBuf> {
    let (root, folder) = (workspace::root(), workspace::target_dir().join(name).join("source"));
    if folder.exists() {
        fs::remove_dir_all(&folder)?;
    }
    for name in workspace::files()? {
        let to = folder.join(&name);
        fs::create_dir_all(to.parent().unwrap_or(&folder))?;
        fs::copy(root.join(&name), &to).with_context(|| format!("cannot copy {name}"))?;
    }
    set_members(&folder, &PUBLISHED)?;
    Ok(folder)
}

/// Leaves the root's package and the one of a folder in the workspace of a copy.
pub fn keep_only(copy: &Path, folder: &str) -> Result<()> {
    let members: Vec<&str> = PUBLISHED.into_iter().filter(|name| *name == folder).collect();
    // The versions of the tree, of which the members before may have kept some only.
    fs::copy(workspace::root().join("Cargo.lock"), copy.join("Cargo.lock"))?;
    set_members(copy, &members)
}

fn set_members(copy: &Path, members: &[&str]) -> Result<()> {
    let manifest = copy.join("Cargo.toml");
    fs::write(&manifest, with_members(&fs::read_to_string(&manifest)?, members)?)?;
    Ok(())
}

/// A manifest with other packages of the workspace.
fn with_members(manifest: &str, members: &[&str]) -> Result<String> {
    let mut lines: Vec<String> = manifest.lines().map(ToOwned::to_owned).collect();
    let own =
        [("members = ", format!("members = {members:?}")), ("default-members = ", "default-members = [\".\"]".into())];
    for (start, replacement) in own {
        let line = lines.iter_mut().find(|line| line.starts_with(start));
        *line.with_context(|| format!("the manifest has no line {start}"))? = replacement;
    }
    Ok(lines.join("\n") + "\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_published_packages_stay_in_the_workspace() -> Result<()> {
        let manifest = fs::read_to_string(workspace::root().join("Cargo.toml"))?;
        let text = with_members(&manifest, &PUBLISHED)?;
        assert!(text.contains("\nmembers = [\"c-api\", \"workbench/cli\", ") && !text.contains("host-tests"), "{text}");
        assert!(with_members(&text, &[])?.contains("\nmembers = []\n"));
        assert!(with_members("[workspace]\n", &[]).is_err());
        Ok(())
    }
}
