//! The files that may have traces: those that are given, and those of known formats in folders and below.
//!
//! Every command takes this list. What is no recording is left out and named: hidden files, folders of results, labels,
//! and features ([`walk`]).

pub(crate) mod labels;
pub(crate) mod naming;
pub mod walk;

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use crate::front_end::cleaned;
use crate::reader::{self, names_of_rows};
use crate::table::Table;
use labels::has_labels;
use model::Error;
use model::trace::{Channels, TextForm, Trace, TraceNames, file_name, is_known, stem, trace_name};
use naming::Naming;
use walk::{Walk, reason_to_skip};

/// Files that are named in a line.
const NAMED: usize = 5;
/// What becomes of records without a label.
pub(crate) const LEFT_OUT: &str = "left out";
/// Why files of folders are left out.
pub(crate) const LACKING: &str = "without the columns of the channels";

/// Extensions of files that may be recordings, but are of no format that is read: measuring systems, drives and logs.
const UNREAD: [&str; 25] = [
    "wav", "flac", "mf4", "mdf", "tdms", "tdm", "dxd", "d7d", "uff", "unv", "xls", "xlsx", "ods", "sqlite", "db",
    "bag", "mcap", "ulg", "ulog", "blf", "dcexp", "jsonl", "ndjson", "trc", "rec",
];

/// Whether a file may be a recording of a format that is not read.
fn is_foreign(file: &Path) -> bool {
    let extension = file.extension().map(|own| own.to_string_lossy().to_lowercase());
    extension.is_some_and(|own| UNREAD.contains(&own.as_str()))
}

/// A file that may have traces.
#[derive(Debug)]
pub struct Candidate {
    /// The file.
    pub file: PathBuf,
    /// Whether it was found in a folder, where files without the columns have no traces.
    of_folder: bool,
    /// The name of its trace, with the extension of the file.
    name: String,
    /// Whether labels give this name.
    labelled: bool,
}

/// The files that may have traces, and what is left out.
#[derive(Debug, Default)]
pub struct Listing {
    /// The files.
    pub candidates: Vec<Candidate>,
    /// What is left out, in lines.
    pub left_out: Vec<String>,
}

impl Listing {
    /// The files in these paths, with names that labels give, or that tell them apart.
    ///
    /// # Errors
    /// A folder that cannot be read.
    pub fn of(paths: &[PathBuf], names: Option<&TraceNames>) -> Result<Self, Error> {
        let (mut files, mut left_out) = (Vec::new(), Vec::new());
        let given: HashSet<PathBuf> = paths.iter().map(|path| whole(path)).collect();
        let mut seen = HashSet::new();
        for path in paths {
            if !path.is_dir() {
                files.push((path.clone(), false));
                continue;
            }
            let takes = |file: &Path| is_known(file) || is_foreign(file);
            let mut walked = Walk { links: true, takes: &takes, skips: &reason_to_skip }.of(path)?;
            left_out.extend(walked.skipped.iter().map(ToString::to_string));
            let unread: Vec<PathBuf> = walked.files.extract_if(.., |file| !is_known(file)).collect();
            left_out.extend(without(unread.iter(), "of a format that is not read; save it as CSV, MATLAB or Parquet"));
            // A folder may be given beside one that it is in.
            let new = walked.files.into_iter().filter(|file| !given.contains(&whole(file)) && seen.insert(whole(file)));
            let (own, labels): (Vec<PathBuf>, Vec<PathBuf>) =
                new.partition(|file| is_trace(file) || crate::table::is_unread(file));
            let (features, own): (Vec<PathBuf>, Vec<PathBuf>) = own.into_iter().partition(|file| is_part(file));
            let below: Vec<&PathBuf> = labels.iter().filter(|file| file.parent() != Some(path)).collect();
            left_out.extend(without(below.into_iter(), "labels, no recording"));
            left_out.extend(without(features.iter(), "features, no recording"));
            files.extend(own.into_iter().map(|file| (file, true)));
        }
        let all: Vec<PathBuf> = files.iter().map(|(file, _)| file.clone()).collect();
        let naming = Naming::of(paths, &all);
        let named = match names {
            Some(names) => naming.labelled(&all, names),
            None => all.iter().map(|file| (naming.name(file), false)).collect(),
        };
        let candidates = files.into_iter().zip(named);
        let candidates = candidates
            .map(|((file, of_folder), (name, labelled))| Candidate { file, of_folder, name, labelled })
            .collect();
        Ok(Self { candidates, left_out })
    }

    /// The same without files of labels, which may have any name.
    ///
    /// # Errors
    /// A folder that cannot be read.
    pub fn without_labels(paths: &[PathBuf], names: Option<&TraceNames>) -> Result<Self, Error> {
        let Self { candidates, mut left_out } = Self::of(paths, names)?;
        let are_labels: Vec<bool> = candidates.par_iter().map(|own| own.of_folder && has_labels(&own.file)).collect();
        let (labels, candidates): (Vec<_>, Vec<_>) = candidates.into_iter().zip(are_labels).partition(|(_, are)| *are);
        let [labels, candidates] =
            [labels, candidates].map(|all| all.into_iter().map(|(file, _)| file).collect::<Vec<_>>());
        left_out.extend(without(labels.iter().map(|own| &own.file), "labels, no recording"));
        Ok(Self { candidates, left_out })
    }

    /// The files.
    #[must_use]
    pub fn files(&self) -> Vec<PathBuf> {
        self.candidates.iter().map(|own| own.file.clone()).collect()
    }

    /// What is left out of labelled traces, in lines: files without the channels, and records without a label.
    pub(crate) fn beside_labels(&self, channels: &Channels, names: &TraceNames) -> Vec<String> {
        let (mut records, mut others, mut bad) = (Vec::new(), Vec::new(), Vec::new());
        for own in self.candidates.iter().filter(|own| !own.labelled) {
            match own.open(&channels.text) {
                Ok(table) if has_columns(&table, channels) => records.extend(unlabelled(&table, names)),
                _ if has_labels(&own.file) => {}
                Ok(_) => others.push(&own.file),
                Err(_) => bad.push(&own.file),
            }
        }
        let further = [
            without(others.into_iter(), LACKING),
            without(bad.into_iter(), "cannot be read, and no label names them"),
            told_unlabelled(&records, LEFT_OUT),
        ];
        self.left_out.iter().cloned().chain(further.into_iter().flatten()).collect()
    }
}

/// Says how many records have no label, and what becomes of them.
pub(crate) fn told_unlabelled(names: &[String], then: &str) -> Option<String> {
    let all = some(names.iter().cloned());
    Some(match names.len() {
        0 => return None,
        1 => format!("1 record has no label: {all}; it is {then}"),
        count => format!("{count} records have no label: {all}; they are {then}"),
    })
}

/// The names of the traces of a table that labels do not give.
pub(crate) fn unlabelled(table: &Table, names: &TraceNames) -> Vec<String> {
    let mut all = names_of_rows(table).unwrap_or_else(|| vec![table.id()]);
    let mut seen = HashSet::new();
    all.retain(|name| !names.has(&trace_name(name)) && seen.insert(name.clone()));
    all
}

/// Says which files are left out, and why; nothing of none.
pub(crate) fn without<'a>(files: impl Iterator<Item = &'a PathBuf>, why: &str) -> Option<String> {
    let names: Vec<String> = files.map(|file| file.display().to_string()).collect();
    let count = if names.len() == 1 { "1 file".to_string() } else { format!("{} files", names.len()) };
    (!names.is_empty()).then(|| format!("left out {count}: {}: {why}", some(names.into_iter())))
}

/// The first of some names, and how many more there are.
fn some(names: impl ExactSizeIterator<Item = String>) -> String {
    let more = names.len().saturating_sub(NAMED);
    let first = names.take(NAMED).collect::<Vec<_>>().join(", ");
    if more > 0 { format!("{first} and {more} more") } else { first }
}

fn whole(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf())
}

/// Whether a file is a trace by its name alone: of a known format, and not called labels.
#[must_use]
pub fn is_trace(file: &Path) -> bool {
    is_known(file) && !stem(&file_name(file)).eq_ignore_ascii_case("labels")
}

/// Whether a file has features: their plan is beside it.
fn is_part(file: &Path) -> bool {
    file.extension().is_some_and(|end| end == "parquet") && file.with_extension("plan.json").is_file()
}

impl Candidate {
    /// A file that was given.
    #[must_use]
    pub fn given(file: &Path) -> Self {
        Self { file: file.into(), of_folder: false, name: file_name(file), labelled: false }
    }

    /// The name of its trace as names are compared.
    #[must_use]
    pub fn id(&self) -> String {
        trace_name(&self.name).into_owned()
    }

    /// Whether labels give its name.
    #[must_use]
    pub const fn is_labelled(&self) -> bool {
        self.labelled
    }

    /// Whether it was found in a folder.
    #[must_use]
    pub const fn is_of_folder(&self) -> bool {
        self.of_folder
    }

    /// Opens the file; its only trace has the name.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn open(&self, form: &TextForm) -> Result<Table, Error> {
        Ok(Table::open_as(&self.file, form)?.called(self.name.clone()))
    }

    /// Reads the wanted traces; `None` of a file in a folder that lacks the columns, unless a trace of its name is
    /// wanted.
    ///
    /// # Errors
    /// A file or columns that cannot be read.
    pub fn read(
        &self,
        channels: &Channels,
        wanted: Option<&(dyn Fn(&str) -> bool + Sync)>,
    ) -> Result<Option<Vec<Trace>>, Error> {
        let may_lack = self.of_folder && !wanted.is_some_and(|wanted| wanted(&self.id()));
        let table = match self.open(&channels.text) {
            Err(_) if may_lack => return Ok(None),
            table => table?,
        };
        if may_lack && !has_columns(&table, channels) {
            log::info!("left out {}: it lacks columns of the channels", self.file.display());
            return Ok(None);
        }
        read_table(&table, channels, wanted.unwrap_or(&|_| true)).map(Some)
    }
}

/// Reads the wanted traces of one table.
pub(crate) fn read_table(
    table: &Table,
    channels: &Channels,
    wanted: &(dyn Fn(&str) -> bool + Sync),
) -> Result<Vec<Trace>, Error> {
    match &channels.front_end {
        Some(front_end) => cleaned::read(table, channels, front_end, wanted),
        None => reader::read(table, channels, wanted),
    }
}

/// Whether a table has the columns of channels.
pub(crate) fn has_columns(table: &Table, channels: &Channels) -> bool {
    match &channels.front_end {
        Some(front_end) => cleaned::has_columns(table, channels, front_end),
        None => reader::has_columns(table, channels),
    }
}
