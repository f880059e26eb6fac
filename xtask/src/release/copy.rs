//! A copy of the tree whose workspace has the published packages only, for programs that write beside manifests, or
//! whose results the other packages would change.

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result};

use crate::{child, workspace};

/// Lines of the manifest that name the packages of the workspace, by their starts, and their replacements.
const MEMBERS: [(&str, &str); 2] =
    [("members = ", "members = [\"c-api\", \"workbench\"]"), ("default-members = ", "default-members = [\".\"]")];

/// Copies all files that git has or would add into a folder of `target`.
pub fn of_tree(name: &str) -> Result<PathBuf> {
    let (root, folder) = (workspace::root(), workspace::target_dir().join(name).join("source"));
    if folder.exists() {
        fs::remove_dir_all(&folder)?;
    }
    let arguments = ["ls-files", "--cached", "--others", "--exclude-standard"];
    let list = child::output(Command::new("git").args(arguments).current_dir(&root)).context("git ls-files failed")?;
    // A file that is removed but not committed is still listed.
    for name in list.lines().filter(|name| root.join(name).exists()) {
        let to = folder.join(name);
        fs::create_dir_all(to.parent().unwrap_or(&folder))?;
        fs::copy(root.join(name), &to).with_context(|| format!("cannot copy {name}"))?;
    }
    let manifest = folder.join("Cargo.toml");
    fs::write(&manifest, published_only(&fs::read_to_string(&manifest)?)?)?;
    Ok(folder)
}

fn published_only(manifest: &str) -> Result<String> {
    let mut lines: Vec<&str> = manifest.lines().collect();
    for (start, replacement) in MEMBERS {
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
        let text = published_only(&manifest)?;
        assert!(text.contains("\nmembers = [\"c-api\", \"workbench\"]\n") && !text.contains("host-tests"), "{text}");
        assert!(published_only("[workspace]\n").is_err());
        Ok(())
    }
}
