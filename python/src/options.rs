//! Keyword arguments as options of a command.

use std::path::PathBuf;

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyList, PyMapping, PySequence, PyString};
use workbench::call::{Call, Value};

use crate::tables::{table, tables};

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
    Ok(Call {
        drive,
        options: options.collect::<PyResult<_>>()?,
        traces: traces.map(tables).transpose()?,
        labels: labels.map(|labels| table("labels", labels)).transpose()?,
    })
}

fn value_of(key: &str, given: &Bound<'_, PyAny>) -> PyResult<Value> {
    if let Ok(flag) = given.cast::<PyBool>() {
        return Ok(Value::Flag(flag.is_true()));
    }
    if given.is_instance_of::<PyString>() {
        return given.extract().map(Value::One);
    }
    if let Ok(mapping) = given.cast::<PyMapping>() {
        let each = |pair: Bound<'_, PyAny>| {
            let (name, value): (String, Bound<'_, PyAny>) = pair.extract()?;
            Ok(format!("{name}={}", plain(key, &value)?))
        };
        return mapping.items()?.iter().map(each).collect::<PyResult<_>>().map(Value::Many);
    }
    if let Ok(list) = given.cast::<PySequence>() {
        return list.try_iter()?.map(|value| plain(key, &value?)).collect::<PyResult<_>>().map(Value::Many);
    }
    plain(key, given).map(Value::One)
}

/// A text, a path, or a number as text.
fn plain(key: &str, given: &Bound<'_, PyAny>) -> PyResult<String> {
    if let Ok(text) = given.extract::<String>() {
        return Ok(text);
    }
    if let Ok(whole) = given.extract::<i64>() {
        return Ok(whole.to_string());
    }
    if let Ok(number) = given.extract::<f64>() {
        return Ok(number.to_string());
    }
    if let Ok(path) = given.extract::<PathBuf>() {
        return Ok(path.to_string_lossy().into_owned());
    }
    let kind = given.get_type().name()?;
    Err(PyTypeError::new_err(format!("{key} takes a text, a number or a list of them, not {kind}")))
}
