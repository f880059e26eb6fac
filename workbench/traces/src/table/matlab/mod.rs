//! MATLAB files: variables of formats 4 to 7, and of format 7.3, which is HDF5.
//!
//! [`variables`] says which columns the variables become.

mod arrays;
mod elements;
mod format_4;
pub(super) mod octave;
mod value;
mod variables;
mod writer;

use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use hdf5_pure::mat::MatError;

use crate::damaged::guarded;
use crate::table::arrays::records::Arrays;
use crate::table::columns::About;
use crate::table::hdf5::{claims, links};
use crate::table::limit;
use model::Error;
use value::Value;
use variables::columns_of_variables;

pub(super) use writer::write;

/// What a file of format 7.3 has behind its text header.
const HDF5_AT: usize = 512;
const HDF5: &[u8] = b"\x89HDF";
/// The formats of these files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Four,
    Elements,
    Hdf5,
}

impl Format {
    /// By the first bytes of a file.
    fn of(head: &[u8]) -> Option<Self> {
        if head.starts_with(HDF5) || head.get(HDF5_AT..).is_some_and(|rest| rest.starts_with(HDF5)) {
            Some(Self::Hdf5)
        } else if elements::is_header(head) {
            Some(Self::Elements)
        } else {
            format_4::is_header(head).then_some(Self::Four)
        }
    }
}

/// Opens a file, also one of Octave's text.
pub(super) fn open(path: &Path, about: &mut About) -> Result<Arrays, Error> {
    octave::read(path, about)?.map_or_else(|| read(path, about), Ok)
}

/// Returns names and columns, of one record or of several.
fn read(path: &Path, about: &mut About) -> Result<Arrays, Error> {
    let unreadable = || {
        let problem = "not readable as a MATLAB file of format 4 to 7.3; save it again, e.g. with -v7";
        Error::content(path, "content", problem)
    };
    let mut head = Vec::new();
    let file = File::open(path).map_err(Error::io(path))?;
    // A file that is something else may be large.
    file.take((HDF5_AT + HDF5.len()) as u64).read_to_end(&mut head).map_err(Error::io(path))?;
    let format = Format::of(&head).ok_or_else(unreadable)?;
    let bytes = limit::whole(path)?;
    let value = guarded(|| match format {
        Format::Hdf5 => of_hdf5(&bytes, about),
        Format::Elements => of_elements(&bytes),
        Format::Four => Ok(format_4::variables(&bytes)),
    });
    let value = value.unwrap_or(Ok(None)).map_err(|problem| Error::content(path, "content", problem))?;
    let Some(Value::Fields(variables)) = value else { return Err(unreadable()) };
    columns_of_variables(path, &variables, about)
}

/// Reads the variables of format 7.3.
fn of_hdf5(bytes: &[u8], about: &mut About) -> Result<Option<Value>, String> {
    claims::check(bytes)?;
    let links = links::links(bytes);
    let first = links.first().map(|(place, reason)| format!("{place} is {reason}; replace it by the array"));
    links.into_iter().for_each(|(place, reason)| about.omit(place, reason));
    let unreadable = |error: MatError| {
        let cause = first.unwrap_or_else(|| error.to_string());
        format!("not readable as a MATLAB file of format 7.3: {cause}, or save it with -v7")
    };
    hdf5_pure::mat::from_bytes(bytes).map(Some).map_err(unreadable)
}

/// Reads the variables of format 5 to 7.
fn of_elements(bytes: &[u8]) -> Result<Option<Value>, String> {
    let Some(plain) = elements::unpacked(bytes)? else { return Ok(None) };
    let Some((arrays, is_little)) = elements::outermost(&plain) else { return Ok(None) };
    let named: Option<Vec<_>> = arrays.into_iter().map(|content| arrays::named(content, is_little)).collect();
    // Objects have their content in an array without a name.
    Ok(named.map(|all| Value::Fields(all.into_iter().filter(|(name, _)| !name.is_empty()).collect())))
}

#[cfg(test)]
mod tests {
    use serde::Serialize;

    use super::*;

    fn read_bytes(bytes: &[u8]) -> Result<(Vec<String>, Vec<Vec<f64>>), String> {
        let file = tempfile::Builder::new().suffix(".mat").tempfile().expect("a file");
        std::fs::write(file.path(), bytes).expect("writable");
        let Arrays { names, columns, .. } =
            read(file.path(), &mut About::default()).map_err(|error| error.to_string())?;
        Ok((names, columns))
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

    /// Each complex number comes as a structure.
    #[test]
    fn complex_numbers_and_lists_of_format_7_3_are_columns() {
        use hdf5_pure::mat::Complex64;

        #[derive(Serialize)]
        struct File {
            z: Vec<Complex64>,
            pair: Vec<Vec<Complex64>>,
            cells: (Vec<f64>, Vec<f64>, String),
        }
        let number = |k: usize| Complex64::new(k as f64, 0.5 - k as f64);
        let z: Vec<Complex64> = (0..20_000).map(number).collect();
        let pair = z.iter().map(|own| vec![*own, number(3)]).collect();
        let file = File { z, pair, cells: (vec![1.0; 20_000], vec![2.0, 3.0], "x".into()) };
        let (names, columns) = read_bytes(&hdf5_pure::mat::to_bytes(&file).expect("written")).expect("read");
        let column = |name: &str| &columns[names.iter().position(|own| own == name).expect("a column")];
        assert_eq!(names.len(), 7, "{names:?}");
        assert_eq!((column("z_re")[7], column("z_im")[7], column("pair_re_1")[7]), (7.0, -6.5, 7.0));
        assert_eq!((column("pair_im_2")[9], column("cells(1)")[3]), (-2.5, 1.0));
    }

    #[test]
    fn damaged_files_are_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("x.mat");
        write(&path, &["x".into()], &[vec![1.0, 2.0, 3.0]]).expect("written");
        let good = std::fs::read(&path).expect("read");
        assert_eq!(read_bytes(&good).expect("good").1, [[1.0, 2.0, 3.0]]);
        for length in [0, 5, 127, 130, good.len() - 7] {
            let problem = read_bytes(&good[..length]).expect_err("cut");
            assert!(problem.contains("not readable as a MATLAB file") || problem.contains("no arrays"), "{problem}");
        }
    }
}
