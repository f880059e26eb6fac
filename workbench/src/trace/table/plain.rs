//! Rows of text without quotes, read in parallel.
//!
//! The text is split at ends of lines; each piece is read by itself, and the pieces are joined in their order. What is
//! read, and every message, is that of the general reader of [`super::text`].

use memchr::{memchr, memchr_iter};
use rayon::prelude::*;

/// Bytes of a piece.
const PIECE: usize = 1 << 20;

/// How rows are written, and which cells are wanted.
pub(super) struct Form<'a> {
    pub(super) separator: u8,
    /// Lines that start with it are left out.
    pub(super) comment: Option<u8>,
    /// Number of cells of a row.
    pub(super) cells: usize,
    /// Places of the numbers, each once.
    pub(super) numbers: &'a [usize],
    /// Place of the text by which rows are chosen.
    pub(super) text: Option<usize>,
    pub(super) row: &'a (dyn Fn(&str) -> bool + Sync),
    /// The number in a cell.
    pub(super) number: &'a (dyn Fn(&str) -> Result<f64, String> + Sync),
}

/// Why a row is not taken.
#[derive(Debug, PartialEq)]
pub(super) enum Refusal {
    /// It has so many cells.
    Cells(usize),
    /// The number at this place.
    Number(usize, String),
}

/// The rows of a text.
#[derive(Debug, Default)]
pub(super) struct Rows {
    pub(super) numbers: Vec<Vec<f64>>,
    pub(super) texts: Vec<String>,
    /// Line of each row that was wanted.
    pub(super) lines: Vec<u64>,
    /// All rows, also those that were not wanted.
    pub(super) count: usize,
}

/// Whether the text can be read here: no quotes, and lines that end with a line feed.
pub(super) fn suits(text: &str) -> bool {
    let bytes = text.as_bytes();
    memchr(b'"', bytes).is_none() && memchr_iter(b'\r', bytes).all(|place| bytes.get(place + 1) == Some(&b'\n'))
}

/// Reads the rows after the line `first` of a text; the error has the line.
pub(super) fn rows(text: &str, first: u64, form: &Form<'_>) -> Result<Rows, (u64, Refusal)> {
    let pieces = pieces(text);
    let counts: Vec<u64> = pieces.par_iter().map(|piece| memchr_iter(b'\n', piece.as_bytes()).count() as u64).collect();
    let starts = counts.iter().scan(first, |line, count| {
        let start = *line;
        *line += count;
        Some(start)
    });
    let numbered: Vec<(&str, u64)> = pieces.iter().copied().zip(starts).collect();
    let read: Vec<Result<Rows, _>> =
        numbered.into_par_iter().map(|(piece, line)| piece_rows(piece, line, form)).collect();
    let count = read.iter().flatten().map(|rows| rows.lines.len()).sum();
    let numbers = vec![Vec::with_capacity(count); form.numbers.len()];
    let mut all = Rows { numbers, lines: Vec::with_capacity(count), ..Rows::default() };
    all.numbers.iter_mut().for_each(|column| column.reserve_exact(count));
    for rows in read {
        let rows = rows?;
        all.numbers.iter_mut().zip(&rows.numbers).for_each(|(column, further)| column.extend_from_slice(further));
        all.texts.extend(rows.texts);
        all.lines.extend_from_slice(&rows.lines);
        all.count += rows.count;
    }
    Ok(all)
}

fn pieces(text: &str) -> Vec<&str> {
    let (mut rest, mut pieces) = (text, vec![]);
    while rest.len() > PIECE {
        let Some(end) = memchr(b'\n', &rest.as_bytes()[PIECE..]) else { break };
        let (piece, later) = rest.split_at(PIECE + end + 1);
        pieces.push(piece);
        rest = later;
    }
    pieces.push(rest);
    pieces
}

fn piece_rows(piece: &str, first: u64, form: &Form<'_>) -> Result<Rows, (u64, Refusal)> {
    let mut slots = vec![None; form.cells];
    form.numbers.iter().enumerate().for_each(|(slot, place)| slots[*place] = Some(slot));
    let mut rows = Rows { numbers: vec![Vec::new(); form.numbers.len()], ..Rows::default() };
    let mut cells: Vec<&str> = Vec::with_capacity(form.cells);
    let mut rest = piece;
    let mut line = first;
    while !rest.is_empty() {
        let end = memchr(b'\n', rest.as_bytes()).unwrap_or(rest.len());
        let own = &rest[..end];
        rest = rest.get(end + 1..).unwrap_or("");
        line += 1;
        let own = own.strip_suffix('\r').unwrap_or(own);
        if own.is_empty() || form.comment.is_some_and(|mark| own.as_bytes()[0] == mark) {
            continue;
        }
        cells.clear();
        let mut from = 0;
        // Cells are short: looking at each byte is quicker than a search for the next separator.
        for (at, byte) in own.bytes().enumerate() {
            if byte == form.separator {
                cells.push(&own[from..at]);
                from = at + 1;
            }
        }
        cells.push(&own[from..]);
        rows.count += 1;
        if cells.len() != form.cells {
            return Err((line, Refusal::Cells(cells.len())));
        }
        if let Some(place) = form.text {
            let text = cells[place].trim();
            if !(form.row)(text) {
                continue;
            }
            rows.texts.push(text.to_string());
        }
        for (place, (cell, slot)) in cells.iter().zip(&slots).enumerate() {
            if let Some(slot) = slot {
                let number = match short_decimal(cell.as_bytes()) {
                    Some(number) => number,
                    None => (form.number)(cell.trim()).map_err(|problem| (line, Refusal::Number(place, problem)))?,
                };
                rows.numbers[*slot].push(number);
            }
        }
        rows.lines.push(line);
    }
    Ok(rows)
}

/// A decimal number of at most 15 digits without an exponent: its digits and the power of ten are exact, so that their
/// quotient is the nearest number, as of any correct parser. `None` of everything else.
fn short_decimal(cell: &[u8]) -> Option<f64> {
    /// Exact powers of ten.
    const TENS: [f64; 16] = [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15];
    let (negative, digits) = match cell {
        [b'-', digits @ ..] => (true, digits),
        digits => (false, digits),
    };
    let (mut value, mut seen, mut after) = (0_u64, 0, None);
    for byte in digits {
        match byte {
            b'0'..=b'9' => {
                value = 10 * value + u64::from(byte - b'0');
                seen += 1;
                if seen > 15 {
                    return None;
                }
                after = after.map(|count| count + 1);
            }
            b'.' if after.is_none() => after = Some(0),
            _ => return None,
        }
    }
    let number = value as f64 / TENS.get(after.unwrap_or(0))?;
    (seen > 0).then_some(if negative { -number } else { number })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bit by bit the numbers of the standard library's parser.
    #[test]
    fn short_decimals_are_exact() {
        for text in
            ["0", "-0.0", "1.5", "-2.675", "0.1", "123456.789012345", "999999999999999", "0.00000000000001", "5."]
        {
            let expected: f64 = text.parse().expect("a number");
            assert_eq!(short_decimal(text.as_bytes()).map(f64::to_bits), Some(expected.to_bits()), "{text}");
        }
        let mut state = 1_u64;
        for _ in 0..20_000 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let (digits, places) = (state >> 16 & 0x1_ffff_ffff_ffff, (state >> 8) as usize % 16);
            let text = format!("{}.{:0>1$}", digits % 97, places.min(13));
            let long = format!("-{}.{}", digits % 1000, digits / 1000 % 10_000_000_000);
            for text in [&text, &long] {
                let expected: f64 = text.parse().expect("a number");
                assert_eq!(short_decimal(text.as_bytes()).map(f64::to_bits), Some(expected.to_bits()), "{text}");
            }
        }
        assert!(
            ["", "-", ".", "1e5", "+1", " 1", "1,5", "1.2.3", "1234567890123456", "nan"]
                .iter()
                .all(|text| { short_decimal(text.as_bytes()).is_none() })
        );
    }

    /// Pieces are joined in their order, and lines are counted over them.
    #[test]
    fn a_long_text_is_read_as_a_whole() {
        let row = |k: usize| format!("{k},{},x\n", k % 97);
        let count = 300_000;
        let mut text: String = (0..count).map(row).collect();
        text.insert_str(0, "# a comment\n\n");
        assert!(text.len() > 3 * PIECE && suits(&text));
        let number = |cell: &str| cell.parse::<f64>().map_err(|_| "no number".to_string());
        let form = Form {
            separator: b',',
            comment: Some(b'#'),
            cells: 3,
            numbers: &[1, 0],
            text: None,
            row: &|_| true,
            number: &number,
        };
        let found = rows(&text, 1, &form).expect("good rows");
        assert_eq!((found.count, found.numbers[0].len()), (count, count));
        assert!((0..count).all(|k| found.numbers[1][k] == k as f64 && found.numbers[0][k] == (k % 97) as f64));
        // Line 1 is the header before the text, 2 the comment, 3 empty.
        assert!((0..count).all(|k| found.lines[k] == k as u64 + 4));
        // The first of two bad rows in different pieces is told.
        let text = text.replace("\n250000,", "\n250000,7,").replace("\n290000,", "\nx,");
        assert_eq!(rows(&text, 1, &form).expect_err("four cells"), (250_004, Refusal::Cells(4)));
        assert!(!suits("a,\"b\"\n") && !suits("1\r2\r") && suits("1\r\n2\r\n"));
    }
}
