//! Labels from the names of files and folders.
//!
//! ```text
//! unbalanced_800_3_test.csv                      class unbalanced, n1 800, n2 3, set test
//! gesund_Lauf01_1.csv                            class gesund, run Lauf01, n1 01, n2 1
//! outer/rec1.csv, healthy/rec1.csv               classes outer, healthy; run rec1
//! class=healthy/run=3/load=2/a.csv               class healthy, run 3, load 2
//! axis1/ok_1.csv, J2_ok_1.csv                    classes ok, axis axis1 and J2, if there are several
//! ```
//!
//! Folders `class=…` say the class, and other keys are columns. Otherwise files in several folders have the names of
//! these as their classes, unless only their own names have words of health or damage; a folder of a run is none.
//! Otherwise the words of a name are its class, in lower case, without those that all files have and those that only
//! some files of a class have (normal_operation_1, normal_2). Where all words are the same, codes such as A1 and B0 are
//! the classes. If these are the same too, the classes are unknown: all files get the class [`REFERENCE`], which does
//! not say that the machine is healthy.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

pub(super) use super::words::is_healthy;
use super::words::{is_clearly_healthy, is_damaged, is_run_key, motor_of, plain, runs_of, tells_class};
use crate::listing::naming::Naming;
use crate::listing::walk::key_of;
use model::Error;
use model::outputs::cell;
use model::trace::{composed, file_name, stem, trace_name};

/// Words that say what a file is for, not what it shows.
const SETS: [&str; 5] = ["test", "train", "training", "validation", "log"];
/// The class of files whose classes cannot be told.
pub(super) const REFERENCE: &str = "reference";
/// Class names of machines without a defect that are taken before others.
pub(super) const HEALTHY: [&str; 8] = ["healthy", "normal", "good", "ok", "nominal", "baseline", "sound", "undamaged"];
/// Keys of folders that say the class.
const CLASS_KEYS: [&str; 10] =
    ["class_name", "class", "label", "fault", "condition", "state", "health", "defect", "klasse", "zustand"];
/// Columns of labels whose names no key of a folder can have.
const RESERVED: [&str; 5] = ["trace", "class_name", "run", "set", AXIS];
/// The column of the motors of one machine.
pub(super) const AXIS: &str = "axis";

/// One file: its name, and the parts of the name.
struct Name {
    /// As labels name it.
    trace: String,
    /// Its folders that are neither runs nor keys.
    folders: Vec<String>,
    /// Keys and values of its folders.
    keys: Vec<(String, String)>,
    /// Its runs, the outermost first.
    runs: Vec<String>,
    /// Number of these that are folders.
    folder_runs: usize,
    /// The name of the file without its runs, in lower case.
    rest: String,
    words: Vec<String>,
    /// Parts of letters and digits, such as A1 and 100watt.
    codes: Vec<String>,
    numbers: Vec<String>,
    set: String,
}

/// How the files of a folder are named.
#[derive(Clone, Copy)]
struct Style {
    /// Whether a word of a test begins a run.
    is_test_a_run: bool,
    /// Whether files are of several motors.
    has_axes: bool,
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
    fn of(path: &Path, naming: &Naming, Style { is_test_a_run, has_axes }: Style) -> Self {
        let name = file_name(path);
        let whole = stem(&composed(&name)).to_string();
        let (mut folders, mut keys, mut runs) = (Vec::new(), Vec::new(), Vec::new());
        let without = |text: &str| match motor_of(text) {
            Some((_, rest)) if has_axes => rest,
            _ => text.to_string(),
        };
        let is_left = |folder: &String| !has_axes || folder.contains(char::is_alphanumeric);
        for folder in naming.folders(path).iter().map(|folder| without(folder)).filter(is_left) {
            let (of_folder, rest) = runs_of(&folder, true);
            let is_run = !of_folder.is_empty() && !rest.contains(char::is_alphanumeric);
            match key_of(&folder) {
                Some((key, run)) if is_run_key(&key) => runs.extend((!run.is_empty()).then_some(run)),
                Some(pair) => keys.push(pair),
                None if is_run => runs.push(folder),
                None => folders.push(folder),
            }
        }
        let (own_runs, rest) = runs_of(&without(&whole), is_test_a_run);
        let folder_runs = runs.len();
        runs.extend(own_runs);
        let (lower, rest) = (whole.to_lowercase(), plain(&rest));
        let all = rest.split(|c: char| !c.is_alphabetic()).filter(|word| word.chars().count() > 1);
        let parts = rest.split(|c: char| !c.is_alphanumeric()).filter(|part| !part.is_empty());
        let is_code = |part: &&str| part.contains(char::is_alphabetic) && part.contains(|c: char| c.is_ascii_digit());
        let codes: Vec<String> = parts.filter(is_code).map(String::from).collect();
        let (set, words): (Vec<&str>, Vec<&str>) = all.partition(|word| SETS.contains(word));
        let numbers = lower.split(|c: char| !c.is_ascii_digit()).filter(|part| !part.is_empty());
        Self {
            words: words.into_iter().map(String::from).collect(),
            codes,
            numbers: numbers.map(String::from).collect(),
            set: set.first().map_or_else(String::new, ToString::to_string),
            trace: trace_name(&naming.name(path)).into_owned(),
            folders,
            keys,
            runs,
            folder_runs,
            rest,
        }
    }

    fn class(&self, left_out: &BTreeSet<String>) -> String {
        let words: Vec<&str> = self.words.iter().map(String::as_str).filter(|word| !left_out.contains(*word)).collect();
        words.join("_")
    }

    /// The class by the key of a folder.
    fn keyed_class(&self) -> Option<&str> {
        let of = |wanted: &&str| self.keys.iter().find(|(key, _)| key.to_lowercase() == **wanted);
        CLASS_KEYS.iter().find_map(of).map(|(_, value)| value.as_str()).filter(|value| !value.is_empty())
    }

    /// The value of a key of a folder.
    fn value(&self, key: &str) -> String {
        let own = self.keys.iter().find(|(own, _)| own == key);
        own.map_or_else(String::new, |(_, value)| value.clone())
    }
}

/// The labels as CSV, and how classes were told.
pub(super) fn labels(files: &[PathBuf], naming: &Naming) -> Result<(String, Told), Error> {
    // Where some files are of the training, those of a test are no runs.
    let is_of_set = |file: &PathBuf| {
        let lower = file_name(file).to_lowercase();
        lower.split(|c: char| !c.is_alphabetic()).any(|word| word != "test" && SETS.contains(&word))
    };
    let axes: Vec<Option<String>> = files.iter().map(|file| axis_of(file, naming)).collect();
    let has_axes = axes.iter().flatten().collect::<BTreeSet<_>>().len() > 1;
    let style = Style { is_test_a_run: !files.iter().any(is_of_set), has_axes };
    let names: Vec<Name> = files.iter().map(|file| Name::of(file, naming, style)).collect();
    let (classes, told) = classes(&names);
    let mut columns = vec![("trace".to_string(), names.iter().map(|name| name.trace.clone()).collect())];
    let folders = further_folders(&names, &classes);
    let runs = runs(&names, &classes);
    columns.push(("class_name".into(), classes));
    columns.extend(runs.map(|runs| ("run".into(), runs)));
    if has_axes {
        columns.push((AXIS.into(), axes.into_iter().map(|axis| axis.unwrap_or_else(|| "none".into())).collect()));
    }
    columns.extend(keyed(&names).into_iter().chain(folders));
    columns.extend(numbered("n", &names, |name| &name.numbers));
    columns.extend(numbered("code", &names, |name| &name.codes));
    if names.iter().any(|name| !name.set.is_empty()) {
        let set = |name: &Name| if name.set.is_empty() { "none".to_string() } else { name.set.clone() };
        columns.push(("set".into(), names.iter().map(set).collect()));
    }
    Ok((csv_of(&columns)?, told))
}

/// The motor that a file is of: by its name, or by the innermost folder.
fn axis_of(path: &Path, naming: &Naming) -> Option<String> {
    let own = motor_of(stem(&composed(&file_name(path))));
    let of_folder = || naming.folders(path).iter().rev().find_map(|folder| motor_of(folder));
    own.or_else(of_folder).map(|(motor, _)| motor)
}

/// A column and its cells.
type Column = (String, Vec<String>);

/// The run of each file, if names tell runs: of several in one name the outermost one that is not that of all files. A
/// file without one is a run of its own. Where files of one class in several folders have the same, the folders are in
/// it: numbers start again in each.
fn runs(names: &[Name], classes: &[String]) -> Option<Vec<String>> {
    let most = names.iter().map(|name| name.runs.len()).max().filter(|most| *most > 0)?;
    let of = |k: usize| names.iter().map(|name| name.runs.get(k)).collect::<BTreeSet<_>>();
    let level = (0..most).find(|k| of(*k).len() > 1).unwrap_or(0);
    let run = |name: &Name| name.runs.get(level).or(name.runs.last()).unwrap_or(&name.trace).clone();
    let all: Vec<String> = names.iter().map(run).collect();
    let is_own = |name: &Name| level >= name.folder_runs && !name.runs.is_empty();
    let mut seen: BTreeMap<(&String, &String), &Vec<String>> = BTreeMap::new();
    let mut starts_again = false;
    for ((name, run), class) in names.iter().zip(&all).zip(classes).filter(|((name, _), _)| is_own(name)) {
        starts_again |= *seen.entry((class, run)).or_insert(&name.folders) != &name.folders;
    }
    let whole = |(name, run): (&Name, &String)| match starts_again && is_own(name) && !name.folders.is_empty() {
        true => format!("{}/{run}", name.folders.join("/")),
        false => run.clone(),
    };
    Some(names.iter().zip(&all).map(whole).collect())
}

/// A column for each level of folders in which files differ and that is not their class.
fn further_folders(names: &[Name], classes: &[String]) -> Vec<Column> {
    let depth = names.iter().map(|name| name.folders.len()).max().unwrap_or(0);
    let level = |k: usize| -> Vec<String> {
        names.iter().map(|name| name.folders.get(k).cloned().unwrap_or_default()).collect()
    };
    let is_class = |cells: &Vec<String>| {
        let mut pairs = cells.iter().zip(classes);
        pairs.all(|(cell, class)| cell.is_empty() || class.split('/').any(|part| part == cell))
    };
    let differs = |cells: &Vec<String>| cells.iter().any(|cell| *cell != cells[0]);
    let all = (0..depth).map(|k| (format!("folder{}", k + 1), level(k)));
    all.filter(|(_, cells)| differs(cells) && !is_class(cells)).collect()
}

/// A column for each key of folders that is neither the class nor a run.
fn keyed(names: &[Name]) -> Vec<Column> {
    let is_column = |key: &&String| !CLASS_KEYS.contains(&key.to_lowercase().as_str());
    let keys: BTreeSet<&String> =
        names.iter().flat_map(|name| &name.keys).map(|(key, _)| key).filter(is_column).collect();
    let title = |key: &str| if RESERVED.contains(&key) { format!("{key}_key") } else { key.to_string() };
    keys.into_iter().map(|key| (title(key), names.iter().map(|name| name.value(key)).collect())).collect()
}

/// Columns of the parts of names.
fn numbered(title: &str, names: &[Name], parts: fn(&Name) -> &Vec<String>) -> Vec<Column> {
    let count = names.iter().map(|name| parts(name).len()).max().unwrap_or(0);
    let cells = |k: usize| names.iter().map(|name| parts(name).get(k).cloned().unwrap_or_default()).collect();
    (0..count).map(|k| (format!("{title}{}", k + 1), cells(k))).collect()
}

/// The class of each file.
fn classes(names: &[Name]) -> (Vec<String>, Told) {
    let (by_name, told) = classes_by_name(names);
    let by_folder = classes_by_folder(names, told);
    // A file beside the folders may have the name of one of them as a word.
    let known: BTreeSet<&String> = by_folder.iter().flatten().flatten().collect();
    let or_name = |class: Option<&str>, k: usize| {
        let of_folder =
            || known.iter().find(|class| names[k].words.contains(&class.to_lowercase())).map(|own| (*own).clone());
        let of_name = || (told == Told::Names).then(|| by_name[k].clone());
        class.map(String::from).or_else(of_folder).or_else(of_name).unwrap_or_else(|| UNNAMED.into())
    };
    if names.iter().any(|name| name.keyed_class().is_some()) {
        return (names.iter().enumerate().map(|(k, name)| or_name(name.keyed_class(), k)).collect(), Told::Folders);
    }
    match &by_folder {
        Some(all) => (all.iter().enumerate().map(|(k, class)| or_name(class.as_deref(), k)).collect(), Told::Folders),
        None => (by_name, told),
    }
}

/// The class of a file in the folder of files whose classes are known.
const UNNAMED: &str = "unnamed";

/// The folder that is the class of each file, if folders tell classes: that with words of health or damage, or else all
/// in which files differ.
fn classes_by_folder(names: &[Name], by_name: Told) -> Option<Vec<Option<String>>> {
    let depth = names.iter().map(|name| name.folders.len()).max().unwrap_or(0);
    let at = |k: usize| names.iter().map(move |name| name.folders.get(k));
    let telling = |k: &usize| at(*k).flatten().filter(|folder| tells_class(folder)).count();
    let told = (0..depth).filter(|k| telling(k) > 0).max_by_key(|k| (telling(k), usize::MAX - k));
    if let Some(level) = told {
        return Some(at(level).map(|folder| folder.cloned()).collect());
    }
    let differ: Vec<usize> = (0..depth).filter(|k| at(*k).collect::<BTreeSet<_>>().len() > 1).collect();
    let is_told_by_name = by_name == Told::Names && names.iter().all(|name| tells_class(&name.rest));
    if differ.is_empty() || is_told_by_name {
        return None;
    }
    let class = |name: &Name| {
        let parts: Vec<&str> = differ.iter().filter_map(|k| name.folders.get(*k)).map(String::as_str).collect();
        (!parts.is_empty()).then(|| parts.join("/"))
    };
    Some(names.iter().map(class).collect())
}

/// The class of each file by its own name.
fn classes_by_name(names: &[Name]) -> (Vec<String>, Told) {
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
    let named: Vec<String> = own.iter().map(|own| if own.is_empty() { UNNAMED.into() } else { own.clone() }).collect();
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

/// Whether these are classes: two of several files each, one of a machine without a defect or of a defect beside
/// others, or one such of all files.
fn are_classes(own: &[String]) -> bool {
    let mut counts: BTreeMap<&String, usize> = BTreeMap::new();
    own.iter().filter(|class| !class.is_empty()).for_each(|class| *counts.entry(class).or_default() += 1);
    let several = counts.values().filter(|count| **count > 1).count();
    let is_whole = own.iter().all(|class| !class.is_empty());
    let tells = |class: &&String| {
        let is_healthy = if several > 0 { is_healthy(class) } else { is_clearly_healthy(class) };
        is_healthy || is_damaged(class)
    };
    several > 1 || (counts.len() > 1 || is_whole) && counts.keys().any(tells)
}

/// The columns as CSV, quoted if needed.
fn csv_of(columns: &[Column]) -> Result<String, Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(columns.iter().map(|(title, _)| cell(title).into_owned())).map_err(Error::other)?;
    let rows = columns.first().map_or(0, |(_, cells)| cells.len());
    for row in 0..rows {
        let cells = columns.iter().map(|(_, cells)| cell(&cells[row]).into_owned());
        writer.write_record(cells).map_err(Error::other)?;
    }
    let bytes = writer.into_inner().map_err(|error| Error::Usage(error.to_string()))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

#[cfg(test)]
mod tests;
