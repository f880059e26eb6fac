//! Tables in memory from mappings of arrays and from Arrow.

use std::sync::Arc;

use model::trace::{Cells, Recorded};
use numpy::{PyReadonlyArray1, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use crate::arrow;
use crate::errors::{raised, refused};

/// A table: an object with an Arrow stream, or a dictionary of columns, each an array of float64, a list of texts, or
/// the name of the type of other cells.
pub(crate) fn table(name: &str, given: &Bound<'_, PyAny>) -> PyResult<Arc<Recorded>> {
    let table = unchecked(name, given)?;
    let names: Vec<&str> = table.names().collect();
    match names.iter().enumerate().find(|(k, own)| names[..*k].contains(own)) {
        None => Ok(table),
        Some((_, twice)) => Err(refused(format!("{name}: two columns are named {twice}; rename or drop one"))),
    }
}

fn unchecked(name: &str, given: &Bound<'_, PyAny>) -> PyResult<Arc<Recorded>> {
    let Ok(columns) = given.cast::<PyDict>() else {
        return arrow::table(name, given);
    };
    let columns = columns.iter().map(|(name, cells)| Ok((name.extract::<String>()?, cells_of(&cells)?)));
    let columns = columns.collect::<PyResult<Vec<_>>>()?;
    Recorded::new(name, columns).map(Arc::new).map_err(raised)
}

/// Tables of a list of (name, table).
pub(crate) fn tables(given: &Bound<'_, PyList>) -> PyResult<Vec<Arc<Recorded>>> {
    let each = |pair: Bound<'_, PyAny>| {
        let (name, own): (String, Bound<'_, PyAny>) = pair.extract()?;
        table(&name, &own)
    };
    given.iter().map(each).collect()
}

fn cells_of(given: &Bound<'_, PyAny>) -> PyResult<Cells> {
    if let Ok(array) = given.extract::<PyReadonlyArray1<'_, f64>>() {
        return Ok(Cells::Numbers(array.as_array().to_vec()));
    }
    if let Ok(array) = given.cast::<PyUntypedArray>() {
        return Ok(Cells::Other(format!("an array of {} and {} dimensions", array.dtype(), array.ndim())));
    }
    if let Ok(texts) = given.extract::<Vec<String>>() {
        return Ok(Cells::Texts(texts));
    }
    given.extract().map(Cells::Other)
}
