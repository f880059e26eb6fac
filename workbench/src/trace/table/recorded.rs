//! A table in memory, for programs that call the workbench as a library.

use std::path::Path;

use arrow_array::RecordBatch;

use super::{Columns, Wanted, arrow};
use crate::Error;

/// Named columns of equal length.
#[derive(Clone, Debug, PartialEq)]
pub struct Recorded {
    name: String,
    columns: Vec<(String, Cells)>,
}

/// The cells of a column.
#[derive(Clone, Debug, PartialEq)]
pub enum Cells {
    /// Numbers; NaN for missing ones.
    Numbers(Vec<f64>),
    /// Texts; empty for missing ones.
    Texts(Vec<String>),
    /// Cells that are neither, with the name of their type.
    Other(String),
}

impl Cells {
    fn len(&self) -> Option<usize> {
        match self {
            Self::Numbers(numbers) => Some(numbers.len()),
            Self::Texts(texts) => Some(texts.len()),
            Self::Other(_) => None,
        }
    }
}

impl Recorded {
    /// Makes a table; the name is the id of its only trace, unless it has a column `trace`.
    ///
    /// # Errors
    /// Columns of different lengths.
    pub fn new(name: impl Into<String>, columns: Vec<(String, Cells)>) -> Result<Self, Error> {
        let name = name.into();
        let mut lengths = columns.iter().filter_map(|(own, cells)| Some((own, cells.len()?)));
        if let Some((first, rows)) = lengths.next()
            && let Some((other, length)) = lengths.find(|(_, length)| *length != rows)
        {
            let problem = format!("{length} values, but column {first} has {rows}; give columns of one length");
            return Err(Error::content(Path::new(&name), format!("column {other}"), problem));
        }
        Ok(Self { name, columns })
    }

    /// Makes a table of Arrow's record batches of one schema.
    ///
    /// # Errors
    /// As [`Recorded::new`].
    pub fn of_batches(name: impl Into<String>, names: &[String], batches: &[RecordBatch]) -> Result<Self, Error> {
        let column = |place: usize| arrow::cells(batches.iter().map(|batch| batch.column(place).as_ref()));
        Self::new(name, names.iter().cloned().zip((0..names.len()).map(column)).collect())
    }

    /// The name of the table.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Names of the columns.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.columns.iter().map(|(name, _)| name.as_str())
    }

    /// The columns.
    #[must_use]
    pub fn into_columns(self) -> Vec<(String, Cells)> {
        self.columns
    }

    /// Columns as texts, row by row, as in a file of labels; a whole number has no decimal point.
    ///
    /// # Errors
    /// A column of other cells.
    pub fn rows(&self) -> Result<Vec<Vec<String>>, Error> {
        let count = self.columns.iter().find_map(|(_, cells)| cells.len()).unwrap_or(0);
        let mut rows = vec![Vec::with_capacity(self.columns.len()); count];
        for (name, cells) in &self.columns {
            match cells {
                Cells::Numbers(numbers) => rows.iter_mut().zip(numbers).for_each(|(row, x)| row.push(x.to_string())),
                Cells::Texts(texts) => rows.iter_mut().zip(texts).for_each(|(row, x)| row.push(x.trim().into())),
                Cells::Other(kind) => return Err(self.no(name, "numbers or text", kind)),
            }
        }
        Ok(rows)
    }

    fn no(&self, column: &str, wanted: &str, kind: &str) -> Error {
        let problem = format!("no {wanted} but {kind}");
        Error::content(Path::new(&self.name), format!("column {column}"), problem)
    }

    pub(super) fn read(&self, wanted: Wanted<'_>) -> Result<Columns, Error> {
        let texts = wanted.text.map(|place| self.texts(place)).transpose()?;
        let keep = |cells: &Vec<String>| (0..cells.len()).filter(|row| (wanted.row)(&cells[*row])).collect();
        let kept: Option<Vec<usize>> = texts.as_ref().map(keep);
        let column = |place: &usize| match (&self.columns[*place], &kept) {
            ((_, Cells::Numbers(numbers)), None) => Ok(numbers.clone()),
            ((_, Cells::Numbers(numbers)), Some(kept)) => Ok(kept.iter().map(|row| numbers[*row]).collect()),
            ((name, Cells::Texts(_)), _) => Err(self.no(name, "numbers", "text")),
            ((name, Cells::Other(kind)), _) => Err(self.no(name, "numbers", kind)),
        };
        let numbers: Vec<Vec<f64>> = wanted.numbers.iter().map(column).collect::<Result<_, _>>()?;
        if texts.is_none() && numbers.first().is_some_and(Vec::is_empty) {
            return Err(Error::content(Path::new(&self.name), "content", "no rows"));
        }
        let texts = texts.zip(kept).map(|(cells, kept)| kept.iter().map(|row| cells[*row].clone()).collect());
        Ok(Columns { numbers, texts, ..Columns::default() })
    }

    /// The cells of a column of text, or of whole numbers as text.
    fn texts(&self, place: usize) -> Result<Vec<String>, Error> {
        match &self.columns[place] {
            (_, Cells::Texts(texts)) => Ok(texts.clone()),
            (_, Cells::Numbers(numbers)) if numbers.iter().all(|x| x.fract() == 0.0) => {
                Ok(numbers.iter().map(ToString::to_string).collect())
            }
            (name, Cells::Numbers(_)) => Err(self.no(name, "text or whole numbers", "fractions")),
            (name, Cells::Other(kind)) => Err(self.no(name, "text or whole numbers", kind)),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::Table;
    use super::*;

    fn numbers(values: &[f64]) -> Cells {
        Cells::Numbers(values.to_vec())
    }

    #[test]
    fn a_tidy_table_gives_the_rows_of_wanted_traces() {
        let ids = Cells::Texts(["b", "a", "b"].map(String::from).to_vec());
        let columns = vec![("trace".into(), ids), ("i".into(), numbers(&[1.0, 2.0, 3.0]))];
        let table = Table::of(&Arc::new(Recorded::new("bench", columns).expect("equal lengths")));
        let wanted = |row: &str| row == "b";
        let found = table.read(Wanted { numbers: &[1], text: Some(0), row: &wanted }).expect("numbers");
        assert_eq!((found.numbers, found.texts), (vec![vec![1.0, 3.0]], Some(vec!["b".into(), "b".into()])));
        let text = table.read(Wanted { numbers: &[0], text: None, row: &wanted }).expect_err("text").to_string();
        assert_eq!(text, "bench, column trace: no numbers but text");
    }

    #[test]
    fn bad_tables_are_refused() {
        let columns = vec![("i".into(), numbers(&[1.0, 2.0])), ("v".into(), numbers(&[1.0]))];
        let uneven = Recorded::new("x", columns).expect_err("uneven").to_string();
        assert_eq!(uneven, "x, column v: 1 values, but column i has 2; give columns of one length");
        let read = |values: &[f64]| {
            let table = Table::of(&Arc::new(Recorded::new("x", vec![("i".into(), numbers(values))]).expect("one")));
            table.read(Wanted { numbers: &[0], text: None, row: &|_| true }).expect_err("refused").to_string()
        };
        assert_eq!(read(&[]), "x, content: no rows");
        assert!(read(&[1.0, f64::NAN]).starts_with("x, row 2, column i: NaN is not a finite number"));
    }
}
