//! What the tests of the core and the workbench share; the tests themselves live in `tests/`.

pub mod documents;
pub mod flash;
pub mod halves;
pub mod oracle;
pub mod plans;
pub mod plants;
pub mod streams;
pub mod strokes;

use std::path::PathBuf;

/// Output and both inputs of a regression at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Inputs {
    /// Output.
    pub y: f32,
    /// First input.
    pub u1: f32,
    /// Second input.
    pub u2: f32,
}

/// A folder of the recorded data, which is not part of the repository: `BEARING_WATCH_DATA` or `../shared/data`.
///
/// Where it is absent, prints a line saying that the calling test is skipped, and gives nothing.
#[must_use]
pub fn data(folder: &str) -> Option<PathBuf> {
    let root = std::env::var_os("BEARING_WATCH_DATA")
        .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/data"), PathBuf::from);
    let path = root.join(folder);
    if path.is_dir() {
        return Some(path);
    }
    println!("skipped: no recorded data at {}", path.display());
    None
}

/// Rows of a numeric CSV file by trace id: the header's names, and for each row its first cell and the numbers.
///
/// # Panics
/// Where the file is not such a table; it is part of a test set.
#[must_use]
pub fn table(path: &std::path::Path) -> (Vec<String>, Vec<(String, Vec<f64>)>) {
    let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let mut lines = text.lines();
    let header = lines.next().map(|line| line.split(',').map(String::from).collect()).unwrap_or_default();
    let rows = lines.map(|line| {
        let mut cells = line.split(',');
        let id = cells.next().map(String::from).unwrap_or_default();
        (id, cells.map(|cell| cell.parse().unwrap_or_else(|_| panic!("{cell} in {line}"))).collect())
    });
    (header, rows.collect())
}

/// The numbers of a CSV file by column, its first `labels` columns left out.
///
/// # Panics
/// Where the file is not such a table; it is part of a test set.
#[must_use]
pub fn columns(path: &std::path::Path, labels: usize) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let mut columns: Vec<Vec<f64>> = Vec::new();
    for line in text.lines().skip(1) {
        for (place, cell) in line.split(',').skip(labels).enumerate() {
            if columns.len() <= place {
                columns.push(Vec::new());
            }
            columns[place].push(cell.trim().parse().unwrap_or_else(|_| panic!("{cell} in {line}")));
        }
    }
    columns
}

/// `x − y`, sample by sample.
#[must_use]
pub fn difference(x: &[f64], y: &[f64]) -> Vec<f64> {
    x.iter().zip(y).map(|(a, b)| a - b).collect()
}

/// Largest magnitude.
#[must_use]
pub fn peak(x: impl IntoIterator<Item = f64>) -> f64 {
    x.into_iter().fold(0.0, |most, v| v.abs().max(most))
}
