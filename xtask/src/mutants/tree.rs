//! A copy of the tree, in which the source is changed.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use crate::workspace;

/// Brings a folder up to date with all files that git has or would add. Files that are the same are left alone, so
/// that cargo does not compile them again; others are removed, but for what a build has left behind.
pub fn refresh(folder: &Path) -> Result<()> {
    let (root, names) = (workspace::root(), workspace::files()?);
    for old in all(folder)? {
        if !names.iter().any(|name| folder.join(name) == old) {
            fs::remove_file(&old)?;
        }
    }
    for name in &names {
        let (bytes, to) = (fs::read(root.join(name)).with_context(|| name.clone())?, folder.join(name));
        if !fs::read(&to).is_ok_and(|old| old == bytes) {
            fs::create_dir_all(to.parent().unwrap_or(folder))?;
            fs::write(&to, bytes).with_context(|| format!("cannot copy {name}"))?;
        }
    }
    Ok(())
}

/// The files of a folder and of those in it.
fn all(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    let Ok(entries) = folder.read_dir() else { return Ok(files) };
    for entry in entries {
        let path = entry?.path();
        if path.is_dir() { files.extend(all(&path)?) } else { files.push(path) }
    }
    Ok(files)
}

/// A file of the copy that is changed until this is dropped.
#[derive(Debug)]
pub struct Changed {
    path: PathBuf,
    before: String,
}

impl Changed {
    pub fn new(path: PathBuf, before: String, after: &str) -> Result<Self> {
        fs::write(&path, after).with_context(|| path.display().to_string())?;
        Ok(Self { path, before })
    }
}

impl Drop for Changed {
    fn drop(&mut self) {
        // A copy that is not restored is refreshed by the next run.
        let _ = fs::write(&self.path, &self.before);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::setup::unpacked;

    #[test]
    fn a_change_ends_with_its_guard() -> Result<()> {
        let folder = unpacked::folder_for("changed")?;
        let path = folder.join("file");
        fs::write(&path, "before")?;
        let changed = Changed::new(path.clone(), fs::read_to_string(&path)?, "after")?;
        assert_eq!(fs::read_to_string(&path)?, "after");
        drop(changed);
        assert_eq!(fs::read_to_string(&path)?, "before");
        fs::remove_dir_all(folder)?;
        Ok(())
    }
}
