//! Trained models: training, evaluation, exports.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use model::Error;
use model::session::{Judging, Log, ModelFile, Quiet, Session, Training, lines, to_json};
use model::settings::{Use, from_value};
use model::trace::Cells;
use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyList};
use serde_json::Value;
use studies::simulation::{Set, Simulation};
use traces::given::{given, given_without_front_end};

use crate::errors::{raised, refused};
use crate::options::{Call, call};
use crate::pool::detached;

/// A training that is done, and what it takes to judge it.
#[derive(Debug)]
struct Done {
    session: Session,
    training: Training,
}

/// A model with its file, and with the training that it comes from unless it was loaded.
#[derive(Debug)]
pub(crate) struct Own {
    pub(crate) file: ModelFile,
    bytes: Vec<u8>,
    done: Option<Done>,
}

/// A trained model.
#[pyclass(frozen, module = "bearing_watch._core")]
#[derive(Clone, Debug)]
pub(crate) struct Model {
    pub(crate) own: Arc<Own>,
}

/// Lines and JSON of a report, and the warnings.
type Reported = (Vec<String>, String, Vec<String>);

/// Trains by a call.
fn trained(call: Call, log: &Log<'_>) -> Result<Done, Error> {
    let (settings, further, drive) = call.understood(&Use::TRAIN)?;
    further.end()?;
    let given = given(&settings, call.memory)?;
    let session = Session::new(settings, given, drive)?;
    let training = session.train(log)?;
    log.warn(training.doubts());
    Ok(Done { session, training })
}

/// Trains a model; returns it with the warnings.
#[pyfunction]
pub(crate) fn train(
    py: Python<'_>,
    drive: Option<PathBuf>,
    options: &Bound<'_, PyDict>,
    traces: Option<&Bound<'_, PyList>>,
    labels: Option<&Bound<'_, PyAny>>,
) -> PyResult<(Model, Vec<String>)> {
    let call = call(drive, options, traces, labels)?;
    detached(py, || {
        let log = Log::new(&Quiet);
        let done = trained(call, &log).map_err(raised)?;
        let bytes = done.training.bytes.clone();
        let file = ModelFile::new(Path::new("model"), &bytes).map_err(raised)?;
        Ok((Model { own: Arc::new(Own { file, bytes, done: Some(done) }) }, log.take()))
    })
}

/// Simulates traces; returns a list of (name, class, columns).
#[pyfunction]
pub(crate) fn simulate<'py>(py: Python<'py>, options: &Bound<'py, PyDict>) -> PyResult<Bound<'py, PyList>> {
    let options = call(None, options, None, None)?.options();
    let tables = detached(py, || {
        let simulation: Simulation =
            from_value(Value::Object(options)).map_err(|problem| Error::Usage(format!("simulate: {problem}")))?;
        Set::new(&simulation)?.tables()
    });
    let tables = tables.map_err(raised)?;
    let each = |(table, class): (model::trace::Recorded, &'static str)| {
        let columns = PyDict::new(py);
        let name = table.name().to_string();
        for (name, cells) in table.into_columns() {
            if let Cells::Numbers(numbers) = cells {
                columns.set_item(name, numbers.into_pyarray(py))?;
            }
        }
        Ok((name, class, columns))
    };
    PyList::new(py, tables.into_iter().map(each).collect::<PyResult<Vec<_>>>()?)
}

#[pymethods]
impl Model {
    /// Reads the bytes of a model file; errors name it so.
    #[staticmethod]
    fn from_bytes(name: PathBuf, bytes: &[u8]) -> PyResult<Self> {
        let file = ModelFile::new(&name, bytes).map_err(raised)?;
        Ok(Self { own: Arc::new(Own { file, bytes: bytes.to_vec(), done: None }) })
    }

    /// The model file.
    fn to_bytes<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.own.bytes)
    }

    #[getter]
    fn classes(&self) -> Vec<String> {
        self.own.file.model.classes.clone()
    }

    #[getter]
    fn healthy(&self) -> Option<String> {
        let model = &self.own.file.model;
        model.healthy().map(|class| model.classes[class].clone())
    }

    #[getter]
    fn features(&self) -> Vec<String> {
        self.own.file.features().to_vec()
    }

    #[getter]
    fn orders(&self) -> Vec<String> {
        self.own.file.orders().to_vec()
    }

    /// The columns or formulas of columns that the model reads.
    #[getter]
    fn columns(&self) -> Vec<String> {
        let mut names: Vec<String> = vec![];
        for name in self.own.file.channels().names() {
            if !names.iter().any(|own| own == name) {
                names.push(name.into());
            }
        }
        names
    }

    #[getter]
    fn trained_on(&self) -> Vec<String> {
        self.own.file.trained_on().to_vec()
    }

    #[getter]
    fn segment_samples(&self) -> u32 {
        self.own.file.model.sampling().segment_samples
    }

    /// Interval of the detector's input, s; 0 if it is not known.
    #[getter]
    fn interval_s(&self) -> f32 {
        self.own.file.model.sampling().interval_s
    }

    /// Whether it has the data of its training.
    #[getter]
    fn is_trained(&self) -> bool {
        self.own.done.is_some()
    }

    /// The model as Rust source.
    fn to_rust(&self) -> PyResult<String> {
        self.done()?.training.rust_source().map_err(raised)
    }

    /// The model as a C header.
    fn to_c(&self) -> PyResult<String> {
        match &self.own.done {
            Some(done) => done.training.c_header(None),
            None => self.own.file.c_header(None),
        }
        .map_err(raised)
    }

    /// Lines and JSON of the report of the training, with the warnings.
    fn report(&self, py: Python<'_>, rank: bool) -> PyResult<Reported> {
        let done = self.done()?;
        detached(py, || {
            let log = Log::new(&Quiet);
            let found = done.session.found(&done.training, rank, &log)?;
            let json = Value::Object(to_json(&done.training, &found));
            Ok((lines(&done.training, &found, ""), json.to_string(), log.take()))
        })
        .map_err(raised)
    }

    /// Evaluates on labelled traces.
    fn evaluate(
        &self,
        py: Python<'_>,
        drive: Option<PathBuf>,
        options: &Bound<'_, PyDict>,
        traces: Option<&Bound<'_, PyList>>,
        labels: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Reported> {
        let call = call(drive, options, traces, labels)?;
        detached(py, || {
            let log = Log::new(&Quiet);
            let (settings, mut further, _) = call.understood(&Use::EVALUATE)?;
            let options = further.take()?;
            further.end()?;
            let given = given_without_front_end(&settings, call.memory)?;
            let found = Judging::new(&self.own.file, settings, given, options).evaluate(&log)?;
            Ok((found.lines(), found.to_json().to_string(), log.take()))
        })
        .map_err(raised)
    }
}

impl Model {
    fn done(&self) -> PyResult<&Done> {
        let gone = "a model that was loaded from a file does not have the data of its training; use the model that \
                    train returned";
        self.own.done.as_ref().ok_or_else(|| refused(gone))
    }
}
