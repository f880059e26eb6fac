//! A model file: the model, and the notes of the workbench.

use std::path::Path;

use super::judging::check_rate;
use super::notes::Notes;
use super::source::TraceSource;
use crate::Error;
use crate::core::{Embedded, SegmentReport};
use crate::trace::{Channels, Preparation, Trace};
use crate::train::c_header::c_header;

/// Number of bytes of a signature, `bearing_watch::signature::BLOCK`.
const SIGNATURE: usize = 88;

/// A model file, read.
#[derive(Debug)]
pub struct ModelFile {
    /// The model, ready to run.
    pub model: Embedded,
    /// What it says of itself.
    pub notes: Notes,
}

impl ModelFile {
    /// Reads a model file.
    ///
    /// # Errors
    /// An unreadable file, damaged bytes, or those of another version.
    pub fn read(path: &Path) -> Result<Self, Error> {
        Self::new(path, &std::fs::read(path).map_err(Error::io(path))?)
    }

    /// Reads the bytes of a model file; messages name it so.
    ///
    /// # Errors
    /// Damaged bytes, or those of another version.
    pub fn new(name: &Path, bytes: &[u8]) -> Result<Self, Error> {
        of_bytes(name, bytes).map(|(model, notes)| Self { model, notes })
    }

    /// The columns that the model reads.
    #[must_use]
    pub const fn channels(&self) -> &Channels {
        &self.notes.channels
    }

    /// What is done to recordings before the detector.
    #[must_use]
    pub fn preparation(&self) -> Preparation {
        self.notes.preparation()
    }

    /// Names of the features in use.
    #[must_use]
    pub fn features(&self) -> &[String] {
        &self.notes.features
    }

    /// Names of the tracked orders.
    #[must_use]
    pub fn orders(&self) -> &[String] {
        &self.notes.orders
    }

    /// Ids of the training traces.
    #[must_use]
    pub fn trained_on(&self) -> &[String] {
        &self.notes.trained_on
    }

    /// The model as a C header, with this name in its names.
    ///
    /// # Errors
    /// A model that the header cannot hold, and a name that is not one of C.
    pub fn c_header(&self, name: Option<&str>) -> Result<String, Error> {
        c_header(self.model.model(), (&[], &self.notes.orders), Some(self.channels()), name)
    }

    /// Reads the only trace of a source of this name as the detector takes it.
    ///
    /// # Errors
    /// Missing columns, bad values, several traces, or another rate than that of the model.
    pub fn trace(&self, name: &str, source: &dyn TraceSource) -> Result<Trace, Error> {
        let mut traces = source.read_wanted(self.channels(), &|_| true)?;
        let (Some(trace), true) = (traces.pop(), traces.is_empty()) else {
            return Err(Error::Usage(format!("{name} has several traces; give one")));
        };
        check_rate(&self.model, self.preparation(), std::iter::once(&trace))?;
        self.preparation().apply(&trace)
    }

    /// Reads all traces of a source as the detector takes them.
    ///
    /// # Errors
    /// Missing columns, bad values, or another rate than that of the model.
    pub fn traces(&self, source: &dyn TraceSource) -> Result<Vec<Trace>, Error> {
        let traces = source.read_wanted(self.channels(), &|_| true)?;
        check_rate(&self.model, self.preparation(), traces.iter())?;
        traces.iter().map(|trace| self.preparation().apply(trace)).collect()
    }

    /// Returns why the samples of a trace cannot come in pieces, if they cannot.
    #[must_use]
    pub fn refuses_pieces(&self) -> Option<&'static str> {
        let channels = self.channels();
        if self.preparation() != Preparation::NONE {
            return Some("its recordings are averaged or decimated before the detector");
        }
        if channels.front_end.is_some() {
            return Some("its recordings pass a front end");
        }
        let integrates = channels.names().iter().any(|name| name.contains("integrate("));
        integrates.then_some("one of its channels is an integral from the start of the trace")
    }

    /// Names of what the decision on a segment lacked: missing features, and covariates that were missing or out of
    /// range.
    #[must_use]
    pub fn lacking(&self, segment: &SegmentReport) -> Vec<String> {
        let catalogue = self.model.catalogue(&self.notes.orders);
        let all = segment.missing.iter().copied().chain(self.model.outside(segment));
        all.map(|feature| catalogue.name(feature)).collect()
    }
}

/// Model and notes of the bytes of a model file.
fn of_bytes(path: &Path, bytes: &[u8]) -> Result<(Embedded, Notes), Error> {
    let wrong = |problem: bearing_watch::ModelError| {
        let remedy = match problem {
            bearing_watch::ModelError::Version { given, supported } if given > supported => "",
            bearing_watch::ModelError::Version { .. } => " with `bearing-watch train`",
            _ => "; train it again with `bearing-watch train`",
        };
        Error::content(path, "model", format!("{problem}{remedy}"))
    };
    let bytes = without_signature(bytes);
    let model = Embedded::from_bytes(bytes).map_err(wrong)?;
    let notes = bearing_watch::model::notes(bytes).map_err(wrong)?;
    let notes = serde_json::from_str(notes).map_err(|_| {
        Error::content(path, "notes", "no channel names in this model; train it again with `bearing-watch train`")
    })?;
    Ok((model, notes))
}

/// A model file without the signature that may follow the model; firmware verifies it, and `bearing-watch sign
/// --verify`.
fn without_signature(bytes: &[u8]) -> &[u8] {
    let Ok(length) = bearing_watch::model::stored_len(bytes) else { return bytes };
    let (model, rest) = bytes.split_at(length.min(bytes.len()));
    if rest.len() == SIGNATURE && rest.starts_with(b"BWSG") { model } else { bytes }
}
