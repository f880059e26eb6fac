//! Training of a fleet: features as parts, and the model, from files to files.

use std::path::PathBuf;

use ::fleet::steps::{features, train_features};
use model::Error;
use model::session::{Log, Quiet};
use model::settings::Use;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::Value;
use traces::given::given;

use crate::errors::raised;
use crate::options::{Call, call};
use crate::pool::detached;

/// A step of the training of a fleet.
type Step = fn(Call, &Log<'_>) -> Result<Value, Error>;

/// Runs a step; returns its JSON and the warnings.
#[pyfunction]
pub(crate) fn fleet(
    py: Python<'_>,
    step: &str,
    drive: Option<PathBuf>,
    options: &Bound<'_, PyDict>,
) -> PyResult<(String, Vec<String>)> {
    let step: Step = match step {
        "features" => of_traces,
        "train-features" => model,
        other => return Err(PyValueError::new_err(format!("no step {other}"))),
    };
    let call = call(drive, options, None, None)?;
    detached(py, || {
        let log = Log::new(&Quiet);
        let report = step(call, &log).map_err(raised)?;
        Ok((report.to_string(), log.take()))
    })
}

fn of_traces(call: Call, log: &Log<'_>) -> Result<Value, Error> {
    let (settings, mut further, _) = call.understood(&Use::FEATURES)?;
    let options = further.take()?;
    further.end()?;
    let given = given(&settings, call.memory)?;
    Ok(features(&settings, given, &options, log)?.to_json())
}

fn model(call: Call, log: &Log<'_>) -> Result<Value, Error> {
    let (settings, mut further, drive) = call.understood(&Use::TRAIN_FEATURES)?;
    let (options, exports) = (further.take()?, further.take()?);
    further.end()?;
    Ok(train_features(&settings, &options, &exports, drive, log)?.to_json())
}
