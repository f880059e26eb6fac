//! Labels from the names of files and folders.
//!
//! ```text
//! unbalanced_800_3_test.csv                      class unbalanced, n1 800, n2 3, set test
//! gesund_Lauf01_1.csv                            class gesund, run Lauf01, n1 01, n2 1
//! outer/rec1.csv, healthy/rec1.csv               classes outer, healthy; run rec1
//! class=healthy/run=3/load=2/a.csv               class healthy, run 3, load 2
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
use super::words::{is_clearly_healthy, is_damaged, is_run_key, plain, runs_of, tells_class};
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
const RESERVED: [&str; 4] = ["trace", "class_name", "run", "set"];

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
    fn of(path: &Path, naming: &Naming, is_test_a_run: bool) -> Self {
        let name = file_name(path);
        let whole = stem(&composed(&name)).to_string();
        let (mut folders, mut keys, mut runs) = (Vec::new(), Vec::new(), Vec::new());
        for folder in naming.folders(path) {
            let (of_folder, rest) = runs_of(&folder, true);
            let is_run = !of_folder.is_empty() && !rest.contains(char::is_alphanumeric);
            match key_of(&folder) {
                Some((key, run)) if is_run_key(&key) => runs.extend((!run.is_empty()).then_some(run)),
                Some(pair) => keys.push(pair),
                None if is_run => runs.push(folder),
                None => folders.push(folder),
            }
        }
        let (own_runs, rest) = runs_of(&whole, is_test_a_run);
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
    let is_test_a_run = !files.iter().any(is_of_set);
    let names: Vec<Name> = files.iter().map(|file| Name::of(file, naming, is_test_a_run)).collect();
    let (classes, told) = classes(&names);
    let mut columns = vec![("trace".to_string(), names.iter().map(|name| name.trace.clone()).collect())];
    let folders = further_folders(&names, &classes);
    let runs = runs(&names, &classes);
    columns.push(("class_name".into(), classes));
    columns.extend(runs.map(|runs| ("run".into(), runs)));
    columns.extend(keyed(&names).into_iter().chain(folders));
    columns.extend(numbered("n", &names, |name| &name.numbers));
    columns.extend(numbered("code", &names, |name| &name.codes));
    if names.iter().any(|name| !name.set.is_empty()) {
        let set = |name: &Name| if name.set.is_empty() { "none".to_string() } else { name.set.clone() };
        columns.push(("set".into(), names.iter().map(set).collect()));
    }
    Ok((csv_of(&columns)?, told))
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
mod tests {
    use super::*;

    fn written(files: &[&str]) -> (String, Told) {
        let files: Vec<PathBuf> = files.iter().map(PathBuf::from).collect();
        labels(&files, &Naming::of(&files, &files)).expect("labels")
    }

    fn of(files: &[&str]) -> (Vec<String>, Told) {
        let (text, told) = written(files);
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
        let (text, told) = written(&files);
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
        let (text, told) = written(&["d/healthy/rec1.csv", "d/outer race/rec1.csv"]);
        assert_eq!(told, Told::Folders);
        assert_eq!(text, "trace,class_name,run,n1\nhealthy/rec1,healthy,rec1,1\nouter race/rec1,outer race,rec1,1\n");
    }

    #[test]
    fn runs_are_told_apart_from_classes() {
        let (text, told) = written(&["gesund_Lauf01_1.csv", "gesund_Lauf01_2.csv", "gesund_Lauf02_1.csv"]);
        assert_eq!(told, Told::Names);
        assert_eq!(
            text,
            "trace,class_name,run,n1,n2\ngesund_Lauf01_1,gesund,Lauf01,01,1\ngesund_Lauf01_2,gesund,Lauf01,01,2\n\
             gesund_Lauf02_1,gesund,Lauf02,02,1\n"
        );
        let (text, _) = written(&["Schaden-Messung 7-a1.csv", "i.O.-Messung 8-a1.csv", "i.O.-Messung 9-a1.csv"]);
        let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
        assert_eq!((rows[0][2], rows[1][1], rows[1][2]), ("run", "schaden", "Messung 7"));
        let signs = written(&["正常_測定1.csv", "正常_測定2.csv", "異常_測定1.csv"]).0;
        assert!(signs.contains("正常_測定1,正常,測定1,") && signs.contains("異常_測定1,異常,測定1,"), "{signs}");
        // Sets are no runs; and runs without words of classes say no class.
        let sets = written(&["ok_train_1.csv", "ok_test_1.csv", "bad_train_1.csv", "bad_test_1.csv"]).0;
        assert!(sets.starts_with("trace,class_name,n1,set\nok_train_1,ok,1,train\n"), "{sets}");
        assert_eq!(of(&["run_1.csv", "run_2.csv", "run_3.csv"]), (vec![REFERENCE.into(); 3], Told::Nothing));
    }

    #[test]
    fn folders_of_keys_runs_and_conditions_are_told_apart() {
        let (text, told) = written(&[
            "d/class=healthy/run=1/load=2/a.csv",
            "d/class=healthy/run=1/load=3/a.csv",
            "d/class=outer%20race/run=2/load=2/a.csv",
        ]);
        assert_eq!(told, Told::Folders);
        let cells: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').skip(1).collect()).collect();
        assert_eq!(
            cells,
            [["class_name", "run", "load"], ["healthy", "1", "2"], ["healthy", "1", "3"], ["outer race", "2", "2"]]
        );
        // The level with words of health is the class, whatever is around it.
        let around = of(&["d/m1/healthy/800rpm/a.csv", "d/m1/worn/800rpm/a.csv", "d/m2/worn/900rpm/a.csv"]);
        assert_eq!(around, (["healthy", "worn", "worn"].map(String::from).to_vec(), Told::Folders));
        // Numbers of recordings start again in each folder, and the machines are a column.
        let (text, _) = written(&["d/m1/ok/rec1.csv", "d/m1/worn/rec1.csv", "d/m2/ok/rec1.csv", "d/m2/worn/rec1.csv"]);
        assert!(text.starts_with("trace,class_name,run,folder1,n1\nm1/ok/rec1,ok,m1/ok/rec1,m1,1\n"), "{text}");
        // Runs are no classes: those are in the names.
        let (text, told) = written(&["d/run_1/gut_a.csv", "d/run_2/gut_b.csv", "d/run_2/nio_a.csv"]);
        assert_eq!(told, Told::Names);
        assert!(text.contains("gut_a,gut,run_1") && text.contains("nio_a,nio,run_2"), "{text}");
        let (_, told) = written(&["d/class_a/healthy_mix_1_000.csv", "d/class_a/run_1/healthy_mix_1_001.csv"]);
        assert_eq!(told, Told::Names);
        // Beside folders a file says its class itself, or has none.
        let (all, _) = of(&["d/healthy_3.csv", "d/7.csv", "d/outer/1.csv", "d/outer/2.csv"]);
        assert_eq!((all[1].as_str(), all[2].as_str()), (UNNAMED, "outer"));
        assert_eq!(of(&["d/sound_3.csv", "d/Sound/1.csv", "d/outer/2.csv"]).0[0], "Sound");
    }
}
