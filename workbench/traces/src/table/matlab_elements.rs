//! The elements of a MATLAB file of format 5 to 7, checked and unpacked before a reader takes them, which trusts every
//! length.
//!
//! ```text
//! file     128 bytes of header, the last two "IM" (little-endian) or "MI"; elements
//! element  type u32, size u32, size bytes, zeros to a multiple of 8         or, up to 4 bytes,
//!          type u16 in the low half and size u16 in the high half of a u32, 4 bytes
//! type 14  an array: elements of flags, dimensions, name, and its content, among it further arrays; outermost there
//!          are arrays only
//! type 15  one packed element (zlib), without zeros behind it
//! ```

use crate::table::unpack::{most, unpack};

const HEADER: usize = 128;
const ARRAY: u32 = 14;
const PACKED: u32 = 15;
/// The last type of elements, text of 32 bits.
const LAST: u32 = 18;
/// Types of the elements of flags and of dimensions.
const FLAGS: u32 = 6;
const DIMENSIONS: u32 = 5;
/// Classes of arrays: that without an element for zeros, and the last one with dimensions.
const SPARSE: u8 = 5;
const LAST_CLASS: u8 = 15;
/// Deepest array in an array; the reader is recursive.
const DEEPEST: usize = 16;

/// One element.
struct Element<'a> {
    kind: u32,
    content: &'a [u8],
    /// All of it, with tag and zeros.
    whole: &'a [u8],
    rest: &'a [u8],
}

/// Returns the file with every element unpacked; `None` if its elements do not fit into each other.
pub(super) fn unpacked(bytes: &[u8]) -> Option<Vec<u8>> {
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
            let left = most(bytes.len()).saturating_sub(plain.len() as u64);
            let inner = unpack(flate2::read::ZlibDecoder::new(element.content), left).ok()?;
            check(&inner, is_little, 0)?;
            plain.extend(inner);
        } else {
            check(element.whole, is_little, 0)?;
            plain.extend(element.whole);
        }
    }
    Some(plain)
}

/// Takes the first element.
fn element(bytes: &[u8], is_little: bool) -> Option<Element<'_>> {
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

/// Checks elements, and those of arrays among them; outermost, at depth 0, others are refused.
fn check(mut rest: &[u8], is_little: bool, depth: usize) -> Option<()> {
    while !rest.is_empty() {
        let element = element(rest, is_little)?;
        rest = element.rest;
        match element.kind {
            ARRAY if depth < DEEPEST => {
                check(element.content, is_little, depth + 1)?;
                check_count(element.content, is_little)?;
            }
            // Packed elements are outermost.
            ARRAY | PACKED => return None,
            _ if depth == 0 => return None,
            _ => {}
        }
    }
    Some(())
}

/// Checks that an array has not more elements than bytes: each takes at least one, but for the zeros of a sparse one.
fn check_count(content: &[u8], is_little: bool) -> Option<()> {
    if content.is_empty() {
        return Some(());
    }
    let flags = element(content, is_little).filter(|own| own.kind == FLAGS && own.content.len() == 8)?;
    let class = if is_little { flags.content.first()? } else { flags.content.get(3)? };
    if *class > LAST_CLASS {
        return Some(());
    }
    let dimensions = element(flags.rest, is_little).filter(|own| own.kind == DIMENSIONS)?;
    let (sizes, rest) = dimensions.content.as_chunks::<4>();
    let count = sizes.iter().try_fold(1_usize, |count, own| count.checked_mul(number(own, is_little) as usize))?;
    (rest.is_empty() && (count <= content.len() || *class == SPARSE)).then_some(())
}

/// Four bytes in either order.
fn number(bytes: &[u8; 4], is_little: bool) -> u32 {
    if is_little { u32::from_le_bytes(*bytes) } else { u32::from_be_bytes(*bytes) }
}

#[cfg(test)]
mod tests {
    use super::*;

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

    fn array(class: u8, dimensions: &[u8], inside: &[u8]) -> Vec<u8> {
        let small = [1, 0, 1, 0, b'c', 0, 0, 0];
        let flags = tagged(FLAGS, &[class, 0, 0, 0, 0, 0, 0, 0]);
        tagged(ARRAY, &[&flags, &tagged(DIMENSIONS, dimensions), &small[..], inside].concat())
    }

    fn cells(dimensions: [u32; 2], inside: &[u8]) -> Vec<u8> {
        array(1, &dimensions.map(u32::to_le_bytes).concat(), inside)
    }

    #[test]
    fn lengths_beyond_the_file_are_refused() {
        let good = file(&tagged(ARRAY, &tagged(FLAGS, &[17, 0, 0, 0, 0, 0, 0, 0])));
        assert_eq!(unpacked(&good), Some(good.clone()));
        for place in [HEADER + 4, HEADER + 12] {
            for size in [255, 25] {
                let mut forged = good.clone();
                forged[place] = size;
                assert_eq!(unpacked(&forged), None, "{place} {size}");
            }
        }
        assert_eq!(unpacked(&good[..HEADER + 15]), None);
        let mut other = good.clone();
        other[HEADER + 1] = 3;
        assert_eq!(unpacked(&other), None, "a type of which eight bits are those of an array");
        assert_eq!(unpacked(&file(&[])), Some(file(&[])));
        assert_eq!(unpacked(&[b' '; HEADER]), None, "neither order of bytes");
    }

    #[test]
    fn counts_and_depths_beyond_the_file_are_refused() {
        assert!(unpacked(&file(&cells([1, 1], &cells([1, 0], &[])))).is_some());
        assert_eq!(unpacked(&file(&cells([u32::MAX, 1], &[]))), None);
        assert_eq!(unpacked(&file(&cells([u32::MAX, u32::MAX], &[]))), None);
        // A number, as it should be, and with dimensions beyond the file or of an odd length.
        let number = |dimensions: &[u8], class| unpacked(&file(&array(class, dimensions, &tagged(9, &[0; 8]))));
        assert!(number(&[1, 0, 0, 0, 1, 0, 0, 0], 6).is_some());
        assert_eq!(number(&[1, 0, 0, 0, 0, 0, 0, 9], 6), None);
        assert!(number(&[1, 0, 0, 0, 0, 0, 0, 9], SPARSE).is_some());
        assert_eq!(number(&[1], 6), None);
        assert_eq!(unpacked(&file(&tagged(9, &[0; 8]))), None, "no array");
        let deep = |depth| (0..depth).fold(vec![], |inside, _| cells([1, 1], &inside));
        assert!(unpacked(&file(&deep(DEEPEST))).is_some());
        assert_eq!(unpacked(&file(&deep(DEEPEST + 1))), None);
    }
}
