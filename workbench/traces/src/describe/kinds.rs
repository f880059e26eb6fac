//! Files by their columns, and why some are left out.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::guess::Guess;
use super::proposal::Proposal;
use crate::reader;
use crate::signal::signs::{self, ByName};
use crate::table::Table;
use model::Error;
use model::session::Log;
use model::settings::Data;
use model::trace::{file_name, stem, words};

/// A file that is not described, and why.
pub(super) struct LeftOut {
    pub(super) file: PathBuf,
    pub(super) reason: String,
}

impl LeftOut {
    /// The file and the reason.
    pub(super) fn told(&self) -> String {
        format!("{}: {}", self.file.display(), self.reason)
    }
}

/// Files with the same columns of numbers.
pub(super) struct Kind {
    pub(super) names: Vec<String>,
    /// Columns that most of them do not have as numbers, and why the first one does not.
    pub(super) columns_left: Vec<String>,
    pub(super) files: Vec<PathBuf>,
    /// Those whose rows are of several traces, by a column of their names.
    pub(super) tidy: BTreeSet<PathBuf>,
    /// How columns are written whose numbers are signed ones without their sign.
    pub(super) signs: ByName,
    /// Rows of the first one.
    rows: usize,
}

/// Rows of the shortest recording; shorter tables are of something else, such as parameters.
const FEWEST: usize = 8;

/// Files with the same header.
struct Alike {
    names: Vec<String>,
    /// Rows of the first one.
    rows: usize,
    /// Each with its columns of numbers, and the problems with others.
    files: Vec<(PathBuf, Vec<String>, Vec<Error>)>,
    signs: ByName,
}

/// The kinds of files, with what was left out of each.
pub(super) fn kinds(files: &[PathBuf], data: &Data, log: &Log<'_>) -> (Vec<Kind>, Vec<LeftOut>) {
    let (mut all, mut left): (Vec<Alike>, Vec<LeftOut>) = (Vec::new(), Vec::new());
    let step = log.steps("files", files.len());
    let form = data.text_form();
    let read = |file: &PathBuf| {
        let looked = Table::open_as(file, &form).and_then(|table| {
            let (mut signs, mut rows) = (ByName::new(), None);
            let mut look = |name: &str, values: &[f64]| {
                signs.extend(signs::of_column(name, values).map(|own| (name.to_string(), own)));
                rows = rows.or_else(|| (!is_label(name)).then_some(values.len()));
            };
            let (numeric, problems) = reader::numeric_with(&table, data.time.as_deref(), &mut look)?;
            let (labels, signals): (Vec<String>, Vec<String>) = numeric.into_iter().partition(|name| is_label(name));
            let no_signal =
                |name: &String| Error::content(file, format!("column {name}"), "the class of rows, no signal");
            let problems: Vec<Error> = problems.into_iter().chain(labels.iter().map(no_signal)).collect();
            Ok((table.names().to_vec(), signals, problems, signs, rows.unwrap_or(0)))
        });
        step(1);
        looked
    };
    let looked: Vec<Result<_, Error>> = files.par_iter().map(read).collect();
    for (file, looked) in files.iter().zip(looked) {
        match looked {
            Ok((names, signals, problems, signs, rows)) => match all.iter_mut().find(|alike| alike.names == names) {
                Some(alike) => {
                    alike.files.push((file.clone(), signals, problems));
                    alike.signs.extend(signs);
                }
                None => all.push(Alike { names, rows, files: vec![(file.clone(), signals, problems)], signs }),
            },
            Err(error) => left.push(LeftOut { file: file.clone(), reason: reason(&error) }),
        }
    }
    let kinds = all.into_iter().flat_map(|alike| alike.kinds(&mut left)).collect();
    (kinds, left)
}

/// Whether a column has the class of rows as a number, by its name.
fn is_label(name: &str) -> bool {
    const WORDS: [&str; 5] = ["label", "labels", "class", "klasse", "classe"];
    words(name).iter().any(|word| WORDS.contains(&word.as_str()))
}

/// The reason of an error, without the name of the file.
fn reason(error: &Error) -> String {
    match error {
        Error::Content { place, problem, .. } => format!("{place}: {problem}"),
        other => other.to_string(),
    }
}

impl Alike {
    /// The columns that most files have as numbers; files in which one of them is unreadable are left out.
    fn kinds(self, left: &mut Vec<LeftOut>) -> Option<Kind> {
        let mut counts: BTreeMap<&String, usize> = BTreeMap::new();
        self.files.iter().flat_map(|(_, numeric, _)| numeric).for_each(|name| *counts.entry(name).or_default() += 1);
        let most = |name: &&String| counts.get(name).is_some_and(|count| 2 * count > self.files.len());
        let names: Vec<String> = self.names.iter().filter(most).cloned().collect();
        let mut files = Vec::new();
        for (file, numeric, problems) in &self.files {
            let own_names: BTreeSet<&String> = numeric.iter().collect();
            let lacks = names.iter().find(|name| !own_names.contains(name));
            let own = |name: &String| {
                let named = |problem: &&Error| problem.to_string().contains(&format!("column {name}:"));
                problems.iter().find(named).map(reason)
            };
            let first = || problems.first().map(reason);
            match lacks {
                _ if names.is_empty() => {
                    let reason = first().unwrap_or_else(|| "no column of numbers".into());
                    left.push(LeftOut { file: file.clone(), reason });
                }
                Some(name) => {
                    let reason = own(name).or_else(first).unwrap_or_else(|| format!("column {name} has no numbers"));
                    left.push(LeftOut { file: file.clone(), reason });
                }
                None => files.push(file.clone()),
            }
        }
        let is_kept = |problem: &str| names.iter().any(|name| problem.contains(&format!("column {name}:")));
        let columns_left = self.files.first().map_or(&[][..], |(_, _, problems)| problems).iter().map(reason);
        let columns_left = columns_left.filter(|problem| !is_kept(problem)).collect();
        let is_tidy = self.names.iter().any(|name| name == "trace");
        let tidy = if is_tidy { files.iter().cloned().collect() } else { BTreeSet::new() };
        (!files.is_empty()).then_some(Kind { names, columns_left, files, tidy, signs: self.signs, rows: self.rows })
    }
}

/// The kind of most files that are no short tables, with the files of others that have its channels; of equals one with
/// a current, then the first. The files of other kinds are left out.
pub(super) fn most(mut kinds: Vec<Kind>, left: &mut Vec<LeftOut>) -> Option<Kind> {
    let current = |kind: &Kind| usize::from(Guess::of(&kind.names).current.is_some());
    let most =
        (0..kinds.len()).rev().max_by_key(|&k| (kinds[k].rows >= FEWEST, kinds[k].files.len(), current(&kinds[k])))?;
    let mut own = kinds.swap_remove(most);
    for other in kinds {
        let shared: Vec<String> = own.names.iter().filter(|name| other.names.contains(name)).cloned().collect();
        if !shared.is_empty() && Proposal::of(&shared).stands_for(&Proposal::of(&own.names)) {
            own.names = shared;
            own.files.extend(other.files);
            own.tidy.extend(other.tidy);
            own.signs.extend(other.signs);
        } else {
            // Most of them may be unreadable.
            let first = other.columns_left.first().map_or_else(String::new, |problem| format!("; {problem}"));
            let reason = format!("other columns: {}{first}", other.names.join(", "));
            left.extend(other.files.into_iter().map(|file| LeftOut { file, reason: reason.clone() }));
        }
    }
    own.files.sort_unstable();
    let (mut seen, mut firsts): (Vec<PathBuf>, HashMap<_, String>) = (Vec::new(), HashMap::new());
    for file in std::mem::take(&mut own.files) {
        match firsts.get(&label_of(&file)) {
            Some(first) => left.push(LeftOut { reason: format!("the same name as {first} in another format"), file }),
            None => {
                firsts.insert(label_of(&file), file_name(&file));
                seen.push(file);
            }
        }
    }
    own.files = seen;
    Some(own)
}

/// How labels name a file: its folder, and its name without the format.
pub(super) fn label_of(file: &Path) -> (Option<PathBuf>, String) {
    (file.parent().map(Path::to_path_buf), stem(&file_name(file)).to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_bad_file_takes_nothing_from_others() {
        let folder = tempfile::tempdir().expect("a folder");
        let write = |name: &str, text: &str| {
            let path = folder.path().join(name);
            std::fs::write(&path, text).expect("writable");
            path
        };
        let good = "t_s,current_a,speed_rpm\n0,1,2\n0.1,2,3\n0.2,3,4\n";
        let files = [
            write("a.csv", good),
            write("b.csv", &good.replace("0.1,2,3", "0.1,2,nan")),
            write("bad.csv", &good.replace("2,3\n", "1e306,3\n")),
            write("c.csv", good),
            write("c.txt", good),
            write("words.csv", "a,b\nx,y\nz,w\n"),
        ];
        let log = Log::new(&model::session::Quiet);
        let (all, mut left) = kinds(&files, &Data::default(), &log);
        let own = most(all, &mut left).expect("a kind");
        assert_eq!(own.names, ["current_a", "speed_rpm"]);
        assert_eq!(own.files, [files[0].clone(), files[1].clone(), files[3].clone()]);
        let mut told: Vec<String> =
            left.iter().map(|own| format!("{}: {}", file_name(&own.file), own.reason)).collect();
        told.sort();
        assert!(told[0].starts_with("bad.csv: line 3, column current_a: 1e306 is no measured value"), "{told:?}");
        assert_eq!(told[1], "c.txt: the same name as c.csv in another format");
        assert!(told[2].starts_with("words.csv: line 2, column a: \"x\" is not a number"), "{told:?}");
    }

    #[test]
    fn columns_of_classes_are_no_signals_and_are_named() {
        let folder = tempfile::tempdir().expect("a folder");
        for (name, of_class) in [("a.csv", "label"), ("b.csv", "fault_class"), ("c.csv", "Klasse")] {
            let file = folder.path().join(name);
            std::fs::write(&file, format!("t_s,current_a,{of_class}\n0,1,2\n0.1,2,2\n0.2,3,2\n")).expect("writable");
            let (all, mut left) = kinds(&[file], &Data::default(), &Log::new(&model::session::Quiet));
            let own = most(all, &mut left).expect("a kind");
            assert_eq!(own.names, ["current_a"]);
            assert_eq!(own.columns_left, [format!("column {of_class}: the class of rows, no signal")]);
        }
        assert!(!is_label("classic_speed") && !is_label("velocity"));
    }

    #[test]
    fn tables_of_parameters_are_no_recordings_however_many_there_are() {
        let folder = tempfile::tempdir().expect("a folder");
        let write = |name: &str, text: String| {
            let path = folder.path().join(name);
            std::fs::write(&path, text).expect("writable");
            path
        };
        let rows: String = (0..20).map(|k| format!("{k},{},{}\n", 2 * k, k % 3)).collect();
        let tables = ["parameter,value\nr_ohm,0.5\nl_h,0.001\n", "gain,offset\n1.5,0.2\n", "id;mass_kg\n7;1.25\n"];
        for table in tables {
            let files = ["a.csv", "b.csv", "c.csv"].map(|name| write(name, table.into()));
            let record = write("z.csv", format!("t_s,current_a,speed_rpm\n{rows}"));
            let all: Vec<PathBuf> = files.into_iter().chain([record.clone()]).collect();
            let (all, mut left) = kinds(&all, &Data::default(), &Log::new(&model::session::Quiet));
            assert_eq!(most(all, &mut left).expect("a kind").files, [record], "{table}");
            assert_eq!(left.len(), 3, "{table}");
        }
    }
}
