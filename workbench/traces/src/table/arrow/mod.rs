//! Parquet files and Arrow's files, of which only the wanted columns are read, and which are written.

mod blocks;
mod doubles;
pub mod parquet_pages;
mod values;

use std::fs::File;
use std::io::{BufReader, Read as _, Seek as _};
use std::path::Path;
use std::sync::Arc;

use arrow_array::cast::AsArray as _;
use arrow_array::types::Float64Type;
use arrow_array::{Array, ArrayRef, Float64Array, RecordBatch, RecordBatchReader};
use arrow_ipc::reader::{FileReader, StreamReader};
use arrow_ipc::writer::FileWriter;
use arrow_schema::{DataType, SchemaRef};
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::arrow::{ArrowWriter, ProjectionMask};
use rayon::prelude::*;

use model::trace::Recorded;

use crate::damaged::{DAMAGED, guarded};
use crate::table::columns::{About, Columns, Wanted};
use crate::table::from_first::{FromFirst, HEAD, TEXTS, are_dates};
use crate::table::limit::Limit;
use model::Error;
use values::{cells, numbers, rank, seconds, text_bytes, texts};

/// Rows of one batch.
const BATCH: usize = 65_536;
/// The first bytes of Arrow's file format, and of the first version of Feather.
const FILE: &[u8] = b"ARROW1";
const OLD: &[u8] = b"FEA1";
const NO_ROWS: &str = "no rows";
/// Bytes of the texts of one batch, if each is as long as a dictionary.
const LARGEST_BATCH: u64 = 64 << 20;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Parquet,
    Ipc,
}

fn wrong(path: &Path, kind: Kind) -> impl Fn(String) -> Error {
    let name = if kind == Kind::Parquet { "Parquet" } else { "an Arrow file" };
    move |problem| Error::content(path, "content", format!("not readable as {name}: {problem}"))
}

fn parquet(path: &Path) -> Result<ParquetRecordBatchReaderBuilder<File>, Error> {
    let file = File::open(path).map_err(Error::io(path))?;
    let wrong = wrong(path, Kind::Parquet);
    ParquetRecordBatchReaderBuilder::try_new(file).map_err(|error| wrong(error.to_string()))
}

/// Opens a file of Arrow's file format, or a stream of its messages.
fn ipc(path: &Path, columns: Option<Vec<usize>>) -> Result<Box<dyn RecordBatchReader>, Error> {
    let mut file = File::open(path).map_err(Error::io(path))?;
    let wrong = wrong(path, Kind::Ipc);
    let mut mark = Vec::new();
    file.by_ref().take(FILE.len() as u64).read_to_end(&mut mark).map_err(Error::io(path))?;
    if mark.starts_with(OLD) {
        return Err(wrong("it has version 1 of Feather; write it again with version 2".into()));
    }
    let is_file = mark == FILE;
    if is_file { blocks::check(&mut file) } else { blocks::check_stream(&mut file) }.map_err(&wrong)?;
    file.rewind().map_err(Error::io(path))?;
    let file = BufReader::new(file);
    let opened = if is_file {
        FileReader::try_new(file, columns).map(|reader| Box::new(reader) as Box<dyn RecordBatchReader>)
    } else {
        StreamReader::try_new(file, columns).map(|reader| Box::new(reader) as Box<dyn RecordBatchReader>)
    };
    opened.map_err(|error| wrong(error.to_string()))
}

/// Names of the columns.
pub(super) fn names(path: &Path, kind: Kind, about: &mut About) -> Result<Vec<String>, Error> {
    let schema = guarded(|| schema(path, kind)).unwrap_or_else(|| Err(wrong(path, kind)(DAMAGED.into())))?;
    let fields = || schema.fields().iter().enumerate();
    for (_, field) in fields().filter(|(_, field)| field.data_type().is_nested()) {
        let what = if is_list(field.data_type()) { "a signal in each cell" } else { "nested values" };
        let problem =
            format!("{what} ({}); write a file for each recording, with columns of numbers", field.data_type());
        about.omit(format!("column {}", field.name()), problem);
    }
    let words = fields().filter(|(_, field)| field.name() != "trace" && is_text(field.data_type()));
    let words: Vec<usize> = words.map(|(place, _)| place).collect();
    let dates = if words.is_empty() { vec![] } else { dates(path, kind, words)? };
    let dates = dates.into_iter().map(|place| (TEXTS, place));
    let times = fields().filter_map(|(place, field)| Some((rank(field.data_type())?, place)));
    let mut clocks: Vec<(u8, usize)> = times.chain(dates).collect();
    clocks.sort_unstable();
    about.clocks.extend(clocks.into_iter().map(|(_, place)| place));
    Ok(schema.fields().iter().map(|field| field.name().clone()).collect())
}

fn schema(path: &Path, kind: Kind) -> Result<SchemaRef, Error> {
    if kind == Kind::Ipc {
        return Ok(ipc(path, None)?.schema());
    }
    let builder = parquet(path)?;
    if builder.metadata().file_metadata().num_rows() == 0 {
        return Err(Error::content(path, "content", NO_ROWS));
    }
    Ok(builder.schema().clone())
}

fn is_list(kind: &DataType) -> bool {
    use DataType::{FixedSizeList, LargeList, LargeListView, List, ListView};
    matches!(kind, List(_) | LargeList(_) | FixedSizeList(..) | ListView(_) | LargeListView(_))
}

fn is_text(kind: &DataType) -> bool {
    match kind {
        DataType::Utf8 | DataType::LargeUtf8 | DataType::Utf8View => true,
        DataType::Dictionary(_, values) => is_text(values),
        _ => false,
    }
}

/// Which of these columns of texts begin with dates that have times.
fn dates(path: &Path, kind: Kind, places: Vec<usize>) -> Result<Vec<usize>, Error> {
    let first =
        guarded(|| opened(path, kind, (&places, usize::MAX), HEAD)?.1.next().transpose().map_err(wrong(path, kind)));
    // What is damaged is told where it is read.
    let Some(Ok(Some(batch))) = first else { return Ok(vec![]) };
    let head = batch.slice(0, batch.num_rows().min(HEAD));
    let mut limit = Limit::of_file(path)?;
    let mut is_date = |column: &dyn Array| {
        are_dates(&limit.claim(text_bytes(column)).ok().and_then(|()| texts(column)).unwrap_or_default())
    };
    Ok(places.into_iter().zip(head.columns()).filter(|(_, own)| is_date(own)).map(|(place, _)| place).collect())
}

/// Reads the wanted columns; those of a Parquet file, which are packed one by one, in parallel.
pub(super) fn read(
    file: (&Path, &[String]),
    kind: Kind,
    clocks: &[usize],
    wanted: Wanted<'_>,
) -> Result<Columns, Error> {
    let columns = if kind == Kind::Ipc || wanted.text.is_some() || wanted.numbers.len() < 2 {
        read_some(file, kind, clocks, wanted)?
    } else {
        let part = wanted.numbers.len().div_ceil(rayon::current_num_threads());
        let parts: Vec<&[usize]> = wanted.numbers.chunks(part).collect();
        let row = wanted.row;
        let some = |numbers| read_some(file, kind, clocks, Wanted { numbers, text: None, row });
        let parts: Vec<Result<Columns, Error>> = parts.into_par_iter().map(some).collect();
        let mut all = Columns::default();
        for part in parts {
            all.numbers.extend(part?.numbers);
        }
        all
    };
    if wanted.text.is_none() && columns.numbers.first().is_some_and(Vec::is_empty) {
        return Err(Error::content(file.0, "content", NO_ROWS));
    }
    Ok(columns)
}

fn read_some(file: (&Path, &[String]), kind: Kind, clocks: &[usize], wanted: Wanted<'_>) -> Result<Columns, Error> {
    guarded(|| batches(file, kind, clocks, wanted)).unwrap_or_else(|| Err(wrong(file.0, kind)(DAMAGED.into())))
}

/// The batches of these columns, in the order of the file, and the rows for which memory is reserved.
type Batches = (usize, Box<dyn Iterator<Item = Result<RecordBatch, String>>>);

/// Opens the columns at these places, `columns` in all, in batches of at most `rows` rows.
fn opened(path: &Path, kind: Kind, (places, columns): (&[usize], usize), rows: usize) -> Result<Batches, Error> {
    let wrong = wrong(path, kind);
    Ok(match kind {
        Kind::Parquet => {
            let builder = parquet(path)?;
            let file = File::open(path).map_err(Error::io(path))?;
            let wanted = |place: usize| places.binary_search(&place).is_ok();
            let largest = parquet_pages::check(&file, builder.metadata(), wanted);
            let largest = largest.map_err(|error| wrong(error.to_string()))?;
            let batch = (LARGEST_BATCH / largest.max(1)).clamp(1, rows as u64) as usize;
            let rows = doubles::reserved(builder.metadata().file_metadata().num_rows(), places.len());
            let mask = ProjectionMask::roots(builder.parquet_schema(), places.iter().copied());
            let reader = builder.with_projection(mask).with_batch_size(batch).build();
            let reader = reader.map_err(|error| wrong(error.to_string()))?;
            (rows, Box::new(reader.map(|batch| batch.map_err(|error| error.to_string()))))
        }
        Kind::Ipc => {
            let reader = ipc(path, (places.len() < columns).then(|| places.to_vec()))?;
            (0, Box::new(reader.map(|batch| batch.map_err(|error| error.to_string()))))
        }
    })
}

fn batches(
    (path, names): (&Path, &[String]),
    kind: Kind,
    clocks: &[usize],
    wanted: Wanted<'_>,
) -> Result<Columns, Error> {
    let wrong = wrong(path, kind);
    if kind == Kind::Parquet && wanted.text.is_none() {
        let file = File::open(path).map_err(Error::io(path))?;
        if let Some(numbers) = doubles::read(file, wanted.numbers).map_err(|error| wrong(error.to_string()))? {
            return Ok(Columns { numbers, ..Columns::default() });
        }
    }
    // Readers give each column once, in the order of the file.
    let mut places: Vec<usize> = wanted.numbers.iter().copied().chain(wanted.text).collect();
    places.sort_unstable();
    places.dedup();
    let (rows, batches) = opened(path, kind, (&places, names.len()), BATCH)?;
    let mut columns = Columns {
        numbers: wanted.numbers.iter().map(|_| Vec::with_capacity(rows)).collect(),
        texts: wanted.text.map(|_| Vec::new()),
        ..Columns::default()
    };
    let mut limit = Limit::of_file(path)?;
    let mut since = vec![FromFirst::default(); wanted.numbers.len()];
    let mut before = 0;
    for batch in batches {
        let batch = batch.map_err(&wrong)?;
        limit.claim_numbers([batch.num_rows() as u64, wanted.numbers.len() as u64]).map_err(&wrong)?;
        let own = |place: &usize| batch.column(places.binary_search(place).unwrap_or(0));
        let problem =
            |place: &usize, problem: String| Error::content(path, format!("column {}", names[*place]), problem);
        let kept = match wanted.text {
            Some(place) => {
                limit.claim(text_bytes(own(&place))).map_err(&wrong)?;
                let cells = texts(own(&place)).ok_or_else(|| problem(&place, "no text or whole numbers".into()))?;
                let kept: Vec<usize> = (0..cells.len()).filter(|row| (wanted.row)(&cells[*row])).collect();
                columns.texts.get_or_insert_default().extend(kept.iter().map(|row| cells[*row].clone()));
                Some(kept)
            }
            None => None,
        };
        for ((column, place), since) in columns.numbers.iter_mut().zip(wanted.numbers).zip(&mut since) {
            let array = own(place);
            if let (Some(plain), None) =
                (array.as_primitive_opt::<Float64Type>().filter(|_| array.null_count() == 0), &kept)
            {
                column.extend_from_slice(plain.values());
                continue;
            }
            let values = if clocks.contains(place) && is_text(array.data_type()) {
                limit.claim(text_bytes(array)).map_err(&wrong)?;
                let cells = texts(array).unwrap_or_default();
                since.of_texts(&cells).map_err(|(row, problem)| {
                    Error::content(path, format!("row {}, column {}", before + row + 1, names[*place]), problem)
                })?
            } else {
                let values = seconds(since, array).or_else(|| numbers(array));
                values.ok_or_else(|| problem(place, format!("no numbers but {}", array.data_type())))?
            };
            match &kept {
                Some(kept) => column.extend(kept.iter().map(|row| values[*row])),
                None => column.extend(values),
            }
        }
        before += batch.num_rows();
    }
    Ok(columns)
}

/// Writes a Parquet file.
pub(super) fn write_parquet(path: &Path, names: &[String], columns: &[Vec<f64>]) -> Result<(), Error> {
    let wrong = |problem: String| Error::content(path, "content", problem);
    let (file, batch) = (create(path)?, batch(names, columns).map_err(wrong)?);
    let mut writer = ArrowWriter::try_new(file, batch.schema(), None).map_err(|e| wrong(e.to_string()))?;
    writer.write(&batch).and_then(|()| writer.close()).map(|_| ()).map_err(|e| wrong(e.to_string()))
}

/// Writes a file of Arrow's format.
pub(super) fn write_ipc(path: &Path, names: &[String], columns: &[Vec<f64>]) -> Result<(), Error> {
    let wrong = |problem: String| Error::content(path, "content", problem);
    let (file, batch) = (create(path)?, batch(names, columns).map_err(wrong)?);
    let mut writer = FileWriter::try_new(file, &batch.schema()).map_err(|e| wrong(e.to_string()))?;
    writer.write(&batch).and_then(|()| writer.finish()).map_err(|e| wrong(e.to_string()))
}

/// Writes a stream.
#[cfg(test)]
pub(super) fn write_stream(path: &Path, names: &[String], columns: &[Vec<f64>]) {
    let (file, batch) = (create(path).expect("a file"), batch(names, columns).expect("a batch"));
    let writer = arrow_ipc::writer::StreamWriter::try_new(file, &batch.schema());
    writer.and_then(|mut writer| writer.write(&batch).and_then(|()| writer.finish())).expect("written");
}

fn create(path: &Path) -> Result<File, Error> {
    File::create(path).map_err(Error::io(path))
}

fn batch(names: &[String], columns: &[Vec<f64>]) -> Result<RecordBatch, String> {
    let array = |column: &Vec<f64>| Arc::new(Float64Array::from(column.clone())) as ArrayRef;
    RecordBatch::try_from_iter(names.iter().zip(columns.iter().map(array))).map_err(|error| error.to_string())
}

/// Makes a table of Arrow's record batches of one schema.
///
/// # Errors
/// Columns of different lengths.
pub fn of_batches(name: impl Into<String>, names: &[String], batches: &[RecordBatch]) -> Result<Recorded, Error> {
    let column = |place: usize| cells(batches.iter().map(|batch| batch.column(place).as_ref()));
    Recorded::new(name, names.iter().cloned().zip((0..names.len()).map(column)).collect())
}

#[cfg(test)]
mod tests {
    use arrow_array::types::Int32Type as Key;
    use arrow_array::{DictionaryArray, Int32Array, StringArray, StringViewArray};

    use super::values::TEXT;
    use super::*;
    use crate::table::Table;

    /// A long text that many rows name becomes as many texts.
    #[test]
    fn a_long_text_of_many_rows_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("t.arrow");
        let word = "x".repeat(1 << 20);
        let keys = Int32Array::from(vec![0; 1000]);
        let words = Arc::new(StringArray::from(vec![word.as_str()]));
        let dictionary = DictionaryArray::<Key>::new(keys, words);
        // A view of an array of two rows takes its text once.
        let two = StringViewArray::from(vec![word.as_str(), word.as_str()]);
        for (array, rows) in [(Arc::new(dictionary) as ArrayRef, 1000), (Arc::new(two), 2)] {
            assert_eq!(text_bytes(&array), rows * ((1 << 20) + TEXT));
            let batch = RecordBatch::try_from_iter([("trace", array)]).expect("one column");
            let mut writer =
                FileWriter::try_new(File::create(&path).expect("a file"), &batch.schema()).expect("writes");
            writer.write(&batch).and_then(|()| writer.finish()).expect("writes");
            let table = Table::open(&path).expect("a table");
            let texts = table.read(Wanted { numbers: &[], text: Some(0), row: &|_| false });
            match texts {
                Ok(_) => assert_eq!(rows, 2),
                Err(refused) => {
                    assert!(rows == 1000 && refused.to_string().contains("READ_LIMIT"), "{refused}");
                }
            }
        }
    }
}
