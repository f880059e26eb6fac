//! What is around a part: its plan in a file beside it, keys in the names of its folders, and the parts of a folder.
//!
//! ```text
//! a.parquet  a.plan.json                          the plan, for programs that write the part again without metadata
//! lake/plan.json  lake/year=2026/unit=d7/*.parquet   one plan for all; the keys year and unit are columns
//! ```

use std::path::{Path, PathBuf};

use super::Plan;
use model::Error;

/// Name of the plan of all parts of a folder.
const OF_FOLDER: &str = "plan.json";
/// Value of a key that is missing, in the convention of Hive.
const MISSING: &str = "__HIVE_DEFAULT_PARTITION__";

/// The file with the plan beside a part.
#[must_use]
pub fn plan_file(part: &Path) -> PathBuf {
    part.with_extension(OF_FOLDER)
}

/// The plan beside a part, in its folder, or in the folder above those with keys; `None` if there is none.
pub(super) fn plan_beside(part: &Path) -> Result<Option<Plan>, Error> {
    let mut folder = part.parent();
    let mut files = vec![plan_file(part)];
    while let Some(own) = folder {
        files.push(own.join(OF_FOLDER));
        folder = key(own).and_then(|_| own.parent());
    }
    files.iter().find(|file| file.is_file()).map(|file| read_plan(file)).transpose()
}

/// Reads a file with a plan.
pub(super) fn read_plan(file: &Path) -> Result<Plan, Error> {
    let text = std::fs::read_to_string(file).map_err(Error::io(file))?;
    Plan::parse(&text).map_err(|problem| Error::content(file, "content", problem))
}

/// Key and value of a folder that is named `key=value`.
fn key(folder: &Path) -> Option<(String, String)> {
    let (key, value) = folder.file_name()?.to_str()?.split_once('=')?;
    (!key.is_empty()).then(|| (unescaped(key), unescaped(value)))
}

/// The keys of the folders of a part, the innermost first.
pub(super) fn keys(part: &Path) -> Vec<(String, String)> {
    let folders = part.ancestors().skip(1).map_while(key);
    folders.map(|(key, value)| (key, if value == MISSING { String::new() } else { value })).collect()
}

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

/// These files, and the parts and sums in these folders and below; names with a leading `_` or `.` are left out, as in
/// lakes.
pub(super) fn files(paths: &[PathBuf]) -> Result<Vec<PathBuf>, Error> {
    let mut all = Vec::new();
    for path in paths {
        let before = all.len();
        if path.is_dir() {
            gather(path, &mut all)?;
        } else {
            all.push(path.clone());
        }
        if all.len() == before {
            return Err(Error::content(path, "content", "no part in this folder: no file .parquet or .sums"));
        }
    }
    Ok(all)
}

fn gather(folder: &Path, all: &mut Vec<PathBuf>) -> Result<(), Error> {
    let entries = std::fs::read_dir(folder).map_err(Error::io(folder))?;
    let mut paths: Vec<PathBuf> = entries.filter_map(|entry| entry.ok().map(|entry| entry.path())).collect();
    paths.retain(|path| !path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(['_', '.'])));
    paths.sort();
    for path in paths {
        // A link to a folder may lead back to it.
        if path.is_dir() && !path.is_symlink() {
            gather(&path, all)?;
        } else if path.is_file() && path.extension().is_some_and(|end| end == "parquet" || end == "sums") {
            all.push(path);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_those_of_the_innermost_folders() {
        let of = |path: &str| keys(Path::new(path));
        let pair = |key: &str, value: &str| (key.to_string(), value.to_string());
        assert_eq!(
            of("a=1/lake/year=2026/unit=press%207/part.parquet"),
            [pair("unit", "press 7"), pair("year", "2026")]
        );
        assert_eq!(of("lake/run=__HIVE_DEFAULT_PARTITION__/p.parquet"), [pair("run", "")]);
        assert_eq!((of("p.parquet"), of("lake/=3/p.parquet")), (vec![], vec![]));
        for (text, plain) in [("100%", "100%"), ("%C3%A4", "ä"), ("%ff", "%ff"), ("a%2", "a%2"), ("%", "%")] {
            assert_eq!(unescaped(text), plain);
        }
    }

    #[test]
    fn folders_are_searched_below_and_left_out_names_are_not() {
        let folder = tempfile::tempdir().expect("a folder");
        for name in ["b.parquet", "a/c.sums", "a/notes.txt", "_tmp/x.parquet", "a/.y.parquet", "b.plan.json"] {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().expect("a folder")).expect("made");
            std::fs::write(path, "").expect("written");
        }
        let parts = files(&[folder.path().into()]).expect("files");
        assert_eq!(parts, ["a/c.sums", "b.parquet"].map(|name| folder.path().join(name)));
        let none = files(&[folder.path().join("_tmp")]).map(|files| files.len());
        assert_eq!(none.expect("a folder that is named itself"), 1);
        let refused = files(&[tempfile::tempdir().expect("a folder").path().into()]).expect_err("empty").to_string();
        assert!(refused.contains("no part in this folder"), "{refused}");
    }
}
