//! Files of named columns: text, MATLAB, Parquet, Arrow and NumPy, plain or compressed.
//!
//! ```text
//! .csv .tsv .txt .dat  text ([`text`]), also with .gz or .zst, and .lvm of LabVIEW; Octave's text ([`matlab`])
//! .mat                 MATLAB 4 to 7.3 ([`matlab`]), or Octave's text
//! .parquet             Parquet, .arrow .arrows .feather: Arrow's files and streams ([`arrow`])
//! .h5 .hdf5            HDF5 ([`hdf5`])
//! .npy .npz            arrays of NumPy ([`numpy`])
//! ```
//!
//! No file becomes more than its `limit` in memory.
//!
//! A table may also be in memory (`recorded`). Each format but text is a feature of this crate.

#[cfg(any(feature = "matlab", feature = "numpy"))]
mod arrays;
#[cfg(feature = "parquet")]
mod arrow;
mod columns;
mod formats;
pub mod from_first;
#[cfg(feature = "matlab")]
mod hdf5;
mod limit;
#[cfg(feature = "matlab")]
mod matlab;
#[cfg(feature = "numpy")]
mod numpy;
mod recorded;
mod text;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use rayon::prelude::*;

use model::Error;
use model::trace::{Recorded, TextForm, composed, extensions, file_name};

use columns::{NO_NUMBER, Unusable, settle, too_large};
use formats::{Content, Format, open_text};

#[cfg(feature = "parquet")]
pub use arrow::{of_batches, parquet_pages};
pub use columns::{About, Columns, LARGEST, Omitted, Wanted};
pub use formats::{is_unread, write};
pub use text::csv_error;

/// A file whose columns are known and not yet read, or a table in memory.
#[derive(Debug)]
pub struct Table {
    path: PathBuf,
    names: Vec<String>,
    content: Content,
    about: About,
    /// Id of its only trace, if it is not the name of the file.
    id: Option<String>,
}

impl Table {
    /// Opens a file by its extension; one without a known extension is text.
    ///
    /// # Errors
    /// A file that cannot be read, or is of no known format.
    pub fn open(path: &Path) -> Result<Self, Error> {
        Self::open_as(path, &TextForm::default())
    }

    /// Opens a file; what is given of the layout of texts is not guessed.
    ///
    /// # Errors
    /// The errors of [`Table::open`].
    pub fn open_as(path: &Path, form: &TextForm) -> Result<Self, Error> {
        let name = file_name(path);
        let (extension, compressed) = extensions(&name).unwrap_or_default();
        let format = Format::of(&extension);
        if compressed && format.is_some() {
            let problem = format!("a .{extension} file is compressed by itself; unpack it once");
            return Err(Error::content(path, "name", problem));
        }
        let mut about = About::default();
        let (names, content) = match format {
            Some(format) => (format.open)(path, &mut about)?,
            None => open_text(path, form, &mut about)?,
        };
        #[cfg(any(feature = "matlab", feature = "numpy"))]
        if let Content::Arrays(own) = &content {
            arrays::rising_time(&names, &own.columns, &mut about);
        }
        let names = names.iter().map(|name| composed(name).into_owned()).collect();
        Ok(Self { path: path.to_path_buf(), names, content, about, id: None })
    }

    /// A table in memory; messages name it as a file.
    #[must_use]
    pub fn of(recorded: &Arc<Recorded>) -> Self {
        let names = recorded.names().map(|name| composed(name).into_owned()).collect();
        Self {
            path: recorded.name().into(),
            names,
            content: Content::Memory(Arc::clone(recorded)),
            about: About { clocks: recorded::clocks(recorded), ..About::default() },
            id: None,
        }
    }

    /// The file, for messages.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether it is a table in memory, which may be a piece of a trace.
    pub(crate) const fn is_in_memory(&self) -> bool {
        matches!(self.content, Content::Memory(_))
    }

    /// With this id of its only trace.
    pub(crate) fn called(self, id: String) -> Self {
        Self { id: Some(id), ..self }
    }

    /// Id of the only trace of the table: the name of its file without folder, or of a table in memory.
    #[must_use]
    pub fn id(&self) -> String {
        match &self.content {
            _ if self.id.is_some() => self.id.clone().unwrap_or_default(),
            Content::Memory(recorded) => recorded.name().into(),
            _ => file_name(&self.path),
        }
    }

    /// Columns that are times, and what was left out or guessed.
    #[must_use]
    pub fn about(&self) -> &About {
        &self.about
    }

    /// Names of the columns.
    #[must_use]
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Reads columns.
    ///
    /// # Errors
    /// A cell of a wanted column that is neither a number nor missing, a column without a number, or a row without the
    /// cells.
    pub fn read(&self, wanted: Wanted<'_>) -> Result<Columns, Error> {
        let mut columns = match &self.content {
            Content::Text(text) => text.read((&self.path, &self.names), wanted)?,
            #[cfg(any(feature = "matlab", feature = "numpy"))]
            Content::Arrays(own) => own.read(wanted),
            #[cfg(feature = "parquet")]
            Content::Arrow(kind) => arrow::read((&self.path, &self.names), *kind, &self.about.clocks, wanted)?,
            Content::Memory(recorded) => recorded::read(recorded, &self.about.clocks, wanted)?,
        };
        // As a list first: the first column with such a value is told, whichever thread is first.
        let checks: Vec<Result<(), Unusable>> = columns.numbers.par_iter_mut().map(|own| settle(own)).collect();
        // In a piece of a trace a sensor may give nothing.
        let may_be_empty = self.is_in_memory();
        let refused =
            |check: &Result<(), Unusable>| check.err().filter(|own| !(may_be_empty && *own == Unusable::Empty));
        match checks.iter().enumerate().find_map(|(k, check)| Some((k, refused(check)?))) {
            Some((k, problem)) => {
                let row = |row: usize| columns.place(row);
                Err(self.unusable(wanted.numbers[k], problem, (&columns.numbers[k], &row)))
            }
            None => Ok(columns),
        }
    }

    /// Reads each of these columns of numbers, or says why it is not taken.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn read_each(&self, places: &[usize]) -> Result<Vec<Result<Vec<f64>, Error>>, Error> {
        let all = match &self.content {
            Content::Text(text) => text.read_each((&self.path, &self.names), places)?,
            _ => return Ok(self.read_parts(places)),
        };
        let each = |(place, column): (&usize, Result<Vec<f64>, Error>)| {
            let mut column = column?;
            let row = |row: usize| format!("row {}", row + 1);
            settle(&mut column).map_err(|problem| self.unusable(*place, problem, (&column, &row)))?;
            Ok(column)
        };
        Ok(places.iter().zip(all).map(each).collect())
    }

    /// Reads columns at once, and by halves where one is refused, so that a few bad ones among many cost little.
    fn read_parts(&self, places: &[usize]) -> Vec<Result<Vec<f64>, Error>> {
        match (self.read(Wanted { numbers: places, text: None, row: &|_| true }), places) {
            (Ok(columns), _) => columns.numbers.into_iter().map(Ok).collect(),
            (Err(_), []) => vec![],
            (Err(problem), [_]) => vec![Err(problem)],
            (Err(_), _) => {
                let (first, second) = places.split_at(places.len() / 2);
                let (mut all, rest) = rayon::join(|| self.read_parts(first), || self.read_parts(second));
                all.extend(rest);
                all
            }
        }
    }

    fn unusable(&self, place: usize, problem: Unusable, (column, at): (&[f64], &dyn Fn(usize) -> String)) -> Error {
        let name = format!("column {}", self.names[place]);
        let (place, problem) = match problem {
            Unusable::Large(row) => (format!("{}, {name}", at(row)), too_large(&column[row].to_string())),
            Unusable::Empty => (name, NO_NUMBER.into()),
        };
        Error::content(&self.path, place, problem)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lengths and offsets in such a file lead readers beyond its end, and some readers panic there.
    #[test]
    fn files_with_a_changed_byte_are_read_or_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let columns = [vec![1.0, 2.0, 3.0], vec![0.5, -1.5, 1e3]];
        for name in ["t.mat", "t.parquet", "t.arrow", "t.arrows", "t.h5", "t.npz", "t.csv.gz", "t.csv.zst"] {
            let path = folder.path().join(name);
            match name {
                "t.arrows" => arrow::write_stream(&path, &["a".into(), "b".into()], &columns),
                "t.h5" => {
                    let mut builder = hdf5_pure::FileBuilder::new();
                    builder.create_dataset("a").with_f64_data(&columns[0]);
                    builder.create_dataset("b").with_complex64_data(&[(1.0, -1.0), (2.0, -2.0), (3.0, 0.5)]);
                    std::fs::write(&path, builder.finish().expect("written")).expect("writable");
                }
                _ => write(&path, &["a".into(), "b".into()], &columns).expect("written"),
            }
            let good = std::fs::read(&path).expect("read");
            let mut refused = 0;
            for place in 0..good.len() {
                let mut bytes = good.clone();
                bytes[place] ^= [0xFF, 0x40, 0x01][place % 3];
                std::fs::write(&path, bytes).expect("writable");
                let wanted = Wanted { numbers: &[0, 1], text: None, row: &|_| true };
                let table = Table::open(&path).ok().filter(|table| table.names()[0] == "a" && table.names().len() > 1);
                refused += usize::from(table.is_none_or(|table| table.read(wanted).is_err()));
            }
            assert!(refused > 20, "{name}: {refused}");
        }
    }

    /// Only the first bytes are looked at.
    #[test]
    fn large_files_of_something_else_are_refused_at_once() {
        let folder = tempfile::tempdir().expect("a folder");
        for (name, byte) in [
            ("t.mat", 0x5A),
            ("t.h5", 0x5A),
            ("t.npz", 0x5A),
            ("t.arrow", 0x3A),
            ("t.arrow", 0xFF),
            ("t.arrows", 0x7A),
            ("t.parquet", 0x5A),
        ] {
            let path = folder.path().join(name);
            std::fs::write(&path, [byte; 600]).expect("writable");
            let file = std::fs::File::options().write(true).open(&path);
            file.and_then(|file| file.set_len(1 << 31)).expect("without content");
            let refused = Table::open(&path).expect_err("something else").to_string();
            assert!(refused.contains("not readable as"), "{refused}");
        }
    }

    #[test]
    fn formats_that_are_not_read_say_what_to_do() {
        let folder = tempfile::tempdir().expect("a folder");
        for (name, said) in [("a.tdms", "export it as CSV"), ("b.XLSX", "save its sheet as CSV")] {
            let path = folder.path().join(name);
            std::fs::write(&path, "TDSm").expect("writable");
            let refused = Table::open(&path).expect_err("not read").to_string();
            assert!(refused.contains(said), "{refused}");
        }
        for name in ["a.npy", "a.h5", "a.tdms", "a.arrows"] {
            let refused = write(&folder.path().join(name), &["a".into()], &[vec![1.0]]).expect_err("not written");
            assert!(refused.to_string().contains("give a name that ends with"), "{refused}");
        }
    }
}
