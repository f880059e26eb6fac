//! The arrays of a MATLAB file of format 5 to 7 whose elements were checked.
//!
//! ```text
//! array      elements of flags, sides, name; then by the class in the flags
//! numbers    an element of the real parts, in any kind of numbers that holds them, and one of the imaginary parts
//! cells      an array each
//! structure  elements of the length of a name of a field and of all names; of each structure an array a field
//! object     no sides, but further names
//! ```

use crate::table::arrays::numbers::{self as cells, Kind};
use crate::table::matlab::elements::{Element, element};
use crate::table::matlab::value::{EMPTY, OBJECT, SPARSE, Value};

/// Classes of arrays.
const CELLS: u8 = 1;
const STRUCTURE: u8 = 2;
const OLD_OBJECT: u8 = 3;
const TEXT: u8 = 4;
const SPARSE_NUMBERS: u8 = 5;
const LAST_NUMBERS: u8 = 15;
const FUNCTION: u8 = 16;
const OPAQUE: u8 = 17;
/// Flag of complex numbers.
const COMPLEX: u8 = 8;
/// What is said of an array that its reader does not follow.
const DAMAGED: &str = "not readable: save it again, e.g. with -v7";

/// Elements one after the other.
struct Elements<'a> {
    rest: &'a [u8],
    is_little: bool,
}

impl<'a> Elements<'a> {
    fn next(&mut self) -> Option<Element<'a>> {
        let element = element(self.rest, self.is_little)?;
        self.rest = element.rest;
        Some(element)
    }

    /// The next element as text without zeros.
    fn text(&mut self) -> Option<String> {
        Some(until_zero(self.next()?.content))
    }

    /// The class of an array, its flags, and two other bytes.
    fn flags(&mut self) -> Option<[u8; 4]> {
        let mut flags: [u8; 4] = *self.next()?.content.first_chunk()?;
        if !self.is_little {
            flags.reverse();
        }
        Some(flags)
    }

    fn numbers(&mut self) -> Option<Vec<f64>> {
        let is_little = self.is_little;
        self.next().and_then(|own| numbers(own.kind, own.content, is_little))
    }

    fn array(&mut self) -> Option<Value> {
        Some(named(self.next()?.content, self.is_little).map_or(Value::Other(DAMAGED), |(_, value)| value))
    }
}

/// An array with its name, by the content of its element; `None` of numbers, text, cells or
/// structures that do not begin with flags, sides and a name.
pub(super) fn named(content: &[u8], is_little: bool) -> Option<(String, Value)> {
    if content.is_empty() {
        return Some((String::new(), Value::Other(EMPTY)));
    }
    let mut elements = Elements { rest: content, is_little };
    let Some((class, is_complex, name, sides)) = head(&mut elements) else {
        let class = Elements { rest: content, is_little }.flags()?[0];
        return (class > LAST_NUMBERS).then(|| (String::new(), Value::Other(DAMAGED)));
    };
    let value = match class {
        OPAQUE | OLD_OBJECT => Some(Value::Other(OBJECT)),
        FUNCTION => Some(Value::Other("a function")),
        SPARSE_NUMBERS => Some(Value::Other(SPARSE)),
        CELLS => (0..count(&sides)).map(|_| elements.array()).collect::<Option<_>>().map(Value::List),
        STRUCTURE => structures(&mut elements, count(&sides)),
        TEXT => elements.next().map(|own| Value::Text(text(&own, is_little))),
        ..=LAST_NUMBERS => array_of(&mut elements, &sides, is_complex),
        _ => None,
    };
    Some((name, value.unwrap_or(Value::Other(DAMAGED))))
}

/// Class, whether it is complex, name and sides.
fn head(elements: &mut Elements<'_>) -> Option<(u8, bool, String, Vec<usize>)> {
    let [class, flags, ..] = elements.flags()?;
    let sides = if class == OPAQUE { vec![] } else { elements.numbers()? };
    // Sides have a sign in the file.
    let sides = sides.iter().map(|side| (*side >= 0.0).then_some(*side as usize)).collect::<Option<_>>()?;
    Some((class, flags & COMPLEX != 0, elements.text()?, sides))
}

fn count(sides: &[usize]) -> usize {
    sides.iter().fold(1, |count, side| count.saturating_mul(*side))
}

fn array_of(elements: &mut Elements<'_>, sides: &[usize], is_complex: bool) -> Option<Value> {
    let fits = |numbers: &Vec<f64>| numbers.len() == count(sides);
    let re = elements.numbers().filter(fits)?;
    let value = Value::array(sides, re);
    Some(match value {
        Value::Numbers { rows, values: re } if is_complex => {
            Value::Complex { rows, re, im: elements.numbers().filter(fits)? }
        }
        other => other,
    })
}

fn structures(elements: &mut Elements<'_>, count: usize) -> Option<Value> {
    let length = *elements.numbers()?.first()? as usize;
    let names = elements.next()?.content;
    let names: Vec<String> = names.chunks(length.max(1)).map(until_zero).collect();
    let mut one = || -> Option<Value> {
        let field = |name: &String| Some((name.clone(), elements.array()?));
        names.iter().map(field).collect::<Option<_>>().map(Value::Fields)
    };
    // Structures without fields take no bytes.
    match count {
        _ if names.is_empty() => Some(Value::Other(EMPTY)),
        0 => Some(Value::Other(EMPTY)),
        1 => one(),
        _ => (0..count).map(|_| one()).collect::<Option<_>>().map(Value::List),
    }
}

fn until_zero(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end]).into_owned()
}

fn text(own: &Element<'_>, is_little: bool) -> String {
    match own.kind {
        1 | 2 | 16 => String::from_utf8_lossy(own.content).into_owned(),
        kind => {
            // UTF-16, also as whole numbers.
            let units = numbers(if kind == 17 { 4 } else { kind }, own.content, is_little).unwrap_or_default();
            let units: Vec<u16> = units.iter().map(|unit| *unit as u16).collect();
            String::from_utf16_lossy(&units)
        }
    }
}

/// The numbers of an element, by its type.
fn numbers(kind: u32, content: &[u8], is_little: bool) -> Option<Vec<f64>> {
    let (kind, size) = match kind {
        1 => (Kind::Signed, 1),
        2 => (Kind::Unsigned, 1),
        3 => (Kind::Signed, 2),
        4 => (Kind::Unsigned, 2),
        5 => (Kind::Signed, 4),
        6 => (Kind::Unsigned, 4),
        7 => (Kind::Float, 4),
        9 => (Kind::Float, 8),
        12 => (Kind::Signed, 8),
        13 => (Kind::Unsigned, 8),
        _ => return None,
    };
    let is_whole = content.len().is_multiple_of(size);
    is_whole.then(|| cells::numbers(kind, size, !is_little, content.chunks_exact(size))).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::columns::About;
    use crate::table::matlab::read;
    use crate::table::matlab::writer::{array, element, header, packed};

    /// Names, columns, and what was left out.
    type Found = (Vec<String>, Vec<Vec<f64>>, About);

    fn file(arrays: &[Vec<u8>], is_packed: bool) -> Result<Found, String> {
        let elements = |array: &Vec<u8>| if is_packed { packed(array).expect("in memory") } else { array.clone() };
        let bytes = [header(), arrays.iter().flat_map(elements).collect()].concat();
        let path = tempfile::Builder::new().suffix(".mat").tempfile().expect("a file").into_temp_path();
        std::fs::write(&path, bytes).expect("writable");
        let mut about = About::default();
        let own = read(&path, &mut about).map_err(|error| error.to_string())?;
        Ok((own.names, own.columns, about))
    }

    fn doubles(values: &[f64]) -> Vec<u8> {
        element(9, &values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>())
    }

    fn texts(all: &[&str]) -> Vec<u8> {
        all.iter().flat_map(|text| element(1, text.as_bytes())).collect()
    }

    fn row(name: &str, values: &[f64]) -> Vec<u8> {
        array(6, 0, &[1, values.len() as u32], name, &doubles(values))
    }

    fn structure(name: &str, names: &[&str], values: &[Vec<u8>]) -> Vec<u8> {
        let length = names.iter().map(|name| name.len() + 1).max().unwrap_or(1);
        let padded = |name: &&str| [name.as_bytes(), &vec![0; length - name.len()]].concat();
        let names: Vec<u8> = names.iter().flat_map(padded).collect();
        let inside = [element(5, &(length as u32).to_le_bytes()), element(1, &names), values.concat()].concat();
        array(STRUCTURE, 0, &[1, 1], name, &inside)
    }

    #[test]
    fn arrays_of_other_programs_are_read_to_the_bit_and_what_is_left_out_is_named() {
        let complex = [doubles(&[1.0, 2.0, 3.0]), doubles(&[-1.0, -2.0, 0.1])].concat();
        let arrays = [
            row("t", &[0.0, 0.1, 0.2]),
            // Doubles that are stored as bytes.
            array(6, 0, &[3, 1], "k", &element(2, &[7, 255, 0])),
            array(6, 0, &[2, 3], "m", &doubles(&[1.0, 4.0, 2.0, 5.0, 3.0, 6.0])),
            array(6, COMPLEX, &[1, 3], "z", &complex),
            structure("s", &["a", "b", "deep"], &[row("", &[1.0; 3]), row("", &[9.0; 2]), element(14, &[])]),
            array(CELLS, 0, &[1, 2], "c", &[row("", &[4.0, 5.0, 6.0]), row("", &[8.0])].concat()),
            array(TEXT, 0, &[1, 2], "note", &element(4, &[b'o', 0, b'k', 0])),
            array(6, 0, &[2, 3, 4], "cube", &doubles(&[0.0; 24])),
            array(6, 0, &[0, 0], "none", &doubles(&[])),
            array(SPARSE_NUMBERS, 0, &[1, 1], "sparse", &[]),
            element(
                14,
                &[&element(6, &[OPAQUE, 0, 0, 0, 0, 0, 0, 0])[..], &texts(&["log", "MCOS", "timetable"])].concat(),
            ),
            // Where objects have their content.
            array(9, 0, &[1, 4000], "", &element(2, &[3; 4000])),
        ];
        for is_packed in [false, true] {
            let (names, columns, about) = file(&arrays, is_packed).expect("readable");
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            assert_eq!(names, ["t", "k", "m_1", "m_2", "z_re", "z_im", "s.a", "c(1)", "c(2)"]);
            assert_eq!(columns[..3], [[0.0, 0.1, 0.2], [7.0, 255.0, 0.0], [1.0, 2.0, 3.0]]);
            assert_eq!(columns[4..6], [[1.0, 2.0, 3.0], [-1.0, -2.0, 0.1]]);
            assert_eq!(columns[7..], [[4.0, 5.0, 6.0], [8.0; 3]]);
            let left: Vec<String> = about.omitted.iter().map(|own| format!("{}: {}", own.place, own.reason)).collect();
            let said = [
                "array s.deep: it is empty",
                "array note: text",
                "array cube: more than two dimensions",
                "array none: it is empty",
                "array sparse: sparse numbers",
                "array log: a table object: save it with table2struct or parquetwrite",
                "array s.b: it has 2 values where the longest have 3",
            ];
            assert_eq!(left.len(), said.len(), "{left:?}");
            assert!(left.iter().zip(said).all(|(left, said)| left.starts_with(said)), "{left:?}");
        }
        let refused = file(&arrays[10..], false).expect_err("a table");
        assert!(refused.contains("array log: nothing but a table object: save it with table2struct"), "{refused}");
        let refused = file(&arrays[6..7], false).expect_err("text");
        assert!(refused.contains("no arrays of numbers; left out: array note: text"), "{refused}");
    }

    #[test]
    fn structures_of_an_array_are_traces() {
        let names: Vec<u8> = ["t", "i"].iter().flat_map(|name| [name.as_bytes(), &[0]].concat()).collect();
        let head = [element(5, &2_u32.to_le_bytes()), element(1, &names)].concat();
        let of_length = |count: usize| {
            let values: Vec<f64> = (0..count).map(|k| k as f64 / 2.0).collect();
            [row("", &values), row("", &values)].concat()
        };
        for lengths in [vec![3, 2], vec![3, 3, 3], vec![2, 5, 4]] {
            let inside: Vec<u8> = lengths.iter().flat_map(|count| of_length(*count)).collect();
            let sides = [1, lengths.len() as u32];
            let data = array(STRUCTURE, 0, &sides, "data", &[head.clone(), inside].concat());
            let (names, columns, about) = file(&[data, row("fs", &[2.0])], true).expect("records");
            assert_eq!(names, ["trace", "t", "i", "fs"]);
            assert_eq!((columns[2].len(), columns[3][0]), (lengths.iter().sum(), 2.0));
            assert!(about.notes[0].contains(&format!("{} records", lengths.len())), "{:?}", about.notes);
        }
    }

    #[test]
    fn arrays_that_end_early_are_named() {
        let short = array(6, 0, &[1, 3], "i", &doubles(&[1.0, 2.0]));
        let half = array(6, COMPLEX, &[1, 2], "z", &doubles(&[1.0, 2.0]));
        let fields = array(STRUCTURE, 0, &[1, 1], "s", &element(5, &[2, 0, 0, 0]));
        let cells = array(CELLS, 0, &[1000, 1000], "c", &row("", &[1.0]));
        let (names, _, about) = file(&[row("t", &[0.0, 1.0]), short, half, fields, cells], false).expect("t");
        assert_eq!((names, about.omitted.len()), (vec!["t".to_string()], 4));
        let negative = array(CELLS, 0, &[u32::MAX, 1], "c", &[]);
        let refused = file(&[row("t", &[0.0, 1.0]), negative], false).expect_err("no sides");
        assert!(refused.contains("not readable as a MATLAB file"), "{refused}");
        assert!(about.omitted.iter().all(|own| own.reason == DAMAGED), "{about:?}");
    }
}
