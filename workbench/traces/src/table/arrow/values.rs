//! The values of Arrow's arrays: numbers, texts, and times as seconds from the first one.

use arrow_array::cast::AsArray as _;
use arrow_array::types::{
    Date32Type, Date64Type, Decimal32Type, Decimal64Type, Decimal128Type, Decimal256Type, DecimalType,
    DurationMicrosecondType, DurationMillisecondType, DurationNanosecondType, DurationSecondType, Float16Type,
    Float32Type, Float64Type, Int8Type, Int16Type, Int32Type, Int64Type, Time32MillisecondType, Time32SecondType,
    Time64MicrosecondType, Time64NanosecondType, TimestampMicrosecondType, TimestampMillisecondType,
    TimestampNanosecondType, TimestampSecondType, UInt8Type, UInt16Type, UInt32Type, UInt64Type,
};
use arrow_array::{Array, ArrowPrimitiveType, PrimitiveArray};
use arrow_schema::DataType;

use model::trace::{Cells, Times};

use crate::table::from_first::{DATES, FromFirst, OF_DAY, POINTS, SPANS};
use crate::table::limit::NUMBER;

/// Bytes of a text beside its letters.
pub(super) const TEXT: u64 = 3 * NUMBER;

/// The numbers of an array, NaN for missing ones; `None` of an array without numbers.
pub(super) fn numbers(array: &dyn Array) -> Option<Vec<f64>> {
    macro_rules! each {
        ($($kind:ty => $convert:expr),+) => {
            $(if let Some(array) = array.as_primitive_opt::<$kind>() {
                let values = array.values().iter().map($convert);
                return Some(with_missing(array, values.collect()));
            })+
        };
    }
    macro_rules! decimals {
        ($($kind:ty => $whole:expr),+) => {
            $(if let Some(array) = array.as_primitive_opt::<$kind>() {
                return decimals(array, $whole);
            })+
        };
    }
    each!(
        Float64Type => |x| *x, Float32Type => |x| f64::from(*x), Float16Type => |x| x.to_f64(),
        Int8Type => |x| f64::from(*x), Int16Type => |x| f64::from(*x), Int32Type => |x| f64::from(*x),
        Int64Type => |x| *x as f64, UInt8Type => |x| f64::from(*x), UInt16Type => |x| f64::from(*x),
        UInt32Type => |x| f64::from(*x), UInt64Type => |x| *x as f64
    );
    decimals!(
        Decimal32Type => |x| Some(i128::from(x)), Decimal64Type => |x| Some(i128::from(x)), Decimal128Type => Some,
        Decimal256Type => |x| x.to_i128()
    );
    if let Some(array) = array.as_any_dictionary_opt() {
        let values = numbers(array.values().as_ref())?;
        let value = |(row, key): (usize, usize)| {
            if array.is_null(row) { f64::NAN } else { values.get(key).copied().unwrap_or(f64::NAN) }
        };
        return Some(keys(array).into_iter().enumerate().map(value).collect());
    }
    let flags = array.as_boolean_opt()?;
    Some(flags.iter().map(|flag| flag.map_or(f64::NAN, |flag| f64::from(u8::from(flag)))).collect())
}

fn with_missing<T: ArrowPrimitiveType>(array: &PrimitiveArray<T>, mut values: Vec<f64>) -> Vec<f64> {
    if array.null_count() > 0 {
        (0..values.len()).filter(|row| array.is_null(*row)).for_each(|row| values[row] = f64::NAN);
    }
    values
}

/// The keys of a dictionary, which may be empty.
fn keys(array: &dyn arrow_array::array::AnyDictionaryArray) -> Vec<usize> {
    if array.values().is_empty() { vec![0; array.len()] } else { array.normalized_keys() }
}

/// Decimal numbers, each the double next to it.
fn decimals<T: DecimalType>(array: &PrimitiveArray<T>, whole: impl Fn(T::Native) -> Option<i128>) -> Option<Vec<f64>> {
    /// The largest power of ten that is a double.
    const EXACT: i8 = 22;
    /// Whole numbers below are doubles.
    const WHOLE: u128 = 1 << 53;
    let scale = array.scale();
    let power = (0..=EXACT).contains(&scale).then(|| 10_f64.powi(i32::from(scale)));
    let value = |row| {
        if array.is_null(row) {
            return Some(f64::NAN);
        }
        // The quotient of two doubles is rounded once; other numbers are read as text.
        let whole = whole(array.value(row)).filter(|whole| whole.unsigned_abs() < WHOLE);
        match whole.zip(power) {
            Some((whole, power)) => Some(whole as f64 / power),
            None => array.value_as_string(row).parse().ok(),
        }
    };
    (0..array.len()).map(value).collect()
}

/// Whether values of this type are points or spans of time, and how well they serve as the time of rows: the smallest
/// is the best. A day is no time of a row.
pub(super) fn rank(kind: &DataType) -> Option<u8> {
    match kind {
        DataType::Timestamp(..) => Some(POINTS),
        DataType::Time32(_) | DataType::Time64(_) => Some(OF_DAY),
        DataType::Duration(_) => Some(SPANS),
        DataType::Date64 => Some(DATES),
        _ => None,
    }
}

/// The seconds of an array of times, NaN for missing ones; `None` of one of other values.
pub(super) fn seconds(since: &mut FromFirst, array: &dyn Array) -> Option<Vec<f64>> {
    macro_rules! each {
        ($($kind:ty => $a_second:expr, $units:expr),+) => {
            $(if let Some(array) = array.as_primitive_opt::<$kind>() {
                let times = array.iter().map(|time| time.map(|time| i128::from(time) * $units));
                return Some(since.seconds(times, $a_second));
            })+
        };
    }
    each!(
        TimestampSecondType => 1.0, 1, TimestampMillisecondType => 1e3, 1, TimestampMicrosecondType => 1e6, 1,
        TimestampNanosecondType => 1e9, 1, DurationSecondType => 1.0, 1, DurationMillisecondType => 1e3, 1,
        DurationMicrosecondType => 1e6, 1, DurationNanosecondType => 1e9, 1, Time32SecondType => 1.0, 1,
        Time32MillisecondType => 1e3, 1, Time64MicrosecondType => 1e6, 1, Time64NanosecondType => 1e9, 1,
        Date32Type => 1.0, 86_400, Date64Type => 1e3, 1
    );
    None
}

/// The cells of the chunks of a column.
pub(super) fn cells<'a>(chunks: impl Iterator<Item = &'a dyn Array> + Clone) -> Cells {
    let first = chunks.clone().next().map(|array| array.data_type().clone());
    let mut since = FromFirst::default();
    if let Some(kind) = &first
        && let Some(found) = chunks.clone().map(|array| seconds(&mut since, array)).collect::<Option<Vec<_>>>()
    {
        return Cells::Times(Times { seconds: found.concat(), rank: rank(kind) });
    }
    let kind = first.map_or_else(String::new, |kind| kind.to_string());
    if let Some(found) = chunks.clone().map(numbers).collect::<Option<Vec<_>>>() {
        return Cells::Numbers(found.concat());
    }
    chunks.map(texts).collect::<Option<Vec<_>>>().map_or(Cells::Other(kind), |found| Cells::Texts(found.concat()))
}

/// Bytes of the cells of a column of text: many may be the same long one of a dictionary, or of a list of views.
pub(super) fn text_bytes(array: &dyn Array) -> u64 {
    let sum = |lengths: &mut dyn Iterator<Item = usize>| {
        lengths.fold(0_u64, |sum, length| sum.saturating_add(length as u64 + TEXT))
    };
    if let Some(array) = array.as_string_view_opt() {
        return sum(&mut array.lengths().map(|length| length as usize));
    }
    if let Some(array) = array.as_any_dictionary_opt() {
        let words = texts(array.values().as_ref()).unwrap_or_default();
        let length = |key: usize| words.get(key).map_or(0, String::len);
        return sum(&mut keys(array).into_iter().map(length));
    }
    // As long as what holds it.
    array.len() as u64 * TEXT
}

/// The cells of a column of text, also of a dictionary, or of whole numbers as text.
pub(super) fn texts(array: &dyn Array) -> Option<Vec<String>> {
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
        let word = |(row, key): (usize, usize)| {
            if array.is_null(row) { String::new() } else { words.get(key).cloned().unwrap_or_default() }
        };
        return Some(keys(array).into_iter().enumerate().map(word).collect());
    }
    let array = array.as_primitive_opt::<Int64Type>()?;
    Some(array.iter().map(|cell| cell.map_or_else(String::new, |number| number.to_string())).collect())
}

#[cfg(test)]
mod tests {
    use std::fs::File;
    use std::path::Path;
    use std::sync::Arc;

    use arrow_array::builder::ListBuilder;
    use arrow_array::types::Int8Type as Key;
    use arrow_array::{
        ArrayRef, BooleanArray, DictionaryArray, Float64Array, Int8Array, LargeStringArray, RecordBatch, StringArray,
        StringViewArray,
    };
    use arrow_ipc::writer::{FileWriter, StreamWriter};
    use parquet::arrow::ArrowWriter;

    use super::*;
    use crate::table::{Table, Wanted};

    /// Writes batches of these columns in each of the formats.
    fn written(folder: &Path, batch: &RecordBatch) -> Vec<std::path::PathBuf> {
        let paths = ["t.parquet", "t.arrow", "t.arrows", "stream.arrow"].map(|name| folder.join(name));
        let create = |k: usize| File::create(&paths[k]).expect("a file");
        let schema = batch.schema();
        let halves =
            [batch.slice(0, batch.num_rows() / 2), batch.slice(batch.num_rows() / 2, batch.num_rows().div_ceil(2))];
        let mut writer = ArrowWriter::try_new(create(0), schema.clone(), None).expect("a schema");
        halves.iter().try_for_each(|half| writer.write(half).and_then(|()| writer.flush())).expect("written");
        writer.close().expect("written");
        let mut writer = FileWriter::try_new(create(1), &schema).expect("a schema");
        halves.iter().try_for_each(|half| writer.write(half)).and_then(|()| writer.finish()).expect("written");
        for k in [2, 3] {
            let mut writer = StreamWriter::try_new(create(k), &schema).expect("a schema");
            halves.iter().try_for_each(|half| writer.write(half)).and_then(|()| writer.finish()).expect("written");
        }
        paths.to_vec()
    }

    fn column(table: &Table, name: &str) -> Result<Vec<f64>, String> {
        let place = table.names().iter().position(|own| own == name).ok_or("no such column")?;
        let read = table.read(Wanted { numbers: &[place], text: None, row: &|_| true });
        read.map(|mut read| read.numbers.remove(0)).map_err(|error| error.to_string())
    }

    fn batch(columns: Vec<(&str, ArrayRef)>) -> RecordBatch {
        RecordBatch::try_from_iter_with_nullable(columns.into_iter().map(|(name, array)| (name, array, true)))
            .expect("equal lengths")
    }

    #[test]
    fn times_are_seconds_from_the_first_row_in_every_format() {
        let folder = tempfile::tempdir().expect("a folder");
        let day = 1_795_651_200_i64;
        macro_rules! times {
            ($kind:ty, $units:expr) => {
                Arc::new(PrimitiveArray::<$kind>::from(vec![Some($units), None, Some($units + 1), Some($units + 5)]))
            };
        }
        let zone = times!(TimestampMicrosecondType, day * 1_000_000).as_ref().clone().with_timezone("Europe/Berlin");
        let text = |parts: [&'static str; 4]| parts.map(|part| format!("2026-11-26 00:00:0{part}")).to_vec();
        let columns: Vec<(&str, ArrayRef, f64)> = vec![
            ("day", times!(Date32Type, 20_000), 86_400.0),
            ("elapsed", times!(DurationNanosecondType, 5), 1e-9),
            ("clock", times!(Time64MicrosecondType, 5), 1e-6),
            ("clock_ms", times!(Time32MillisecondType, 5), 1e-3),
            ("zone", Arc::new(zone), 1e-6),
            ("s", times!(TimestampSecondType, day), 1.0),
            ("ms", times!(TimestampMillisecondType, day * 1000), 1e-3),
            ("ns", times!(TimestampNanosecondType, day * 1_000_000_000), 1e-9),
            ("date_ms", times!(Date64Type, day * 1000), 1e-3),
        ];
        let mut all: Vec<(&str, ArrayRef)> = columns.iter().map(|(name, own, _)| (*name, own.clone())).collect();
        let iso: ArrayRef = Arc::new(LargeStringArray::from(text(["0", "0.5", "1", "2.25"])));
        let view: ArrayRef = Arc::new(StringViewArray::from(text(["0Z", "0.000000001Z", "1Z", "2Z"])));
        all.extend([("iso", iso), ("view", view)]);
        for path in written(folder.path(), &batch(all)) {
            let table = Table::open(&path).expect("a table");
            let clocks: Vec<&str> = table.about().clocks.iter().map(|place| table.names()[*place].as_str()).collect();
            // The best time is the first one; a day is none.
            assert_eq!(clocks, ["zone", "s", "ms", "ns", "iso", "view", "clock", "clock_ms", "elapsed", "date_ms"]);
            for (name, _, unit) in &columns {
                let found = column(&table, name).expect(name);
                let expected = [0.0, f64::NAN, *unit, 5.0 * unit];
                let is_same = |(a, b): (&f64, &f64)| (a.is_nan() && b.is_nan()) || (a - b).abs() <= 1e-15 * b.abs();
                assert!(found.len() == 4 && found.iter().zip(&expected).all(is_same), "{name}: {found:?}");
            }
            assert_eq!(column(&table, "iso"), Ok(vec![0.0, 0.5, 1.0, 2.25]));
            assert_eq!(column(&table, "view"), Ok(vec![0.0, 1e-9, 1.0, 2.0]));
        }
    }

    #[test]
    fn numbers_of_every_type_are_doubles_and_nested_ones_are_named() {
        let folder = tempfile::tempdir().expect("a folder");
        let half = PrimitiveArray::<Float16Type>::from_iter_values(
            [0.5_f32, -2.0, 65_504.0].map(<Float16Type as ArrowPrimitiveType>::Native::from_f32),
        );
        let decimal = PrimitiveArray::<Decimal128Type>::from(vec![Some(123), None, Some(10_i128.pow(16) + 1)]);
        let wide = PrimitiveArray::<Decimal256Type>::from_iter_values(
            [1, 2, -3].map(<Decimal256Type as ArrowPrimitiveType>::Native::from_i128),
        );
        let keys = Int8Array::from(vec![Some(1), None, Some(0)]);
        let numbers = DictionaryArray::<Key>::new(keys.clone(), Arc::new(Float64Array::from(vec![1.5, 2.5])));
        let words = DictionaryArray::<Key>::new(keys, Arc::new(StringArray::from(vec!["b", "a"])));
        let mut lists = ListBuilder::new(arrow_array::builder::Float64Builder::new());
        (0..3).for_each(|k| lists.append_value([Some(f64::from(k))]));
        let columns: Vec<(&str, ArrayRef)> = vec![
            ("trace", Arc::new(words)),
            ("half", Arc::new(half)),
            ("double", Arc::new(Float64Array::from(vec![Some(0.5), None, Some(2.0)]))),
            ("whole", Arc::new(Int8Array::from(vec![Some(1), Some(-2), None]))),
            ("decimal", Arc::new(decimal.with_precision_and_scale(30, 2).expect("fits"))),
            ("wide", Arc::new(wide.with_precision_and_scale(60, 1).expect("fits"))),
            ("numbers", Arc::new(numbers)),
            ("flags", Arc::new(BooleanArray::from(vec![true, false, true]))),
            ("lists", Arc::new(lists.finish())),
        ];
        for path in written(folder.path(), &batch(columns)) {
            let table = Table::open(&path).expect("a table");
            let cells = |name: &str| format!("{:?}", column(&table, name).expect(name));
            assert_eq!(cells("half"), "[0.5, -2.0, 65504.0]");
            assert_eq!((cells("double"), cells("whole")), ("[0.5, NaN, 2.0]".into(), "[1.0, -2.0, NaN]".into()));
            assert_eq!(cells("decimal"), "[1.23, NaN, 100000000000000.02]");
            assert_eq!(cells("wide"), "[0.1, 0.2, -0.3]");
            assert_eq!(cells("numbers"), "[2.5, NaN, 1.5]");
            assert_eq!(cells("flags"), "[1.0, 0.0, 1.0]");
            assert!(column(&table, "lists").expect_err("lists").contains("no numbers but List"));
            let omitted = &table.about().omitted;
            assert!(omitted.len() == 1 && omitted[0].place == "column lists", "{omitted:?}");
            assert_eq!(table.about().clocks, [0; 0]);
            let texts = table.read(Wanted { numbers: &[1], text: Some(0), row: &|cell| cell == "a" }).expect("texts");
            assert_eq!((texts.numbers, texts.texts), (vec![vec![0.5]], Some(vec!["a".into()])));
        }
    }

    #[test]
    fn no_rows_and_texts_among_dates_are_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let empty: ArrayRef = Arc::new(Float64Array::from(Vec::<f64>::new()));
        for path in written(folder.path(), &batch(vec![("i", empty)])) {
            let refused = Table::open(&path).map_err(|error| error.to_string()).and_then(|table| column(&table, "i"));
            assert!(refused.expect_err("no rows").ends_with("content: no rows"), "{}", path.display());
        }
        let mut dates = vec!["2026-11-26 00:00:00"; 100];
        dates[90] = "later";
        let dates: ArrayRef = Arc::new(StringArray::from(dates));
        for path in written(folder.path(), &batch(vec![("when", dates)])) {
            let refused = column(&Table::open(&path).expect("a table"), "when").expect_err("a word");
            assert!(refused.contains("row 91, column when: \"later\" is no date with a time"), "{refused}");
        }
    }
}
