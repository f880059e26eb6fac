//! Recorded or simulated signals, from files to what identification takes.

mod csv_reader;
pub mod labels;
pub mod prepare;

use std::path::PathBuf;

use crate::Error;

pub use labels::{Condition, Labels};
pub use prepare::Preparation;

/// One record: output and two inputs at a constant rate.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    /// Name of its file, or the `trace` cell of a tidy table.
    pub id: String,
    /// Median step of the `t_s` column, s, where there is one.
    pub interval_s: Option<f64>,
    /// Output.
    pub y: Vec<f64>,
    /// First input.
    pub u1: Vec<f64>,
    /// Second input.
    pub u2: Vec<f64>,
}

/// Which columns the three signals come from: a column's name, or a difference `a-b` of two.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channels {
    /// Output.
    pub y: String,
    /// First input.
    pub u1: String,
    /// Second input.
    pub u2: String,
}

/// The id of a trace without the `.csv` of its file, for comparing.
#[must_use]
pub fn stem(id: &str) -> &str {
    id.strip_suffix(".csv").unwrap_or(id)
}

/// Reads every trace of the given files and folders.
///
/// A folder stands for its `.csv` files that hold the wanted columns (others, such as labels or parameter tables,
/// are passed over); a file named outright must hold them.
///
/// # Errors
/// Unreadable files; missing columns; ragged, non-numeric or non-finite cells; an id that comes twice; no trace.
pub fn read(paths: &[PathBuf], channels: &Channels) -> Result<Vec<Trace>, Error> {
    let mut traces: Vec<Trace> = Vec::new();
    let mut origin = std::collections::HashMap::new();
    for path in paths {
        let found = if path.is_dir() { read_folder(path, channels)? } else { csv_reader::read(path, channels)? };
        for trace in found {
            if let Some(first) = origin.insert(stem(&trace.id).to_string(), path.clone()) {
                let problem = format!("comes twice, in {} and {}; give each id once", first.display(), path.display());
                return Err(Error::trace(&trace.id, problem));
            }
            traces.push(trace);
        }
    }
    if traces.is_empty() {
        let names: Vec<_> = paths.iter().map(|path| path.display().to_string()).collect();
        let Channels { y, u1, u2 } = channels;
        return Err(Error::Usage(format!(
            "no trace with the columns of {y}, {u1}, {u2} in {}; check the path and --y, --u1, --u2",
            names.join(", ")
        )));
    }
    Ok(traces)
}

fn read_folder(folder: &PathBuf, channels: &Channels) -> Result<Vec<Trace>, Error> {
    let entries = std::fs::read_dir(folder).map_err(Error::io(folder))?;
    let mut files: Vec<PathBuf> = entries.filter_map(|entry| entry.ok().map(|entry| entry.path())).collect();
    files.retain(|file| file.extension().is_some_and(|e| e == "csv"));
    files.sort();
    let mut traces = Vec::new();
    for file in files {
        if csv_reader::has_columns(&file, channels)? {
            traces.extend(csv_reader::read(&file, channels)?);
        }
    }
    Ok(traces)
}
