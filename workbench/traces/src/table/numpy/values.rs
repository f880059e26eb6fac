//! The values of NumPy's arrays: numbers, times as seconds from the first one, complex numbers as two columns, and the
//! fields of a structure.

use npyz::{DType, Endianness, TimeUnits, TypeChar, TypeStr};

use crate::table::arrays::numbers::{self as cells, Kind, little};
use crate::table::from_first::FromFirst;

/// Part of each element of an array.
struct Leaf {
    /// What the name of the array gets.
    name: String,
    /// First byte in an element.
    at: usize,
    kind: TypeStr,
}

/// Column of an array whose elements are in one row.
pub(super) struct Values {
    /// What the name of the array gets.
    pub(super) name: String,
    /// Numbers, or why there are none.
    pub(super) values: Result<Vec<f64>, String>,
    /// Whether they are seconds from the first one.
    pub(super) is_time: bool,
}

/// How many numbers an element has.
pub(super) fn numbers_of(kind: &DType) -> u64 {
    match kind {
        DType::Plain(kind) => {
            if kind.type_char() == TypeChar::Complex {
                2
            } else {
                1
            }
        }
        DType::Array(count, kind) => count.saturating_mul(numbers_of(kind)),
        DType::Record(fields) => fields.iter().fold(0, |sum: u64, own| sum.saturating_add(numbers_of(&own.dtype))),
    }
}

/// The columns of elements of this type.
pub(super) fn columns(kind: &DType, bytes: &[u8]) -> Vec<Values> {
    let (mut leaves, size) = (Vec::new(), kind.num_bytes().unwrap_or(0).max(1));
    add(kind, String::new(), &mut 0, &mut leaves);
    let parts = |leaf: Leaf| -> Vec<Values> {
        let own = leaf.kind.num_bytes().unwrap_or(0);
        let part = |name: &str, at: usize, own: usize| {
            let cells = bytes.chunks_exact(size).filter_map(|element| element.get(at..at + own));
            let (values, is_time) = match seconds_in(&leaf.kind) {
                Some(unit) => (times(&leaf.kind, cells, unit), true),
                None => (numbers(&leaf.kind, own, cells), false),
            };
            Values { name: format!("{}{name}", leaf.name), values, is_time }
        };
        match leaf.kind.type_char() {
            TypeChar::Complex => vec![part("_re", leaf.at, own / 2), part("_im", leaf.at + own / 2, own / 2)],
            _ => vec![part("", leaf.at, own)],
        }
    };
    leaves.into_iter().flat_map(parts).collect()
}

/// Adds the parts of an element.
fn add(kind: &DType, name: String, at: &mut usize, leaves: &mut Vec<Leaf>) {
    match kind {
        DType::Plain(kind) => {
            let own = *at;
            *at += kind.num_bytes().unwrap_or(0);
            leaves.push(Leaf { name, at: own, kind: kind.clone() });
        }
        DType::Array(count, kind) => {
            for k in 1..=*count {
                add(kind, format!("{name}_{k}"), at, leaves);
            }
        }
        DType::Record(fields) => {
            for field in fields {
                // What fills a structure up has no name.
                match &field.dtype {
                    filling if field.name.is_empty() => *at += filling.num_bytes().unwrap_or(0),
                    kind => add(kind, format!("{name}.{}", field.name), at, leaves),
                }
            }
        }
    }
}

fn numbers<'a>(kind: &TypeStr, size: usize, cells: impl Iterator<Item = &'a [u8]>) -> Result<Vec<f64>, String> {
    let number = match kind.type_char() {
        TypeChar::Float | TypeChar::Complex => Kind::Float,
        TypeChar::Int => Kind::Signed,
        // Flags are zero or one.
        TypeChar::Uint | TypeChar::Bool => Kind::Unsigned,
        TypeChar::ByteStr | TypeChar::UnicodeStr => return Err("text".into()),
        TypeChar::Object => return Err("objects of Python: save it as numbers".into()),
        _ => return Err(format!("no numbers but {kind}")),
    };
    let numbers = cells::numbers(number, size, kind.endianness() == Endianness::Big, cells);
    numbers.ok_or_else(|| format!("{kind}: save it as float64"))
}

/// Whole units of times, and how many of them a second has; `None` of other values.
fn seconds_in(kind: &TypeStr) -> Option<Option<(i128, f64)>> {
    if !matches!(kind.type_char(), TypeChar::DateTime | TypeChar::TimeDelta) {
        return None;
    }
    Some(kind.time_units().and_then(|unit| {
        Some(match unit {
            TimeUnits::Week => (604_800, 1.0),
            TimeUnits::Day => (86_400, 1.0),
            TimeUnits::Hour => (3600, 1.0),
            TimeUnits::Minute => (60, 1.0),
            TimeUnits::Second => (1, 1.0),
            TimeUnits::Millisecond => (1, 1e3),
            TimeUnits::Microsecond => (1, 1e6),
            TimeUnits::Nanosecond => (1, 1e9),
            TimeUnits::Picosecond => (1, 1e12),
            TimeUnits::Femtosecond => (1, 1e15),
            TimeUnits::Attosecond => (1, 1e18),
            // Years and months differ.
            _ => return None,
        })
    }))
}

/// Times as seconds from the first one; NaN of what is no time.
fn times<'a>(
    kind: &TypeStr,
    cells: impl Iterator<Item = &'a [u8]>,
    unit: Option<(i128, f64)>,
) -> Result<Vec<f64>, String> {
    let (many, a_second) = unit.ok_or_else(|| format!("times of an unknown unit ({kind}): save them as seconds"))?;
    let is_big = kind.endianness() == Endianness::Big;
    let time = |cell| Some(i64::from_le_bytes(little(cell, is_big))).filter(|time| *time != i64::MIN);
    Ok(FromFirst::default().seconds(cells.map(|cell| time(cell).map(|time| i128::from(time) * many)), a_second))
}
