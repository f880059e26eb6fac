//! The files of a folder that can be shown.

use std::path::{Component, Path, PathBuf};

use model::Error;
use traces::walk::{Walk, is_hidden};

/// Files that are listed.
const FILES: usize = 5000;

/// What a file is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Trace,
    Model,
    Page,
}

impl Kind {
    pub(super) const ALL: [Self; 3] = [Self::Trace, Self::Model, Self::Page];

    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Trace => "trace",
            Self::Model => "model",
            Self::Page => "page",
        }
    }

    fn of(path: &Path) -> Option<Self> {
        let extension = path.extension().and_then(|extension| extension.to_str()).map(str::to_ascii_lowercase);
        match extension.as_deref() {
            Some("bwm") => Some(Self::Model),
            Some("html" | "htm") => Some(Self::Page),
            _ => traces::is_trace(path).then_some(Self::Trace),
        }
    }
}

/// A folder that is served.
#[derive(Clone, Debug)]
pub(super) struct Folder {
    root: PathBuf,
}

impl Folder {
    pub(super) fn open(path: &Path) -> Result<Self, Error> {
        if !path.is_dir() {
            return Err(Error::Usage(format!("{} is no folder", path.display())));
        }
        Ok(Self { root: path.canonicalize().map_err(Error::io(path))? })
    }

    /// Names of the files, relative to the folder, with their kinds; hidden ones are left out.
    pub(super) fn list(&self) -> Vec<(Kind, String)> {
        // A link could lead out of the folder.
        let walk = Walk { links: false, takes: &|path| Kind::of(path).is_some(), skips: &|_| None };
        let files = walk.of(&self.root).unwrap_or_default().files;
        let named = |path: &PathBuf| Some((Kind::of(path)?, path.strip_prefix(&self.root).ok()?.to_str()?.to_owned()));
        files.iter().filter_map(named).take(FILES).collect()
    }

    /// The file of this kind and name, if it is in the folder.
    pub(super) fn find(&self, kind: Kind, name: &str) -> Option<PathBuf> {
        let relative = Path::new(name);
        if name.is_empty() || !is_shown(relative) {
            return None;
        }
        let path = self.root.join(relative).canonicalize().ok()?;
        // A link may lead to a hidden file.
        let is_shown = path.strip_prefix(&self.root).is_ok_and(is_shown);
        (is_shown && path.is_file() && Kind::of(&path) == Some(kind)).then_some(path)
    }
}

/// Whether a relative path leads down only, through nothing that is hidden.
fn is_shown(path: &Path) -> bool {
    path.components().all(|part| matches!(part, Component::Normal(name) if !is_hidden(Path::new(name))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_files_of_the_folder_are_found() {
        let outer = tempfile::tempdir().expect("folder");
        let inner = outer.path().join("in");
        std::fs::create_dir_all(inner.join("deep")).expect("folder");
        std::fs::create_dir_all(inner.join(".git")).expect("folder");
        for name in [
            "in/.git/a.csv",
            "secret.csv",
            "in/a.csv",
            "in/deep/m.bwm",
            "in/labels.csv",
            "in/notes.md",
            "in/.hidden.csv",
        ] {
            std::fs::write(outer.path().join(name), "x").expect("written");
        }
        #[cfg(unix)]
        for (from, to) in [("secret.csv", "link.csv"), ("in/.hidden.csv", "shown.csv")] {
            std::os::unix::fs::symlink(outer.path().join(from), inner.join(to)).expect("a link");
        }
        let folder = Folder::open(&inner).expect("a folder");
        let names: Vec<String> = folder.list().into_iter().map(|(_, name)| name).collect();
        assert!(names.contains(&"a.csv".into()) && names.contains(&"deep/m.bwm".into()), "{names:?}");
        assert!(!names.iter().any(|name| name.contains("hidden") || name.contains("labels") || name.contains("notes")));
        assert!(folder.find(Kind::Trace, "a.csv").is_some() && folder.find(Kind::Model, "deep/m.bwm").is_some());
        let absolute = outer.path().join("secret.csv").display().to_string();
        for bad in ["../secret.csv", "deep/../../secret.csv", &absolute, "link.csv", "", ".", "m.bwm", "notes.md"] {
            assert_eq!(folder.find(Kind::Trace, bad), None, "{bad}");
        }
        for hidden in [".hidden.csv", "deep/../.hidden.csv", ".git/a.csv", "shown.csv"] {
            assert_eq!(folder.find(Kind::Trace, hidden), None, "{hidden}");
        }
    }
}
