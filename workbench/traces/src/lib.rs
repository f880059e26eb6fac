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
//! | room | content |
//! |---|---|
//! | `listing` | the files of folders that may have traces, their names, and labels |
//! | [`table`] | named columns of a file of any format, or in memory |
//! | [`reader`] | columns → traces: one file a trace, or a table with a column of their names |
//! | `signal` | a channel by the text of its formula |
//! | `time` | the times of rows |
//! | [`front_end`] | recordings at the control rate → clean samples |
//! | [`units`] | units, by the names of columns |
//! | `temperature` | temperatures, by the names of columns |
//! | `turning` | the units of angle and velocity, by names and by values |
//! | [`resample`] | irregular times → a constant rate |
//! | [`given`] | labels, front end and traces that settings name |
//! | [`audit`] | what recordings are worth |
//! | [`describe`] | recordings → the text of a drive file |
//! | [`damaged`] | damaged files, at which readers of other crates panic |

pub mod audit;
pub mod damaged;
pub mod describe;
pub mod front_end;
pub mod given;
mod listing;
pub mod reader;
pub mod resample;
mod signal;
pub mod table;
mod temperature;
mod time;
mod turning;
pub mod units;

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rayon::prelude::*;

use model::Error;

use listing::{LACKING, read_table, without};

pub use listing::labels::read_labels;
pub use listing::naming::whole_name;
pub use listing::{Candidate, Listing, is_trace, walk};
use model::trace::{Channels, Recorded, Trace, TraceNames, trace_name};
pub use table::LARGEST;
use table::Table;

/// Reads every trace of the given files and folders.
///
/// In a folder and those below it, the files of known formats with the wanted columns are read (others, for example
/// labels or parameter tables, are skipped); a file given directly must have the columns.
///
/// # Errors
/// Unreadable files; missing columns; ragged rows; cells that are neither numbers nor missing; a channel without a
/// number; an id that occurs twice; no trace.
pub fn read(paths: &[PathBuf], channels: &Channels) -> Result<Vec<Trace>, Error> {
    read_files((paths, None), channels, None)
}

/// Where traces come from.
#[derive(Clone, Debug)]
pub enum Source {
    /// Files, and folders of files.
    Files(Vec<PathBuf>),
    /// The same, with the names that labels give.
    Labelled(Vec<PathBuf>, TraceNames),
    /// Tables in memory.
    Memory(Vec<Arc<Recorded>>),
}

impl Source {
    /// The files and folders; none of tables in memory.
    #[must_use]
    pub fn paths(&self) -> &[PathBuf] {
        match self {
            Self::Files(paths) | Self::Labelled(paths, _) => paths,
            Self::Memory(_) => &[],
        }
    }

    /// The names that labels give.
    fn names(&self) -> Option<&TraceNames> {
        match self {
            Self::Labelled(_, names) => Some(names),
            Self::Files(_) | Self::Memory(_) => None,
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
            Self::Files(paths) | Self::Labelled(paths, _) => read_files((paths, self.names()), channels, Some(wanted)),
            Self::Memory(tables) => {
                let mut gathered = Gathered::default();
                for table in tables.iter().map(Table::of) {
                    gathered.add(read_table(&table, channels, wanted)?, table.path())?;
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
            Self::Files(paths) | Self::Labelled(paths, _) => read_files((paths, self.names()), channels, None),
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

/// The remedy of a name that two files have.
const TWICE: &str = "give each id once, or give the labels the folders too, such as run_1/NAME";

/// The file of each trace.
#[derive(Debug, Default)]
pub struct Origins(HashMap<String, PathBuf>);

impl Origins {
    /// Adds a trace.
    ///
    /// # Errors
    /// An id that another file has too.
    pub fn add(&mut self, id: &str, file: &Path) -> Result<(), Error> {
        let Some(first) = self.0.insert(trace_name(id).into_owned(), file.to_path_buf()) else { return Ok(()) };
        let (first, second) = (first.display(), file.display());
        Err(Error::trace(id, format!("comes twice, in {first} and {second}; {TWICE}")))
    }

    /// Whether a trace has come.
    #[must_use]
    pub fn has(&self, id: &str) -> bool {
        self.0.contains_key(&*trace_name(id))
    }
}

impl Gathered {
    fn add(&mut self, traces: Vec<Trace>, file: &Path) -> Result<(), Error> {
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

/// Reads the wanted traces of files. The caller says which files have no label.
fn read_files(
    (paths, names): (&[PathBuf], Option<&TraceNames>),
    channels: &Channels,
    wanted: Option<&(dyn Fn(&str) -> bool + Sync)>,
) -> Result<Vec<Trace>, Error> {
    let Listing { candidates, left_out } = Listing::of(paths, names)?;
    let read: Vec<Result<Option<Vec<Trace>>, Error>> =
        candidates.par_iter().map(|candidate| candidate.read(channels, wanted)).collect();
    let (mut gathered, mut files, mut lacking) = (Gathered::default(), 0, Vec::new());
    for (candidate, traces) in candidates.iter().zip(read) {
        match traces? {
            Some(traces) => {
                gathered.add(traces, &candidate.file)?;
                files += 1;
            }
            None => lacking.push(&candidate.file),
        }
    }
    let traces =
        gathered.complete(channels, files, &paths.iter().map(|path| path.display().to_string()).collect::<Vec<_>>())?;
    if names.is_none() || wanted.is_none() {
        left_out.into_iter().chain(without(lacking.into_iter(), LACKING)).for_each(|line| log::warn!("{line}"));
    }
    Ok(traces)
}
