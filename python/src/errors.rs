//! Errors of the workbench as exceptions of Python.

use std::io::ErrorKind;

use model::Error;
use pyo3::create_exception;
use pyo3::exceptions::{PyFileNotFoundError, PyOSError, PyPermissionError, PyValueError};
use pyo3::prelude::*;

create_exception!(
    bearing_watch,
    BearingWatchError,
    PyValueError,
    "Input that cannot be used: what is wrong, where, and what to do."
);

/// The exception of an error, with its text.
pub(crate) fn raised(error: Error) -> PyErr {
    let text = error.to_string();
    match error {
        Error::Io { source, .. } => match source.kind() {
            ErrorKind::NotFound => PyFileNotFoundError::new_err(text),
            ErrorKind::PermissionDenied => PyPermissionError::new_err(text),
            _ => PyOSError::new_err(text),
        },
        _ => refused(text),
    }
}

/// The exception of a problem.
pub(crate) fn refused(text: impl Into<String>) -> PyErr {
    BearingWatchError::new_err(text.into())
}
