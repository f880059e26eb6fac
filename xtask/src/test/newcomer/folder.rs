//! Folders outside the checkout: cargo would merge the configuration of the checkout with theirs.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};

use crate::child;

/// An empty folder outside the checkout, which is removed at the end.
#[derive(Debug)]
pub struct Folder(PathBuf);

impl Folder {
    pub fn new(name: &str) -> Result<Self> {
        let path = env::temp_dir().join(format!("bearing-watch-newcomer-{}", std::process::id())).join(name);
        if path.exists() {
            fs::remove_dir_all(&path)?;
        }
        fs::create_dir_all(&path).with_context(|| format!("cannot create {}", path.display()))?;
        Ok(Self(path))
    }

    pub fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // What cannot be removed stays in the system's folder for temporary files.
        let _ = fs::remove_dir_all(&self.0);
        let _ = self.0.parent().map(fs::remove_dir);
    }
}

/// Copies folders, with all folders in them, to the same places in another one.
pub fn copy(folders: &[&str], from: &Path, to: &Path) -> Result<()> {
    child::succeed(Command::new("cp").args(["-r", "--parents"]).args(folders).arg(to).current_dir(from))
}
