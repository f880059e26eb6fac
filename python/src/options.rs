//! Keyword arguments as values of settings.

use std::path::{Path, PathBuf};

use model::Error;
use model::settings::{DriveFile, Further, Settings, Use};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyList, PyMapping, PySequence, PyString};
use serde_json::{Map, Value};
use traces::given::Memory;

use crate::tables::{table, tables};

/// What a job is called with.
#[derive(Debug)]
pub(crate) struct Call {
    drive: Option<PathBuf>,
    options: Map<String, Value>,
    /// Tables that take the place of files.
    pub(crate) memory: Memory,
}

/// Settings, further options, and the text of the drive file if one is given.
pub(crate) type Understood = (Settings, Further, Option<String>);

impl Call {
    /// The settings and the further options of a job; settings go over those of the drive file.
    pub(crate) fn understood(&self, job: &Use) -> Result<Understood, Error> {
        let (own, further) = job.options(self.options.clone())?;
        let (settings, text) = match self.drive.as_deref().map(DriveFile::read).transpose()? {
            Some(DriveFile { settings, text }) => (own.over(settings), Some(text)),
            None => (own, None),
        };
        let mut wanted = settings.clone();
        if self.memory.labels.is_some() {
            // Labels in memory are labels too.
            wanted.data.labels.get_or_insert_with(|| Path::new("labels").to_path_buf());
        }
        job.require(&wanted)?;
        Ok((settings, further, text))
    }

    /// The options of a job without settings.
    pub(crate) fn options(self) -> Map<String, Value> {
        self.options
    }
}

/// A call with these options, and with tables in memory where they are given.
pub(crate) fn call(
    drive: Option<PathBuf>,
    options: &Bound<'_, PyDict>,
    traces: Option<&Bound<'_, PyList>>,
    labels: Option<&Bound<'_, PyAny>>,
) -> PyResult<Call> {
    let given = options.iter().filter(|(_, value)| !value.is_none());
    let options = given.map(|(key, value)| {
        let key: String = key.extract()?;
        let value = value_of(&key, &value)?;
        Ok((key, value))
    });
    let memory = Memory {
        traces: traces.map(tables).transpose()?,
        labels: labels.map(|labels| table("labels", labels)).transpose()?,
    };
    Ok(Call { drive, options: options.collect::<PyResult<_>>()?, memory })
}

fn value_of(key: &str, given: &Bound<'_, PyAny>) -> PyResult<Value> {
    if let Ok(flag) = given.cast::<PyBool>() {
        return Ok(flag.is_true().into());
    }
    if given.is_instance_of::<PyString>() {
        return given.extract::<String>().map(Value::from);
    }
    if let Ok(mapping) = given.cast::<PyMapping>() {
        let each = |pair: Bound<'_, PyAny>| {
            let (name, value): (String, Bound<'_, PyAny>) = pair.extract()?;
            Ok((name, plain(key, &value)?))
        };
        return mapping.items()?.iter().map(each).collect::<PyResult<Map<_, _>>>().map(Value::Object);
    }
    if let Ok(list) = given.cast::<PySequence>() {
        return list.try_iter()?.map(|value| plain(key, &value?)).collect::<PyResult<Vec<_>>>().map(Value::Array);
    }
    plain(key, given)
}

/// A text, a path, or a number.
fn plain(key: &str, given: &Bound<'_, PyAny>) -> PyResult<Value> {
    if let Ok(text) = given.extract::<String>() {
        return Ok(text.into());
    }
    if let Ok(whole) = given.extract::<i64>() {
        return Ok(whole.into());
    }
    if let Ok(number) = given.extract::<f64>() {
        // JSON has no infinity, but its text is understood.
        return Ok(serde_json::Number::from_f64(number).map_or_else(|| number.to_string().into(), Value::Number));
    }
    if let Ok(path) = given.extract::<PathBuf>() {
        return Ok(path.to_string_lossy().into());
    }
    let kind = given.get_type().name()?;
    Err(PyTypeError::new_err(format!("{key} takes a text, a number or a list of them, not {kind}")))
}

/// The settings of a job by options, as text: what `train` and the others understand.
#[pyfunction]
pub(crate) fn settings(job: &str, options: &Bound<'_, PyDict>) -> PyResult<String> {
    let jobs = [Use::TRAIN, Use::EVALUATE, Use::REPLAY, Use::FEATURES, Use::TRAIN_FEATURES];
    let unknown = || crate::errors::refused(format!("no job {job}"));
    let job = jobs.iter().find(|own| own.name == job).ok_or_else(unknown)?;
    let call = call(None, options, None, None)?;
    let understood = job.options(call.options).and_then(|(settings, further)| {
        further.end()?;
        settings.text(Path::new("drive.toml"), job)
    });
    understood.map_err(crate::errors::raised)
}
