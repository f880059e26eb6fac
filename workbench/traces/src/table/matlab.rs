//! MATLAB files: variables of formats 5 to 7, and of format 7.3, which is HDF5.
//!
//! ```text
//! x, y            vectors of one length     columns x, y
//! m               a matrix                  columns m_1, m_2, …, along its longer side
//! s.a, s.b        fields of a structure     columns s.a, s.b; a, b if s is the only variable
//! s.signals(k)    "structure with time"     column of the signal's label, beside s.time
//! r               a number                  a constant column
//! ```
//!
//! The longest arrays are the columns; arrays of other lengths, text and objects are left out.

use std::path::Path;

use matrw::{MatFile, MatVariable};

use crate::damaged::guarded;
use crate::table::about::About;
use crate::table::arrays::of_one_length;
use crate::table::matlab_value::Value;
use crate::table::{limit, matlab_elements, matlab_hdf5};
use model::Error;

/// What a file of format 7.3 has behind its text header.
const HDF5_AT: usize = 512;
const HDF5: &[u8] = b"\x89HDF";

/// Returns names and columns.
pub(super) fn read(path: &Path, about: &mut About) -> Result<(Vec<String>, Vec<Vec<f64>>), Error> {
    let bytes = limit::whole(path)?;
    let is_hdf5 = bytes.starts_with(HDF5) || bytes.get(HDF5_AT..).is_some_and(|rest| rest.starts_with(HDF5));
    let value = guarded(|| if is_hdf5 { of_hdf5(&bytes) } else { variables(&bytes) }).unwrap_or(Ok(None));
    let value = value.map_err(|problem| Error::content(path, "content", problem))?;
    let Some(Value::Fields(variables)) = value else {
        let problem = "not readable as a MATLAB file of format 5 to 7.3; save it again, e.g. with -v7";
        return Err(Error::content(path, "content", problem));
    };
    let mut found = Vec::new();
    for (name, value) in &variables {
        columns(name, value, &mut found);
    }
    if let Some(alone) = only_variable(&found) {
        found.iter_mut().for_each(|(name, _)| *name = name[alone..].to_string());
    }
    of_one_length(path, found, about)
}

/// Reads the variables of format 7.3.
fn of_hdf5(bytes: &[u8]) -> Result<Option<Value>, String> {
    matlab_hdf5::check(bytes)?;
    Ok(hdf5_pure::mat::from_bytes(bytes).ok())
}

/// Reads the variables of format 5 to 7.
fn variables(bytes: &[u8]) -> Result<Option<Value>, String> {
    let Some(plain) = matlab_elements::unpacked(bytes)? else { return Ok(None) };
    let Ok(file) = matrw::load_matfile_from_u8(&plain) else { return Ok(None) };
    Ok(Some(Value::Fields(file.iter().map(|(name, value)| (name.clone(), value.into())).collect())))
}

/// Length of the part of all names that is the name of the only variable and its dot.
fn only_variable(found: &[(String, Vec<f64>)]) -> Option<usize> {
    let (first, _) = found.first()?.0.split_once('.')?;
    let own = |(name, _): &(String, Vec<f64>)| name.strip_prefix(first).is_some_and(|rest| rest.starts_with('.'));
    found.iter().all(own).then_some(first.len() + 1)
}

/// Adds the columns of a value.
fn columns(name: &str, value: &Value, found: &mut Vec<(String, Vec<f64>)>) {
    match value {
        Value::Numbers { rows, values } => arrays(name, *rows, values, found),
        Value::Fields(fields) => {
            for (field, value) in fields {
                if field == "signals" {
                    signals(name, value, found);
                } else {
                    columns(&format!("{name}.{field}"), value, found);
                }
            }
        }
        Value::List(elements) => {
            for (k, element) in elements.iter().enumerate() {
                columns(&format!("{name}({})", k + 1), element, found);
            }
        }
        Value::Text(_) | Value::Other => {}
    }
}

fn arrays(name: &str, rows: usize, values: &[f64], found: &mut Vec<(String, Vec<f64>)>) {
    let across = values.len().checked_div(rows).unwrap_or(0);
    if rows <= 1 || across <= 1 {
        if !values.is_empty() {
            found.push((name.to_string(), values.to_vec()));
        }
        return;
    }
    let columns: Vec<Vec<f64>> = if rows >= across {
        values.chunks_exact(rows).map(<[f64]>::to_vec).collect()
    } else {
        (0..rows).map(|row| values.iter().skip(row).step_by(rows).copied().collect()).collect()
    };
    found.extend((1..).map(|k| format!("{name}_{k}")).zip(columns));
}

/// The signals of a "structure with time", by their labels.
fn signals(name: &str, value: &Value, found: &mut Vec<(String, Vec<f64>)>) {
    let one = std::slice::from_ref(value);
    let list = if let Value::List(list) = value { list } else { one };
    for (k, signal) in list.iter().enumerate() {
        let Value::Fields(fields) = signal else { continue };
        let field = |wanted: &str| fields.iter().find(|(name, _)| name == wanted).map(|(_, value)| value);
        let label = match field("label") {
            Some(Value::Text(label)) if !label.trim().is_empty() => label.trim().to_string(),
            _ => format!("signal_{}", k + 1),
        };
        if let Some(values) = field("values") {
            columns(&format!("{name}.{label}"), values, found);
        }
    }
}

/// Writes a file of format 7.
pub(super) fn write(path: &Path, names: &[String], columns: &[Vec<f64>]) -> Result<(), Error> {
    let mut file = MatFile::new();
    for (name, column) in names.iter().zip(columns) {
        let allowed = |c: char| c.is_ascii_alphanumeric() || c == '_';
        if !name.starts_with(|c: char| c.is_ascii_alphabetic()) || !name.chars().all(allowed) || name.len() > 63 {
            let problem = "MATLAB allows no such name; give another one with NAME=CHANNEL";
            return Err(Error::content(path, format!("column {name}"), problem));
        }
        file.insert(name, MatVariable::from(column.clone()));
    }
    let name = path.to_string_lossy();
    matrw::save_matfile_v7(&name, file, true).map_err(|error| Error::content(path, "content", error.to_string()))
}

#[cfg(test)]
mod tests {
    use serde::Serialize;

    use super::*;

    fn read_bytes(bytes: &[u8]) -> Result<(Vec<String>, Vec<Vec<f64>>), String> {
        let file = tempfile::Builder::new().suffix(".mat").tempfile().expect("a file");
        std::fs::write(file.path(), bytes).expect("writable");
        read(file.path(), &mut About::default()).map_err(|error| error.to_string())
    }

    #[test]
    fn structures_with_time_and_plain_vectors_become_columns() {
        let signal = |label: &str, values: Vec<f64>| {
            let numbers = Value::Numbers { rows: values.len(), values };
            Value::Fields(vec![("values".into(), numbers), ("label".into(), Value::Text(label.into()))])
        };
        let with_time = Value::Fields(vec![
            ("time".into(), Value::Numbers { rows: 2, values: vec![0.0, 0.1] }),
            ("signals".into(), Value::List(vec![signal("i", vec![1.0, 2.0]), signal("", vec![3.0, 4.0])])),
            ("blockName".into(), Value::Text("model".into())),
        ]);
        let mut found = Vec::new();
        columns("log", &with_time, &mut found);
        let names: Vec<&str> = found.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["log.time", "log.i", "log.signal_2"]);
        assert_eq!(only_variable(&found), Some(4));
        let mut found = Vec::new();
        arrays("m", 3, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], &mut found);
        arrays("w", 2, &[1.0, 4.0, 2.0, 5.0, 3.0, 6.0], &mut found);
        let columns = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]].map(|column| column.to_vec());
        assert_eq!(
            found.iter().map(|(_, column)| column.clone()).collect::<Vec<_>>(),
            [columns.clone(), columns].concat()
        );
    }

    #[derive(Serialize)]
    struct File {
        time: Vec<f64>,
        pair: Vec<Vec<f64>>,
        rpm: f64,
        note: String,
        log: Log,
    }

    #[derive(Serialize)]
    struct Log {
        current: Vec<f32>,
        short: Vec<i16>,
    }

    #[test]
    fn format_7_3_gives_the_same_columns() {
        let log = Log { current: vec![0.5, 1.5, 2.5], short: vec![1, 2] };
        let pair = vec![vec![1.0, 4.0], vec![2.0, 5.0], vec![3.0, 6.0]];
        let file = File { time: vec![0.0, 0.1, 0.2], pair, rpm: 1500.0, note: "x".into(), log };
        let (names, columns) = read_bytes(&hdf5_pure::mat::to_bytes(&file).expect("written")).expect("read");
        let column = |name: &str| names.iter().position(|own| own == name).map(|place| columns[place].clone());
        assert_eq!(column("time"), Some(vec![0.0, 0.1, 0.2]), "{names:?}");
        assert_eq!(column("pair_2"), Some(vec![4.0, 5.0, 6.0]), "{names:?}");
        assert_eq!(column("rpm"), Some(vec![1500.0; 3]));
        assert_eq!(column("log.current"), Some(vec![0.5, 1.5, 2.5]));
        assert_eq!((column("log.short"), column("note")), (None, None));
    }

    #[test]
    fn damaged_files_are_refused() {
        let file = matrw::matfile!(x: matrw::matvar!([1.0, 2.0, 3.0]));
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("x.mat");
        matrw::save_matfile_v7(&path.to_string_lossy(), file, false).expect("written");
        let good = std::fs::read(&path).expect("read");
        assert_eq!(read_bytes(&good).expect("good").1, [[1.0, 2.0, 3.0]]);
        for length in [0, 5, 127, 130, good.len() - 7] {
            let problem = read_bytes(&good[..length]).expect_err("cut");
            assert!(problem.contains("not readable as a MATLAB file") || problem.contains("no arrays"), "{problem}");
        }
    }
}
