//! Parts: Parquet files with one row a segment.
//!
//! ```text
//! trace, segment, class_name, unit, run     text, but the segment's number in its trace
//! usable                                    part of the segment's samples that was used
//! NAME, NAME_variance                       each feature, missing = null; variance of its error, of friction alone
//! further columns                           the labels, as text
//! ```
//!
//! The metadata has the plan ([`Plan`], key `bearing_watch_plan`), and `bearing_watch_sorted = unit` if the units
//! ascend. Row groups are written as they fill. Of a part that another program has written again, without metadata,
//! the plan is in a file beside it, and the order of the units is looked at. A column may also be a key in the names of
//! the folders (`plan_files`).

use std::fs::File;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use arrow_array::cast::AsArray as _;
use arrow_array::types::{Float32Type, Float64Type, Int32Type};
use arrow_array::{Array, ArrayRef, DictionaryArray};
use arrow_schema::{ArrowError, DataType, Field, Schema};
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::{ArrowReaderMetadata, ArrowReaderOptions, ParquetRecordBatchReaderBuilder};
use parquet::file::statistics::Statistics;

use super::Plan;
use super::double::LARGEST;
use super::plan_files::{keys, plan_beside};
use model::Error;
use model::near::among;
use model::trace::Condition;
use traces::damaged::{DAMAGED, guarded};
use traces::table::parquet_pages;

/// Key of the plan in the metadata.
pub(super) const PLAN: &str = "bearing_watch_plan";
/// Key that tells whether the units ascend.
pub(super) const SORTED: &str = "bearing_watch_sorted";
/// Columns of text that every part has, in their order.
pub(super) const TEXTS: [&str; 4] = ["trace", "class_name", "unit", "run"];
/// Names that no column of the labels can have.
pub const RESERVED: [&str; 6] = ["trace", "segment", "class_name", "unit", "run", "usable"];
/// Rows of a batch that is read.
const BATCH: usize = 8192;
/// What is said of a file without a plan.
const NO_PLAN: &str = "no table of features with their plan; write it with `bearing-watch features`. If another program \
                       has written a part again, its metadata with the plan is lost: put the file NAME.plan.json, \
                       which `features` wrote beside the part, beside this one, or as plan.json into its folder";

/// Name of the column with the variances of a feature's errors.
pub(super) fn variance_of(name: &str) -> String {
    format!("{name}_variance")
}

/// A part whose rows are not yet read.
#[derive(Debug)]
pub struct Part {
    /// The file.
    pub path: PathBuf,
    /// Its plan.
    pub plan: Plan,
    /// Whether its units ascend.
    pub sorted: bool,
    /// Columns that are keys in the names of its folders.
    keys: Vec<(String, String)>,
    metadata: ArrowReaderMetadata,
}

/// What is read of a part.
#[derive(Clone, Debug, Default)]
pub struct Wanted {
    /// Names of the features.
    pub features: Vec<String>,
    /// Conditions on columns of text.
    pub conditions: Vec<Condition>,
}

/// Some rows of a part.
#[derive(Debug)]
pub struct Batch {
    texts: Vec<DictionaryArray<Int32Type>>,
    /// Rows of features, one after the other; NaN if missing.
    values: Vec<f64>,
    /// Variances of their errors.
    variances: Vec<f64>,
    features: usize,
    /// Whether each row is wanted.
    kept: Vec<bool>,
}

impl Part {
    /// Opens a part.
    ///
    /// # Errors
    /// A file that cannot be read, is no part, or is one of another version.
    pub fn open(path: &Path) -> Result<Self, Error> {
        let damaged = || Err(Error::content(path, "content", DAMAGED));
        guarded(|| Self::opened(path)).unwrap_or_else(damaged)
    }

    fn opened(path: &Path) -> Result<Self, Error> {
        let wrong = |problem: String| Error::content(path, "content", problem);
        let file = File::open(path).map_err(Error::io(path))?;
        let unreadable = |error: parquet::errors::ParquetError| wrong(format!("not readable as Parquet: {error}"));
        let plain = ArrowReaderMetadata::load(&file, ArrowReaderOptions::new()).map_err(unreadable)?;
        let pairs = plain.metadata().file_metadata().key_value_metadata();
        let value = |key: &str| pairs?.iter().find(|pair| pair.key == key)?.value.clone();
        let in_file = value(PLAN);
        let is_in_file = in_file.is_some();
        let plan = match in_file {
            Some(plan) => Plan::parse(&plan).map_err(wrong)?,
            None => plan_beside(path)?.ok_or_else(|| wrong(NO_PLAN.into()))?,
        };
        // Texts as dictionaries, whoever wrote them.
        let as_dictionary = |field: &Arc<Field>| {
            if !is_text(field.data_type()) {
                return field.clone();
            }
            let kind = DataType::Dictionary(Box::new(DataType::Int32), Box::new(DataType::Utf8));
            Arc::new(Field::new(field.name(), kind, field.is_nullable()))
        };
        let schema = Arc::new(Schema::new(plain.schema().fields().iter().map(as_dictionary).collect::<Vec<_>>()));
        let options = ArrowReaderOptions::new().with_schema(schema);
        let metadata = ArrowReaderMetadata::try_new(plain.metadata().clone(), options).map_err(unreadable)?;
        parquet_pages::check(&file, metadata.metadata(), |_| true).map_err(unreadable)?;
        let sorted = value(SORTED).as_deref() == Some("unit");
        let mut part = Self { path: path.to_path_buf(), plan, sorted, keys: keys(path), metadata };
        if !is_in_file {
            part.sorted = part.ascends()?;
        }
        Ok(part)
    }

    /// Whether the units ascend, by reading them.
    fn ascends(&self) -> Result<bool, Error> {
        let wanted = Wanted::default();
        let mut last: Option<String> = None;
        for group in 0..self.row_groups() {
            for batch in self.read(group, &wanted)? {
                let batch = batch?;
                for rows in batch.stretches() {
                    let [_, unit, _] = batch.texts(rows.start);
                    match &last {
                        Some(last) if last.as_str() > unit => return Ok(false),
                        Some(last) if last == unit => {}
                        _ => last = Some(unit.into()),
                    }
                }
            }
        }
        Ok(true)
    }

    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> u64 {
        u64::try_from(self.metadata.metadata().file_metadata().num_rows()).unwrap_or(0)
    }

    /// Names of the columns.
    #[must_use]
    pub fn columns(&self) -> Vec<&str> {
        self.metadata.schema().fields().iter().map(|field| field.name().as_str()).collect()
    }

    /// Where the cells of a column of text are.
    fn text(&self, name: &str) -> Result<Text<'_>, Error> {
        let key = || self.keys.iter().find(|(key, _)| key == name).map(|(_, value)| Text::Key(value));
        match self.place(name) {
            Ok(place) => Ok(Text::Column(place)),
            Err(missing) => key().ok_or(missing),
        }
    }

    fn place(&self, name: &str) -> Result<usize, Error> {
        let found = self.metadata.schema().fields().iter().position(|field| field.name() == name);
        found.ok_or_else(|| {
            let problem = format!("no column {name}{}", among(name, &self.columns()));
            Error::content(&self.path, "header", problem)
        })
    }

    /// Number of row groups.
    #[must_use]
    pub fn row_groups(&self) -> usize {
        self.metadata.metadata().num_row_groups()
    }

    /// Returns the rows of a row group, with bounds of its units in their order; `None` if the file does not tell them.
    #[must_use]
    pub fn bounds(&self, group: usize) -> (u64, Option<[String; 2]>) {
        let own = self.metadata.metadata().row_group(group);
        let rows = u64::try_from(own.num_rows()).unwrap_or(0);
        if let Ok(Text::Key(unit)) = self.text("unit") {
            return (rows, Some([unit.into(), unit.into()]));
        }
        let column = own.columns().iter().find(|column| column.column_path().string() == "unit");
        let bounds = column.and_then(|column| match column.statistics()? {
            Statistics::ByteArray(values) => {
                let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).ok();
                Some([text(values.min_bytes_opt()?)?, text(values.max_bytes_opt()?)?])
            }
            _ => None,
        });
        (rows, bounds)
    }

    /// Reads a row group in batches.
    ///
    /// # Errors
    /// A missing column, or a file that is damaged.
    pub fn read<'a>(
        &'a self,
        group: usize,
        wanted: &'a Wanted,
    ) -> Result<impl Iterator<Item = Result<Batch, Error>> + 'a, Error> {
        let wrong = move |problem: String| Error::content(&self.path, format!("row group {group}"), problem);
        let errors = wanted.features.iter().map(|name| self.place(&variance_of(name)).ok());
        let errors: Vec<Option<usize>> = errors.collect();
        let numbers = wanted.features.iter().map(|name| self.place(name)).collect::<Result<Vec<_>, _>>()?;
        let texts = TEXTS[1..].iter().map(|name| self.text(name)).collect::<Result<Vec<_>, _>>()?;
        let conditions: Vec<Text<'_>> =
            wanted.conditions.iter().map(|own| self.text(own.column())).collect::<Result<_, _>>()?;
        let of_texts = texts.iter().chain(&conditions).filter_map(Text::place);
        let mut places: Vec<usize> = numbers.iter().chain(errors.iter().flatten()).copied().chain(of_texts).collect();
        places.sort_unstable();
        places.dedup();
        let file = File::open(&self.path).map_err(Error::io(&self.path))?;
        let builder = ParquetRecordBatchReaderBuilder::new_with_metadata(file, self.metadata.clone());
        let mask = ProjectionMask::roots(builder.parquet_schema(), places.iter().copied());
        let reader = builder.with_row_groups(vec![group]).with_projection(mask).with_batch_size(BATCH).build();
        let mut reader = reader.map_err(|error| wrong(error.to_string()))?;
        let mut damaged = false;
        let batches = std::iter::from_fn(move || {
            if damaged {
                return None;
            }
            let batch = guarded(|| reader.next());
            damaged = batch.is_none();
            batch.unwrap_or_else(|| Some(Err(ArrowError::ParquetError(DAMAGED.into()))))
        });
        let at = move |place: usize| places.binary_search(&place).unwrap_or(0);
        Ok(batches.map(move |batch| {
            let batch = batch.map_err(|error| wrong(error.to_string()))?;
            let rows = batch.num_rows();
            let text = |text: Text<'_>| {
                let place = match text {
                    Text::Column(place) => place,
                    Text::Key(value) => return Ok(std::iter::repeat_n(value, rows).collect()),
                };
                let column = batch.column(at(place)).as_dictionary_opt::<Int32Type>().cloned();
                let problem = |what: &str| wrong(format!("column {} {what}", self.columns()[place]));
                let column = column.ok_or_else(|| problem("is no text"))?;
                if column.null_count() > 0 {
                    return Err(problem("lacks cells; fill them in, also with an empty text"));
                }
                Ok(column)
            };
            let mut kept = vec![true; rows];
            for (condition, &place) in wanted.conditions.iter().zip(&conditions) {
                let column: DictionaryArray<Int32Type> = text(place)?;
                let holds: Vec<_> = values_of(&column).map(|cell| condition.holds(cell)).collect();
                for (kept, key) in kept.iter_mut().zip(column.keys().values()) {
                    *kept &= holds[*key as usize].clone().map_err(wrong)?;
                }
            }
            let features = numbers.len();
            let (mut values, mut variances) = (vec![f64::NAN; rows * features], vec![0.0; rows * features]);
            for (k, (&place, error)) in numbers.iter().zip(&errors).enumerate() {
                let name = &wanted.features[k];
                fill(batch.column(at(place)), (&mut values, k, features))
                    .map_err(|p| wrong(format!("column {name}{p}")))?;
                if let Some(place) = error {
                    fill(batch.column(at(*place)), (&mut variances, k, features))
                        .map_err(|p| wrong(format!("column {}{p}", variance_of(name))))?;
                }
            }
            let texts = texts.iter().map(|&place| text(place)).collect::<Result<_, _>>()?;
            Ok(Batch { texts, values, variances, features, kept })
        }))
    }
}

/// Where the cells of a column of text are.
#[derive(Clone, Copy)]
enum Text<'a> {
    /// In the column at this place.
    Column(usize),
    /// In the names of the folders: one for all rows.
    Key(&'a str),
}

impl Text<'_> {
    fn place(&self) -> Option<usize> {
        if let Self::Column(place) = self { Some(*place) } else { None }
    }
}

fn is_text(kind: &DataType) -> bool {
    match kind {
        DataType::Utf8 | DataType::LargeUtf8 | DataType::Utf8View => true,
        DataType::Dictionary(_, values) => is_text(values),
        _ => false,
    }
}

/// The values of a dictionary.
fn values_of(column: &DictionaryArray<Int32Type>) -> impl Iterator<Item = &str> {
    column.values().as_string::<i32>().iter().map(Option::unwrap_or_default)
}

/// Fills a column of a table by rows; missing cells stay as they are.
fn fill(column: &ArrayRef, (table, place, width): (&mut [f64], usize, usize)) -> Result<(), String> {
    let mut put = |row: usize, x: f64| {
        if x.is_infinite() || x.abs() > LARGEST {
            return Err(format!(", row {}: {x} is no value of a feature", row + 1));
        }
        if !x.is_nan() {
            table[row * width + place] = x;
        }
        Ok(())
    };
    let is_there = |row: usize| column.is_valid(row);
    if let Some(own) = column.as_primitive_opt::<Float64Type>() {
        return own.values().iter().enumerate().filter(|(row, _)| is_there(*row)).try_for_each(|(row, x)| put(row, *x));
    }
    let own = column.as_primitive_opt::<Float32Type>().ok_or(" has no floating-point numbers")?;
    own.values().iter().enumerate().filter(|(row, _)| is_there(*row)).try_for_each(|(row, x)| put(row, f64::from(*x)))
}

impl Batch {
    /// Wanted rows, next to each other, that are of one class, unit and run.
    pub fn stretches(&self) -> impl Iterator<Item = Range<usize>> {
        let keys = |row: usize| [0, 1, 2].map(|k| self.texts[k].keys().value(row));
        let mut next = 0;
        std::iter::from_fn(move || {
            let start = (next..self.kept.len()).find(|row| self.kept[*row])?;
            let own = keys(start);
            next = (start + 1..self.kept.len())
                .find(|row| !self.kept[*row] || keys(*row) != own)
                .unwrap_or(self.kept.len());
            Some(start..next)
        })
    }

    /// Class, unit and run.
    #[must_use]
    pub fn texts(&self, row: usize) -> [&str; 3] {
        [0, 1, 2].map(|k| {
            let own = &self.texts[k];
            own.values().as_string::<i32>().value(own.keys().value(row) as usize)
        })
    }

    /// The features of a row, NaN if missing.
    #[must_use]
    pub fn values(&self, row: usize) -> &[f64] {
        &self.values[row * self.features..(row + 1) * self.features]
    }

    /// The variances of their errors.
    #[must_use]
    pub fn variances(&self, row: usize) -> &[f64] {
        &self.variances[row * self.features..(row + 1) * self.features]
    }
}
