//! Names of the traces of files: that of the file, with as many of its folders as tell the files apart.
//!
//! ```text
//! data/a.csv, data/b.csv            a, b
//! data/1/a.csv, data/2/a.csv        1/a, 2/a
//! data/x/1/a.csv, data/y/1/a.csv    x/1/a, y/1/a
//! ```
//!
//! Labels may name a trace with more folders or fewer: the longest name that the path of a file ends with is its own.
//! Of several files with one name it is that of the file whose whole path below the common folder it is.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use model::trace::{TraceNames, composed, trace_name};

/// How files are named among others.
#[derive(Debug)]
pub(crate) struct Naming {
    /// Number of parts of the folder that all have in common.
    root: usize,
    /// Number of parts of a name, with that of the file.
    depth: usize,
    files: HashSet<PathBuf>,
}

/// The parts of a whole path.
fn parts(path: &Path) -> Vec<String> {
    let whole = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    whole.iter().map(|part| composed(&part.to_string_lossy()).into_owned()).collect()
}

/// The whole path of a file as names are compared.
#[must_use]
pub fn whole_name(file: &Path) -> String {
    trace_name(&parts(file).join("/")).into_owned()
}

impl Naming {
    /// Of these files, which are in these folders or are them.
    pub(crate) fn of(paths: &[PathBuf], files: &[PathBuf]) -> Self {
        let folder = |path: &PathBuf| {
            let all = parts(path);
            let length = if path.is_dir() { all.len() } else { all.len().saturating_sub(1) };
            all[..length].to_vec()
        };
        let common = |one: Vec<String>, other: Vec<String>| {
            one.into_iter().zip(other).take_while(|(one, other)| one == other).map(|(one, _)| one).collect()
        };
        let root: usize = paths.iter().map(folder).reduce(common).map_or(0, |all: Vec<String>| all.len());
        let mut own = Self { root, depth: 1, files: files.iter().cloned().collect() };
        let below = |file: &PathBuf| trace_name(&own.parts_below(file).join("/")).into_owned();
        let all: HashSet<String> = files.iter().map(below).collect();
        let most = all.iter().map(|name| name.split('/').count()).max().unwrap_or(1);
        let tells =
            |depth: &usize| all.iter().map(|name| last(name, *depth)).collect::<HashSet<_>>().len() == all.len();
        own.depth = (1..most).find(tells).unwrap_or(most);
        own
    }

    /// The folders of a file below the common one, and its name.
    fn parts_below(&self, file: &Path) -> Vec<String> {
        let all = parts(file);
        let start = self.root.min(all.len().saturating_sub(1));
        all[start..].to_vec()
    }

    /// The folders of a file below the common one.
    pub(crate) fn folders(&self, file: &Path) -> Vec<String> {
        let mut all = self.parts_below(file);
        all.pop();
        all
    }

    /// The name of a file, with its extension; of others, such as the traces of a table, only their own.
    pub(crate) fn name(&self, file: &Path) -> String {
        let depth = if self.files.contains(file) { self.depth } else { 1 };
        let all = self.parts_below(file);
        all[all.len().saturating_sub(depth)..].join("/")
    }

    /// The name of each file, and whether labels give it.
    pub(crate) fn labelled(&self, files: &[PathBuf], names: &TraceNames) -> Vec<(String, bool)> {
        let whole: Vec<String> = files.iter().map(|file| whole_name(file)).collect();
        let given: Vec<Option<&str>> = whole.iter().map(|whole| names.longest(whole)).collect();
        let mut exact: HashMap<&str, usize> = HashMap::new();
        let is_exact = |k: usize| {
            let below = self.parts_below(&files[k]).join("/");
            given[k].is_some_and(|given| *given == *trace_name(&below))
        };
        for (k, given) in given.iter().enumerate() {
            if let Some(given) = given.filter(|_| is_exact(k)) {
                *exact.entry(given).or_default() += 1;
            }
        }
        let of = |(k, file): (usize, &PathBuf)| match given[k] {
            Some(given) if is_exact(k) || !exact.contains_key(given) => {
                let all = parts(file);
                let length = given.split('/').count();
                (all[all.len().saturating_sub(length)..].join("/"), true)
            }
            // Another file has the name that this one ends with.
            Some(_) => (self.parts_below(file).join("/"), false),
            None => (self.name(file), false),
        };
        files.iter().enumerate().map(of).collect()
    }
}

/// The last parts of a name.
fn last(name: &str, parts: usize) -> &str {
    name.rmatch_indices('/').nth(parts - 1).map_or(name, |(at, _)| &name[at + 1..])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn paths(names: &[&str]) -> Vec<PathBuf> {
        names.iter().map(PathBuf::from).collect()
    }

    fn named(files: &[&str]) -> Vec<String> {
        let files = paths(files);
        let naming = Naming::of(&files, &files);
        files.iter().map(|file| naming.name(file)).collect()
    }

    #[test]
    fn as_many_folders_are_in_a_name_as_tell_files_apart() {
        assert_eq!(named(&["d/a.csv", "d/e/b.csv"]), ["a.csv", "b.csv"]);
        assert_eq!(named(&["d/1/a.csv", "d/2/a.mat"]), ["1/a.csv", "2/a.mat"]);
        assert_eq!(named(&["d/x/1/a.csv", "d/y/1/a.csv", "d/b.csv"]), ["x/1/a.csv", "y/1/a.csv", "b.csv"]);
        // Formats do not tell traces apart, and folders cannot.
        assert_eq!(named(&["d/a.csv", "d/a.mat"]), ["a.csv", "a.mat"]);
        // One letter that two systems write in two ways.
        assert_eq!(named(&["d/\u{fc}/a.csv", "d/u\u{308}/a.csv", "d/o/b.csv"])[0], "a.csv");
    }

    #[test]
    fn labels_name_files_with_more_folders_or_fewer() {
        let given = |files: &[&str], names: &[&str]| {
            let names = TraceNames::of(names.iter().map(|name| trace_name(name).into_owned()));
            let files = paths(files);
            let all = Naming::of(&files, &files).labelled(&files, &names);
            all.into_iter().map(|(name, labelled)| format!("{name} {labelled}")).collect::<Vec<_>>()
        };
        let deep = ["d/class_a/run_1/x.csv", "d/class_b/run_1/x.csv"];
        for names in [["class_a/run_1/x", "class_b\\run_1\\x.csv"], ["d/class_a/run_1/x.mat", "./d/class_b/run_1/x"]] {
            let own: Vec<bool> = given(&deep, &names).iter().map(|own| own.ends_with("true")).collect();
            assert_eq!(own, [true, true], "{names:?}");
        }
        assert_eq!(given(&["d/a.csv", "d/e/b.csv"], &["b"]), ["a.csv false", "b.csv true"]);
        // The file that is named wholly, although another one ends alike.
        assert_eq!(given(&["d/x.csv", "d/e/x.csv"], &["x"]), ["x.csv true", "e/x.csv false"]);
        assert_eq!(given(&["d/x.csv", "d/e/x.csv"], &["x", "e/x"]), ["x.csv true", "e/x.csv true"]);
        // Neither is named wholly: both have the name, and reading both is refused.
        assert_eq!(given(&["d/e/x.csv", "d/f/x.csv"], &["x"]), ["x.csv true", "x.csv true"]);
        assert_eq!(given(&["d/1/pru\u{308}f.csv"], &["pr\u{fc}f"]), ["pr\u{fc}f.csv true"]);
    }
}
