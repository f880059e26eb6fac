//! The formats of files, one entry each: how files with its extensions are opened and written.

use std::path::Path;
use std::sync::Arc;

use model::Error;
use model::outputs::cell;
use model::trace::{Recorded, TextForm, extensions, file_name};

#[cfg(any(feature = "matlab", feature = "numpy"))]
use crate::table::arrays::records::Arrays;
#[cfg(feature = "parquet")]
use crate::table::arrow::{self, Kind};
use crate::table::columns::About;
#[cfg(feature = "numpy")]
use crate::table::numpy;
use crate::table::text::{Text, packed};
#[cfg(feature = "matlab")]
use crate::table::{hdf5, matlab};

/// What is known of a file that is open, or a table in memory.
#[derive(Debug)]
pub(super) enum Content {
    Text(Box<Text>),
    #[cfg(any(feature = "matlab", feature = "numpy"))]
    Arrays(Arrays),
    #[cfg(feature = "parquet")]
    Arrow(Kind),
    Memory(Arc<Recorded>),
}

/// Names of the columns, and the content.
type Opened = Result<(Vec<String>, Content), Error>;

type Write = fn(&Path, &[String], &[Vec<f64>]) -> Result<(), Error>;

/// A format of files that are no text.
pub(super) struct Format {
    pub(super) open: fn(&Path, &mut About) -> Opened,
    /// `None` if files are only read.
    write: Option<Write>,
    /// What is said of files that are known and not read.
    unread: Option<&'static str>,
}

impl Format {
    /// By the extension of a file; `None` of text.
    pub(super) fn of(extension: &str) -> Option<Self> {
        Some(match extension {
            #[cfg(feature = "matlab")]
            "mat" => Self::read(|path, about| arrays(matlab::open(path, about))).written(matlab::write),
            #[cfg(feature = "matlab")]
            "h5" | "hdf5" => Self::read(|path, about| arrays(hdf5::read(path, about))),
            #[cfg(feature = "numpy")]
            "npy" => Self::read(|path, about| arrays(numpy::read(path, about))),
            #[cfg(feature = "numpy")]
            "npz" => Self::read(|path, about| arrays(numpy::read(path, about))).written(numpy::write),
            #[cfg(feature = "parquet")]
            "parquet" => Self::read(|path, about| arrow(path, Kind::Parquet, about)).written(arrow::write_parquet),
            #[cfg(feature = "parquet")]
            "arrow" | "feather" => Self::read(|path, about| arrow(path, Kind::Ipc, about)).written(arrow::write_ipc),
            #[cfg(feature = "parquet")]
            "arrows" => Self::read(|path, about| arrow(path, Kind::Ipc, about)),
            #[cfg(not(feature = "matlab"))]
            "mat" | "h5" | "hdf5" => Self::left_out(),
            #[cfg(not(feature = "numpy"))]
            "npy" | "npz" => Self::left_out(),
            #[cfg(not(feature = "parquet"))]
            "parquet" | "arrow" | "feather" | "arrows" => Self::left_out(),
            "tdms" => Self::unread(
                "a TDMS file of LabVIEW, which is not read: export it as CSV, or write its channels as Parquet",
            ),
            "xlsx" => {
                Self::unread("an Excel workbook, which is not read: save its sheet as CSV, the labels as labels.csv")
            }
            _ => return None,
        })
    }

    const fn read(open: fn(&Path, &mut About) -> Opened) -> Self {
        Self { open, write: None, unread: None }
    }

    const fn written(self, write: Write) -> Self {
        Self { write: Some(write), ..self }
    }

    const fn unread(why: &'static str) -> Self {
        Self { unread: Some(why), ..Self::read(|path, _| Err(refused(path))) }
    }

    /// One that this program was built without.
    #[cfg(not(all(feature = "matlab", feature = "numpy", feature = "parquet")))]
    const fn left_out() -> Self {
        Self::read(|path, _| Err(refused(path))).written(|path, _, _| Err(refused(path)))
    }
}

/// The error of a file of a format that is not read, or that this program was built without.
fn refused(path: &Path) -> Error {
    let (extension, _) = extensions(&file_name(path)).unwrap_or_default();
    match Format::of(&extension).and_then(|format| format.unread) {
        Some(why) => Error::content(path, "content", why),
        None => {
            let problem = format!("this program was built without the format .{extension}; build it with all features");
            Error::content(path, "name", problem)
        }
    }
}

#[cfg(any(feature = "matlab", feature = "numpy"))]
fn arrays(read: Result<Arrays, Error>) -> Opened {
    read.map(|own| (own.names.clone(), Content::Arrays(own)))
}

#[cfg(feature = "parquet")]
fn arrow(path: &Path, kind: Kind, about: &mut About) -> Opened {
    Ok((arrow::names(path, kind, about)?, Content::Arrow(kind)))
}

/// Opens a file that is text by its name: columns, or the variables of Octave.
pub(super) fn open_text(path: &Path, form: &TextForm, about: &mut About) -> Opened {
    #[cfg(feature = "matlab")]
    if let Some(own) = matlab::octave::read(path, about)? {
        return arrays(Ok(own));
    }
    let text = Text::open(path, form, about)?;
    Ok((text.names(), Content::Text(Box::new(text))))
}

/// Whether a file has a format that is known and not read.
#[must_use]
pub fn is_unread(file: &Path) -> bool {
    let format = extensions(&file_name(file)).and_then(|(extension, _)| Format::of(&extension));
    format.is_some_and(|format| format.unread.is_some())
}

/// Writes columns of equal lengths by the extension of the name.
///
/// # Errors
/// An unknown extension, a format that this program was built without, a name that MATLAB does not allow, or a file
/// that cannot be written.
pub fn write(path: &Path, names: &[String], columns: &[Vec<f64>]) -> Result<(), Error> {
    let known = extensions(&file_name(path)).map(|(extension, packed)| (Format::of(&extension), extension, packed));
    let bytes = match known {
        Some((Some(Format { write: Some(write), .. }), ..)) => return write(path, names, columns),
        Some((None, extension, is_packed)) => {
            let text = text(names, columns, if extension == "tsv" { '\t' } else { ',' });
            if is_packed { packed(path, &text) } else { Ok(text.into_bytes()) }
        }
        _ => {
            let problem = "give a name that ends with .csv, .tsv, .mat, .parquet, .arrow or .npz";
            return Err(Error::Usage(format!("{}: {problem}", path.display())));
        }
    };
    bytes.and_then(|bytes| std::fs::write(path, bytes)).map_err(Error::io(path))
}

/// A number in the shortest form that is read back as the same bits.
fn number(x: f64) -> String {
    if x == 0.0 || (1e-4..1e15).contains(&x.abs()) { x.to_string() } else { format!("{x:e}") }
}

fn text(names: &[String], columns: &[Vec<f64>], separator: char) -> String {
    let quoted = |name: &String| {
        let name = cell(name);
        match name.contains([separator, '"', '\n', '\r', '\t']) {
            true => format!("\"{}\"", name.replace('"', "\"\"")),
            false => name.into_owned(),
        }
    };
    let mut text = names.iter().map(quoted).collect::<Vec<_>>().join(&separator.to_string());
    text.push('\n');
    for row in 0..columns.first().map_or(0, Vec::len) {
        for (k, column) in columns.iter().enumerate() {
            if k > 0 {
                text.push(separator);
            }
            text.push_str(&number(column[row]));
        }
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::{Table, Wanted};

    #[test]
    fn every_format_gives_back_the_same_bits() {
        let names = ["t_s".to_string(), "current_a".into()];
        let columns = [vec![0.0, 0.1, 0.2, 1e-7], vec![-0.1, 1.0 / 3.0, f64::MIN_POSITIVE, 1e14 + 0.015_625]];
        let folder = tempfile::tempdir().expect("a folder");
        for name in ["a.csv", "a.tsv", "a.csv.gz", "a.txt.zst", "a.mat", "a.parquet", "a.arrow", "a.npz"] {
            let path = folder.path().join(name);
            write(&path, &names, &columns).expect(name);
            let table = Table::open(&path).expect(name);
            // Archives may order their arrays.
            let places: Vec<usize> =
                names.iter().map(|own| table.names().iter().position(|other| other == own).expect(name)).collect();
            let read = table.read(Wanted { numbers: &places, text: None, row: &|_| true }).expect(name);
            assert_eq!(read.numbers, columns, "{name}");
        }
        // A name that a spreadsheet would compute is written as text, and read as it was.
        let formula = ["=1+1".to_string(), "-x".into()];
        let path = folder.path().join("f.csv");
        write(&path, &formula, &columns).expect("written");
        let text = std::fs::read_to_string(&path).expect("text");
        assert!(text.starts_with("'=1+1,'-x\n0,-0.1\n"), "{text}");
        assert_eq!(Table::open(&path).expect("read").names(), formula);
        assert!(write(&folder.path().join("a.xls"), &names, &columns).is_err());
        let wrong = write(&folder.path().join("a.mat"), &["i [A]".into()], &columns[..1]).expect_err("a bracket");
        assert!(wrong.to_string().contains("MATLAB allows no such name"), "{wrong}");
    }
}
