//! Reads recorded signals from files: tables of columns enter, traces in SI units leave.
//!
//! ```text
//! .csv .mat .parquet .arrow .npz, or a table in memory ─► table: named columns ─┬─► reader ───────────► traces
//!                                                                               └─► front_end: clean ─┘
//! ```
//!
//! A trace is one recording: current, velocity, load and further channels of one length, at one sampling interval. A
//! recording at the control rate (phase currents, counts of the position sensor) passes the front end of the firmware
//! first. [`read`] and [`Source`] read traces; the other modules are its steps.
//!
//! | module | content |
//! |---|---|
//! | [`table`] | named columns of a file of any format, or in memory |
//! | [`reader`] | columns → traces: one file a trace, or a table with a column of their names |
//! | `table_header` | which columns are the time, the traces and signals |
//! | `changes` | logs of changes: the last value is held |
//! | `row_times` | columns → the time of each row |
//! | `assemble` | rows → samples: what is missing is NaN |
//! | [`front_end`] | recordings at the control rate → clean samples |
//! | [`units`] | units, by the names of columns |
//! | `temperature` | temperatures, by the names of columns |
//! | [`resample`] | irregular times → a constant rate |
//! | [`given`] | labels, front end and traces that settings name |
//! | [`audit`] | what recordings are worth |
//! | [`describe`] | recordings → the text of a drive file |
//! | [`damaged`] | damaged files, at which readers of other crates panic |

mod assemble;
pub mod audit;
mod changes;
mod cleaned_reader;
pub mod damaged;
pub mod describe;
pub mod front_end;
pub mod given;
mod labels;
pub mod reader;
pub mod resample;
mod row_times;
mod signal;
pub mod table;
mod table_header;
mod temperature;
mod time;
pub mod units;

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rayon::prelude::*;

use model::Error;

pub use labels::read_labels;
use model::trace::{Channels, Recorded, Trace, is_known, stem};
pub use table::LARGEST;
use table::Table;

/// Reads every trace of the given files and folders.
///
/// In a folder, the files of known formats with the wanted columns are read (others, for example labels or parameter
/// tables, are skipped); a file given directly must have the columns.
///
/// # Errors
/// Unreadable files; missing columns; ragged rows; cells that are neither numbers nor missing; a channel without a
/// number; an id that occurs twice; no trace.
pub fn read(paths: &[PathBuf], channels: &Channels) -> Result<Vec<Trace>, Error> {
    read_files(paths, channels, None)
}

/// Where traces come from.
#[derive(Clone, Debug)]
pub enum Source {
    /// Files, and folders of files.
    Files(Vec<PathBuf>),
    /// Tables in memory.
    Memory(Vec<Arc<Recorded>>),
}

impl Source {
    /// The files and folders; none of tables in memory.
    #[must_use]
    pub fn paths(&self) -> &[PathBuf] {
        match self {
            Self::Files(paths) => paths,
            Self::Memory(_) => &[],
        }
    }

    /// Reads only the traces for whose id (without the extension of its format) `wanted` is true; others are skipped
    /// and not checked. A wanted trace must have the columns.
    ///
    /// # Errors
    /// The errors of [`read`].
    pub fn read_wanted(
        &self,
        channels: &Channels,
        wanted: &(dyn Fn(&str) -> bool + Sync),
    ) -> Result<Vec<Trace>, Error> {
        match self {
            Self::Files(paths) => read_files(paths, channels, Some(wanted)),
            Self::Memory(tables) => {
                let mut gathered = Gathered::default();
                for table in tables {
                    gathered.add(&Table::of(table), channels, wanted)?;
                }
                gathered.complete(channels, tables.len(), &[format!("{} tables", tables.len())])
            }
        }
    }

    /// Reads every trace.
    ///
    /// # Errors
    /// The errors of [`read`].
    pub fn read(&self, channels: &Channels) -> Result<Vec<Trace>, Error> {
        match self {
            Self::Files(paths) => read_files(paths, channels, None),
            Self::Memory(_) => self.read_wanted(channels, &|_| true),
        }
    }
}

/// Reads the next samples of a trace, one for each row of a table: what is missing is NaN, also at the ends, and also a
/// whole channel.
///
/// # Errors
/// Missing columns; columns of other cells than numbers; a table without rows.
pub fn read_piece(table: &Arc<Recorded>, channels: &Channels) -> Result<Vec<Trace>, Error> {
    reader::read_piece(&Table::of(table), channels)
}

/// The traces read so far.
#[derive(Default)]
struct Gathered {
    traces: Vec<Trace>,
    origins: Origins,
}

/// The file of each trace.
#[derive(Debug, Default)]
pub struct Origins(HashMap<String, PathBuf>);

impl Origins {
    /// Adds a trace.
    ///
    /// # Errors
    /// An id that another file has too.
    pub fn add(&mut self, id: &str, file: &Path) -> Result<(), Error> {
        let Some(first) = self.0.insert(stem(id).to_string(), file.to_path_buf()) else { return Ok(()) };
        let (first, second) = (first.display(), file.display());
        Err(Error::trace(id, format!("comes twice, in {first} and {second}; give each id once")))
    }

    /// Whether a trace has come.
    #[must_use]
    pub fn has(&self, id: &str) -> bool {
        self.0.contains_key(id)
    }
}

/// Reads the wanted traces of one table.
fn read_table(table: &Table, channels: &Channels, wanted: &(dyn Fn(&str) -> bool + Sync)) -> Result<Vec<Trace>, Error> {
    match &channels.front_end {
        Some(front_end) => cleaned_reader::read(table, channels, front_end, wanted),
        None => reader::read(table, channels, wanted),
    }
}

impl Gathered {
    fn add(&mut self, table: &Table, channels: &Channels, wanted: &(dyn Fn(&str) -> bool + Sync)) -> Result<(), Error> {
        self.add_all(read_table(table, channels, wanted)?, table.path())
    }

    fn add_all(&mut self, traces: Vec<Trace>, file: &Path) -> Result<(), Error> {
        for trace in traces {
            self.origins.add(&trace.id, file)?;
            self.traces.push(trace);
        }
        Ok(())
    }

    /// The traces; none of so many files or tables is an error.
    fn complete(self, channels: &Channels, files: usize, names: &[String]) -> Result<Vec<Trace>, Error> {
        if !self.traces.is_empty() {
            return Ok(self.traces);
        }
        if files > 0 {
            let problem = "no trace that the labels select; compare their column trace with the names of the traces";
            return Err(Error::Usage(format!("{}: {problem}", names.join(", "))));
        }
        let Channels { y, u1, u2, .. } = channels;
        Err(Error::Usage(format!(
            "no trace with the columns of {y}, {u1}, {u2} in {}; check the path and --y, --u1, --u2",
            names.join(", ")
        )))
    }
}

fn has_columns(table: &Table, channels: &Channels) -> bool {
    match &channels.front_end {
        Some(front_end) => cleaned_reader::has_columns(table, channels, front_end),
        None => reader::has_columns(table, channels),
    }
}

fn read_files(
    paths: &[PathBuf],
    channels: &Channels,
    wanted: Option<&(dyn Fn(&str) -> bool + Sync)>,
) -> Result<Vec<Trace>, Error> {
    let candidates = candidates(paths)?;
    let read: Vec<Result<Option<Vec<Trace>>, Error>> =
        candidates.par_iter().map(|candidate| candidate.read(channels, wanted)).collect();
    let (mut gathered, mut files) = (Gathered::default(), 0);
    for (candidate, traces) in candidates.iter().zip(read) {
        if let Some(traces) = traces? {
            gathered.add_all(traces, &candidate.file)?;
            files += 1;
        }
    }
    gathered.complete(channels, files, &paths.iter().map(|path| path.display().to_string()).collect::<Vec<_>>())
}

/// A file that may have traces.
#[derive(Debug)]
pub struct Candidate {
    /// The file.
    pub file: PathBuf,
    /// Whether it was found in a folder, where files without the columns have no traces.
    of_folder: bool,
}

/// The files that may have traces: these files, and those of known formats in these folders.
pub fn candidates(paths: &[PathBuf]) -> Result<Vec<Candidate>, Error> {
    let mut all = Vec::new();
    for path in paths {
        if path.is_dir() {
            all.extend(known_files(path)?.into_iter().map(|file| Candidate { file, of_folder: true }));
        } else {
            all.push(Candidate { file: path.clone(), of_folder: false });
        }
    }
    Ok(all)
}

impl Candidate {
    /// Reads the wanted traces; `None` of a file in a folder that lacks the columns, unless a trace of its name is
    /// wanted.
    pub fn read(
        &self,
        channels: &Channels,
        wanted: Option<&(dyn Fn(&str) -> bool + Sync)>,
    ) -> Result<Option<Vec<Trace>>, Error> {
        let asked_for = || {
            let name = self.file.file_name().map(|name| name.to_string_lossy().into_owned());
            let names = [name, self.qualified()];
            wanted.is_some_and(|wanted| names.iter().flatten().any(|name| wanted(stem(name))))
        };
        let may_lack = self.of_folder && !asked_for();
        let table = match Table::open_as(&self.file, &channels.text) {
            Err(_) if may_lack => return Ok(None),
            table => table?,
        };
        if may_lack && !has_columns(&table, channels) {
            log::info!("left out {}: it lacks columns of the channels", self.file.display());
            return Ok(None);
        }
        // Labels may name a trace with its folder, since files of several folders may have one name.
        let wants = |name: &str| wanted.is_some_and(|wanted| wanted(stem(name)));
        let qualified = self.qualified().filter(|name| wants(name) && !wants(&table.id()));
        let table = match qualified {
            Some(name) => table.called(name),
            None => table,
        };
        read_table(&table, channels, wanted.unwrap_or(&|_| true)).map(Some)
    }

    /// The name of the file with its folder.
    fn qualified(&self) -> Option<String> {
        let folder = self.file.parent()?.file_name()?.to_string_lossy();
        Some(format!("{folder}/{}", self.file.file_name()?.to_string_lossy()))
    }
}

/// The files among these files and in these folders, in known formats; labels in a folder are left out.
pub fn files(paths: &[PathBuf]) -> Result<Vec<PathBuf>, Error> {
    let mut found = Vec::new();
    for path in paths {
        if !path.is_dir() {
            found.push(path.clone());
            continue;
        }
        let is_labels = |file: &PathBuf| Table::open(file).is_ok_and(|table| reader::is_labels(&table));
        found.extend(known_files(path)?.into_iter().filter(|file| !is_labels(file)));
    }
    Ok(found)
}

/// Whether a file is a trace by its name alone: of a known format, and not called labels.
#[must_use]
pub fn is_trace(file: &Path) -> bool {
    is_known(file) && stem(&file.file_name().unwrap_or_default().to_string_lossy()) != "labels"
}

fn known_files(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let entries = std::fs::read_dir(folder).map_err(Error::io(folder))?;
    let mut files: Vec<PathBuf> = entries.filter_map(|entry| entry.ok().map(|entry| entry.path())).collect();
    files.retain(|file| file.is_file() && is_known(file));
    files.sort();
    Ok(files)
}
