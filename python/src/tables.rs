//! Tables in memory from mappings of arrays and from Arrow.

use std::sync::Arc;

use model::trace::{Cells, Recorded, Times};
use numpy::{PyReadonlyArray1, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use traces::reader;
use traces::table::from_first::{FromFirst, OF_DAY, POINTS, SPANS};

use crate::arrow;
use crate::errors::{raised, refused};

/// A table: an object with an Arrow stream, or a dictionary of columns, each an array of float64, a list of texts,
/// times (see [`times`]), or the name of the type of other cells.
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
    if let Some(found) = times(given) {
        return Ok(Cells::Times(found));
    }
    if let Ok(texts) = given.extract::<Vec<String>>() {
        return Ok(Cells::Texts(texts));
    }
    given.extract().map(Cells::Other)
}

/// Times as (kind, units a second, array of int64 in these units): points, spans, times of the day, or days; the
/// smallest number is a missing one, as in NumPy.
fn times(given: &Bound<'_, PyAny>) -> Option<Times> {
    let (kind, a_second, units): (String, f64, PyReadonlyArray1<'_, i64>) = given.extract().ok()?;
    let rank = match kind.as_str() {
        "points" => Some(POINTS),
        "spans" => Some(SPANS),
        "times of the day" => Some(OF_DAY),
        _ => None,
    };
    let units = units.as_array();
    let units = units.iter().map(|unit| (*unit != i64::MIN).then_some(i128::from(*unit)));
    Some(Times { seconds: FromFirst::default().seconds(units, a_second), rank })
}

/// Whether a column of this name is a time, as in files.
#[pyfunction]
pub(crate) fn is_time(name: &str) -> bool {
    reader::is_time(name)
}
