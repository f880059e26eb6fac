//! What a session reads: labels, and traces of whatever source.

use std::path::{Path, PathBuf};

use crate::Error;
use crate::trace::{Channels, FrontEndFile, Labels, Trace, TraceNames};

/// Where traces come from.
pub trait TraceSource: std::fmt::Debug + Send + Sync {
    /// Reads the traces for whose id (without the extension of its format) `wanted` is true; others are skipped and not
    /// checked.
    ///
    /// # Errors
    /// What cannot be read, an id that occurs twice, or no trace.
    fn read_wanted(&self, channels: &Channels, wanted: &(dyn Fn(&str) -> bool + Sync)) -> Result<Vec<Trace>, Error>;

    /// The files and folders; none of tables in memory.
    fn paths(&self) -> &[PathBuf];

    /// The columns that are temperatures by name or unit, of the files or tables that may have wanted traces.
    ///
    /// # Errors
    /// A folder that cannot be read.
    fn temperatures(
        &self,
        channels: &Channels,
        wanted: &(dyn Fn(&str) -> bool + Sync),
    ) -> Result<Vec<TemperatureColumn>, Error>;

    /// What is left out, in lines: files without these channels, and records of which labels with these names have
    /// none.
    ///
    /// # Errors
    /// A folder that cannot be read.
    fn left_out(&self, channels: &Channels, names: &TraceNames) -> Result<Vec<String>, Error>;

    /// What may have traces, each part to be read alone.
    ///
    /// # Errors
    /// A folder that cannot be read.
    fn pieces(&self) -> Result<Vec<Box<dyn Piece>>, Error>;
}

/// A column that is a temperature by its name or unit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TemperatureColumn {
    /// Its name.
    pub name: String,
    /// Number of files or tables without it.
    pub lacking: usize,
    /// Number of files or tables.
    pub of: usize,
}

/// A part of a source, such as a file.
pub trait Piece: Send + Sync {
    /// Its file.
    fn file(&self) -> &Path;

    /// The name of its trace, if it has only one, as names are compared.
    fn name(&self) -> String;

    /// Reads the wanted traces; `None` of a file that is there by chance.
    ///
    /// # Errors
    /// What cannot be read.
    fn read(&self, channels: &Channels, wanted: &(dyn Fn(&str) -> bool + Sync)) -> Result<Option<Vec<Trace>>, Error>;
}

/// What is read besides the settings.
#[derive(Debug)]
pub struct Given {
    /// The labels.
    pub labels: Labels,
    /// The file of the labels, if they are in one.
    pub file: Option<PathBuf>,
    /// The traces.
    pub source: Box<dyn TraceSource>,
    /// The front end of the recordings, if they pass one.
    pub front_end: Option<FrontEndFile>,
}
