//! Places of the separators and the line feeds of a text.
//!
//! 64 bytes at a time become 64 bits, one for each byte, and the bits become places, eight at a time. Where a cell ends
//! is so known before the one before it is read, without branches that depend on the lengths of cells (Langdale and
//! Lemire 2019, *Parsing gigabytes of JSON per second*).

/// Bytes that become the bits of one integer.
const BLOCK: usize = 64;

/// Finds the places, in their order, and the end of the text if its last line does not end.
pub(super) fn find(text: &[u8], separator: u8, places: &mut Vec<usize>) {
    places.clear();
    let (blocks, rest) = text.as_chunks();
    for (block, start) in blocks.iter().zip((0..).step_by(BLOCK)) {
        add(bits(block, separator), start, places);
    }
    let mut last = [0; BLOCK];
    last[..rest.len()].copy_from_slice(rest);
    add(bits(&last, separator), text.len() - rest.len(), places);
    if text.last().is_some_and(|last| *last != b'\n') {
        places.push(text.len());
    }
}

/// Adds the places of the bits of a block.
#[inline]
fn add(mut bits: u64, start: usize, places: &mut Vec<usize>) {
    let end = places.len() + bits.count_ones() as usize;
    while places.len() < end {
        let eight: [usize; 8] = std::array::from_fn(|_| {
            let place = start + bits.trailing_zeros() as usize;
            bits &= bits.wrapping_sub(1);
            place
        });
        places.extend_from_slice(&eight);
    }
    places.truncate(end);
}

#[inline]
fn bits(block: &[u8; BLOCK], separator: u8) -> u64 {
    let mut bits = 0;
    for (place, eight) in block.as_chunks().0.iter().enumerate() {
        let word = u64::from_le_bytes(*eight);
        let found = zeros(word ^ all(separator)) | zeros(word ^ all(b'\n'));
        // The product moves the highest bit of each byte into the highest byte.
        bits |= (found.wrapping_mul(0x0002_0408_1020_4081) >> 56) << (8 * place);
    }
    bits
}

/// The highest bit of each byte that is zero.
fn zeros(word: u64) -> u64 {
    const LOW: u64 = all(0x7F);
    !(((word & LOW) + LOW) | word | LOW)
}

const fn all(byte: u8) -> u64 {
    u64::from_ne_bytes([byte; 8])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_where_the_bytes_are() {
        let (mut state, mut found) = (7_u64, vec![1]);
        for length in 0..300 {
            let mut next = || {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                [b',', b'\n', 0, 0x80, 0xFF, b'-', b'\r', (state >> 40) as u8][(state >> 61) as usize]
            };
            let text: Vec<u8> = (0..length).map(|_| next()).collect();
            let mut expected: Vec<usize> = (0..length).filter(|k| matches!(text[*k], b',' | b'\n')).collect();
            expected.extend((length > 0 && text[length - 1] != b'\n').then_some(length));
            find(&text, b',', &mut found);
            assert_eq!(found, expected);
        }
        find(&[b'\n'; 200], b';', &mut found);
        assert_eq!(found, (0..200).collect::<Vec<_>>());
    }
}
