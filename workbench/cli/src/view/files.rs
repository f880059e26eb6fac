//! The files of a folder that can be shown.

use std::path::{Component, Path, PathBuf};

use model::Error;

/// Folders within folders, and files of one kind, that are listed.
const DEPTH: usize = 6;
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
        let mut found = Vec::new();
        self.walk(&self.root, 0, &mut found);
        found.sort_by(|one, other| one.1.cmp(&other.1));
        found
    }

    fn walk(&self, folder: &Path, depth: usize, found: &mut Vec<(Kind, String)>) {
        let Ok(entries) = std::fs::read_dir(folder) else { return };
        for path in entries.filter_map(|entry| entry.ok().map(|entry| entry.path())) {
            let hidden = path.file_name().is_none_or(|name| name.to_string_lossy().starts_with('.'));
            if hidden || found.len() >= FILES {
                continue;
            }
            // A link could lead out of the folder, or in a circle.
            if path.is_dir() && !path.is_symlink() && depth < DEPTH {
                self.walk(&path, depth + 1, found);
            } else if let (true, Some(kind)) = (path.is_file(), Kind::of(&path)) {
                let name = path.strip_prefix(&self.root).ok().and_then(Path::to_str);
                found.extend(name.map(|name| (kind, name.to_owned())));
            }
        }
    }

    /// The file of this kind and name, if it is in the folder.
    pub(super) fn find(&self, kind: Kind, name: &str) -> Option<PathBuf> {
        let relative = Path::new(name);
        if name.is_empty() || relative.components().any(|part| !matches!(part, Component::Normal(_))) {
            return None;
        }
        let path = self.root.join(relative).canonicalize().ok()?;
        (path.starts_with(&self.root) && path.is_file() && Kind::of(&path) == Some(kind)).then_some(path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_files_of_the_folder_are_found() {
        let outer = tempfile::tempdir().expect("folder");
        let inner = outer.path().join("in");
        std::fs::create_dir_all(inner.join("deep")).expect("folder");
        for name in ["secret.csv", "in/a.csv", "in/deep/m.bwm", "in/labels.csv", "in/notes.md", "in/.hidden.csv"] {
            std::fs::write(outer.path().join(name), "x").expect("written");
        }
        #[cfg(unix)]
        std::os::unix::fs::symlink(outer.path().join("secret.csv"), inner.join("link.csv")).expect("a link");
        let folder = Folder::open(&inner).expect("a folder");
        let names: Vec<String> = folder.list().into_iter().map(|(_, name)| name).collect();
        assert!(names.contains(&"a.csv".into()) && names.contains(&"deep/m.bwm".into()), "{names:?}");
        assert!(!names.iter().any(|name| name.contains("hidden") || name.contains("labels") || name.contains("notes")));
        assert!(folder.find(Kind::Trace, "a.csv").is_some() && folder.find(Kind::Model, "deep/m.bwm").is_some());
        let absolute = outer.path().join("secret.csv").display().to_string();
        for bad in ["../secret.csv", "deep/../../secret.csv", &absolute, "link.csv", "", ".", "m.bwm", "notes.md"] {
            assert_eq!(folder.find(Kind::Trace, bad), None, "{bad}");
        }
    }
}
