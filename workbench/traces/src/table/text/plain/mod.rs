//! Rows of text without quotes, read in parallel.
//!
//! Each piece of the text is read by itself, into its part of the columns. What is read, and every message, is that of
//! the general reader of [`super::Text`].

mod digits;
mod separators;
mod source;

use memchr::{memchr, memchr_iter};
use rayon::prelude::*;

use crate::table::columns::{LARGEST, Lines};
use digits::decimal;

pub(super) use source::Source;

/// Pieces that are in memory at a time. The same for any number of threads, as it decides which of two problems in a
/// text is told.
const GROUP: usize = 32;

/// How rows are written, and which cells are wanted.
pub(super) struct Form<'a> {
    pub(super) separator: u8,
    /// The point of decimal numbers, or the comma.
    pub(super) point: u8,
    /// Lines that start with it are left out.
    pub(super) comment: Option<u8>,
    /// Number of cells of a row, and whether a row may have fewer.
    pub(super) cells: usize,
    pub(super) ends_early: bool,
    /// Places of the numbers, each once, and whether a column has decimal numbers alone.
    pub(super) numbers: &'a [usize],
    pub(super) quick: &'a (dyn Fn(usize) -> bool + Sync),
    /// Place of the text by which rows are chosen.
    pub(super) text: Option<usize>,
    pub(super) row: &'a (dyn Fn(&str) -> bool + Sync),
    /// The number in a cell, by its place and line.
    pub(super) number: &'a (dyn Fn(usize, u64, &str) -> f64 + Sync),
}

/// Why rows are not read.
#[derive(Debug)]
pub(super) enum Failure {
    /// The row in this line has so many cells.
    Cells(u64, usize),
    /// A file cannot be read any more.
    File(std::io::Error),
}

/// The rows of a text.
#[derive(Debug, Default)]
pub(super) struct Rows {
    pub(super) numbers: Vec<Vec<f64>>,
    pub(super) texts: Vec<String>,
    /// Line of each row that was wanted.
    pub(super) lines: Lines,
    /// All rows, also those that were not wanted.
    pub(super) count: usize,
}

/// Reads the rows after the line `first` of a text; `None` if the text cannot be read here.
pub(super) fn rows(source: Source<'_>, first: u64, form: &Form<'_>) -> Result<Option<Rows>, Failure> {
    let pieces = source.pieces();
    let mut memory = vec![(Vec::new(), Vec::new()); GROUP.min(pieces)];
    let mut all = Rows { numbers: vec![Vec::new(); form.numbers.len()], ..Rows::default() };
    let (mut line, mut bytes) = (first, 0);
    for start in (0..pieces).step_by(GROUP) {
        let own = memory.par_iter_mut().zip(start..pieces.min(start + GROUP));
        // As a list first: what is found must not depend on which thread is first.
        let group: Vec<_> = own
            .map(|((buffer, marks), piece)| Ok(Piece::find(source.piece(piece, buffer)?, form.separator, marks)))
            .collect();
        let group: std::io::Result<Option<Vec<Piece<'_>>>> = group.into_iter().collect();
        let Some(group) = group.map_err(Failure::File)? else { return Ok(None) };
        let lines: Vec<usize> = group.iter().map(|piece| piece.lines).collect();
        // A piece has at most as many rows as lines.
        let filled = all.lines.rows();
        let needed = filled + lines.iter().sum::<usize>();
        bytes += group.iter().map(|piece| piece.text.len() as u64).sum::<u64>();
        let expected = 1.02 * needed as f64 * source.bytes() as f64 / bytes.max(1) as f64;
        all.numbers.par_iter_mut().for_each(|column| lengthen(column, needed, expected as usize));
        let mut rest: Vec<&mut [f64]> = all.numbers.iter_mut().map(|column| &mut column[filled..]).collect();
        let mut parts = Vec::with_capacity(group.len());
        for piece in group {
            let lines = piece.lines;
            let (columns, later) = rest.into_iter().map(|column| column.split_at_mut(lines)).unzip();
            parts.push((line, piece, columns));
            (rest, line) = (later, line + lines as u64);
        }
        let read = |(line, piece, columns): (u64, Piece<'_>, Vec<_>)| piece.read(line, form, columns);
        let read: Vec<Result<Rows, Failure>> = parts.into_par_iter().map(read).collect();
        let (mut from, mut end) = (filled, filled);
        for (rows, lines) in read.into_iter().zip(lines) {
            let mut rows = rows?;
            let count = rows.lines.rows();
            if from != end {
                all.numbers.iter_mut().for_each(|column| column.copy_within(from..from + count, end));
            }
            all.texts.append(&mut rows.texts);
            all.lines.append(&rows.lines);
            all.count += rows.count;
            (from, end) = (from + lines, end + count);
        }
    }
    let rows = all.lines.rows();
    all.numbers.iter_mut().for_each(|column| column.truncate(rows));
    Ok(Some(all))
}

/// Makes room for the rows that are needed, and for more if so many are expected.
fn lengthen(column: &mut Vec<f64>, needed: usize, expected: usize) {
    if column.is_empty() {
        // Zeros of the system, which is quicker than zeros that are written.
        *column = vec![0.0; needed.max(expected)];
    } else if column.len() < needed {
        column.resize(needed.max(expected), 0.0);
    }
}

/// Text that can be read here: UTF-8 without quotes, whose lines end with a line feed.
pub(super) fn plain(text: &[u8]) -> Option<&str> {
    let feed = |place: usize| text.get(place + 1) == Some(&b'\n');
    let suits = memchr(b'"', text).is_none() && memchr_iter(b'\r', text).all(feed);
    std::str::from_utf8(text).ok().filter(|_| suits)
}

/// A piece of the text, where its cells end, and how many lines it has; the last one need not end.
struct Piece<'a> {
    text: &'a str,
    marks: &'a mut [usize],
    lines: usize,
}

impl<'a> Piece<'a> {
    fn find(text: &'a [u8], separator: u8, marks: &'a mut Vec<usize>) -> Option<Self> {
        let text = plain(text)?;
        separators::find(text.as_bytes(), separator, marks);
        let is_open = !text.is_empty() && !text.ends_with('\n');
        Some(Self { text, marks, lines: memchr_iter(b'\n', text.as_bytes()).count() + usize::from(is_open) })
    }

    /// Reads the rows after a line; the numbers go into columns, and those returned are empty.
    fn read(self, line: u64, form: &Form<'_>, mut columns: Vec<&mut [f64]>) -> Result<Rows, Failure> {
        let (text, bytes) = (self.text, self.text.as_bytes());
        let mut slots = vec![None; form.cells];
        let own = form.numbers.iter().enumerate();
        own.for_each(|(slot, place)| slots[*place] = Some((slot, (form.quick)(*place))));
        let mut rows = Rows::default();
        let is_last = |mark: &usize| bytes.get(*mark).is_none_or(|byte| *byte == b'\n');
        let (mut rest, mut next, mut line) = (self.marks, 0, line);
        while let Some(last) = rest.iter().position(is_last) {
            let (ends, later) = rest.split_at_mut(last + 1);
            let start = next;
            (rest, next, line) = (later, ends[last] + 1, line + 1);
            ends[last] -= usize::from(text[start..ends[last]].ends_with('\r'));
            if ends[last] == start || form.comment.is_some_and(|mark| bytes[start] == mark) {
                continue;
            }
            rows.count += 1;
            if let Some(place) = form.text {
                let before = place.checked_sub(1).map_or(Some(start), |before| Some(ends.get(before)? + 1));
                let cell = before.zip(ends.get(place)).map_or("", |(start, end)| &text[start..*end]).trim();
                if !(form.row)(cell) {
                    continue;
                }
                rows.texts.push(cell.to_string());
            }
            let (row, mut start) = (rows.lines.rows(), start);
            if ends.len() != form.cells {
                if ends.len() > form.cells || !form.ends_early {
                    return Err(Failure::Cells(line, ends.len()));
                }
                slots[ends.len()..].iter().flatten().for_each(|(slot, _)| columns[*slot][row] = f64::NAN);
            }
            for (place, (end, slot)) in ends.iter().zip(&slots).enumerate() {
                let cell = start..*end;
                start = end + 1;
                let Some((slot, is_decimal)) = slot else { continue };
                let any = || if form.point == b'.' { fast_float2::parse(&bytes[cell.clone()]).ok() } else { None };
                let quick = if *is_decimal { decimal(bytes, cell.clone(), form.point).or_else(any) } else { None };
                columns[*slot][row] = match quick.filter(|number| number.abs() <= LARGEST) {
                    Some(number) => number,
                    None => (form.number)(place, line, text[cell].trim()),
                };
            }
            rows.lines.push(line);
        }
        Ok(rows)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use source::PIECE;

    fn read(text: &str, first: u64, form: &Form<'_>) -> Result<Rows, (u64, usize)> {
        match rows(Source::Memory(text), first, form) {
            Ok(found) => Ok(found.expect("plain text")),
            Err(Failure::Cells(line, cells)) => Err((line, cells)),
            Err(Failure::File(error)) => panic!("{error}"),
        }
    }

    /// Bit by bit the numbers of the standard library's parser, and refused where it refuses.
    #[test]
    fn numbers_are_those_of_the_general_reader() {
        let refused = std::sync::atomic::AtomicBool::new(false);
        let number = |_: usize, _: u64, cell: &str| {
            cell.parse::<f64>().unwrap_or_else(|_| {
                refused.store(true, std::sync::atomic::Ordering::Relaxed);
                f64::NAN
            })
        };
        let of = |text: &str| {
            let form = Form {
                separator: b',',
                point: b'.',
                comment: None,
                cells: 1,
                ends_early: false,
                numbers: &[0],
                quick: &|_| true,
                text: None,
                row: &|_| true,
                number: &number,
            };
            let found = read(text, 0, &form).expect("one cell").numbers[0][0].to_bits();
            (!refused.swap(false, std::sync::atomic::Ordering::Relaxed)).then_some(found)
        };
        let plain = ["0", "-0.0", "1.5", "-2.675", "0.1", "999999999999999", "5.", ".5", "+1", " 1", "1e5", "1E-5"];
        let odd = ["-", ".", "1.2.3", "1_0", "0x1", "1e", "e5", "--1", "1 2", "nano", "+-1"];
        let mut texts: Vec<String> = plain.iter().chain(&odd).map(ToString::to_string).collect();
        let mut state = 1_u64;
        for _ in 0..20_000 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let (digits, places) = (state >> 16 & 0x1_ffff_ffff_ffff, (state >> 8) as usize % 16);
            texts.push(format!("{}.{:0>1$}", digits % 97, places));
            texts.push(format!("-{}.{digits}", digits % 1000));
            texts.push(format!("{:e}", f64::from_bits(state)));
        }
        for text in texts {
            let expected = text.trim().parse::<f64>().ok().map(f64::to_bits);
            assert_eq!(of(&text), expected, "{text}");
        }
    }

    /// Pieces are joined in their order, and lines are counted over them.
    #[test]
    fn a_long_text_is_read_as_a_whole() {
        let row = |k: usize| format!("{k},{},x\n", k % 97);
        let count = 500_000;
        let mut text: String = (0..count).map(row).collect();
        text.insert_str(0, "# a comment\n\n");
        assert!(text.len() > (GROUP + 1) * PIECE);
        let number = |_: usize, _: u64, cell: &str| cell.parse::<f64>().unwrap_or(f64::NAN);
        let form = Form {
            separator: b',',
            point: b'.',
            comment: Some(b'#'),
            cells: 3,
            ends_early: false,
            numbers: &[1, 0],
            quick: &|_| true,
            text: None,
            row: &|_| true,
            number: &number,
        };
        let found = read(&text, 1, &form).expect("good rows");
        assert_eq!((found.count, found.numbers[0].len()), (count, count));
        assert!((0..count).all(|k| found.numbers[1][k] == k as f64 && found.numbers[0][k] == (k % 97) as f64));
        // Line 1 is the header before the text, 2 the comment, 3 empty.
        assert!((0..count).all(|k| found.lines.of(k) == Some(k as u64 + 4)));
        // The first of two bad rows in different pieces is told.
        let text = text.replace("\n250000,", "\n250000,7,").replace("\n290000,", "\nx,");
        assert_eq!(read(&text, 1, &form).expect_err("four cells"), (250_004, 4));
        for (text, suits) in [("1\r\n2\r\n", true), ("a,\"b\"\n", false), ("1\r2\r", false)] {
            assert_eq!(plain(text.as_bytes()), Some(text).filter(|_| suits));
        }
        assert_eq!(plain(b"1\xb0\n"), None);
    }
}
