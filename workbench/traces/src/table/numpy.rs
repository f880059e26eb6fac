//! Archives of NumPy: each array is a column, a matrix several.

use std::fs::File;
use std::io::{BufReader, Cursor, Error as IoError, ErrorKind, Read};
use std::path::Path;

use npyz::{DType, NpyFile, Order, TypeChar, WriterBuilder as _};
use zip::ZipArchive;

use crate::damaged::{DAMAGED, guarded};
use crate::table::about::About;
use crate::table::arrays::of_one_length;
use crate::table::limit::{Limit, VALUE};
use model::Error;

/// Bytes of the longest header.
const LONGEST: usize = 1 << 16;
/// Bytes of the name and the list of a column.
const PER_COLUMN: u64 = 64;
/// Brackets within each other in a header, at most: the time of the parser is exponential in their number. The headers
/// of arrays of numbers have two.
const DEEPEST: usize = 6;

/// Returns names and columns. Arrays of one number are constant columns; arrays of other lengths than the longest, and
/// those of text, are left out.
pub(super) fn read(path: &Path, about: &mut About) -> Result<(Vec<String>, Vec<Vec<f64>>), Error> {
    let damaged = || Err(Error::content(path, "content", format!("not readable as .npz: {DAMAGED}")));
    of_one_length(path, guarded(|| arrays(path)).unwrap_or_else(damaged)?, about)
}

fn arrays(path: &Path) -> Result<Vec<(String, Vec<f64>)>, Error> {
    let wrong = |error: std::io::Error| Error::content(path, "content", format!("not readable as .npz: {error}"));
    let file = File::open(path).map_err(Error::io(path))?;
    let mut limit = Limit::of_file(path)?;
    let mut archive = ZipArchive::new(BufReader::new(file)).map_err(|error| wrong(error.into()))?;
    let mut found = Vec::new();
    for place in 0..archive.len() {
        let file = archive.by_index(place).map_err(|error| wrong(error.into()))?;
        let Some(name) = file.name().strip_suffix(".npy").map(String::from) else { continue };
        let array = opened(file).map_err(wrong)?;
        // All of it, also what is skipped: an archive may have many arrays, and one of them many columns of no rows.
        let claimed = limit.claim_numbers(array.shape().iter().copied()).and_then(|()| limit.claim(VALUE));
        let across = array.shape().get(1).copied().unwrap_or(1);
        let claimed = claimed.and_then(|()| limit.claim(across.saturating_mul(PER_COLUMN)));
        claimed.map_err(|problem| Error::content(path, format!("array {name}"), problem))?;
        found.extend(columns(&name, array).map_err(wrong)?);
    }
    Ok(found)
}

/// Checks the header, and has it parsed.
fn opened<R: Read>(mut file: R) -> std::io::Result<NpyFile<impl Read>> {
    let refused = |problem| IoError::new(ErrorKind::InvalidData, problem);
    let mut head = Vec::new();
    file.by_ref().take(12).read_to_end(&mut head)?;
    let length = match head[..] {
        [_, _, _, _, _, _, 1, _, low, high, ..] => 10 + usize::from(u16::from_le_bytes([low, high])),
        [_, _, _, _, _, _, _, _, a, b, c, d] => 12 + u32::from_le_bytes([a, b, c, d]) as usize,
        _ => return Err(refused("an array has no header")),
    };
    if length > LONGEST {
        return Err(refused("the header of an array is too long"));
    }
    file.by_ref().take(length.saturating_sub(head.len()) as u64).read_to_end(&mut head)?;
    let mut depth = 0_usize;
    for byte in &head {
        match byte {
            b'(' | b'[' | b'{' => depth += 1,
            b')' | b']' | b'}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth > DEEPEST {
            return Err(refused("the header of an array has too many brackets"));
        }
    }
    NpyFile::new(Cursor::new(head).chain(file))
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

/// Writes an archive with one array a column.
pub(super) fn write(path: &Path, names: &[String], columns: &[Vec<f64>]) -> std::io::Result<()> {
    let mut archive = zip::ZipWriter::new(File::create(path)?);
    for (name, column) in names.iter().zip(columns) {
        archive.start_file(format!("{name}.npy"), zip::write::SimpleFileOptions::default())?;
        let mut writer =
            npyz::WriteOptions::new().default_dtype().shape(&[column.len() as u64]).writer(&mut archive).begin_nd()?;
        writer.extend(column)?;
        writer.finish()?;
    }
    archive.finish()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An array of no values with this description.
    fn array(version: u8, header: &str) -> Vec<u8> {
        let length = (header.len() as u32).to_le_bytes();
        let length = if version == 1 { &length[..2] } else { &length[..] };
        [b"\x93NUMPY", &[version, 0][..], length, header.as_bytes()].concat()
    }

    #[test]
    fn headers_that_would_be_parsed_for_ever_are_refused() {
        let deep = "{(".repeat(59);
        let good = "{'descr': '<f8', 'fortran_order': False, 'shape': (0, ), }\n";
        for version in [1, 2] {
            let error = opened(&array(version, &deep)[..]).err().expect("too deep").to_string();
            assert!(error.contains("too many brackets"), "{error}");
            assert_eq!(opened(&array(version, good)[..]).expect("good").shape(), [0]);
        }
        let mut long = array(2, good);
        long[8..12].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(opened(&long[..]).is_err() && opened(&b"\x93NUMPY\x01\x00v"[..]).is_err());
    }

    /// Headers of archives of a few hundred bytes.
    #[test]
    fn arrays_that_claim_too_much_are_refused() {
        use std::io::Write as _;
        let path = tempfile::Builder::new().suffix(".npz").tempfile().expect("a file").into_temp_path();
        let read_with = |shapes: &[&str]| {
            let mut archive = zip::ZipWriter::new(File::create(&path).expect("a file"));
            for (k, shape) in shapes.iter().enumerate() {
                archive.start_file(format!("a{k}.npy"), zip::write::SimpleFileOptions::default()).expect("opened");
                let header = format!("{{'descr': '|i1', 'fortran_order': False, 'shape': ({shape}), }}\n");
                archive.write_all(&array(1, &header)).expect("written");
            }
            archive.finish().expect("written");
            read(&path, &mut About::default()).expect_err("too large, or no numbers").to_string()
        };
        for shape in ["2147483648,", "0, 2147483648", "65536, 65536", "1, 2, 999999999"] {
            let refused = read_with(&[shape]);
            assert!(refused.contains("array a0: it claims") && refused.contains("READ_LIMIT"), "{shape}: {refused}");
        }
        let refused = read_with(&["0,"; 3]);
        assert!(refused.contains("no arrays of numbers"), "{refused}");
    }
}
