//! Arrays of NumPy, alone or in an archive: each is a column, a matrix several, a structured one a column a field.

mod values;

use std::fs::File;
use std::io::{BufReader, Cursor, Error as IoError, ErrorKind, Read, Seek as _};
use std::path::Path;

use npyz::{DType, NpyFile, Order, WriterBuilder as _};
use zip::ZipArchive;

use crate::damaged::{DAMAGED, guarded};
use crate::table::arrays::columns::{along_longer, matrix, of_one_length, without_variable};
use crate::table::arrays::groups::Named;
use crate::table::arrays::records::Arrays;
use crate::table::columns::About;
use crate::table::limit::{Limit, VALUE};
use model::Error;
use values::{Values, columns, numbers_of};

/// Bytes of the longest header.
const LONGEST: usize = 1 << 16;
/// Bytes of the name and the list of a column.
const PER_COLUMN: u64 = 64;
/// Brackets within each other in a header, at most: the time of the parser is exponential in their number. The headers
/// of arrays of numbers have two.
const DEEPEST: usize = 6;
/// The first bytes of an array, and of an archive.
const ARRAY: &[u8] = b"\x93NUMPY";
const ARCHIVE: &[u8] = b"PK";

/// Returns names and columns. Arrays of one number are constant columns; arrays of other lengths than the longest, and
/// those of text, are left out. The columns of an array alone are called c1, c2 and so on, as those of text are.
pub(super) fn read(path: &Path, about: &mut About) -> Result<Arrays, Error> {
    let damaged = || Err(Error::content(path, "content", format!("not readable as NumPy's arrays: {DAMAGED}")));
    let found = guarded(|| arrays(path, about)).unwrap_or_else(damaged)?;
    let (mut columns, mut times) = (found.columns, found.times);
    without_variable(&mut columns, &mut times);
    let (names, columns) = of_one_length(path, columns, about)?;
    about.clocks.extend(times.iter().filter_map(|time| names.iter().position(|name| name == time)));
    Ok((names, columns).into())
}

/// What is found of a file.
struct Found<'a> {
    columns: Named,
    /// Names of the columns that are times.
    times: Vec<String>,
    about: &'a mut About,
}

fn arrays<'a>(path: &Path, about: &'a mut About) -> Result<Found<'a>, Error> {
    let wrong =
        |error: IoError| Error::content(path, "content", format!("not readable as NumPy's arrays: {error}; {DAMAGED}"));
    let mut file = File::open(path).map_err(Error::io(path))?;
    let mut mark = Vec::new();
    file.by_ref().take(ARRAY.len() as u64).read_to_end(&mut mark).map_err(Error::io(path))?;
    file.rewind().map_err(Error::io(path))?;
    let (mut found, mut limit) = (Found { columns: vec![], times: vec![], about }, Limit::of_file(path)?);
    if mark == ARRAY {
        let array = opened(BufReader::new(file)).map_err(wrong)?;
        found.add(path, None, array, &mut limit)?;
        return Ok(found);
    }
    if !mark.starts_with(ARCHIVE) {
        return Err(wrong(refused("it starts neither as an array nor as an archive")));
    }
    let mut archive = ZipArchive::new(BufReader::new(file)).map_err(|error| wrong(error.into()))?;
    for place in 0..archive.len() {
        let file = archive.by_index(place).map_err(|error| wrong(error.into()))?;
        let Some(name) = file.name().strip_suffix(".npy").map(String::from) else { continue };
        found.add(path, Some(&name), opened(file).map_err(wrong)?, &mut limit)?;
    }
    Ok(found)
}

impl Found<'_> {
    /// Adds the columns of an array; one alone has no name.
    fn add<R: Read>(
        &mut self,
        path: &Path,
        name: Option<&str>,
        array: NpyFile<R>,
        limit: &mut Limit,
    ) -> Result<(), Error> {
        let place = format!("array {}", name.unwrap_or("of the file"));
        let (shape, order, kind) = (array.shape().to_vec(), array.order(), array.dtype());
        let parts = numbers_of(&kind);
        // All of it, also what is skipped: an archive may have many arrays, and one of them many columns of no rows.
        let across = shape.get(1).copied().unwrap_or(1).saturating_mul(parts);
        let claimed = limit.claim_numbers(shape.iter().copied().chain([parts])).and_then(|()| limit.claim(VALUE));
        let claimed = claimed.and_then(|()| limit.claim(across.saturating_mul(PER_COLUMN)));
        let size = kind.num_bytes().map_or(u64::MAX, |size| size as u64);
        let size = shape.iter().fold(size, |size, side| size.saturating_mul(*side));
        // Objects have no size.
        let claimed = claimed.and_then(|()| if size == u64::MAX { Ok(()) } else { limit.claim(size) });
        claimed.map_err(|problem| Error::content(path, &place, problem))?;
        let long: Vec<usize> = shape.iter().filter(|side| **side != 1).map(|side| *side as usize).collect();
        let mut omit = |reason: &str| self.about.omit(&place, reason);
        if long.len() > 2 {
            omit("more than two dimensions: save it as a matrix");
            return Ok(());
        }
        if kind.uses_pickled_array() {
            omit("objects of Python: save it as numbers");
            return Ok(());
        }
        let mut bytes = Vec::new();
        let read = array.into_inner().take(size).read_to_end(&mut bytes);
        let read = read.map_err(|error| error.to_string());
        if read.and_then(|read| if read as u64 == size { Ok(()) } else { Err("it ends early".into()) }).is_err() {
            return Err(Error::content(path, place, format!("it ends early; {DAMAGED}")));
        }
        let base = name.map_or(String::new(), String::from);
        for Values { name: part, values, is_time } in columns(&kind, &bytes) {
            let own = match (&kind, name) {
                (DType::Record(_), None) => part.trim_start_matches('.').to_string(),
                _ => format!("{base}{part}"),
            };
            match values {
                Err(reason) if name.is_none() && own.is_empty() => self.about.omit(&place, reason),
                Err(reason) => self.about.omit(format!("array {own}"), reason),
                Ok(values) if is_time && values.len() < 2 => {
                    self.about.omit(format!("array {own}"), "a single time");
                }
                Ok(values) => {
                    let is_bare = name.is_none() && !matches!(kind, DType::Record(_));
                    let named = sides(&own, is_bare.then_some(&*part), &long, order, values);
                    if is_time {
                        self.times.extend(named.iter().map(|(name, _)| name.clone()));
                    }
                    self.columns.extend(named);
                }
            }
        }
        Ok(())
    }
}

/// The columns of values along the longer of two sides; those without a name are called c1, c2 and so on, with what
/// their part is called behind it.
fn sides(name: &str, bare: Option<&str>, long: &[usize], order: Order, values: Vec<f64>) -> Named {
    let by_rows = order == Order::C;
    match (long, bare) {
        (&[rows, across], None) => matrix(name, [rows, across], by_rows, &values),
        (&[rows, across], Some(part)) => {
            let names = (1..).map(|k| format!("c{k}{part}"));
            names.zip(along_longer([rows, across], by_rows, &values)).collect()
        }
        (_, Some(part)) => vec![(format!("c1{part}"), values)],
        (_, None) => vec![(name.to_string(), values)],
    }
}

fn refused(problem: &'static str) -> IoError {
    IoError::new(ErrorKind::InvalidData, problem)
}

/// Checks the header, and has it parsed.
fn opened<R: Read>(mut file: R) -> std::io::Result<NpyFile<impl Read>> {
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

/// Writes an archive with one array a column.
pub(super) fn write(path: &Path, names: &[String], columns: &[Vec<f64>]) -> Result<(), Error> {
    archive(path, names, columns).map_err(Error::io(path))
}

fn archive(path: &Path, names: &[String], columns: &[Vec<f64>]) -> std::io::Result<()> {
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

    /// Names, columns, and what was left out.
    type Parts = (Vec<String>, Vec<Vec<f64>>, About);

    /// What is read of an array that is alone.
    fn read_array(kind: &str, shape: &str, content: &[u8]) -> Result<Parts, String> {
        let path = tempfile::Builder::new().suffix(".npy").tempfile().expect("a file").into_temp_path();
        let header = format!("{{'descr': {kind}, 'fortran_order': False, 'shape': ({shape}), }}\n");
        std::fs::write(&path, [&array(1, &header), content].concat()).expect("writable");
        let mut about = About::default();
        let Arrays { names, columns, .. } = read(&path, &mut about).map_err(|error| error.to_string())?;
        Ok((names, columns, about))
    }

    #[test]
    fn columns_are_along_the_longer_side() {
        let six: Vec<u8> = (1..=6).collect();
        for (shape, expected) in [
            ("6,", vec![vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0]]),
            ("1, 6", vec![vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0]]),
            ("6, 1", vec![vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0]]),
            ("2, 3", vec![vec![1.0, 2.0, 3.0], vec![4.0, 5.0, 6.0]]),
            ("3, 2", vec![vec![1.0, 3.0, 5.0], vec![2.0, 4.0, 6.0]]),
        ] {
            let (names, columns, _) = read_array("'|u1'", shape, &six).expect(shape);
            assert_eq!(columns, expected, "{shape}");
            assert_eq!(names, ["c1", "c2"][..expected.len()], "{shape}");
        }
        let refused = read_array("'|u1'", "7,", &six).expect_err("one is missing");
        assert!(refused.contains("array of the file: it ends early"), "{refused}");
        let refused = read_array("'<f8'", "2147483648,", &six).expect_err("too large");
        assert!(refused.contains("it claims") && refused.contains("READ_LIMIT"), "{refused}");
    }

    #[test]
    fn numbers_and_times_of_every_type_are_read() {
        let columns = |kind: &str, content: &[u8]| read_array(kind, "2,", content).expect(kind);
        assert_eq!(columns("'<f2'", &[0, 0x38, 0, 0xC0]).1, [[0.5, -2.0]]);
        assert_eq!(columns("'>f2'", &[0x38, 0, 0xC0, 0]).1, [[0.5, -2.0]]);
        assert_eq!(columns("'>i4'", &[0, 0, 1, 0, 255, 255, 255, 255]).1, [[256.0, -1.0]]);
        assert_eq!(columns("'|b1'", &[1, 0]).1, [[1.0, 0.0]]);
        let floats = |values: &[f32]| values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
        let (names, complex, _) = columns("'<c8'", &floats(&[1.0, -1.0, 2.0, 0.5]));
        assert_eq!((names, complex), (vec!["c1_re".into(), "c1_im".into()], vec![vec![1.0, 2.0], vec![-1.0, 0.5]]));
        let times = |values: [i64; 2]| values.map(i64::to_le_bytes).concat();
        let day = 1_795_651_200_000_000_007;
        for kind in ["'<M8[ns]'", "'<m8[ns]'"] {
            let (_, found, about) = columns(kind, &times([day, day + 62_500]));
            assert_eq!((found, about.clocks), (vec![vec![0.0, 62_500.0 / 1e9]], vec![0]), "{kind}");
        }
        assert!(columns("'<M8[D]'", &times([3, i64::MIN])).1[0][1].is_nan());
        for (kind, reason) in [("'<M8[M]'", "times of an unknown unit"), ("'<U1'", "text"), ("'<f16'", "save it as")] {
            let refused = read_array(kind, "2,", &[0; 32]).expect_err("no numbers");
            assert!(refused.contains("left out: array of the file: ") && refused.contains(reason), "{refused}");
        }
        let refused = read_array("'|O'", "2,", &[0; 32]).expect_err("no numbers");
        assert!(refused.contains("objects of Python"), "{refused}");
    }

    #[test]
    fn fields_of_a_structure_are_columns() {
        let kind = "[('time', '<m8[s]'), ('i', '|i1'), ('', '|V2'), ('pair', '|u1', (2,)), ('name', '|S1')]";
        let row = |time: u8, i: u8| [&[time, 0, 0, 0, 0, 0, 0, 0, i, 9, 9, 3, 4], &b"x"[..]].concat();
        let (names, columns, about) = read_array(kind, "2,", &[row(5, 1), row(7, 255)].concat()).expect("fields");
        assert_eq!(names, ["time", "i", "pair_1", "pair_2"]);
        assert_eq!(columns, [[0.0, 2.0], [1.0, -1.0], [3.0, 3.0], [4.0, 4.0]]);
        assert_eq!(
            (about.clocks, &*about.omitted[0].place, &*about.omitted[0].reason),
            (vec![0], "array name", "text")
        );
    }
}
