//! MATLAB files of format 4.
//!
//! ```text
//! variable  type i32, rows i32, columns i32, 1 if complex else 0 i32, length of the name i32; the name with a zero at
//!           its end; the real parts column by column; the imaginary ones
//! type      1000 of big-endian numbers + 10 × kind of numbers + 0 of numbers, 1 of text, 2 of sparse numbers
//! ```

use crate::table::arrays::numbers::{self as cells, Kind};
use crate::table::matlab::value::{SPARSE, Value};

const HEADER: usize = 20;
/// The longest name.
const NAME: usize = 256;

/// The header of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Header {
    is_big: bool,
    /// Kind of its numbers, and their bytes.
    kind: (Kind, usize),
    /// 0, 1 or 2.
    class: i32,
    rows: usize,
    columns: usize,
    is_complex: bool,
    name: usize,
}

/// Kind of the numbers, and their bytes, by a digit of the type.
fn number(digit: i32) -> Option<(Kind, usize)> {
    Some(match digit {
        0 => (Kind::Float, 8),
        1 => (Kind::Float, 4),
        2 => (Kind::Signed, 4),
        3 => (Kind::Signed, 2),
        4 => (Kind::Unsigned, 2),
        5 => (Kind::Unsigned, 1),
        _ => return None,
    })
}

impl Header {
    fn of(bytes: &[u8]) -> Option<Self> {
        let (words, _) = bytes.get(..HEADER)?.as_chunks::<4>();
        // The type is below 5000, so that only one order of bytes fits.
        [false, true].into_iter().find_map(|is_big| {
            let word = |k: usize| if is_big { i32::from_be_bytes(words[k]) } else { i32::from_le_bytes(words[k]) };
            let (kind, class) = (number(word(0) / 10 % 10)?, word(0) % 10);
            let size = |k: usize| usize::try_from(word(k)).ok();
            let own = Self {
                is_big,
                kind,
                class,
                rows: size(1)?,
                columns: size(2)?,
                is_complex: word(3) == 1,
                name: size(4)?,
            };
            let order = if is_big { 10 } else { 0 };
            let is_good = word(0) / 100 == order && class <= 2 && [0, 1].contains(&word(3));
            (is_good && (2..=NAME).contains(&own.name)).then_some(own)
        })
    }
}

/// Whether a file starts as one of format 4.
pub(super) fn is_header(head: &[u8]) -> bool {
    let name = |own: Header| head.get(HEADER..HEADER + own.name).map(<[u8]>::to_vec);
    let name = Header::of(head).and_then(name).unwrap_or_default();
    matches!(name.split_last(), Some((0, letters)) if letters.iter().all(u8::is_ascii_graphic))
}

/// Reads the variables; `None` if they do not fit into the file.
pub(super) fn variables(mut bytes: &[u8]) -> Option<Value> {
    let mut found = Vec::new();
    while !bytes.is_empty() {
        let own = Header::of(bytes)?;
        let (name, rest) = bytes.get(HEADER..)?.split_at_checked(own.name)?;
        let (kind, each) = own.kind;
        let size = own.rows.checked_mul(own.columns)?.checked_mul(each)?;
        let (re, rest) = rest.split_at_checked(size)?;
        let (im, rest) = rest.split_at_checked(if own.is_complex { size } else { 0 })?;
        bytes = rest;
        let name = String::from_utf8_lossy(name).trim_end_matches('\0').to_string();
        let numbers = |part: &[u8]| cells::numbers(kind, each, own.is_big, part.chunks_exact(each));
        let value = match own.class {
            0 => match Value::array(&[own.rows, own.columns], numbers(re)?) {
                Value::Numbers { rows, values: re } if own.is_complex => Value::Complex { rows, re, im: numbers(im)? },
                other => other,
            },
            1 => Value::Text(String::new()),
            _ => Value::Other(SPARSE),
        };
        found.push((name, value));
    }
    Some(Value::Fields(found))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A variable of this type.
    fn variable(kind: i32, sides: [i32; 2], complex: i32, name: &str, content: &[u8]) -> Vec<u8> {
        let order = |word: i32| if kind >= 1000 { word.to_be_bytes() } else { word.to_le_bytes() };
        let words = [kind, sides[0], sides[1], complex, name.len() as i32 + 1].map(order);
        [words.as_flattened(), name.as_bytes(), &[0], content].concat()
    }

    #[test]
    fn variables_of_either_order_are_read() {
        let doubles: Vec<u8> = [0.5_f64, -1.5].iter().flat_map(|x| x.to_le_bytes()).collect();
        let shorts: Vec<u8> = [300_i16, -7, 1, 2].iter().flat_map(|x| x.to_be_bytes()).collect();
        let file = [
            variable(0, [1, 2], 0, "i", &doubles),
            variable(1030, [2, 1], 1, "z", &shorts),
            variable(1030, [2, 2], 0, "m", &shorts),
            variable(51, [1, 2], 0, "note", b"ok"),
            variable(50, [0, 0], 0, "none", b""),
        ];
        assert!(is_header(&file[0]) && is_header(&file[1]));
        let Some(Value::Fields(found)) = variables(&file.concat()) else { panic!("no variables") };
        assert_eq!(found[0], ("i".into(), Value::Numbers { rows: 2, values: vec![0.5, -1.5] }));
        let complex = Value::Complex { rows: 2, re: vec![300.0, -7.0], im: vec![1.0, 2.0] };
        assert_eq!(found[1], ("z".into(), complex));
        assert_eq!(found[2], ("m".into(), Value::Numbers { rows: 2, values: vec![300.0, -7.0, 1.0, 2.0] }));
        assert!(matches!((&found[3].1, &found[4].1), (Value::Text(_), Value::Other(_))));
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let good = variable(0, [1, 1], 0, "i", &[0; 8]);
        assert!(is_header(&good) && variables(&good).is_some());
        for length in 1..good.len() {
            assert_eq!(variables(&good[..length]), None, "{length}");
        }
        for wrong in [
            variable(60, [1, 1], 0, "i", &[0; 8]),
            variable(3, [1, 1], 0, "i", &[0; 8]),
            variable(0, [-1, 1], 0, "i", &[0; 8]),
            variable(0, [1, 1], 2, "i", &[0; 8]),
            variable(0, [i32::MAX, i32::MAX], 0, "i", &[0; 8]),
        ] {
            assert_eq!(variables(&wrong), None, "{wrong:?}");
        }
        assert!(!is_header(&variable(0, [1, 1], 0, "i\x01", &[0; 8])) && !is_header(b"text"));
    }
}
