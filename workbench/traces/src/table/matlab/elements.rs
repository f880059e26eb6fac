//! The elements of a MATLAB file of format 5 to 7, unpacked within the limit of the file, and refused if they do not
//! fit into each other: their reader ([`super::arrays`]) is recursive, and makes eight bytes of a small number.
//!
//! ```text
//! file     128 bytes of header, the last two "IM" (little-endian) or "MI"; elements
//! element  type u32, size u32, size bytes, zeros to a multiple of 8         or, up to 4 bytes,
//!          type u16 in the low half and size u16 in the high half of a u32, 4 bytes
//! type 14  an array: elements of flags, dimensions, name, and its content, among it further arrays; outermost there
//!          are arrays only
//! type 15  one packed element (zlib), without zeros behind it
//! ```

use crate::table::limit::Limit;

const HEADER: usize = 128;
const ARRAY: u32 = 14;
const PACKED: u32 = 15;
/// The last type of elements, text of 32 bits.
const LAST: u32 = 18;
/// Deepest array in an array.
const DEEPEST: usize = 16;

/// One element.
pub(super) struct Element<'a> {
    pub(super) kind: u32,
    pub(super) content: &'a [u8],
    /// All of it, with tag and zeros.
    whole: &'a [u8],
    pub(super) rest: &'a [u8],
}

/// Returns the file with every element unpacked; `None` if its elements do not fit into each other.
///
/// # Errors
/// More than the limit, in words.
pub(super) fn unpacked(bytes: &[u8]) -> Result<Option<Vec<u8>>, String> {
    let mut unpacking = Unpacking { limit: Limit::of(bytes.len() as u64), refused: None };
    let plain = unpacking.file(bytes);
    unpacking.refused.map_or(Ok(plain), Err)
}

/// What is used of the limit, and why nothing is left.
struct Unpacking {
    limit: Limit,
    refused: Option<String>,
}

/// Takes the first element.
pub(super) fn element(bytes: &[u8], is_little: bool) -> Option<Element<'_>> {
    let word = |at: usize| -> Option<u32> { Some(number(bytes.get(at..)?.first_chunk()?, is_little)) };
    let first = word(0)?;
    let (kind, start, size, padded): (u32, usize, usize, usize) = if first >> 16 == 0 {
        let size = word(4)? as usize;
        let padded = if first == PACKED { size } else { size.checked_next_multiple_of(8)? };
        (first, 8, size, padded)
    } else {
        (first & 0xFFFF, 4, (first >> 16) as usize, 4)
    };
    // The reader looks at eight bits of the type only.
    if !(1..=LAST).contains(&kind) {
        return None;
    }
    let content = bytes.get(start..start.checked_add(size)?).filter(|_| size <= padded)?;
    // The zeros behind the last element may be missing.
    let (whole, rest) = bytes.split_at(start.checked_add(padded)?.min(bytes.len()));
    Some(Element { kind, content, whole, rest })
}

impl Unpacking {
    fn file(&mut self, bytes: &[u8]) -> Option<Vec<u8>> {
        let (header, mut rest) = bytes.split_at_checked(HEADER)?;
        let is_little = match header.last_chunk()? {
            b"IM" => true,
            b"MI" => false,
            _ => return None,
        };
        let mut plain = header.to_vec();
        while !rest.is_empty() {
            let element = element(rest, is_little)?;
            rest = element.rest;
            if element.kind == PACKED {
                let stream = flate2::read::ZlibDecoder::new(element.content);
                let inner = self.told(|limit| limit.unpack(stream))?;
                self.check(&inner, is_little, 0)?;
                plain.extend(inner);
            } else {
                self.check(element.whole, is_little, 0)?;
                plain.extend(element.whole);
            }
        }
        Some(plain)
    }

    /// A part within the limit; the first reason why it is none is kept.
    fn told<T>(&mut self, part: impl FnOnce(&mut Limit) -> Result<T, String>) -> Option<T> {
        part(&mut self.limit).map_err(|problem| self.refused.get_or_insert(problem)).ok()
    }

    /// Checks elements, and those of arrays among them; outermost, at depth 0, others are refused.
    fn check(&mut self, mut rest: &[u8], is_little: bool, depth: usize) -> Option<()> {
        while !rest.is_empty() {
            let element = element(rest, is_little)?;
            rest = element.rest;
            match element.kind {
                ARRAY if depth < DEEPEST => self.check(element.content, is_little, depth + 1)?,
                // Packed elements are outermost.
                ARRAY | PACKED => return None,
                _ if depth == 0 => return None,
                kind => {
                    let numbers = element.content.len() / size(kind);
                    self.told(|limit| limit.claim_numbers([numbers as u64]))?;
                }
            }
        }
        Some(())
    }
}

/// Bytes of a number in an element of this type.
const fn size(kind: u32) -> usize {
    match kind {
        1 | 2 | 16 => 1,
        3 | 4 | 17 => 2,
        5..=7 | 18 => 4,
        _ => 8,
    }
}

/// Whether a file starts as one of format 5 to 7.
pub(super) fn is_header(head: &[u8]) -> bool {
    // Zeros among the first four bytes are of format 4; the version is 1 in either order of bytes.
    let ends = [[1, 0, b'M', b'I'], [0, 1, b'I', b'M'], [1, 0, b'I', b'M'], [0, 1, b'M', b'I']];
    let end = head.get(..HEADER).and_then(<[u8]>::last_chunk);
    !head.iter().take(4).any(|byte| *byte == 0) && end.is_some_and(|end| ends.contains(end))
}

/// The contents of the outermost arrays of a file whose elements are unpacked, and whether it is little-endian.
pub(super) fn outermost(plain: &[u8]) -> Option<(Vec<&[u8]>, bool)> {
    let (header, mut rest) = plain.split_at_checked(HEADER)?;
    let is_little = header.ends_with(b"IM");
    let mut found = Vec::new();
    while !rest.is_empty() {
        let array = element(rest, is_little)?;
        rest = array.rest;
        found.push(array.content);
    }
    Some((found, is_little))
}

/// Four bytes in either order.
fn number(bytes: &[u8; 4], is_little: bool) -> u32 {
    if is_little { u32::from_le_bytes(*bytes) } else { u32::from_be_bytes(*bytes) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::matlab::writer::{array, packed};

    fn plain(bytes: &[u8]) -> Option<Vec<u8>> {
        unpacked(bytes).expect("within the limit")
    }

    fn file(elements: &[u8]) -> Vec<u8> {
        let mut bytes = vec![b' '; HEADER];
        bytes[HEADER - 2..].copy_from_slice(b"IM");
        bytes.extend(elements);
        bytes
    }

    /// An element of this type.
    fn tagged(kind: u32, content: &[u8]) -> Vec<u8> {
        let zeros = vec![0; content.len().next_multiple_of(8) - content.len()];
        [&kind.to_le_bytes(), &(content.len() as u32).to_le_bytes(), content, &zeros].concat()
    }

    #[test]
    fn lengths_beyond_the_file_are_refused() {
        let good = file(&tagged(ARRAY, &tagged(6, &[17, 0, 0, 0, 0, 0, 0, 0])));
        assert_eq!(plain(&good), Some(good.clone()));
        for place in [HEADER + 4, HEADER + 12] {
            for size in [255, 25] {
                let mut forged = good.clone();
                forged[place] = size;
                assert_eq!(plain(&forged), None, "{place} {size}");
            }
        }
        assert_eq!(plain(&good[..HEADER + 15]), None);
        let mut other = good.clone();
        other[HEADER + 1] = 3;
        assert_eq!(plain(&other), None, "a type of which eight bits are those of an array");
        assert_eq!(plain(&file(&[])), Some(file(&[])));
        assert_eq!(plain(&[b' '; HEADER]), None, "neither order of bytes");
    }

    #[test]
    fn arrays_within_too_many_others_are_refused() {
        assert_eq!(plain(&file(&tagged(9, &[0; 8]))), None, "no array");
        let deep = |depth| (0..depth).fold(vec![], |inside, _| array(1, 0, &[1, 1], "c", &inside));
        assert!(plain(&file(&deep(DEEPEST))).is_some());
        assert_eq!(plain(&file(&deep(DEEPEST + 1))), None);
    }

    /// Bytes that are packed a thousand times, and numbers of one byte that become eight.
    #[test]
    fn what_becomes_too_large_is_refused() {
        let packed = |elements: &[u8]| packed(elements).expect("in memory");
        let count = 5_u32 << 20;
        let bytes = array(9, 0, &[1, count], "x", &tagged(2, &vec![0; count as usize]));
        let small = file(&packed(&bytes));
        assert!(small.len() < 1 << 20 && plain(&small).is_some());
        let refused =
            unpacked(&file(&[packed(&bytes), packed(&bytes)].concat())).expect_err("90 MiB of bytes and numbers");
        assert!(refused.contains("more than the limit of 67108864"), "{refused}");
    }
}
