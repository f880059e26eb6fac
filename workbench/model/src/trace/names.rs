//! Names of files of traces: which formats there are, what remains of a name without them, and the names that labels
//! give.
//!
//! Equal names are compared in the composed form of Unicode (NFC): some systems write ü as one character, others as u
//! with two dots.

use std::borrow::Cow;
use std::collections::HashSet;
use std::path::Path;

use unicode_normalization::{UnicodeNormalization as _, is_nfc};

/// Extensions of the files that can be read, or of which is said why not.
const EXTENSIONS: [&str; 16] = [
    "csv", "tsv", "txt", "dat", "lvm", "mat", "h5", "hdf5", "parquet", "arrow", "arrows", "feather", "npy", "npz",
    "tdms", "xlsx",
];
/// Extensions of compressed text.
const COMPRESSED: [&str; 2] = ["gz", "zst"];

/// Extensions of a name, in lower case: that of the format, and of the compression.
#[must_use]
pub fn extensions(name: &str) -> Option<(String, bool)> {
    let lower = name.to_ascii_lowercase();
    let compressed = COMPRESSED.iter().find_map(|end| lower.strip_suffix(&format!(".{end}")));
    let plain = compressed.unwrap_or(&lower);
    let own = EXTENSIONS.iter().find(|end| plain.strip_suffix(**end).is_some_and(|rest| rest.ends_with('.')))?;
    Some(((*own).to_string(), compressed.is_some()))
}

/// Whether the name is that of a file that can be read.
#[must_use]
pub fn is_known(path: &Path) -> bool {
    path.file_name().is_some_and(|name| extensions(&name.to_string_lossy()).is_some())
}

/// The name of a file without its folder.
#[must_use]
pub fn file_name(path: &Path) -> String {
    path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

/// The name of a file without the extensions of formats that can be read.
#[must_use]
pub fn stem(name: &str) -> &str {
    match extensions(name) {
        Some((own, compressed)) => {
            let end = COMPRESSED.iter().find(|end| compressed && name.to_ascii_lowercase().ends_with(**end));
            &name[..name.len() - own.len() - 1 - end.map_or(0, |end| end.len() + 1)]
        }
        None => name,
    }
}

/// A text in the composed form of Unicode.
#[must_use]
pub fn composed(text: &str) -> Cow<'_, str> {
    if is_nfc(text) { Cow::Borrowed(text) } else { Cow::Owned(text.nfc().collect()) }
}

/// The name of a trace as it is compared: composed, with `/` between folders, without the extension, and without what
/// leads from one folder to another one (`./` and `../`).
#[must_use]
pub fn trace_name(text: &str) -> Cow<'_, str> {
    let is_plain = |text: &str| text.is_ascii() && !text.contains(['/', '\\']);
    if is_plain(text) {
        return Cow::Borrowed(stem(text));
    }
    let text = composed(text).replace('\\', "/");
    let parts: Vec<&str> = text.split('/').filter(|part| !part.is_empty() && *part != ".").collect();
    let below = parts.iter().rposition(|part| *part == "..").map_or(0, |last| last + 1);
    let name = parts[below..].join("/");
    Cow::Owned(if name.is_empty() { text } else { stem(&name).to_string() })
}

/// The names of traces that labels give, as [`trace_name`] has them.
#[derive(Clone, Debug, Default)]
pub struct TraceNames(HashSet<String>);

impl TraceNames {
    /// Of these names.
    pub fn of(names: impl IntoIterator<Item = String>) -> Self {
        Self(names.into_iter().collect())
    }

    /// Whether there is this name.
    #[must_use]
    pub fn has(&self, name: &str) -> bool {
        self.0.contains(name)
    }

    /// The longest name that a path ends with: `run_1/x` before `x` of `data/run_1/x`. The path is as [`trace_name`]
    /// has it.
    #[must_use]
    pub fn longest<'a>(&self, path: &'a str) -> Option<&'a str> {
        let starts = std::iter::once(0).chain(path.match_indices('/').map(|(at, _)| at + 1));
        starts.map(|start| &path[start..]).find(|end| self.has(end))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_traces_are_alike_whatever_system_wrote_them() {
        for (text, expected) in [
            ("a.csv", "a"),
            ("class_a/run_1/x.csv", "class_a/run_1/x"),
            ("class_a\\run_1\\x.mat", "class_a/run_1/x"),
            ("./x.csv", "x"),
            ("../recordings/x", "recordings/x"),
            ("/data//x.csv.gz", "data/x"),
            ("pru\u{308}fung 3.csv", "pr\u{fc}fung 3"),
            ("run.1", "run.1"),
            ("..", ".."),
        ] {
            assert_eq!(trace_name(text), expected, "{text}");
        }
    }

    #[test]
    fn the_longest_name_is_that_of_a_path() {
        let names = TraceNames::of(["x", "run_1/x", "unrun_1/y"].map(String::from));
        assert_eq!(names.longest("data/run_1/x"), Some("run_1/x"));
        assert_eq!(names.longest("data/run_2/x"), Some("x"));
        assert_eq!(names.longest("x"), Some("x"));
        assert_eq!((names.longest("data/run_1/y"), names.longest("run_1")), (None, None));
    }

    #[test]
    fn names_lose_the_extensions_of_known_formats() {
        for (name, expected) in [
            ("a.csv", "a"),
            ("a.CSV", "a"),
            ("a.b.csv.gz", "a.b"),
            ("a.txt.ZST", "a"),
            ("a.mat", "a"),
            ("a.lvm", "a"),
            ("a.parquet", "a"),
            ("a.gz", "a.gz"),
            ("a.log", "a.log"),
            ("a", "a"),
            ("csv", "csv"),
        ] {
            assert_eq!(stem(name), expected, "{name}");
        }
        assert!(is_known(Path::new("x/a.tsv.gz")) && !is_known(Path::new("x/a.bwm")));
    }
}
