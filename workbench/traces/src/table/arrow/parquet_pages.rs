//! The headers of a Parquet file's pages, which its reader trusts.
//!
//! A header is a structure of Thrift's compact protocol. The reader skips unknown fields; at a list of texts it asks
//! the end of the file for each of as many texts as the list claims. Headers of the format have no lists, sets or maps,
//! so a file with one is refused. It reserves memory for as many values as a dictionary claims; each has a byte at
//! least. A page of a few bytes can hold any number of equal values, so that the sizes of all pages without compression
//! and the numbers of their values stay within the limit of the file. What else is wrong, the reader says.

use std::fs::File;
use std::io::{BufRead, BufReader, Seek, SeekFrom};

use crate::table::limit::Limit;
use parquet::errors::ParquetError;
use parquet::file::metadata::ParquetMetaData;

/// Structures within structures; headers have two.
const DEEPEST: u8 = 8;
/// The field of a header with the size of the page without compression.
const BYTES: i64 = 2;
/// That with the size of the page behind it.
const SIZE: i64 = 3;
/// That with the structure of a dictionary's page.
const DICTIONARY: i64 = 7;
/// Those with the structure of a page of data, in both versions.
const DATA: [i64; 2] = [5, 8];
/// The field of these structures with the number of values.
const VALUES: i64 = 1;

/// Refuses a file with a list in a header of a page of these columns, by their place in the table, with a dictionary
/// that has more values than bytes, or with pages that become too large. Returns the size of the largest dictionary.
///
/// # Errors
/// A list, a dictionary of more values than bytes, more than the limit.
pub fn check(file: &File, metadata: &ParquetMetaData, wanted: impl Fn(usize) -> bool) -> Result<u64, ParquetError> {
    let Ok(length) = file.metadata().map(|about| about.len()) else { return Ok(0) };
    within(Limit::of(length), (file, length), metadata, wanted)
}

fn within(
    mut limit: Limit,
    (file, length): (&File, u64),
    metadata: &ParquetMetaData,
    wanted: impl Fn(usize) -> bool,
) -> Result<u64, ParquetError> {
    let mut largest = 0;
    // Headers are short; pages are not read.
    let mut reader = BufReader::with_capacity(256, file);
    let schema = metadata.file_metadata().schema_descr();
    let all = metadata.row_groups().iter().flat_map(|group| group.columns().iter().enumerate());
    for (_, column) in all.filter(|(leaf, _)| wanted(schema.get_column_root_idx(*leaf))) {
        let (start, bytes) = column.byte_range();
        let end = start.saturating_add(bytes).min(length);
        let mut at = start;
        while at < end {
            if reader.seek(SeekFrom::Start(at)).is_err() {
                break;
            }
            let mut header = Header { reader: &mut reader, left: end - at, page: Page::default() };
            let wrong = match header.fields(DEEPEST, None) {
                Err(Wrong::List) => "the header of a page has a list".to_string(),
                Ok(()) if header.page.values > header.page.bytes => "a dictionary has more values than bytes".into(),
                Ok(()) => {
                    let Page { size, bytes, values, rows } = header.page;
                    if values > 0 {
                        largest = bytes.max(largest);
                    }
                    match (limit.claim(bytes).and_then(|()| limit.claim_numbers([rows])), size) {
                        (Ok(()), Some(size)) => {
                            at = (end - header.left).saturating_add(size);
                            continue;
                        }
                        (Ok(()), None) => break,
                        (Err(problem), _) => problem,
                    }
                }
                Err(Wrong::Malformed) => break,
            };
            return Err(ParquetError::General(format!("column {}: {wrong}", column.column_path().string())));
        }
    }
    Ok(largest)
}

/// Why a header is not read.
#[derive(Debug, PartialEq, Eq)]
enum Wrong {
    List,
    Malformed,
}

/// What a header says of its page.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Page {
    /// Size of the page behind the header.
    size: Option<u64>,
    /// Its size without compression.
    bytes: u64,
    /// Number of values of a dictionary.
    values: u64,
    /// Number of values of a page of data.
    rows: u64,
}

/// A header, and how many bytes it may have.
struct Header<R> {
    reader: R,
    left: u64,
    page: Page,
}

impl<R: BufRead> Header<R> {
    /// Reads a structure: the header, or that of its field `within`.
    fn fields(&mut self, deepest: u8, within: Option<i64>) -> Result<(), Wrong> {
        let mut id = 0_i64;
        loop {
            let head = self.byte()?;
            let (delta, kind) = (i64::from(head >> 4), head & 0xf);
            if kind == 0 {
                return Ok(());
            }
            id = if delta == 0 { self.integer()? } else { id.saturating_add(delta) };
            match kind {
                // Their value is in the kind.
                1 | 2 => {}
                3 => self.skip(1)?,
                4..=6 => {
                    let value = u64::try_from(self.integer()?);
                    match (within, id) {
                        (None, BYTES) => self.page.bytes = value.unwrap_or(0),
                        (None, SIZE) => self.page.size = value.ok(),
                        // The reader takes a negative number for a large one.
                        (Some(DICTIONARY), VALUES) => self.page.values = value.unwrap_or(u64::MAX),
                        (Some(within), VALUES) if DATA.contains(&within) => self.page.rows = value.unwrap_or(u64::MAX),
                        _ => {}
                    }
                }
                7 => self.skip(8)?,
                8 => {
                    let length = self.varint()?;
                    self.skip(length)?;
                }
                9..=11 => return Err(Wrong::List),
                12 => {
                    let deeper = deepest.checked_sub(1).ok_or(Wrong::Malformed)?;
                    // A structure within a structure is none of the header's own.
                    self.fields(deeper, Some(if within.is_none() { id } else { 0 }))?;
                }
                13 => self.skip(16)?,
                _ => return Err(Wrong::Malformed),
            }
        }
    }

    fn byte(&mut self) -> Result<u8, Wrong> {
        let buffer = self.reader.fill_buf().map_err(|_io| Wrong::Malformed)?;
        let byte = *buffer.first().ok_or(Wrong::Malformed)?;
        self.left = self.left.checked_sub(1).ok_or(Wrong::Malformed)?;
        self.reader.consume(1);
        Ok(byte)
    }

    fn skip(&mut self, bytes: u64) -> Result<(), Wrong> {
        // A length beyond the chunk ends here, before it is read.
        if bytes > self.left {
            return Err(Wrong::Malformed);
        }
        for _ in 0..bytes {
            self.byte()?;
        }
        Ok(())
    }

    /// Seven bits a byte, the lowest first.
    fn varint(&mut self) -> Result<u64, Wrong> {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            value |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Ok(value);
            }
        }
        Err(Wrong::Malformed)
    }

    /// A signed one: its sign is the lowest bit.
    fn integer(&mut self) -> Result<i64, Wrong> {
        let value = self.varint()?;
        Ok((value >> 1).cast_signed() ^ -(value & 1).cast_signed())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::{Table, Wanted, write};

    /// What is said of a file of this column in whose first pages bytes are others.
    fn refused(column: Vec<f64>, change: impl FnOnce(&mut Vec<u8>)) -> String {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("t.parquet");
        write(&path, &["a".into()], &[column]).expect("written");
        let mut bytes = std::fs::read(&path).expect("read");
        change(&mut bytes);
        std::fs::write(&path, bytes).expect("writable");
        let table = Table::open(&path).expect("the names of its columns are in its footer");
        table.read(Wanted { numbers: &[0], text: None, row: &|_| true }).expect_err("forged").to_string()
    }

    /// Without the checks the reader asks for as many texts as a list claims, for minutes, or reserves as many values
    /// as a dictionary claims.
    #[test]
    fn lists_in_headers_and_dictionaries_of_more_values_than_bytes_are_refused() {
        let said = refused(vec![1.0, 2.0], |bytes| {
            // The first page starts behind the mark of the format: the type becomes a list of 2³⁰ texts.
            assert_eq!(bytes[4], 0x15);
            bytes[4..11].copy_from_slice(&[0x19, 0xf8, 0x80, 0x80, 0x80, 0x80, 4]);
        });
        assert!(said.contains("column a: the header of a page has a list"), "{said}");
        let said = refused((0..50).map(|k| f64::from(k % 2)).collect(), |bytes| {
            // A dictionary's page of two values; its number of values becomes −1.
            let place = bytes.windows(3).position(|own| own == [0x4c, 0x15, 4]).expect("a dictionary") + 2;
            bytes[place] = 1;
        });
        assert!(said.contains("column a: a dictionary has more values than bytes"), "{said}");
    }

    /// Headers, what they say, and how many bytes are left behind them.
    #[test]
    fn headers_say_sizes_and_numbers_of_values() {
        let read = |bytes: &[u8]| {
            let mut header = Header { reader: bytes, left: bytes.len() as u64, page: Page::default() };
            (header.fields(DEEPEST, None).map(|()| header.page), header.left)
        };
        let page = Page::default();
        for (header, said, left) in [
            // Type 0, 300 and 200 bytes, statistics with a text and a boolean in the structure of field 5.
            (
                &[0x15, 0, 0x15, 0xd8, 4, 0x15, 0x90, 3, 0x2c, 0x18, 2, b'a', b'b', 0x11, 0, 0, 9][..],
                Page { size: Some(200), bytes: 300, ..page },
                1,
            ),
            // The identifier of a field in full, 3; its value −1.
            (&[0x05, 6, 1, 0], page, 0),
            // 16 bytes; in the structure of field 7 three values, and a structure whose first field is none of its own.
            (
                &[0x25, 32, 0x15, 32, 0x4c, 0x15, 6, 0x1c, 0x15, 20, 0, 0, 0],
                Page { size: Some(16), bytes: 16, values: 3, rows: 0 },
                0,
            ),
            (&[0x7c, 0x15, 1, 0, 0], Page { values: u64::MAX, ..page }, 0),
            (&[0x5c, 0x15, 20, 0, 0], Page { rows: 10, ..page }, 0),
            (&[0x8c, 0x15, 1, 0, 0], Page { rows: u64::MAX, ..page }, 0),
        ] {
            assert_eq!(read(header), (Ok(said), left));
        }
        for kind in [9, 10, 11] {
            assert_eq!(read(&[0x15, 0, 0x20 | kind, 0xff, 0xff, 0xff, 0xff, 7]).0, Err(Wrong::List));
        }
        let text_beyond_the_end = [0x18, 0xff, 0xff, 0xff, 0xff, 7, 0];
        for malformed in [&text_beyond_the_end[..], &[0x1c; 100], &[0x16, 0xff, 0xff], &[0x1f], &[]] {
            assert_eq!(read(malformed).0, Err(Wrong::Malformed));
        }
    }

    /// A column of equal values takes a few bytes, however many they are.
    #[test]
    fn equal_values_beyond_the_limit_are_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("t.parquet");
        write(&path, &["a".into(), "b".into()], &[vec![1.0; 1 << 20], vec![2.0; 1 << 20]]).expect("written");
        let length = path.metadata().expect("there").len();
        let file = File::open(&path).expect("there");
        let reader =
            parquet::file::reader::SerializedFileReader::new(file.try_clone().expect("open")).expect("readable");
        let metadata = parquet::file::reader::FileReader::metadata(&reader);
        assert!(length < 1 << 16 && check(&file, metadata, |_| true).is_ok(), "{length}");
        // One column has eight megabytes.
        let mut limit = Limit::of(1);
        let rest = limit.left() - (12 << 20);
        assert_eq!(limit.claim(rest), Ok(()));
        assert!(within(limit.clone(), (&file, length), metadata, |place| place == 0).is_ok());
        let refused = within(limit, (&file, length), metadata, |_| true).expect_err("16 megabytes").to_string();
        assert!(refused.contains("column b: it claims") && refused.contains("READ_LIMIT"), "{refused}");
    }
}
