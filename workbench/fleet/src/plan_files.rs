//! What is around a part: its plan in a file beside it, keys in the names of its folders, and the parts of a folder.
//!
//! ```text
//! a.parquet  a.plan.json                          the plan, for programs that write the part again without metadata
//! lake/plan.json  lake/year=2026/unit=d7/*.parquet   one plan for all; the keys year and unit are columns
//! ```

use std::path::{Path, PathBuf};

use super::Plan;
use model::Error;
use model::trace::file_name;
use traces::walk::{Walk, key_of};

/// Name of the plan of all parts of a folder.
const OF_FOLDER: &str = "plan.json";
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
        folder = key_of(&file_name(own)).and_then(|_| own.parent());
    }
    files.iter().find(|file| file.is_file()).map(|file| read_plan(file)).transpose()
}

/// Reads a file with a plan.
pub(super) fn read_plan(file: &Path) -> Result<Plan, Error> {
    let text = std::fs::read_to_string(file).map_err(Error::io(file))?;
    Plan::parse(&text).map_err(|problem| Error::content(file, "content", problem))
}

/// The keys of the folders of a part, the innermost first.
pub(super) fn keys(part: &Path) -> Vec<(String, String)> {
    part.ancestors().skip(1).map_while(|folder| key_of(&file_name(folder))).collect()
}

/// These files, and the parts in these folders and below; names with a leading `_` or `.` are left out, as in
/// lakes.
pub(super) fn files(paths: &[PathBuf]) -> Result<Vec<PathBuf>, Error> {
    let is_part = |path: &Path| path.extension().is_some_and(|end| end == "parquet");
    let is_scratch = |path: &Path| file_name(path).starts_with('_');
    let walk = Walk {
        links: false,
        takes: &|path| is_part(path) && !is_scratch(path),
        skips: &|folder| is_scratch(folder).then(|| "its name begins with _".into()),
    };
    let mut all = Vec::new();
    for path in paths {
        let before = all.len();
        if path.is_dir() {
            all.extend(walk.of(path)?.files);
        } else {
            all.push(path.clone());
        }
        if all.len() == before {
            return Err(Error::content(path, "content", "no part in this folder: no file .parquet"));
        }
    }
    Ok(all)
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
    }

    #[test]
    fn folders_are_searched_below_and_left_out_names_are_not() {
        let folder = tempfile::tempdir().expect("a folder");
        for name in ["b.parquet", "a/c.parquet", "a/notes.txt", "_tmp/x.parquet", "a/.y.parquet", "b.plan.json"] {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().expect("a folder")).expect("made");
            std::fs::write(path, "").expect("written");
        }
        let parts = files(&[folder.path().into()]).expect("files");
        assert_eq!(parts, ["a/c.parquet", "b.parquet"].map(|name| folder.path().join(name)));
        let none = files(&[folder.path().join("_tmp")]).map(|files| files.len());
        assert_eq!(none.expect("a folder that is named itself"), 1);
        let refused = files(&[tempfile::tempdir().expect("a folder").path().into()]).expect_err("empty").to_string();
        assert!(refused.contains("no part in this folder"), "{refused}");
    }
}
