//! Columns of numbers → a MATLAB file of format 7, whose elements are those of [`super::elements`].

use std::io::Write as _;
use std::path::Path;

use flate2::Compression;
use flate2::write::ZlibEncoder;

use model::Error;

/// Types of elements.
const TEXT: u32 = 1;
const SIDES: u32 = 5;
const FLAGS: u32 = 6;
const DOUBLES: u32 = 9;
const ARRAY: u32 = 14;
const PACKED: u32 = 15;
/// Class of arrays of doubles.
const CLASS: u8 = 6;
/// Bytes of the longest name.
const NAME: usize = 63;
/// Numbers of an array, whose size is below 2³¹ bytes with its name.
const LONGEST: usize = (1 << 28) - 64;

/// Writes a file.
///
/// # Errors
/// A name that MATLAB does not allow, a column that is longer than the format allows, or a file that cannot be written.
pub(in crate::table) fn write(path: &Path, names: &[String], columns: &[Vec<f64>]) -> Result<(), Error> {
    let mut bytes = header();
    for (name, column) in names.iter().zip(columns) {
        let wrong = |problem: &str| Err(Error::content(path, format!("column {name}"), problem));
        let allowed = |c: char| c.is_ascii_alphanumeric() || c == '_';
        if !name.starts_with(|c: char| c.is_ascii_alphabetic()) || !name.chars().all(allowed) || name.len() > NAME {
            return wrong("MATLAB allows no such name; give another one with NAME=CHANNEL");
        }
        if column.len() >= LONGEST {
            return wrong("too long for a MATLAB file of format 7; write it as Parquet");
        }
        let values: Vec<u8> = column.iter().flat_map(|value| value.to_le_bytes()).collect();
        let array = array(CLASS, 0, &[column.len() as u32, 1], name, &element(DOUBLES, &values));
        bytes.extend(packed(&array).map_err(Error::io(path))?);
    }
    std::fs::write(path, bytes).map_err(Error::io(path))
}

/// The header: a text, the version, and the mark of little-endian numbers.
pub(super) fn header() -> Vec<u8> {
    let mut bytes = b"MATLAB 5.0 MAT-file, written by bearing-watch".to_vec();
    bytes.resize(124, b' ');
    bytes.extend([0, 1, b'I', b'M']);
    bytes
}

/// An element; one of up to four bytes is in the short form.
pub(super) fn element(kind: u32, content: &[u8]) -> Vec<u8> {
    let size = content.len() as u32;
    let (mut whole, unit) = match size {
        1..=4 => ((kind | size << 16).to_le_bytes().to_vec(), 4),
        _ => ([kind, size].map(u32::to_le_bytes).concat(), 8),
    };
    whole.extend(content);
    whole.resize(whole.len().next_multiple_of(unit), 0);
    whole
}

/// An array of a class, with flags, sides and name, and what is behind these.
pub(super) fn array(class: u8, flags: u8, sides: &[u32], name: &str, inside: &[u8]) -> Vec<u8> {
    let flags = element(FLAGS, &[class, flags, 0, 0, 0, 0, 0, 0]);
    let sides = element(SIDES, sides.iter().copied().flat_map(u32::to_le_bytes).collect::<Vec<u8>>().as_slice());
    element(ARRAY, &[&flags, &sides, &element(TEXT, name.as_bytes()), inside].concat())
}

/// Elements as one that is packed, without zeros behind it.
pub(super) fn packed(elements: &[u8]) -> std::io::Result<Vec<u8>> {
    let mut packer = ZlibEncoder::new(Vec::new(), Compression::default());
    packer.write_all(elements)?;
    let packed = packer.finish()?;
    Ok([&[PACKED, packed.len() as u32].map(u32::to_le_bytes).concat(), &packed[..]].concat())
}
