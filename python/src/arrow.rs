//! Arrow's C data interface: streams of record batches come in as tables, and arrays go out as streams.

use std::sync::Arc;

use arrow_array::ffi_stream::{FFI_ArrowArrayStream, RecordBatchStreamReader};
use arrow_array::{ArrayRef, BooleanArray, Float32Array, Float64Array, Int64Array, RecordBatch, RecordBatchIterator};
use arrow_array::{RecordBatchReader, StringArray};
use model::trace::Recorded;
use numpy::PyReadonlyArray1;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyCapsule, PyDict};

use crate::errors::{raised, refused};

/// Name of the capsules of streams, by the interface.
const STREAM: &std::ffi::CStr = c"arrow_array_stream";

/// The table of an object with `__arrow_c_stream__`.
pub(crate) fn table(name: &str, given: &Bound<'_, PyAny>) -> PyResult<Arc<Recorded>> {
    if !given.hasattr("__arrow_c_stream__")? {
        let kind = given.get_type().name()?;
        return Err(PyTypeError::new_err(format!("{name} is a mapping of columns or an Arrow table, not {kind}")));
    }
    let capsule = given.call_method0("__arrow_c_stream__")?;
    let capsule = capsule.cast::<PyCapsule>()?;
    let stream = capsule.pointer_checked(Some(STREAM))?.cast::<FFI_ArrowArrayStream>();
    // SAFETY: a capsule of this name holds a stream of the interface; it is taken out of the capsule, which then has a
    // released one.
    let reader = unsafe { RecordBatchStreamReader::from_raw(stream.as_ptr()) };
    let unreadable = |error| refused(format!("{name}: not readable as an Arrow stream: {error}"));
    let reader = reader.map_err(unreadable)?;
    let names: Vec<String> = reader.schema().fields().iter().map(|field| field.name().clone()).collect();
    let batches = reader.collect::<Result<Vec<_>, _>>().map_err(unreadable)?;
    traces::table::of_batches(name, &names, &batches).map(Arc::new).map_err(raised)
}

/// A capsule with an Arrow stream of one batch: a dictionary of arrays of one dimension (float64, float32, int64 or
/// bool), and of lists of texts, None for missing ones.
#[pyfunction]
pub(crate) fn arrow_stream<'py>(py: Python<'py>, columns: &Bound<'py, PyDict>) -> PyResult<Bound<'py, PyCapsule>> {
    let each = |(name, cells): (Bound<'_, PyAny>, Bound<'_, PyAny>)| Ok((name.extract::<String>()?, array(&cells)?));
    let columns = columns.iter().map(each).collect::<PyResult<Vec<_>>>()?;
    let nullable = columns.into_iter().map(|(name, array)| (name, array, true));
    let batch = RecordBatch::try_from_iter_with_nullable(nullable).map_err(|error| refused(error.to_string()))?;
    let schema = batch.schema();
    let reader = RecordBatchIterator::new([Ok(batch)], schema);
    PyCapsule::new_with_value(py, FFI_ArrowArrayStream::new(Box::new(reader)), STREAM)
}

fn array(cells: &Bound<'_, PyAny>) -> PyResult<ArrayRef> {
    if let Ok(own) = cells.extract::<PyReadonlyArray1<'_, f64>>() {
        return Ok(Arc::new(Float64Array::from_iter_values(own.as_array().iter().copied())));
    }
    if let Ok(own) = cells.extract::<PyReadonlyArray1<'_, f32>>() {
        return Ok(Arc::new(Float32Array::from_iter_values(own.as_array().iter().copied())));
    }
    if let Ok(own) = cells.extract::<PyReadonlyArray1<'_, i64>>() {
        return Ok(Arc::new(Int64Array::from_iter_values(own.as_array().iter().copied())));
    }
    if let Ok(own) = cells.extract::<PyReadonlyArray1<'_, bool>>() {
        return Ok(Arc::new(BooleanArray::from_iter(own.as_array().iter().map(|flag| Some(*flag)))));
    }
    let texts: Vec<Option<String>> = cells.extract()?;
    Ok(Arc::new(StringArray::from(texts)))
}
