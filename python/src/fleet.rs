//! Training of a fleet: features as parts, their sums, and the model, from files to files.

use std::path::PathBuf;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use workbench::call::{self, FleetStep};

use crate::errors::raised;
use crate::options::call;

/// Runs a step; returns its JSON and the warnings.
#[pyfunction]
pub(crate) fn fleet(
    py: Python<'_>,
    step: &str,
    drive: Option<PathBuf>,
    options: &Bound<'_, PyDict>,
) -> PyResult<(String, Vec<String>)> {
    let step = match step {
        "features" => FleetStep::Features,
        "features-sum" => FleetStep::Sum,
        "train-features" => FleetStep::Train,
        other => return Err(PyValueError::new_err(format!("no step {other}"))),
    };
    let call = call(drive, options, None, None)?;
    py.detach(|| {
        let (report, warnings) = call::fleet(step, call);
        Ok((report.map_err(raised)?.json.to_string(), warnings))
    })
}
