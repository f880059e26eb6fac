//! The files of a folder and of the folders below it.
//!
//! ```text
//! recordings/
//!   labels.csv  healthy/run=1/a.csv   taken, in the order of their paths
//!   .trash/b.csv                      left out: hidden
//!   results/model.bwm  results/c.csv  left out by a rule of the caller, such as [`reason_to_skip`]
//!   latest -> healthy                 left out: taken already
//! ```
//!
//! Names that begin with a dot are hidden. Links to folders are followed after everything else, and each folder is
//! entered once, so that no circle of links has an end of its own. The folder that is named is never left out.

use std::collections::{HashSet, VecDeque};
use std::path::{Path, PathBuf};

use model::Error;
use model::trace::file_name;

/// Files that are counted at most in a folder that is left out.
const COUNTED: usize = 10_000;

/// How folders are walked.
#[derive(Clone, Copy)]
pub struct Walk<'a> {
    /// Whether links to folders are followed.
    pub links: bool,
    /// Which files are taken.
    pub takes: &'a dyn Fn(&Path) -> bool,
    /// Why a folder below is left out with its files, if it is.
    pub skips: &'a dyn Fn(&Path) -> Option<String>,
}

/// The files of a folder.
#[derive(Debug, Default)]
pub struct Walked {
    /// In the order of their paths.
    pub files: Vec<PathBuf>,
    /// What is left out.
    pub skipped: Vec<Skipped>,
}

/// A file or folder that is left out, with the number of files in it that would be taken otherwise.
#[derive(Debug)]
pub struct Skipped {
    /// The file or folder.
    pub path: PathBuf,
    /// Number of files.
    pub files: usize,
    /// Why.
    pub reason: String,
}

impl std::fmt::Display for Skipped {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { path, files, reason } = self;
        let files = match files {
            0 => String::new(),
            1 => "1 file: ".into(),
            _ => format!("{files} files: "),
        };
        write!(f, "left out {files}{}: {reason}", path.display())
    }
}

impl std::fmt::Debug for Walk<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Walk").field("links", &self.links).finish_non_exhaustive()
    }
}

impl Walk<'_> {
    /// Walks through a folder.
    ///
    /// # Errors
    /// A folder that cannot be read; one below it is left out.
    pub fn of(&self, folder: &Path) -> Result<Walked, Error> {
        // The parts of a path are without `/./`.
        let folder = &folder.components().collect::<PathBuf>();
        let mut walked = Walked::default();
        let mut state = State { entered: HashSet::new(), links: VecDeque::new() };
        state.entered.extend(folder.canonicalize().ok());
        self.enter(folder, &mut state, &mut walked).map_err(Error::io(folder))?;
        while let Some(link) = state.links.pop_front() {
            self.follow(&link, &mut state, &mut walked);
        }
        walked.files.sort();
        self.once(&mut walked);
        walked.skipped.sort_by(|one, other| one.path.cmp(&other.path));
        Ok(walked)
    }

    fn enter(&self, folder: &Path, state: &mut State, walked: &mut Walked) -> std::io::Result<()> {
        let mut paths: Vec<PathBuf> = std::fs::read_dir(folder)?.filter_map(|entry| Some(entry.ok()?.path())).collect();
        paths.sort();
        for path in paths {
            if path.is_dir() {
                self.below(path, state, walked);
            } else if path.is_file() && (self.takes)(&path) {
                if is_hidden(&path) {
                    walked.skipped.push(Skipped { path, files: 1, reason: "hidden".into() });
                } else {
                    walked.files.push(path);
                }
            }
        }
        Ok(())
    }

    fn below(&self, path: PathBuf, state: &mut State, walked: &mut Walked) {
        let hidden = is_hidden(&path).then(|| "hidden".to_string());
        if let Some(reason) = hidden.or_else(|| (self.skips)(&path)) {
            let files = self.count(&path);
            walked.skipped.extend((files > 0).then_some(Skipped { path, files, reason }));
        } else if path.is_symlink() {
            state.links.extend(self.links.then_some(path));
        } else if path.canonicalize().is_ok_and(|own| state.entered.insert(own))
            && let Err(error) = self.enter(&path, state, walked)
        {
            walked.skipped.push(Skipped { path, files: 0, reason: format!("cannot be read: {error}") });
        }
    }

    /// Follows a link, unless its folder was entered or is in one that was.
    fn follow(&self, link: &Path, state: &mut State, walked: &mut Walked) {
        let Ok(target) = link.canonicalize() else { return };
        if !state.entered.insert(target.clone()) {
            let (files, reason) = (self.count(link), "the folder is taken by its other name".to_string());
            walked.skipped.extend((files > 0).then_some(Skipped { path: link.into(), files, reason }));
        } else if let Err(error) = self.enter(link, state, walked) {
            let reason = format!("cannot be read: {error}");
            walked.skipped.push(Skipped { path: link.into(), files: 0, reason });
        }
    }

    /// Leaves out links to files that are taken themselves.
    fn once(&self, walked: &mut Walked) {
        let (links, files): (Vec<PathBuf>, Vec<PathBuf>) =
            std::mem::take(&mut walked.files).into_iter().partition(|file| file.is_symlink());
        let mut taken: HashSet<PathBuf> = HashSet::new();
        if !links.is_empty() {
            taken.extend(files.iter().filter_map(|file| file.canonicalize().ok()));
        }
        walked.files = files;
        for path in links {
            if path.canonicalize().is_ok_and(|file| taken.insert(file)) {
                walked.files.push(path);
            } else {
                walked.skipped.push(Skipped { path, files: 1, reason: "a link to a file that is taken itself".into() });
            }
        }
        walked.files.sort();
    }

    /// The number of files in a folder that is left out; links are not followed.
    fn count(&self, folder: &Path) -> usize {
        let (mut open, mut count) = (vec![folder.to_path_buf()], 0);
        while let Some(folder) = open.pop().filter(|_| count < COUNTED) {
            let entries = std::fs::read_dir(&folder).into_iter().flatten().filter_map(Result::ok);
            for path in entries.map(|entry| entry.path()) {
                if path.is_dir() {
                    open.extend((!path.is_symlink()).then_some(path));
                } else {
                    count += usize::from(path.is_file() && (self.takes)(&path));
                }
            }
        }
        count
    }
}

/// Folders that were entered, and links to folders that are still to follow.
struct State {
    entered: HashSet<PathBuf>,
    links: VecDeque<PathBuf>,
}

/// Whether a name begins with a dot.
#[must_use]
pub fn is_hidden(path: &Path) -> bool {
    file_name(path).starts_with('.')
}

/// Why a folder has no recordings, if it has none: scratch folders, those of caches, and those of results, which have a
/// model.
#[must_use]
pub fn reason_to_skip(folder: &Path) -> Option<String> {
    if file_name(folder).starts_with('_') {
        return Some("its name begins with _; name the folder to read it".into());
    }
    if folder.join("CACHEDIR.TAG").is_file() || folder.join("pyvenv.cfg").is_file() {
        return Some("a cache or a Python environment; name the folder to read it".into());
    }
    let entries = std::fs::read_dir(folder).into_iter().flatten().filter_map(Result::ok);
    let is_model = |path: &PathBuf| path.extension().is_some_and(|end| end.eq_ignore_ascii_case("bwm"));
    let model = entries.map(|entry| entry.path()).find(is_model)?;
    Some(format!("a folder of results, for it has the model {}; name the folder to read it", file_name(&model)))
}

/// Key and value of a folder that is named `key=value`, in the convention of Hive; `%20` and the like are characters.
#[must_use]
pub fn key_of(folder: &str) -> Option<(String, String)> {
    let (key, value) = folder.split_once('=')?;
    let value = if value == MISSING { String::new() } else { unescaped(value) };
    (!key.is_empty()).then(|| (unescaped(key), value))
}

/// Value of a key that is missing, in the convention of Hive.
const MISSING: &str = "__HIVE_DEFAULT_PARTITION__";

/// Text with `%20` and the like as characters.
fn unescaped(text: &str) -> String {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find('%') {
        let (before, from) = rest.split_at(at);
        bytes.extend(before.bytes());
        let code = from.get(1..3).and_then(|digits| u8::from_str_radix(digits, 16).ok());
        bytes.push(code.unwrap_or(b'%'));
        rest = &from[if code.is_some() { 3 } else { 1 }..];
    }
    bytes.extend(rest.bytes());
    String::from_utf8(bytes).unwrap_or_else(|_| text.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(names: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().expect("a folder");
        for name in names {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().expect("a folder")).expect("made");
            std::fs::write(path, "").expect("written");
        }
        folder
    }

    fn walked(folder: &Path, links: bool) -> (Vec<String>, Vec<String>) {
        let takes = |path: &Path| path.extension().is_some_and(|end| end == "csv");
        let walked = Walk { links, takes: &takes, skips: &reason_to_skip }.of(folder).expect("a folder");
        let below = |path: &PathBuf| path.strip_prefix(folder).expect("below").display().to_string().replace('\\', "/");
        let skipped = walked.skipped.iter().map(|own| format!("{} {}", below(&own.path), own.files));
        (walked.files.iter().map(below).collect(), skipped.collect())
    }

    #[test]
    fn files_are_found_at_every_depth_and_what_is_left_out_is_counted() {
        let own = folder(&[
            "z.csv",
            "a/b/c/d/deep.csv",
            "a/x.csv",
            "notes.md",
            ".git/x.csv",
            ".git/y/z.csv",
            ".a.csv",
            "_old/x.csv",
            "out/model.bwm",
            "out/pages/r.csv",
            "target/CACHEDIR.TAG",
            "target/t.csv",
            ".empty/x.md",
        ]);
        let (files, skipped) = walked(own.path(), true);
        assert_eq!(files, ["a/b/c/d/deep.csv", "a/x.csv", "z.csv"]);
        assert_eq!(skipped, [".a.csv 1", ".git 2", "_old 1", "out 1", "target 1"]);
        // What is named is read.
        assert_eq!(walked(&own.path().join("_old"), true).0, ["x.csv"]);
        assert_eq!(walked(&own.path().join("out"), true).0, ["pages/r.csv"]);
        assert!(Walk { links: true, takes: &|_| true, skips: &|_| None }.of(&own.path().join("none")).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_once() {
        use std::os::unix::fs::symlink;
        let (own, other) = (folder(&["a/x.csv", "b/c/y.csv"]), folder(&["in/z.csv"]));
        let at = |name: &str| own.path().join(name);
        for (from, to) in
            [(at(""), "a/up"), (at("b"), "a/side"), (at("b/c/y.csv"), "a/y.csv"), (other.path().into(), "far")]
        {
            symlink(from, at(to)).expect("a link");
        }
        symlink(own.path(), other.path().join("back")).expect("a link");
        symlink(own.path().join("nowhere"), at("broken")).expect("a link");
        let (files, skipped) = walked(own.path(), true);
        assert_eq!(files, ["a/x.csv", "b/c/y.csv", "far/in/z.csv"]);
        assert_eq!(skipped, ["a/side 1", "a/up 3", "a/y.csv 1", "far/back 3"]);
        assert_eq!(walked(own.path(), false).0, ["a/x.csv", "b/c/y.csv"]);
    }

    #[test]
    fn keys_are_read_of_names_of_folders() {
        let pair = |key: &str, value: &str| Some((key.to_string(), value.to_string()));
        assert_eq!(key_of("unit=press%207"), pair("unit", "press 7"));
        assert_eq!(key_of("run=__HIVE_DEFAULT_PARTITION__"), pair("run", ""));
        assert_eq!((key_of("=3"), key_of("run_3")), (None, None));
        for (text, plain) in [("100%", "100%"), ("%C3%A4", "ä"), ("%ff", "%ff"), ("a%2", "a%2"), ("%", "%")] {
            assert_eq!(unescaped(text), plain);
        }
    }
}
