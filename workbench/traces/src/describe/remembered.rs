//! Traces that are read once for several trainings.
//!
//! The trial of a description trains by several recipes. Most of them read the same columns of the same recordings.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use model::Error;
use model::session::{Given, Piece, TemperatureColumn, TraceSource};
use model::trace::{Channels, Trace, TraceNames};

/// Most bytes of traces that are kept.
const MOST_BYTES: usize = 1 << 30;

/// Traces by what was read: the channels, and the ids.
type Read = HashMap<(String, Vec<String>), Vec<Trace>>;

/// The traces that were read.
#[derive(Clone, Debug, Default)]
pub(super) struct Kept(Arc<Mutex<Read>>);

impl Kept {
    /// The same recordings, read by what is kept.
    ///
    /// # Errors
    /// Labels without classes.
    pub(super) fn given(&self, given: Given) -> Result<Given, Error> {
        let ids = given.labels.select(&[])?.into_iter().map(|(id, _)| id).collect();
        Ok(Given { source: Box::new(Remembering { source: given.source, ids, kept: self.clone() }), ..given })
    }
}

/// A source whose traces are kept.
#[derive(Debug)]
struct Remembering {
    source: Box<dyn TraceSource>,
    /// Ids of the labels.
    ids: Vec<String>,
    kept: Kept,
}

impl TraceSource for Remembering {
    fn read_wanted(&self, channels: &Channels, wanted: &(dyn Fn(&str) -> bool + Sync)) -> Result<Vec<Trace>, Error> {
        let key = (format!("{channels:?}"), self.ids.iter().filter(|id| wanted(id)).cloned().collect());
        let mut kept = self.kept.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(traces) = kept.get(&key) {
            return Ok(traces.clone());
        }
        let traces = self.source.read_wanted(channels, wanted)?;
        let size = |traces: &Vec<Trace>| traces.iter().map(bytes).sum::<usize>();
        // The next recipe reads what this one did, rather than what those before did.
        if kept.values().map(size).sum::<usize>() + size(&traces) > MOST_BYTES {
            kept.clear();
        }
        if size(&traces) <= MOST_BYTES {
            kept.insert(key, traces.clone());
        }
        Ok(traces)
    }

    fn paths(&self) -> &[PathBuf] {
        self.source.paths()
    }

    fn temperatures(
        &self,
        channels: &Channels,
        wanted: &(dyn Fn(&str) -> bool + Sync),
    ) -> Result<Vec<TemperatureColumn>, Error> {
        self.source.temperatures(channels, wanted)
    }

    fn left_out(&self, channels: &Channels, names: &TraceNames) -> Result<Vec<String>, Error> {
        self.source.left_out(channels, names)
    }

    fn pieces(&self) -> Result<Vec<Box<dyn Piece>>, Error> {
        self.source.pieces()
    }
}

/// Memory of a trace: output, two inputs, further columns, and those of a motion.
fn bytes(trace: &Trace) -> usize {
    let of_motion = if trace.motion.is_some() { 5 } else { 0 };
    (3 + trace.further.len() + of_motion) * trace.y.len() * size_of::<f64>()
}
