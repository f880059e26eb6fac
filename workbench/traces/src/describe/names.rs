//! Labels from the names of files.
//!
//! ```text
//! unbalanced_800_3_test.csv ─► class unbalanced, n1 800, n2 3, set test
//! ```
//!
//! The words of a name are its class, in lower case. A word that only some files of a class have (normal_operation_1,
//! normal_2) is left out. If fewer than two classes of several files follow, all files are healthy.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use model::Error;
use model::outputs::cell;
use model::trace::stem;

/// Words that say what a file is for, not what it shows.
const SETS: [&str; 5] = ["test", "train", "training", "validation", "log"];
/// The class of files if their names give no classes.
pub(super) const ALL_HEALTHY: &str = "healthy";

/// One file: its name, and the parts of the name.
struct Name {
    stem: String,
    words: Vec<String>,
    numbers: Vec<String>,
    set: String,
}

impl Name {
    fn of(path: &Path) -> Self {
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let stem = stem(&name).to_string();
        let lower = stem.to_lowercase();
        let all = lower.split(|c: char| !c.is_alphabetic()).filter(|word| word.len() > 1);
        let (set, words): (Vec<&str>, Vec<&str>) = all.partition(|word| SETS.contains(word));
        let numbers = lower.split(|c: char| !c.is_ascii_digit()).filter(|part| !part.is_empty());
        Self {
            words: words.into_iter().map(String::from).collect(),
            numbers: numbers.map(String::from).collect(),
            set: set.first().map_or_else(String::new, ToString::to_string),
            stem,
        }
    }

    fn class(&self, left_out: &BTreeSet<String>) -> String {
        let words: Vec<&str> = self.words.iter().map(String::as_str).filter(|word| !left_out.contains(*word)).collect();
        words.join("_")
    }
}

/// The labels as CSV, and whether the names give classes.
pub(super) fn labels(files: &[PathBuf]) -> Result<(String, bool), Error> {
    let names: Vec<Name> = files.iter().map(|file| Name::of(file)).collect();
    let all: BTreeSet<&Vec<String>> = names.iter().map(|name| &name.words).collect();
    let without = |words: &[String], left: &String| -> Vec<String> {
        words.iter().filter(|word| *word != left).cloned().collect()
    };
    let is_some_only = |words: &&Vec<String>, word: &String| {
        let rest = without(words, word);
        !rest.is_empty() && all.contains(&rest)
    };
    let left_out: BTreeSet<String> =
        all.iter().flat_map(|words| words.iter().filter(|word| is_some_only(words, word)).cloned()).collect();
    let classes: Vec<String> = names.iter().map(|name| name.class(&left_out)).collect();
    let several = |class: &String| classes.iter().filter(|other| *other == class).count() > 1;
    let found: BTreeSet<&String> = classes.iter().filter(|class| !class.is_empty() && several(class)).collect();
    let are_found = found.len() > 1;
    let numbers = names.iter().map(|name| name.numbers.len()).max().unwrap_or(0);
    let has_sets = names.iter().any(|name| !name.set.is_empty());
    let mut header: Vec<String> = ["trace", "class_name"].map(String::from).to_vec();
    header.extend((1..=numbers).map(|k| format!("n{k}")));
    header.extend(has_sets.then(|| "set".to_string()));
    let mut rows = vec![header];
    for (name, class) in names.iter().zip(classes) {
        let class = match (are_found, class.is_empty()) {
            (false, _) => ALL_HEALTHY.to_string(),
            (true, true) => "unnamed".into(),
            (true, false) => class,
        };
        let number = |k: usize| name.numbers.get(k).cloned().unwrap_or_default();
        let set = if name.set.is_empty() { "none" } else { &name.set };
        let mut row = vec![name.stem.clone(), class];
        row.extend((0..numbers).map(number));
        row.extend(has_sets.then(|| set.to_string()));
        rows.push(row);
    }
    Ok((csv_of(&rows)?, are_found))
}

/// The rows as CSV, quoted if needed.
fn csv_of(rows: &[Vec<String>]) -> Result<String, Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let cells = |row: &Vec<String>| row.iter().map(|text| cell(text).into_owned()).collect::<Vec<_>>();
    rows.iter().try_for_each(|row| writer.write_record(cells(row))).map_err(Error::other)?;
    let bytes = writer.into_inner().map_err(|error| Error::Usage(error.to_string()))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_numbers_and_sets_are_told_apart() {
        let files = [
            "Normal_operation_1000.csv",
            "normal_800_1.csv",
            "normal_800_2_test.csv",
            "bad-load_800_1.csv",
            "bad-load_800_2.csv",
        ];
        let (text, found) = labels(&files.map(PathBuf::from)).expect("labels");
        let rows: Vec<&str> = text.lines().collect();
        assert!(found);
        assert_eq!(
            rows[..3],
            ["trace,class_name,n1,n2,set", "Normal_operation_1000,normal,1000,,none", "normal_800_1,normal,800,1,none"]
        );
        assert_eq!(rows[3..5], ["normal_800_2_test,normal,800,2,test", "bad-load_800_1,bad_load,800,1,none"]);
        let (text, found) = labels(&["park_50rpm.csv", "steps_1.csv"].map(PathBuf::from)).expect("labels");
        assert!(!found && text.contains("park_50rpm,healthy,50\n") && text.contains("steps_1,healthy,1\n"), "{text}");
    }
}
