//! A table in memory, for programs that call the workbench as a library.

use std::path::Path;

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
    /// Points or spans of time.
    Times(Times),
    /// Cells that are neither, with the name of their type.
    Other(String),
}

/// Points or spans of time of a column.
#[derive(Clone, Debug, PartialEq)]
pub struct Times {
    /// Seconds from the first one; NaN for missing ones.
    pub seconds: Vec<f64>,
    /// How well they serve as the time of rows, the smallest best; `None` of days, which are no time of a row.
    pub rank: Option<u8>,
}

impl Cells {
    fn len(&self) -> Option<usize> {
        match self {
            Self::Numbers(numbers) => Some(numbers.len()),
            Self::Texts(texts) => Some(texts.len()),
            Self::Times(times) => Some(times.seconds.len()),
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

    /// The name of the table.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Names of the columns.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.columns.iter().map(|(name, _)| name.as_str())
    }

    /// Takes the table to pieces.
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
                Cells::Times(_) => return Err(self.wrong_kind(name, "numbers or text", "times; write them as text")),
                Cells::Other(kind) => return Err(self.wrong_kind(name, "numbers or text", kind)),
            }
        }
        Ok(rows)
    }

    /// The columns.
    #[must_use]
    pub fn columns(&self) -> &[(String, Cells)] {
        &self.columns
    }

    /// The error of a column whose cells are of another kind than the wanted one.
    #[must_use]
    pub fn wrong_kind(&self, column: &str, wanted: &str, kind: &str) -> Error {
        let problem = format!("no {wanted} but {kind}");
        Error::content(Path::new(&self.name), format!("column {column}"), problem)
    }
}
