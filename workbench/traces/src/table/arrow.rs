//! Parquet files and Arrow's files, of which only the wanted columns are read.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use arrow_array::cast::AsArray as _;
use arrow_array::types::{
    Float32Type, Float64Type, Int8Type, Int16Type, Int32Type, Int64Type, UInt8Type, UInt16Type, UInt32Type, UInt64Type,
};
use arrow_array::{Array, ArrowPrimitiveType, RecordBatch};
use arrow_ipc::reader::FileReader;
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use rayon::prelude::*;

use model::trace::{Cells, Recorded};

use crate::damaged::{DAMAGED, guarded};
use crate::table::about::About;
use crate::table::columns::{Columns, Wanted};
use crate::table::limit::{Limit, NUMBER};
use crate::table::{arrow_blocks, doubles, parquet_pages};
use model::Error;

/// Bytes of a text beside its letters.
const TEXT: u64 = 3 * NUMBER;
/// Rows of one batch.
const BATCH: usize = 65_536;
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

fn ipc(path: &Path, columns: Option<Vec<usize>>) -> Result<FileReader<BufReader<File>>, Error> {
    let mut file = File::open(path).map_err(Error::io(path))?;
    let wrong = wrong(path, Kind::Ipc);
    arrow_blocks::check(&mut file).map_err(&wrong)?;
    FileReader::try_new(BufReader::new(file), columns).map_err(|error| wrong(error.to_string()))
}

/// Names of the columns.
pub(super) fn names(path: &Path, kind: Kind, _about: &mut About) -> Result<Vec<String>, Error> {
    let open = || match kind {
        Kind::Parquet => Ok(parquet(path)?.schema().clone()),
        Kind::Ipc => Ok(ipc(path, None)?.schema()),
    };
    let schema = guarded(open).unwrap_or_else(|| Err(wrong(path, kind)(DAMAGED.into())))?;
    Ok(schema.fields().iter().map(|field| field.name().clone()).collect())
}

/// Reads the wanted columns; those of a Parquet file, which are packed one by one, in parallel.
pub(super) fn read(file: (&Path, &[String]), kind: Kind, wanted: Wanted<'_>) -> Result<Columns, Error> {
    if kind == Kind::Ipc || wanted.text.is_some() || wanted.numbers.len() < 2 {
        return read_some(file, kind, wanted);
    }
    let part = wanted.numbers.len().div_ceil(rayon::current_num_threads());
    let parts: Vec<&[usize]> = wanted.numbers.chunks(part).collect();
    let row = wanted.row;
    let parts = parts.into_par_iter().map(|numbers| read_some(file, kind, Wanted { numbers, text: None, row }));
    let parts: Vec<Result<Columns, Error>> = parts.collect();
    let mut all = Columns::default();
    for part in parts {
        all.numbers.extend(part?.numbers);
    }
    Ok(all)
}

fn read_some(file: (&Path, &[String]), kind: Kind, wanted: Wanted<'_>) -> Result<Columns, Error> {
    guarded(|| batches(file, kind, wanted)).unwrap_or_else(|| Err(wrong(file.0, kind)(DAMAGED.into())))
}

fn batches((path, names): (&Path, &[String]), kind: Kind, wanted: Wanted<'_>) -> Result<Columns, Error> {
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
    let (rows, batches): (usize, Box<dyn Iterator<Item = Result<RecordBatch, String>>>) = match kind {
        Kind::Parquet => {
            let builder = parquet(path)?;
            let file = File::open(path).map_err(Error::io(path))?;
            let wanted = |place: usize| places.binary_search(&place).is_ok();
            let largest = parquet_pages::check(&file, builder.metadata(), wanted);
            let largest = largest.map_err(|error| wrong(error.to_string()))?;
            let batch = (LARGEST_BATCH / largest.max(1)).clamp(1, BATCH as u64) as usize;
            let rows = doubles::reserved(builder.metadata().file_metadata().num_rows(), places.len());
            let mask = ProjectionMask::roots(builder.parquet_schema(), places.iter().copied());
            let reader = builder.with_projection(mask).with_batch_size(batch).build();
            let reader = reader.map_err(|error| wrong(error.to_string()))?;
            (rows, Box::new(reader.map(|batch| batch.map_err(|error| error.to_string()))))
        }
        Kind::Ipc => {
            let reader = ipc(path, Some(places.clone()))?;
            (0, Box::new(reader.map(|batch| batch.map_err(|error| error.to_string()))))
        }
    };
    let mut columns = Columns {
        numbers: wanted.numbers.iter().map(|_| Vec::with_capacity(rows)).collect(),
        texts: wanted.text.map(|_| Vec::new()),
        ..Columns::default()
    };
    let mut limit = Limit::of_file(path)?;
    for batch in batches {
        let batch = batch.map_err(&wrong)?;
        limit.claim_numbers([batch.num_rows() as u64, wanted.numbers.len() as u64]).map_err(&wrong)?;
        let own = |place: &usize| batch.column(places.iter().position(|other| other == place).unwrap_or(0));
        let no_numbers = |place: &usize| {
            Error::content(
                path,
                format!("column {}", names[*place]),
                format!("no numbers but {}", own(place).data_type()),
            )
        };
        let kept = match wanted.text {
            Some(place) => {
                limit.claim(text_bytes(own(&place))).map_err(&wrong)?;
                let cells = texts(own(&place)).ok_or_else(|| {
                    Error::content(path, format!("column {}", names[place]), "no text or whole numbers")
                })?;
                let kept: Vec<usize> = (0..cells.len()).filter(|row| (wanted.row)(&cells[*row])).collect();
                columns.texts.get_or_insert_default().extend(kept.iter().map(|row| cells[*row].clone()));
                Some(kept)
            }
            None => None,
        };
        for (column, place) in columns.numbers.iter_mut().zip(wanted.numbers) {
            let array = own(place);
            if let (Some(plain), None) =
                (array.as_primitive_opt::<Float64Type>().filter(|_| array.null_count() == 0), &kept)
            {
                column.extend_from_slice(plain.values());
                continue;
            }
            let values = numbers(array).ok_or_else(|| no_numbers(place))?;
            match &kept {
                Some(kept) => column.extend(kept.iter().map(|row| values[*row])),
                None => column.extend(values),
            }
        }
    }
    Ok(columns)
}

/// The numbers of an array, NaN for missing ones; `None` of an array without numbers.
fn numbers(array: &dyn Array) -> Option<Vec<f64>> {
    macro_rules! each {
        ($($kind:ty => $convert:expr),+) => {
            $(if let Some(array) = array.as_primitive_opt::<$kind>() {
                let values = array.values().iter().map($convert);
                return Some(with_missing(array, values.collect()));
            })+
        };
    }
    fn with_missing<T: ArrowPrimitiveType>(array: &arrow_array::PrimitiveArray<T>, mut values: Vec<f64>) -> Vec<f64> {
        if array.null_count() > 0 {
            (0..values.len()).filter(|row| array.is_null(*row)).for_each(|row| values[row] = f64::NAN);
        }
        values
    }
    each!(
        Float64Type => |x| *x, Float32Type => |x| f64::from(*x),
        Int8Type => |x| f64::from(*x), Int16Type => |x| f64::from(*x), Int32Type => |x| f64::from(*x),
        Int64Type => |x| *x as f64, UInt8Type => |x| f64::from(*x), UInt16Type => |x| f64::from(*x),
        UInt32Type => |x| f64::from(*x), UInt64Type => |x| *x as f64
    );
    let flags = array.as_boolean_opt()?;
    Some(flags.iter().map(|flag| flag.map_or(f64::NAN, |flag| f64::from(u8::from(flag)))).collect())
}

/// The cells of the chunks of a column.
pub(super) fn cells<'a>(chunks: impl Iterator<Item = &'a dyn Array> + Clone) -> Cells {
    let kind = chunks.clone().next().map_or_else(String::new, |array| array.data_type().to_string());
    if let Some(found) = chunks.clone().map(numbers).collect::<Option<Vec<_>>>() {
        return Cells::Numbers(found.concat());
    }
    chunks.map(texts).collect::<Option<Vec<_>>>().map_or(Cells::Other(kind), |found| Cells::Texts(found.concat()))
}

/// Bytes of the cells of a column of text: many may be the same long one of a dictionary, or of a list of views.
fn text_bytes(array: &dyn Array) -> u64 {
    let sum = |lengths: &mut dyn Iterator<Item = usize>| {
        lengths.fold(0_u64, |sum, length| sum.saturating_add(length as u64 + TEXT))
    };
    if let Some(array) = array.as_string_view_opt() {
        return sum(&mut array.lengths().map(|length| length as usize));
    }
    if let Some(array) = array.as_any_dictionary_opt() {
        let words = texts(array.values().as_ref()).unwrap_or_default();
        let length = |key: usize| words.get(key).map_or(0, String::len);
        return sum(&mut array.normalized_keys().into_iter().map(length));
    }
    // As long as what holds it.
    array.len() as u64 * TEXT
}

/// The cells of a column of text, also of a dictionary, or of whole numbers as text.
fn texts(array: &dyn Array) -> Option<Vec<String>> {
    let owned = |cell: Option<&str>| cell.unwrap_or_default().to_string();
    if let Some(array) = array.as_string_opt::<i32>() {
        return Some(array.iter().map(owned).collect());
    }
    if let Some(array) = array.as_string_opt::<i64>() {
        return Some(array.iter().map(owned).collect());
    }
    if let Some(array) = array.as_string_view_opt() {
        return Some(array.iter().map(owned).collect());
    }
    if let Some(array) = array.as_any_dictionary_opt() {
        let words = texts(array.values().as_ref())?;
        let keys = array.normalized_keys().into_iter().enumerate();
        return Some(
            keys.map(|(row, key)| if array.is_null(row) { String::new() } else { words[key].clone() }).collect(),
        );
    }
    let array = array.as_primitive_opt::<Int64Type>()?;
    Some(array.iter().map(|cell| cell.map_or_else(String::new, |number| number.to_string())).collect())
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
    use std::sync::Arc;

    use arrow_array::types::Int32Type as Key;
    use arrow_array::{ArrayRef, DictionaryArray, Int32Array, StringArray, StringViewArray};
    use arrow_ipc::writer::FileWriter;

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
