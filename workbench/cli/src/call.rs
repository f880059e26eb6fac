//! Commands as functions, for programs that call the workbench, such as the Python package: options and tables in
//! memory come in, results and warnings go out. The results are those of the command line, to the last bit.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::{Args, FromArgMatches};
use serde_json::Value as Json;

use super::args::traces::Given;
use super::drive;
use super::model_file::{self, Notes, check_rate};
use super::output;
use super::training::{Session, Settings, words};
use model::Error;
use model::core::{Embedded, SegmentReport};
use model::trace::{Channels, Preparation, Recorded, Trace};
use model::train::c_header::c_header;
use traces::Source;

pub use super::drive::Value;
pub use super::training::Training;

/// What a command is called with.
#[derive(Clone, Debug, Default)]
pub struct Call {
    /// The drive file.
    pub drive: Option<PathBuf>,
    /// Options by the keys of a drive file; they go before those in it.
    pub options: Vec<(String, Value)>,
    /// Tables that take the place of files of traces.
    pub traces: Option<Vec<Arc<Recorded>>>,
    /// A table that takes the place of the file of labels.
    pub labels: Option<Arc<Recorded>>,
}

impl Call {
    /// Returns the settings of a command, and what it is given in memory.
    fn parsed<T: Args + FromArgMatches>(mut self, name: &'static str) -> Result<(T, Given), Error> {
        if self.labels.is_some() {
            // The command wants a file.
            self.options.push(("labels".into(), Value::One("labels".into())));
        }
        let command = T::augment_args(clap::Command::new(name));
        let arguments = drive::of_options(&command, &self.options, self.drive.as_deref())?;
        let parsed = command.try_get_matches_from(arguments).and_then(|matches| T::from_arg_matches(&matches));
        let refusal = |error| Error::Usage(super::usage_line(&error).trim_start_matches("error: ").to_string());
        Ok((parsed.map_err(refusal)?, Given { traces: self.traces, labels: self.labels }))
    }
}

/// What a command reports: the lines that it prints, and the value of `--json`.
#[derive(Clone, Debug)]
pub struct Report {
    /// Lines.
    pub lines: Vec<String>,
    /// The same and more.
    pub json: Json,
}

/// A training that is done, and what it takes to judge it.
#[derive(Debug)]
pub struct Done {
    /// The result.
    pub training: Training,
    session: Session,
}

impl Done {
    /// Evaluates on the traces that were held out, or cross-validates; also ranks the features if wanted.
    ///
    /// # Errors
    /// Held-out traces that cannot be read or do not fit; a ranking that cannot be made.
    pub fn report(&self, rank: bool) -> Result<Report, Error> {
        let found = self.session.found(&self.training, rank)?;
        let lines = words::lines(&self.training, &found, "");
        Ok(Report { lines, json: Json::Object(words::to_json(&self.training, &found)) })
    }
}

/// Trains, and returns the warnings too.
///
/// # Errors
/// The errors of `bearing-watch train`.
pub fn train(call: Call) -> (Result<Done, Error>, Vec<String>) {
    output::with_warnings(|| {
        let (settings, given): (Settings, Given) = call.parsed("train")?;
        let session = settings.session(given)?;
        let training = session.train()?;
        training.warn();
        Ok(Done { training, session })
    })
}

/// Simulates traces, and returns them with their classes.
///
/// # Errors
/// The errors of `bearing-watch simulate`.
pub fn simulate(call: Call) -> Result<Vec<(Recorded, &'static str)>, Error> {
    let (choice, _): (super::simulate::Choice, Given) = call.parsed("simulate")?;
    choice.tables()
}

/// A step of the training of a fleet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FleetStep {
    /// `features`: the features of traces as a part.
    Features,
    /// `features-sum`: the sums of parts and of sums.
    Sum,
    /// `train-features`: the model of parts or sums.
    Train,
}

/// Runs a step of the training of a fleet from files to files, and returns the warnings too.
///
/// # Errors
/// The errors of the command.
pub fn fleet(step: FleetStep, call: Call) -> (Result<Report, Error>, Vec<String>) {
    output::with_warnings(|| match step {
        FleetStep::Features => super::features::made(&call.parsed("features")?.0),
        FleetStep::Sum => super::features_sum::made(&call.parsed("features-sum")?.0),
        FleetStep::Train => super::train_features::made(&call.parsed("train-features")?.0),
    })
}

/// A model file, read.
#[derive(Debug)]
pub struct ModelFile {
    /// The model, ready to run.
    pub model: Embedded,
    notes: Notes,
}

impl ModelFile {
    /// Reads the bytes of a model file; messages name it so.
    ///
    /// # Errors
    /// Damaged bytes, or those of another version.
    pub fn new(name: &Path, bytes: &[u8]) -> Result<Self, Error> {
        model_file::of_bytes(name, bytes).map(|(model, notes)| Self { model, notes })
    }

    /// The columns that the model reads.
    #[must_use]
    pub fn channels(&self) -> Channels {
        self.notes.channels()
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

    /// The model as a C header.
    ///
    /// # Errors
    /// A model that the header cannot hold.
    pub fn c_header(&self) -> Result<String, Error> {
        c_header(self.model.model(), &[], Some(&self.channels()))
    }

    /// Reads the only trace of a table as the detector takes it.
    ///
    /// # Errors
    /// Missing columns, bad values, several traces, or another rate than that of the model.
    pub fn trace(&self, table: &Arc<Recorded>) -> Result<Trace, Error> {
        let mut traces = Source::Memory(vec![Arc::clone(table)]).read(&self.channels())?;
        let (Some(trace), true) = (traces.pop(), traces.is_empty()) else {
            return Err(Error::Usage(format!("{} has several traces; give one", table.name())));
        };
        check_rate(&self.model, self.preparation(), std::iter::once(&trace))?;
        self.preparation().apply(&trace)
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

    /// Evaluates on labelled traces, and returns the warnings too.
    ///
    /// # Errors
    /// The errors of `bearing-watch evaluate`.
    pub fn evaluate(&self, call: Call) -> (Result<Report, Error>, Vec<String>) {
        output::with_warnings(|| {
            let (choice, given): (super::evaluate::Choice, Given) = call.parsed("evaluate")?;
            let found = choice.evaluate((&self.model, &self.notes), given)?;
            Ok(Report { lines: found.lines(), json: found.to_json() })
        })
    }
}
