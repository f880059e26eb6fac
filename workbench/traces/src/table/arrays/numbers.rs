//! Numbers of any size and either order of bytes, one in each cell of an array.

use half::f16;

/// Kinds of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::table) enum Kind {
    Float,
    Signed,
    Unsigned,
}

/// The bytes of a cell in the order of a little-endian machine.
pub(in crate::table) fn little<const N: usize>(cell: &[u8], is_big: bool) -> [u8; N] {
    let mut own = [0; N];
    own.iter_mut().zip(cell).for_each(|(own, byte)| *own = *byte);
    if is_big {
        own.reverse();
    }
    own
}

/// The numbers of cells of `size` bytes; `None` of a size that no kind of number has.
pub(in crate::table) fn numbers<'a>(
    kind: Kind,
    size: usize,
    is_big: bool,
    cells: impl Iterator<Item = &'a [u8]>,
) -> Option<Vec<f64>> {
    macro_rules! each {
        ($kind:ty, $convert:expr) => {{
            let convert = $convert;
            cells.map(|cell| convert(<$kind>::from_le_bytes(little(cell, is_big)))).collect()
        }};
    }
    Some(match (kind, size) {
        (Kind::Float, 8) => each!(f64, |x| x),
        (Kind::Float, 4) => each!(f32, f64::from),
        (Kind::Float, 2) => each!(f16, f64::from),
        (Kind::Signed, 1) => each!(i8, f64::from),
        (Kind::Signed, 2) => each!(i16, f64::from),
        (Kind::Signed, 4) => each!(i32, f64::from),
        (Kind::Signed, 8) => each!(i64, |x| x as f64),
        (Kind::Unsigned, 1) => each!(u8, f64::from),
        (Kind::Unsigned, 2) => each!(u16, f64::from),
        (Kind::Unsigned, 4) => each!(u32, f64::from),
        (Kind::Unsigned, 8) => each!(u64, |x| x as f64),
        _ => return None,
    })
}
