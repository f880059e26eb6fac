//! Columns of doubles of a Parquet file that lack no value, read straight into their lists.

use std::collections::{HashMap, HashSet};
use std::fs::File;

use parquet::basic::Type;
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::DoubleType;
use parquet::errors::Result;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::schema::types::SchemaDescriptor;

use crate::table::arrow::parquet_pages;

/// Numbers for which memory is reserved at most.
const LARGEST_RESERVE: usize = 1 << 24;

/// Values that are read at a time.
const MANY: usize = 65_536;

/// Rows for which memory is reserved in each of some columns: the file's own count of rows may be wrong.
pub(super) fn reserved(rows: i64, columns: usize) -> usize {
    usize::try_from(rows).unwrap_or(0).min(LARGEST_RESERVE / columns.max(1))
}

/// Reads the columns at these places; `None` if one has other values, or lacks some.
pub(super) fn read(file: File, places: &[usize]) -> Result<Option<Vec<Vec<f64>>>> {
    let pages = file.try_clone()?;
    let reader = SerializedFileReader::new(file)?;
    let about = reader.metadata().file_metadata();
    let all = leaves(about.schema_descr());
    let leaves: Option<Vec<usize>> = places.iter().map(|place| all.get(place).copied().flatten()).collect();
    let Some(leaves) = leaves else { return Ok(None) };
    let wanted: HashSet<usize> = places.iter().copied().collect();
    parquet_pages::check(&pages, reader.metadata(), |place| wanted.contains(&place))?;
    let rows = reserved(about.num_rows(), places.len());
    let mut columns: Vec<Vec<f64>> = places.iter().map(|_| Vec::with_capacity(rows)).collect();
    for group in 0..reader.num_row_groups() {
        let group = reader.get_row_group(group)?;
        for (column, leaf) in columns.iter_mut().zip(&leaves) {
            let ColumnReader::DoubleColumnReader(reader) = group.get_column_reader(*leaf)? else { return Ok(None) };
            if !add(reader, column)? {
                return Ok(None);
            }
        }
    }
    Ok(Some(columns))
}

/// The column of the file that is all of each column of its table; none of one that is nested or has no doubles.
fn leaves(schema: &SchemaDescriptor) -> HashMap<usize, Option<usize>> {
    let mut found = HashMap::new();
    for leaf in 0..schema.num_columns() {
        let column = schema.column(leaf);
        let is_flat = column.path().parts().len() == 1 && column.max_rep_level() == 0;
        let own = (is_flat && column.physical_type() == Type::DOUBLE).then_some(leaf);
        // A second one makes it nested.
        found.entry(schema.get_column_root_idx(leaf)).and_modify(|first| *first = None).or_insert(own);
    }
    found
}

/// Adds the values of a part of a column; whether it lacks none.
fn add(mut reader: ColumnReaderImpl<DoubleType>, column: &mut Vec<f64>) -> Result<bool> {
    let mut levels = Vec::new();
    loop {
        levels.clear();
        match reader.read_records(MANY, Some(&mut levels), None, column)? {
            (0, ..) => return Ok(true),
            (records, values, _) if records != values => return Ok(false),
            _ => {}
        }
    }
}
