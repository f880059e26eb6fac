//! Labels from the names of files and folders.
//!
//! ```text
//! unbalanced_800_3_test.csv ─► class unbalanced, n1 800, n2 3, set test
//! outer/rec1.csv, healthy/rec1.csv ─► classes outer, healthy
//! ```
//!
//! Files in several folders have the names of these as their classes. Otherwise the words of a name are its class, in
//! lower case, without those that all files have and those that only some files of a class have (normal_operation_1,
//! normal_2). Where all words are the same, codes such as A1 and B0 are the classes. If these are the same too, the
//! classes are unknown: all files get the class [`REFERENCE`], which does not say that the machine is healthy.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use model::Error;
use model::outputs::cell;
use model::trace::{file_name, stem};

/// Words that say what a file is for, not what it shows.
const SETS: [&str; 5] = ["test", "train", "training", "validation", "log"];
/// The class of files whose classes cannot be told.
pub(super) const REFERENCE: &str = "reference";
/// Class names of machines without a defect.
pub(super) const HEALTHY: [&str; 8] = ["healthy", "normal", "good", "ok", "nominal", "baseline", "sound", "undamaged"];

/// One file: its name, and the parts of the name.
struct Name {
    /// As labels name it.
    trace: String,
    folder: String,
    words: Vec<String>,
    /// Parts of letters and digits, such as A1 and 100watt.
    codes: Vec<String>,
    numbers: Vec<String>,
    set: String,
}

/// How classes were told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Told {
    /// By the folders, or by the names.
    Folders,
    Names,
    /// Not at all.
    Nothing,
}

impl Name {
    fn of(path: &Path, qualified: bool) -> Self {
        let name = file_name(path);
        let folder = path.parent().and_then(Path::file_name).map(|name| name.to_string_lossy().into_owned());
        let folder = folder.unwrap_or_default();
        let stem = stem(&name).to_string();
        let lower = stem.to_lowercase();
        let all = lower.split(|c: char| !c.is_alphabetic()).filter(|word| word.chars().count() > 1);
        let parts: Vec<&str> = lower.split(|c: char| !c.is_alphanumeric()).filter(|part| !part.is_empty()).collect();
        let is_code = |part: &&&str| part.contains(char::is_alphabetic) && part.contains(|c: char| c.is_ascii_digit());
        let codes: Vec<String> = parts.iter().filter(is_code).map(ToString::to_string).collect();
        let (set, words): (Vec<&str>, Vec<&str>) = all.partition(|word| SETS.contains(word));
        let numbers = lower.split(|c: char| !c.is_ascii_digit()).filter(|part| !part.is_empty());
        Self {
            words: words.into_iter().map(String::from).collect(),
            codes,
            numbers: numbers.map(String::from).collect(),
            set: set.first().map_or_else(String::new, ToString::to_string),
            trace: if qualified { format!("{folder}/{stem}") } else { stem },
            folder,
        }
    }

    fn class(&self, left_out: &BTreeSet<String>) -> String {
        let words: Vec<&str> = self.words.iter().map(String::as_str).filter(|word| !left_out.contains(*word)).collect();
        words.join("_")
    }
}

/// The labels as CSV, and how classes were told.
pub(super) fn labels(files: &[PathBuf]) -> Result<(String, Told), Error> {
    let folders: BTreeSet<Option<&Path>> = files.iter().map(|file| file.parent()).collect();
    let names: Vec<Name> = files.iter().map(|file| Name::of(file, folders.len() > 1)).collect();
    let (classes, told) = classes(&names, folders.len() > 1);
    let numbers = names.iter().map(|name| name.numbers.len()).max().unwrap_or(0);
    let codes = names.iter().map(|name| name.codes.len()).max().unwrap_or(0);
    let has_sets = names.iter().any(|name| !name.set.is_empty());
    let mut header: Vec<String> = ["trace", "class_name"].map(String::from).to_vec();
    header.extend((1..=numbers).map(|k| format!("n{k}")));
    header.extend((1..=codes).map(|k| format!("code{k}")));
    header.extend(has_sets.then(|| "set".to_string()));
    let mut rows = vec![header];
    for (name, class) in names.iter().zip(classes) {
        let part = |parts: &[String], k: usize| parts.get(k).cloned().unwrap_or_default();
        let set = if name.set.is_empty() { "none" } else { &name.set };
        let mut row = vec![name.trace.clone(), class];
        row.extend((0..numbers).map(|k| part(&name.numbers, k)));
        row.extend((0..codes).map(|k| part(&name.codes, k)));
        row.extend(has_sets.then(|| set.to_string()));
        rows.push(row);
    }
    Ok((csv_of(&rows)?, told))
}

/// The class of each file.
fn classes(names: &[Name], by_folder: bool) -> (Vec<String>, Told) {
    if by_folder {
        return (names.iter().map(|name| name.folder.clone()).collect(), Told::Folders);
    }
    let all: BTreeSet<&Vec<String>> = names.iter().map(|name| &name.words).collect();
    let without = |words: &[String], left: &String| -> Vec<String> {
        words.iter().filter(|word| *word != left).cloned().collect()
    };
    let is_some_only = |words: &&Vec<String>, word: &String| {
        let rest = without(words, word);
        !rest.is_empty() && all.contains(&rest)
    };
    let of_some = all.iter().flat_map(|words| words.iter().filter(|word| is_some_only(words, word)).cloned());
    let of_all = |word: &&String| all.len() > 1 && all.iter().all(|words| words.contains(word));
    let common = all.iter().flat_map(|words| words.iter()).filter(of_all).cloned();
    let left_out: BTreeSet<String> = of_some.chain(common).collect();
    let own: Vec<String> = names.iter().map(|name| name.class(&left_out)).collect();
    let named: Vec<String> =
        own.iter().map(|own| if own.is_empty() { "unnamed".into() } else { own.clone() }).collect();
    if are_classes(&own) {
        return (named, Told::Names);
    }
    // A code that is the same in all files tells nothing.
    let code =
        |name: &Name| name.codes.iter().find(|code| !names.iter().all(|other| other.codes.contains(code))).cloned();
    let codes: Vec<String> = names.iter().map(|name| code(name).unwrap_or_default()).collect();
    let distinct = codes.iter().collect::<BTreeSet<_>>().len();
    if codes.iter().all(|code| !code.is_empty()) && distinct > 1 && 2 * distinct <= codes.len() && are_classes(&codes) {
        return (codes, Told::Names);
    }
    (vec![REFERENCE.to_string(); names.len()], Told::Nothing)
}

/// Class names that say so where each class has a single file; `good` and `ok` may be of the file itself.
const PLAIN: [&str; 6] = ["healthy", "normal", "nominal", "baseline", "sound", "undamaged"];

/// Whether these are classes: two of several files each, or one of a machine without a defect beside others.
fn are_classes(own: &[String]) -> bool {
    let mut counts: BTreeMap<&String, usize> = BTreeMap::new();
    own.iter().filter(|class| !class.is_empty()).for_each(|class| *counts.entry(class).or_default() += 1);
    let several = counts.values().filter(|count| **count > 1).count();
    let words: &[&str] = if several > 0 { &HEALTHY } else { &PLAIN };
    let is_healthy = |class: &&&String| class.split('_').any(|word| words.contains(&word));
    several > 1 || counts.len() > 1 && counts.keys().any(|class| is_healthy(&class))
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

    fn of(files: &[&str]) -> (Vec<String>, Told) {
        let files: Vec<PathBuf> = files.iter().map(PathBuf::from).collect();
        let (text, told) = labels(&files).expect("labels");
        let class = |line: &str| line.split(',').nth(1).unwrap_or_default().to_string();
        (text.lines().skip(1).map(class).collect(), told)
    }

    #[test]
    fn words_numbers_and_sets_are_told_apart() {
        let files = [
            "Normal_operation_1000.csv",
            "normal_800_1.csv",
            "normal_800_2_test.csv",
            "bad-load_800_1.csv",
            "bad-load_800_2.csv",
        ];
        let (text, told) = labels(&files.map(PathBuf::from)).expect("labels");
        let rows: Vec<&str> = text.lines().collect();
        assert_eq!(told, Told::Names);
        assert_eq!(
            rows[..3],
            ["trace,class_name,n1,n2,set", "Normal_operation_1000,normal,1000,,none", "normal_800_1,normal,800,1,none"]
        );
        assert_eq!(rows[3..5], ["normal_800_2_test,normal,800,2,test", "bad-load_800_1,bad_load,800,1,none"]);
    }

    #[test]
    fn nothing_is_called_healthy_that_no_name_calls_so() {
        assert_eq!(of(&["park_50rpm.csv", "steps_1.csv"]), (vec![REFERENCE.into(); 2], Told::Nothing));
        assert_eq!(of(&["1.csv", "2.csv", "3.csv"]), (vec![REFERENCE.into(); 3], Told::Nothing));
        assert_eq!(of(&["a.csv"]).1, Told::Nothing);
    }

    #[test]
    fn single_records_codes_and_folders_are_classes() {
        let one = of(&["healthy_0_100watt_1.csv", "inner_1.7_100watt_1.csv", "outer_0.7_100watt_1.csv"]);
        assert_eq!(one, (["healthy", "inner", "outer"].map(String::from).to_vec(), Told::Names));
        let codes = of(&["run_A1_01.csv", "run_A1_02.csv", "run_B0_01.csv", "run_B0_02.csv"]);
        assert_eq!(codes, (["a1", "a1", "b0", "b0"].map(String::from).to_vec(), Told::Names));
        let (text, told) = labels(&["d/healthy/rec1.csv", "d/outer race/rec1.csv"].map(PathBuf::from)).expect("labels");
        assert_eq!(told, Told::Folders);
        assert_eq!(text, "trace,class_name,n1,code1\nhealthy/rec1,healthy,1,rec1\nouter race/rec1,outer race,1,rec1\n");
    }
}
