//! Rows of text without quotes, read in parallel.
//!
//! Each piece of the text is read by itself, into its part of the columns. What is read, and every message, is that of
//! the general reader of [`super::text`].

use memchr::{memchr, memchr_iter};
use rayon::prelude::*;

use super::Lines;
use super::digits::decimal;
use super::source::Source;

/// How rows are written, and which cells are wanted.
pub(super) struct Form<'a> {
    pub(super) separator: u8,
    /// Whether numbers have decimal commas.
    pub(super) decimal_comma: bool,
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

/// Why rows are not read.
#[derive(Debug)]
pub(super) enum Failure {
    /// The row in this line is not taken.
    Row(u64, Refusal),
    /// A file cannot be read any more, or changes while it is read.
    File(std::io::Error),
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
    pub(super) lines: Lines,
    /// All rows, also those that were not wanted.
    pub(super) count: usize,
}

/// Counts the lines of each piece; `None` if the text cannot be read here.
pub(super) fn lines(source: Source<'_>) -> std::io::Result<Option<Vec<usize>>> {
    let count = |buffer: &mut Vec<u8>, piece| {
        let text = source.piece(piece, buffer)?;
        Ok(suits(text).then(|| count_lines(text)))
    };
    // As a list first: what is found must not depend on which thread is first.
    let counts: Vec<std::io::Result<Option<usize>>> =
        (0..source.pieces()).into_par_iter().map_init(Vec::new, count).collect();
    counts.into_iter().collect()
}

/// Whether a text can be read here: it is UTF-8 without quotes, and its lines end with a line feed.
pub(super) fn suits(text: &[u8]) -> bool {
    let feed = |place: usize| text.get(place + 1) == Some(&b'\n');
    memchr(b'"', text).is_none() && memchr_iter(b'\r', text).all(feed) && std::str::from_utf8(text).is_ok()
}

/// Reads the rows after the line `first` of a text, of whose pieces the lines are counted.
pub(super) fn rows(source: Source<'_>, first: u64, counts: &[usize], form: &Form<'_>) -> Result<Rows, Failure> {
    // Zeros of the system, which is quicker than copies of a list of zeros.
    let mut numbers: Vec<Vec<f64>> = form.numbers.iter().map(|_| vec![0.0; counts.iter().sum()]).collect();
    let mut parts: Vec<Piece<'_>> = Vec::with_capacity(counts.len());
    let mut rest: Vec<&mut [f64]> = numbers.iter_mut().map(Vec::as_mut_slice).collect();
    let mut line = first;
    for (piece, lines) in counts.iter().enumerate() {
        // A piece has at most as many rows as lines.
        let (columns, later) = rest.into_iter().map(|column| column.split_at_mut(*lines)).unzip();
        parts.push(Piece { piece, line, lines: *lines, columns });
        (rest, line) = (later, line + *lines as u64);
    }
    let read = |buffer: &mut Vec<u8>, piece: Piece<'_>| piece.read(source, buffer, form);
    let read: Vec<Result<Rows, Failure>> = parts.into_par_iter().map_init(Vec::new, read).collect();
    let mut all = Rows::default();
    let (mut start, mut end) = (0, 0);
    for (rows, lines) in read.into_iter().zip(counts) {
        let mut rows = rows?;
        let filled = rows.lines.rows();
        if start != end {
            numbers.iter_mut().for_each(|column| column.copy_within(start..start + filled, end));
        }
        all.texts.append(&mut rows.texts);
        all.lines.append(&rows.lines);
        all.count += rows.count;
        (start, end) = (start + lines, end + filled);
    }
    numbers.iter_mut().for_each(|column| column.truncate(end));
    Ok(Rows { numbers, ..all })
}

/// Number of lines; the last one need not end.
fn count_lines(text: &[u8]) -> usize {
    memchr_iter(b'\n', text).count() + usize::from(text.last().is_some_and(|last| *last != b'\n'))
}

/// A piece of the text, the number of the line before it, how many lines it has, and the columns for its numbers.
struct Piece<'a> {
    piece: usize,
    line: u64,
    lines: usize,
    columns: Vec<&'a mut [f64]>,
}

impl Piece<'_> {
    /// Reads the rows; those returned have no numbers, which are in the columns.
    fn read(mut self, source: Source<'_>, buffer: &mut Vec<u8>, form: &Form<'_>) -> Result<Rows, Failure> {
        let text = source.piece(self.piece, buffer).map_err(Failure::File)?;
        let changed = || Failure::File(std::io::Error::other("the file changes while it is read"));
        let text = std::str::from_utf8(text).ok().filter(|text| count_lines(text.as_bytes()) == self.lines);
        let text = text.ok_or_else(changed)?;
        let mut slots = vec![None; form.cells];
        form.numbers.iter().enumerate().for_each(|(slot, place)| slots[*place] = Some(slot));
        let mut rows = Rows::default();
        let (mut rest, mut line) = (text, self.line);
        while !rest.is_empty() {
            let end = memchr(b'\n', rest.as_bytes()).unwrap_or(rest.len());
            let (own, after) = (&rest[..end], rest);
            rest = rest.get(end + 1..).unwrap_or("");
            line += 1;
            let own = own.strip_suffix('\r').unwrap_or(own);
            if own.is_empty() || form.comment.is_some_and(|mark| own.as_bytes()[0] == mark) {
                continue;
            }
            rows.count += 1;
            if let Some(place) = form.text {
                let text = own.split(char::from(form.separator)).nth(place).unwrap_or("").trim();
                if !(form.row)(text) {
                    form.complete(own).map_err(|refusal| Failure::Row(line, refusal))?;
                    continue;
                }
                rows.texts.push(text.to_string());
            }
            let row = (&slots[..], rows.lines.rows());
            self.numbers((own, after.as_bytes()), row, form).map_err(|refusal| Failure::Row(line, refusal))?;
            rows.lines.push(line);
        }
        Ok(rows)
    }

    /// Reads the numbers of a line into a row of the columns; `after` is the line and the text after it.
    fn numbers(&mut self, (line, after): (&str, &[u8]), row: Row<'_>, form: &Form<'_>) -> Result<(), Refusal> {
        let (slots, row) = row;
        let bytes = line.as_bytes();
        let mut from = 0;
        for (place, slot) in slots.iter().enumerate() {
            if from > bytes.len() {
                return form.complete(line);
            }
            let rest = &bytes[from..];
            let next = || memchr(form.separator, rest).unwrap_or(rest.len());
            let Some(slot) = slot else {
                from += next() + 1;
                continue;
            };
            let ends = |(_, length): &(f64, usize)| rest.get(*length).is_none_or(|byte| *byte == form.separator);
            let any = || fast_float2::parse_partial(rest).ok().filter(ends);
            let quick = if form.decimal_comma { None } else { decimal(&after[from..]).filter(ends).or_else(any) };
            let (number, length) = match quick.filter(|(number, _)| number.abs() <= super::LARGEST) {
                Some(found) => found,
                None => {
                    let length = next();
                    let refused = |problem| form.complete(line).err().unwrap_or(Refusal::Number(place, problem));
                    ((form.number)(line[from..from + length].trim()).map_err(refused)?, length)
                }
            };
            self.columns[*slot][row] = number;
            from += length + 1;
        }
        if from == bytes.len() + 1 { Ok(()) } else { form.complete(line) }
    }
}

/// The slot of each cell of a line, and the row.
type Row<'a> = (&'a [Option<usize>], usize);

impl Form<'_> {
    /// Refuses a line with another number of cells.
    fn complete(&self, line: &str) -> Result<(), Refusal> {
        let cells = 1 + memchr_iter(self.separator, line.as_bytes()).count();
        if cells == self.cells { Ok(()) } else { Err(Refusal::Cells(cells)) }
    }
}

#[cfg(test)]
mod tests {
    use super::super::source::PIECE;
    use super::*;

    fn read(text: &str, first: u64, form: &Form<'_>) -> Result<Rows, (u64, Refusal)> {
        let counts = lines(Source::Memory(text)).expect("in memory").expect("plain text");
        rows(Source::Memory(text), first, &counts, form).map_err(|failure| match failure {
            Failure::Row(line, refusal) => (line, refusal),
            Failure::File(error) => panic!("{error}"),
        })
    }

    /// Bit by bit the numbers of the standard library's parser, and refused where it refuses.
    #[test]
    fn numbers_are_those_of_the_general_reader() {
        let number = |cell: &str| cell.parse::<f64>().map_err(|_| "no number".to_string());
        let of = |text: &str| {
            let form = Form {
                separator: b',',
                decimal_comma: false,
                comment: None,
                cells: 1,
                numbers: &[0],
                text: None,
                row: &|_| true,
                number: &number,
            };
            read(text, 0, &form).map(|found| found.numbers[0][0].to_bits())
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
            assert_eq!(of(&text).ok(), expected, "{text}");
        }
    }

    /// Pieces are joined in their order, and lines are counted over them.
    #[test]
    fn a_long_text_is_read_as_a_whole() {
        let row = |k: usize| format!("{k},{},x\n", k % 97);
        let count = 300_000;
        let mut text: String = (0..count).map(row).collect();
        text.insert_str(0, "# a comment\n\n");
        assert!(text.len() > 3 * PIECE && suits(text.as_bytes()));
        let number = |cell: &str| cell.parse::<f64>().map_err(|_| "no number".to_string());
        let form = Form {
            separator: b',',
            decimal_comma: false,
            comment: Some(b'#'),
            cells: 3,
            numbers: &[1, 0],
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
        assert_eq!(read(&text, 1, &form).expect_err("four cells"), (250_004, Refusal::Cells(4)));
        assert!(!suits(b"a,\"b\"\n") && !suits(b"1\r2\r") && !suits(b"1\xb0\n") && suits(b"1\r\n2\r\n"));
    }
}
