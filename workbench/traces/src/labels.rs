//! The file of labels: the class of each trace, and further columns by which traces are selected.

use std::path::Path;

use model::Error;
use model::outputs::text_of;
use model::trace::Labels;

use crate::table::csv_error;

/// Reads a labels file.
///
/// # Errors
/// Unreadable file, missing `trace` or `class_name`, ragged rows, a trace that occurs twice.
pub fn read_labels(path: &Path) -> Result<Labels, Error> {
    let file = std::fs::File::open(path).map_err(Error::io(path))?;
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(file);
    let problem = |error: csv::Error| match error.kind() {
        csv::ErrorKind::UnequalLengths { pos, len, expected_len } => {
            let line = pos.as_ref().map_or_else(|| "content".into(), |p| format!("line {}", p.line()));
            Error::content(path, line, format!("{len} cells where the header has {expected_len}; complete the row"))
        }
        _ => csv_error(path, &error),
    };
    let text = |cell: &str| text_of(cell).to_string();
    let columns: Vec<String> = reader.headers().map_err(problem)?.iter().map(text).collect();
    let rows = reader.records().map(|r| Ok(r.map_err(problem)?.iter().map(text).collect()));
    Labels::of_cells(path, columns, rows.collect::<Result<_, Error>>()?)
}
