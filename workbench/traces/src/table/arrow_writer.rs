//! Columns of numbers to Parquet and to Arrow's file format.

use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use arrow_array::{ArrayRef, Float64Array, RecordBatch};
use arrow_ipc::writer::FileWriter;
use model::Error;
use parquet::arrow::ArrowWriter;

/// Writes a Parquet file.
pub(super) fn parquet(path: &Path, names: &[String], columns: &[Vec<f64>]) -> Result<(), Error> {
    let wrong = |problem: String| Error::content(path, "content", problem);
    let (file, batch) = (create(path)?, batch(names, columns).map_err(wrong)?);
    let mut writer = ArrowWriter::try_new(file, batch.schema(), None).map_err(|e| wrong(e.to_string()))?;
    writer.write(&batch).and_then(|()| writer.close()).map(|_| ()).map_err(|e| wrong(e.to_string()))
}

/// Writes a file of Arrow's format.
pub(super) fn ipc(path: &Path, names: &[String], columns: &[Vec<f64>]) -> Result<(), Error> {
    let wrong = |problem: String| Error::content(path, "content", problem);
    let (file, batch) = (create(path)?, batch(names, columns).map_err(wrong)?);
    let mut writer = FileWriter::try_new(file, &batch.schema()).map_err(|e| wrong(e.to_string()))?;
    writer.write(&batch).and_then(|()| writer.finish()).map_err(|e| wrong(e.to_string()))
}

fn create(path: &Path) -> Result<File, Error> {
    File::create(path).map_err(Error::io(path))
}

fn batch(names: &[String], columns: &[Vec<f64>]) -> Result<RecordBatch, String> {
    let array = |column: &Vec<f64>| Arc::new(Float64Array::from(column.clone())) as ArrayRef;
    RecordBatch::try_from_iter(names.iter().zip(columns.iter().map(array))).map_err(|error| error.to_string())
}
