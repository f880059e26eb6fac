//! Segments → a part, row group by row group.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use arrow_array::builder::StringDictionaryBuilder;
use arrow_array::types::Int32Type;
use arrow_array::{ArrayRef, Float32Array, Float64Array, RecordBatch, UInt32Array};
use arrow_schema::{DataType, Field, Schema};
use parquet::arrow::ArrowWriter;
use parquet::basic::Compression;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::schema::types::ColumnPath;

use super::Plan;
use super::part::{PLAN, SORTED, TEXTS, variance_of};
use model::Error;

/// Rows of a row group.
const GROUP: usize = 65_536;

/// One segment of a trace.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// Trace, class, unit and run.
    pub texts: [String; 4],
    /// Number of the segment in its trace.
    pub segment: u32,
    /// Part of its samples that was used.
    pub usable: f32,
    /// Features in the order of the plan; NaN if missing.
    pub values: Vec<f64>,
    /// Variances of their errors.
    pub variances: Vec<f64>,
    /// Cells of the further columns of the labels.
    pub labels: Vec<String>,
}

/// Places of the features whose errors have a column.
fn with_errors(plan: &Plan) -> Vec<bool> {
    let catalogue = plan.catalogue();
    (0..plan.features.len()).map(|place| Plan::has_variance(catalogue.core_feature(place))).collect()
}

/// Writes a part, row group by row group.
#[derive(Debug)]
pub struct Writer<W: Write + Send> {
    writer: ArrowWriter<W>,
    schema: Arc<Schema>,
    path: PathBuf,
    with_errors: Vec<bool>,
    rows: Vec<Row>,
    /// The last unit, as long as units ascend.
    last: Option<String>,
    sorted: bool,
    count: u64,
}

impl<W: Write + Send> Writer<W> {
    /// Starts a part with these further columns; `path` is named in errors.
    ///
    /// # Errors
    /// Columns that occur twice, or a file that cannot be written.
    pub fn new(to: W, path: &Path, plan: &Plan, labels: &[String]) -> Result<Self, Error> {
        let with_errors = with_errors(plan);
        let text = |name: &str| {
            let kind = DataType::Dictionary(Box::new(DataType::Int32), Box::new(DataType::Utf8));
            Field::new(name, kind, false)
        };
        let mut fields: Vec<Field> = TEXTS.iter().map(|name| text(name)).collect();
        fields.insert(1, Field::new("segment", DataType::UInt32, false));
        fields.push(Field::new("usable", DataType::Float32, false));
        for (place, name) in plan.features.iter().enumerate() {
            // Raw parameters are sums of the core's, which single precision would round.
            let double = place <= plan.structure_parameters();
            fields.push(Field::new(name, if double { DataType::Float64 } else { DataType::Float32 }, true));
        }
        let errors = plan.features.iter().zip(&with_errors).filter(|(_, has)| **has);
        fields.extend(errors.map(|(name, _)| Field::new(variance_of(name), DataType::Float32, true)));
        if let Some(name) = labels.iter().find(|name| fields.iter().any(|field| field.name() == *name)) {
            let problem = format!("the labels have a column {name}, which is one of the part's own; rename it");
            return Err(Error::Usage(problem));
        }
        fields.extend(labels.iter().map(|name| text(name)));
        let schema = Arc::new(Schema::new(fields));
        let mut properties = WriterProperties::builder()
            .set_max_row_group_row_count(Some(GROUP))
            .set_compression(Compression::SNAPPY)
            .set_key_value_metadata(Some(vec![KeyValue::new(PLAN.to_string(), plan.to_json())]));
        // Features are as good as random: neither a dictionary nor compression would save anything.
        for field in schema.fields().iter().filter(|field| field.is_nullable()) {
            let column = ColumnPath::from(field.name().as_str());
            properties = properties.set_column_dictionary_enabled(column.clone(), false);
            properties = properties.set_column_compression(column, Compression::UNCOMPRESSED);
        }
        let writer = ArrowWriter::try_new(to, schema.clone(), Some(properties.build()));
        let writer = writer.map_err(|error| Error::content(path, "content", error.to_string()))?;
        let (rows, path) = (Vec::new(), path.to_path_buf());
        Ok(Self { writer, schema, path, with_errors, rows, last: None, sorted: true, count: 0 })
    }

    /// Adds a row.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn add(&mut self, row: Row) -> Result<(), Error> {
        let unit = &row.texts[2];
        if self.last.as_ref() != Some(unit) {
            self.sorted &= self.last.as_ref().is_none_or(|last| last < unit);
            self.last = Some(unit.clone());
        }
        self.count += 1;
        self.rows.push(row);
        if self.rows.len() >= GROUP { self.flush() } else { Ok(()) }
    }

    fn flush(&mut self) -> Result<(), Error> {
        if self.rows.is_empty() {
            return Ok(());
        }
        let wrong = |problem: String| Error::content(&self.path, "content", problem);
        let batch = RecordBatch::try_new(self.schema.clone(), columns(&self.rows, &self.schema, &self.with_errors));
        let batch = batch.map_err(|error| wrong(error.to_string()))?;
        self.rows.clear();
        self.writer.write(&batch).and_then(|()| self.writer.flush()).map_err(|error| wrong(error.to_string()))
    }

    /// Completes the part; returns the number of its rows, and whether its units ascend.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn finish(mut self) -> Result<(u64, bool), Error> {
        self.flush()?;
        if self.sorted {
            self.writer.append_key_value_metadata(KeyValue::new(SORTED.to_string(), "unit".to_string()));
        }
        let closed = self.writer.close().map_err(|error| Error::content(&self.path, "content", error.to_string()));
        closed.map(|_| (self.count, self.sorted))
    }
}

/// The columns of rows, in the order of the schema.
fn columns(rows: &[Row], schema: &Schema, with_errors: &[bool]) -> Vec<ArrayRef> {
    let text = |of: &dyn Fn(&Row) -> &str| {
        let mut builder = StringDictionaryBuilder::<Int32Type>::new();
        rows.iter().for_each(|row| builder.append_value(of(row)));
        Arc::new(builder.finish()) as ArrayRef
    };
    let number = |field: &Field, of: &dyn Fn(&Row) -> f64| {
        let cells = rows.iter().map(of).map(|x| x.is_finite().then_some(x));
        match field.data_type() {
            DataType::Float64 => Arc::new(Float64Array::from_iter(cells)) as ArrayRef,
            _ => Arc::new(Float32Array::from_iter(cells.map(|x| x.map(|x| x as f32)))),
        }
    };
    let mut all: Vec<ArrayRef> = (0..TEXTS.len()).map(|k| text(&|row| &row.texts[k])).collect();
    all.insert(1, Arc::new(rows.iter().map(|row| row.segment).collect::<UInt32Array>()));
    all.push(Arc::new(rows.iter().map(|row| row.usable).collect::<Float32Array>()));
    for k in 0..with_errors.len() {
        all.push(number(schema.field(all.len()), &|row| row.values[k]));
    }
    for k in (0..with_errors.len()).filter(|k| with_errors[*k]) {
        all.push(number(schema.field(all.len()), &|row| row.variances[k]));
    }
    let labels = rows.first().map_or(0, |row| row.labels.len());
    (0..labels).for_each(|k| all.push(text(&|row| &row.labels[k])));
    all
}
