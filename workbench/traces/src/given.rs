//! Labels, front end and traces of settings: from files, or from tables in memory.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::listing::labels::read_labels;
use crate::listing::{LEFT_OUT, told_unlabelled, unlabelled};
use crate::table::Table;
use crate::{Candidate, Listing, Source};
use model::Error;
use model::outputs::folder_of;
use model::session::{Given, Piece, TemperatureColumn, TraceSource};
use model::settings::Settings;
use model::trace::{Channels, FrontEndFile, Labels, Recorded, Trace, TraceNames};

/// Tables that take the place of files.
#[derive(Clone, Debug, Default)]
pub struct Memory {
    /// The traces.
    pub traces: Option<Vec<Arc<Recorded>>>,
    /// The labels.
    pub labels: Option<Arc<Recorded>>,
}

/// Reads labels and front end, and finds the traces: those of the settings, or in the folder of the labels.
///
/// # Errors
/// Labels or a front end that cannot be read, no labels, or channels that do not go together.
pub fn given(settings: &Settings, memory: Memory) -> Result<Given, Error> {
    let front_end = settings.data.front_end.as_deref().map(FrontEndFile::read).transpose()?;
    // Settings that do not go together are refused before the labels are read.
    settings.reading(front_end.clone())?;
    Ok(Given { front_end, ..given_without_front_end(settings, memory)? })
}

/// The same for a model, which has its own front end.
///
/// # Errors
/// Labels that cannot be read, or no labels.
pub fn given_without_front_end(settings: &Settings, memory: Memory) -> Result<Given, Error> {
    let (traces, file) = (&settings.data.traces, settings.data.labels.clone());
    let labels = match (memory.labels, &file) {
        (Some(table), _) => (Labels::of(&table)?, None),
        (None, Some(path)) => (read_labels(path)?, file.clone()),
        (None, None) => return Err(Error::Usage("the labels are not given".into())),
    };
    let source = match memory.traces {
        Some(tables) => Source::Memory(tables),
        None if traces.is_empty() => {
            let folder = file.as_deref().map_or(Path::new("."), folder_of);
            Source::Labelled(vec![folder.to_path_buf()], labels.0.names())
        }
        None => Source::Labelled(traces.clone(), labels.0.names()),
    };
    let (labels, file) = labels;
    Ok(Given { labels, file, source: Box::new(source), front_end: None })
}

impl TraceSource for Source {
    fn read_wanted(&self, channels: &Channels, wanted: &(dyn Fn(&str) -> bool + Sync)) -> Result<Vec<Trace>, Error> {
        Self::read_wanted(self, channels, wanted)
    }

    fn paths(&self) -> &[PathBuf] {
        Self::paths(self)
    }

    fn temperatures(
        &self,
        channels: &Channels,
        wanted: &(dyn Fn(&str) -> bool + Sync),
    ) -> Result<Vec<TemperatureColumn>, Error> {
        self.temperature_columns(channels, wanted)
    }

    fn left_out(&self, channels: &Channels, names: &TraceNames) -> Result<Vec<String>, Error> {
        Ok(match self {
            Self::Files(paths) | Self::Labelled(paths, _) => {
                Listing::of(paths, Some(names))?.beside_labels(channels, names)
            }
            Self::Memory(tables) => {
                let all = tables.iter().flat_map(|table| unlabelled(&Table::of(table), names));
                told_unlabelled(&all.collect::<Vec<_>>(), LEFT_OUT).into_iter().collect()
            }
        })
    }

    fn pieces(&self) -> Result<Vec<Box<dyn Piece>>, Error> {
        let all = Listing::of(Self::paths(self), self.names())?.candidates;
        Ok(all.into_iter().map(|candidate| -> Box<dyn Piece> { Box::new(candidate) }).collect())
    }
}

impl Piece for Candidate {
    fn file(&self) -> &Path {
        &self.file
    }

    fn name(&self) -> String {
        self.id()
    }

    fn read(&self, channels: &Channels, wanted: &(dyn Fn(&str) -> bool + Sync)) -> Result<Option<Vec<Trace>>, Error> {
        Self::read(self, channels, Some(wanted))
    }
}
