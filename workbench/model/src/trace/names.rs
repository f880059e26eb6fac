//! Names of files of traces: which formats there are, and what remains of a name without them.

use std::path::Path;

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

#[cfg(test)]
mod tests {
    use super::*;

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
