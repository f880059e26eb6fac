//! The files of a simulated set: one CSV a trace, and the labels.

use std::path::Path;

use crate::Error;
use crate::cli::output;

/// Returns columns of the same length as CSV. Nine significant digits are far finer than the noise, and keep the files
/// small.
pub(super) fn csv(columns: &[(&str, &[f64])]) -> String {
    let names: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
    let mut out = names.join(",") + "\n";
    for k in 0..columns.first().map_or(0, |(_, column)| column.len()) {
        let cells = columns.iter().map(|(_, column)| {
            let digits = format!("{:.8e}", column[k]);
            digits.parse::<f64>().map_or(digits, |rounded| rounded.to_string())
        });
        let cells: Vec<String> = cells.collect();
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
