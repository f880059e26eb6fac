//! Archives of NumPy: each array is a column, a matrix several.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use npyz::{DType, NpyFile, Order, TypeChar};
use zip::ZipArchive;

use super::of_one_length;
use crate::Error;
use crate::damaged::{DAMAGED, guarded};

/// Returns names and columns. Arrays of one number are constant columns; arrays of other lengths than the longest, and
/// those of text, are left out.
pub(super) fn read(path: &Path) -> Result<(Vec<String>, Vec<Vec<f64>>), Error> {
    let damaged = || Err(Error::content(path, "content", format!("not readable as .npz: {DAMAGED}")));
    of_one_length(path, guarded(|| arrays(path)).unwrap_or_else(damaged)?)
}

fn arrays(path: &Path) -> Result<Vec<(String, Vec<f64>)>, Error> {
    let wrong = |error: std::io::Error| Error::content(path, "content", format!("not readable as .npz: {error}"));
    let file = File::open(path).map_err(Error::io(path))?;
    let mut archive = ZipArchive::new(BufReader::new(file)).map_err(|error| wrong(error.into()))?;
    let mut found = Vec::new();
    for place in 0..archive.len() {
        let file = archive.by_index(place).map_err(|error| wrong(error.into()))?;
        let Some(name) = file.name().strip_suffix(".npy").map(String::from) else { continue };
        found.extend(columns(&name, NpyFile::new(file).map_err(wrong)?).map_err(wrong)?);
    }
    Ok(found)
}

fn columns<R: Read>(name: &str, array: NpyFile<R>) -> std::io::Result<Vec<(String, Vec<f64>)>> {
    let (shape, order) = (array.shape().to_vec(), array.order());
    let Some(values) = numbers(array)? else { return Ok(vec![]) };
    Ok(match shape[..] {
        [] | [_] => vec![(name.to_string(), values)],
        [rows, across] => {
            let (rows, across) = (rows as usize, across as usize);
            let value = |row: usize, column: usize| match order {
                Order::C => values[row * across + column],
                Order::Fortran => values[column * rows + row],
            };
            let column = |k: usize| (format!("{name}_{}", k + 1), (0..rows).map(|row| value(row, k)).collect());
            (0..across).map(column).collect()
        }
        _ => vec![],
    })
}

/// The numbers of an array; `None` if it has none.
fn numbers<R: Read>(array: NpyFile<R>) -> std::io::Result<Option<Vec<f64>>> {
    macro_rules! all {
        ($kind:ty, $convert:expr) => {
            array.into_vec::<$kind>()?.into_iter().map($convert).collect()
        };
    }
    let DType::Plain(kind) = array.dtype() else { return Ok(None) };
    Ok(Some(match (kind.type_char(), kind.size_field()) {
        (TypeChar::Float, 8) => array.into_vec()?,
        (TypeChar::Float, 4) => all!(f32, f64::from),
        (TypeChar::Int, 1) => all!(i8, f64::from),
        (TypeChar::Int, 2) => all!(i16, f64::from),
        (TypeChar::Int, 4) => all!(i32, f64::from),
        (TypeChar::Int, 8) => all!(i64, |x| x as f64),
        (TypeChar::Uint, 1) => all!(u8, f64::from),
        (TypeChar::Uint, 2) => all!(u16, f64::from),
        (TypeChar::Uint, 4) => all!(u32, f64::from),
        (TypeChar::Uint, 8) => all!(u64, |x| x as f64),
        (TypeChar::Bool, _) => all!(bool, |x| f64::from(u8::from(x))),
        _ => return Ok(None),
    }))
}
