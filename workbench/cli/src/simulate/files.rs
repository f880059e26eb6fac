//! The files of a simulated set: one CSV a trace, and the labels.

use std::path::Path;

use crate::output;
use model::Error;

/// Columns with their names.
pub(super) type Table = Vec<(&'static str, Vec<f64>)>;

/// Returns columns with nine significant digits, which are far finer than the noise and keep files small.
pub(super) fn table<C: AsRef<[f64]>>(columns: Vec<(&'static str, C)>) -> Table {
    let rounded = |x: &f64| format!("{x:.8e}").parse().unwrap_or(*x);
    columns.into_iter().map(|(name, column)| (name, column.as_ref().iter().map(rounded).collect())).collect()
}

/// Returns columns of the same length as CSV.
pub(super) fn csv(columns: &Table) -> String {
    let names: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
    let mut out = names.join(",") + "\n";
    for k in 0..columns.first().map_or(0, |(_, column)| column.len()) {
        let cells: Vec<String> = columns.iter().map(|(_, column)| column[k].to_string()).collect();
        out.push_str(&cells.join(","));
        out.push('\n');
    }
    out
}

const HEADER: &str = "trace,class_name,severity,seed,condition,waveform";

/// Returns the rows of an existing labels file; none if the file is absent.
pub(super) fn old_labels(path: &Path) -> Result<Vec<String>, Error> {
    if !path.exists() {
        return Ok(vec![]);
    }
    let text = std::fs::read_to_string(path).map_err(Error::io(path))?;
    let mut lines = text.lines();
    if lines.next() != Some(HEADER) {
        return Err(Error::content(path, "line 1", "not labels of simulated traces; choose another --out"));
    }
    Ok(lines.filter(|line| !line.is_empty()).map(String::from).collect())
}

/// Writes the labels of a folder; old rows of the same traces are replaced.
pub(super) fn write_labels(path: &Path, old: &[String], rows: &[[String; 6]]) -> Result<(), Error> {
    let replaced = |line: &str| rows.iter().any(|row| line.split(',').next() == Some(row[0].as_str()));
    let kept = old.iter().filter(|line| !replaced(line)).cloned();
    let lines: Vec<String> =
        std::iter::once(HEADER.to_string()).chain(kept).chain(rows.iter().map(|row| row.join(","))).collect();
    output::write(path, lines.join("\n") + "\n")
}
