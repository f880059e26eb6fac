//! Text files: a header, and one row a line.

mod cells;
mod encoding;
mod file_end;
mod header;
mod layout;
mod plain;
pub(super) mod preamble;
mod quoted;
mod rows;
#[cfg(test)]
mod tests;
mod time_groups;

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{Read as _, Seek as _, SeekFrom};
use std::path::Path;
use std::sync::{Mutex, OnceLock, PoisonError};

use crate::table::columns::{About, Columns, LARGEST, Lines, Wanted, is_missing, too_large};
use crate::table::limit;
use cells::{is_complex, start_of_line, without_end};
use layout::Layout;
use model::Error;
use model::trace::TextForm;
use plain::{Failure, Form, Source};

pub use quoted::csv_error;

#[cfg(feature = "matlab")]
pub(super) use cells::with_unit;
pub(super) use encoding::packed;

/// Bytes of a file from which it is read in pieces, and of its start, which has the layout.
const LARGE: u64 = 4 << 20;
const HEAD: u64 = 64 << 10;

/// A text file and its layout.
#[derive(Debug)]
pub(super) struct Text {
    content: Content,
    layout: Layout,
    /// Whether it was said that channels go on behind others.
    said: OnceLock<()>,
}

#[derive(Debug)]
enum Content {
    Whole(String),
    /// The first lines of a large file, and its size in bytes.
    Large(String, u64),
}

/// The columns of a text, and which of them have a cell that is no number, with line and problem.
type Found = (Columns, BTreeMap<usize, (u64, String)>);

impl Text {
    pub(super) fn open(path: &Path, form: &TextForm, about: &mut About) -> Result<Self, Error> {
        let content = match start(path, form)? {
            Start::Large(head, bytes) => Content::Large(head, bytes),
            Start::Whole(bytes) => {
                let (text, guessed) = decoded(path, bytes)?;
                about.notes.extend(guessed.map(|name| format!("read as {name}, since it is not UTF-8")));
                Content::Whole(text)
            }
        };
        let layout = Layout::of(content.head(), form);
        if let Some(line) = layout.both_commas {
            let problem =
                "commas separate the cells and are decimal marks; export it with semicolons, or with decimal points";
            return Err(Error::content(path, format!("line {}", line + 1), problem));
        }
        let mut own = Self { content, layout, said: OnceLock::new() };
        own.leave_out_end(path)?;
        own.check_length(path)?;
        let of_layout = std::mem::take(&mut own.layout.about);
        let notes = std::mem::take(&mut about.notes);
        *about = About { notes: [notes, of_layout.notes.clone()].concat(), ..of_layout };
        Ok(own)
    }

    /// Names of the columns.
    pub(super) fn names(&self) -> Vec<String> {
        self.layout.names.clone()
    }

    /// Leaves out what is no row at the end of a file.
    fn leave_out_end(&mut self, path: &Path) -> Result<(), Error> {
        if let Content::Whole(text) = &mut self.content
            && let Some(start) = file_end::open_quote(text)
        {
            text.truncate(start);
            self.layout.about.omit("the last row", "the file ends inside a quoted cell of it");
        }
        let tail = match &self.content {
            Content::Whole(text) => Cow::Borrowed(&text.as_bytes()[text.len() - text.len().min(HEAD as usize)..]),
            Content::Large(_, bytes) => {
                let mut file = File::open(path).map_err(Error::io(path))?;
                file.seek(SeekFrom::Start(bytes.saturating_sub(HEAD))).map_err(Error::io(path))?;
                let mut tail = Vec::new();
                file.take(HEAD).read_to_end(&mut tail).map_err(Error::io(path))?;
                Cow::Owned(tail)
            }
        };
        let (cut, omitted) = file_end::of(&tail, &self.layout);
        omitted.into_iter().for_each(|(place, reason)| self.layout.about.omit(place, reason));
        match &mut self.content {
            Content::Whole(text) => text.truncate(text.len() - cut),
            Content::Large(_, bytes) => *bytes -= cut as u64,
        }
        Ok(())
    }

    /// Takes no rate by which the rows do not last as long as the file says.
    fn check_length(&mut self, path: &Path) -> Result<(), Error> {
        let (Some(lasts), Some(step_s)) = (self.layout.lasts, self.layout.about.step_s) else { return Ok(()) };
        let text = match &self.content {
            Content::Whole(text) => Cow::Borrowed(text),
            Content::Large(..) => Cow::Owned(decoded(path, limit::whole(path)?)?.0),
        };
        let is_row = |line: &&str| !line.trim().is_empty() && self.layout.comment != line.bytes().next();
        let rows = text.lines().skip(self.layout.first).filter(is_row).count();
        if let Some(why) = lasts.contradicts(1.0 / step_s, rows) {
            self.layout.about.step_s = None;
            self.layout.about.notes.push(why);
        }
        Ok(())
    }

    pub(super) fn read(&self, (path, names): (&Path, &[String]), wanted: Wanted<'_>) -> Result<Columns, Error> {
        let (columns, problems) = self.found((path, names), wanted)?;
        match problems.into_iter().min_by_key(|(_, (line, _))| *line) {
            Some((place, (line, problem))) => Err(self.wrong((path, names), place, (line, problem))),
            None => Ok(columns),
        }
    }

    /// Reads all these columns; those with a cell that is no number have its problem instead.
    pub(super) fn read_each(
        &self,
        (path, names): (&Path, &[String]),
        numbers: &[usize],
    ) -> Result<Vec<Result<Vec<f64>, Error>>, Error> {
        let (columns, mut problems) = self.found((path, names), Wanted { numbers, text: None, row: &|_| true })?;
        let each = |(place, column): (&usize, Vec<f64>)| match problems.remove(place) {
            Some(problem) => Err(self.wrong((path, names), *place, problem)),
            None => Ok(column),
        };
        Ok(numbers.iter().zip(columns.numbers).map(each).collect())
    }

    fn wrong(&self, (path, names): (&Path, &[String]), place: usize, (line, problem): (u64, String)) -> Error {
        let at = format!("line {line}, column {}", names[place]);
        let again = self.layout.header.get(place).is_some_and(|cell| problem == no_number(cell));
        if again {
            let problem = "the header comes again: two logs are in one file; split it before this line";
            return Error::content(path, at, problem);
        }
        Error::content(path, at, problem)
    }

    fn found(&self, (path, names): (&Path, &[String]), wanted: Wanted<'_>) -> Result<Found, Error> {
        let Some(rates) = &self.layout.rates else { return self.found_in_rows((path, names), wanted) };
        let needed = rates.needed(wanted.numbers);
        let (mut columns, mut problems) = self.found_in_rows((path, names), Wanted { numbers: &needed, ..wanted })?;
        // A time that is not read is told, whichever column has it.
        let times: Vec<usize> = problems.keys().copied().filter(|place| !wanted.numbers.contains(place)).collect();
        if let (Some(time), Some(first)) = (times.first(), wanted.numbers.first()) {
            problems.remove(time).and_then(|problem| problems.insert(*first, problem));
        }
        let read =
            |place: usize| needed.binary_search(&place).map_or_else(|_| vec![], |at| columns.numbers[at].clone());
        let (held, further) = rates.held(wanted.numbers, &read);
        if further > 0.0 && self.said.set(()).is_ok() {
            log::warn!(
                "{}: slower channels go on for {further:.3} s behind the fastest ones: left out",
                path.display()
            );
        }
        columns.numbers = held;
        Ok((columns, problems))
    }

    fn found_in_rows(&self, (path, names): (&Path, &[String]), wanted: Wanted<'_>) -> Result<Found, Error> {
        let is_twice = wanted.numbers.iter().collect::<BTreeSet<_>>().len() < wanted.numbers.len();
        let spaced = self.layout.separator == b' ';
        let start = start_of_line(self.content.head(), self.layout.first);
        if !spaced && !is_twice {
            let source = match &self.content {
                Content::Whole(text) => Source::Memory(&text[start..]),
                Content::Large(_, end) => Source::File { path, start: start as u64, end: *end },
            };
            if let Some(found) = self.found_plain((path, names), source, wanted)? {
                return Ok(found);
            }
        }
        let text = match &self.content {
            Content::Whole(text) => Cow::Borrowed(text),
            Content::Large(_, end) => {
                let mut text = decoded(path, limit::whole(path)?)?.0;
                text.truncate(usize::try_from(*end).unwrap_or(usize::MAX));
                Cow::Owned(text)
            }
        };
        let mut reader = quoted::reader(&text[start_of_line(&text, self.layout.first)..], &self.layout);
        let mut record = csv::StringRecord::new();
        let mut columns = Columns {
            numbers: vec![Vec::new(); wanted.numbers.len()],
            texts: wanted.text.map(|_| Vec::new()),
            lines: Lines::default(),
        };
        let (mut rows, mut problems) = (0, BTreeMap::new());
        while reader.read_record(&mut record).map_err(|error| quoted::csv_error(path, &error))? {
            let line = record.position().map_or(0, csv::Position::line) + self.layout.first as u64;
            rows += 1;
            let ends_early = self.layout.rates.is_some();
            if record.len() != names.len() && !(ends_early && record.len() < names.len()) {
                return Err(ragged(path, line, record.len(), names.len()));
            }
            let cell = |place: usize| record.get(place).unwrap_or_default().trim();
            if let Some(place) = wanted.text {
                let text = cell(place);
                if !(wanted.row)(text) {
                    continue;
                }
                columns.texts.get_or_insert_default().push(text.to_string());
            }
            for (column, place) in columns.numbers.iter_mut().zip(wanted.numbers) {
                let number = self.number(*place, cell(*place));
                column.push(number.unwrap_or_else(|problem| {
                    problems.entry(*place).or_insert((line, problem));
                    f64::NAN
                }));
            }
            columns.lines.push(line);
        }
        if rows == 0 { Err(self.no_rows(path)) } else { Ok((columns, problems)) }
    }

    /// The same for text without quotes; `None` if it has some.
    fn found_plain(
        &self,
        (path, names): (&Path, &[String]),
        source: Source<'_>,
        wanted: Wanted<'_>,
    ) -> Result<Option<Found>, Error> {
        let Wanted { numbers, text, row } = wanted;
        let Layout { separator, decimal_comma, comment, .. } = self.layout;
        let problems = Mutex::new(BTreeMap::new());
        let number = |place: usize, line: u64, cell: &str| {
            self.number(place, cell).unwrap_or_else(|problem| {
                let mut problems = problems.lock().unwrap_or_else(PoisonError::into_inner);
                let first = problems.entry(place).or_insert_with(|| (line, problem.clone()));
                if line < first.0 {
                    *first = (line, problem);
                }
                f64::NAN
            })
        };
        let quick = |place: usize| self.layout.clocks.iter().all(|(clock, _)| *clock != place);
        let (point, cells) = (if decimal_comma { b',' } else { b'.' }, names.len());
        let ends_early = self.layout.rates.is_some();
        let form =
            Form { separator, point, comment, cells, ends_early, numbers, quick: &quick, text, row, number: &number };
        let rows = plain::rows(source, self.layout.first as u64, &form).map_err(|failure| match failure {
            Failure::File(error) => Error::io(path)(error),
            Failure::Cells(line, count) => ragged(path, line, count, names.len()),
        })?;
        let Some(rows) = rows else { return Ok(None) };
        if rows.count == 0 {
            return Err(self.no_rows(path));
        }
        let columns = Columns { numbers: rows.numbers, texts: text.map(|_| rows.texts), lines: rows.lines };
        Ok(Some((columns, problems.into_inner().unwrap_or_else(PoisonError::into_inner))))
    }

    /// The number in a cell of a column.
    fn number(&self, place: usize, cell: &str) -> Result<f64, String> {
        let cell = if self.layout.row_ends { without_end(cell) } else { cell };
        if let Some((_, clock)) = self.layout.clocks.iter().find(|(own, _)| *own == place) {
            return match clock.seconds(cell, self.layout.decimal_comma) {
                Some(seconds) => Ok(seconds),
                None if is_missing(cell) => Ok(f64::NAN),
                None if self.layout.header.get(place).is_some_and(|name| name == cell) => Err(no_number(cell)),
                None => Err(format!("\"{cell}\" is no time as in the rows before")),
            };
        }
        match self.layout.number(cell) {
            Some(value) if value.abs() <= LARGEST => Ok(value),
            Some(value) if value.is_finite() => Err(too_large(cell)),
            Some(_) => Ok(f64::NAN),
            None if is_missing(cell) => Ok(f64::NAN),
            None => Err(no_number(cell)),
        }
    }

    fn no_rows(&self, path: &Path) -> Error {
        let place = format!("line {}", self.layout.first + 1);
        Error::content(path, place, "no rows after the header; record the trace again")
    }
}

impl Content {
    /// The text, or its first lines.
    fn head(&self) -> &str {
        let (Self::Whole(text) | Self::Large(text, _)) = self;
        text
    }
}

/// What is read of a file before its rows.
enum Start {
    /// The first lines of a file that is large and not packed, if they have the layout, and its size.
    Large(String, u64),
    /// All bytes.
    Whole(Vec<u8>),
}

/// The start of a file.
fn start(path: &Path, form: &TextForm) -> Result<Start, Error> {
    let mut file = File::open(path).map_err(Error::io(path))?;
    let about = file.metadata().map_err(Error::io(path))?;
    let mut head = Vec::new();
    file.by_ref().take(HEAD).read_to_end(&mut head).map_err(Error::io(path))?;
    if head.starts_with(b"PK\x03\x04") {
        return Err(Error::content(path, "content", "a ZIP archive; unpack it, and save sheets as CSV"));
    }
    let json = ["{\"", "[{", "[[", "{ \"", "{\n"];
    if std::str::from_utf8(head.trim_ascii_start()).is_ok_and(|text| json.iter().any(|start| text.starts_with(start))) {
        return Err(Error::content(path, "content", "JSON; write its records as CSV, a column each, or as Parquet"));
    }
    if is_binary(&head) {
        return Err(Error::content(path, "content", "no text; save the recording as CSV, MATLAB or Parquet"));
    }
    if !about.is_file() {
        return Ok(Start::Whole(limit::whole(path)?));
    }
    if about.len() < LARGE {
        // The bytes that are there are not read again.
        file.read_to_end(&mut head).map_err(Error::io(path))?;
        return Ok(Start::Whole(head));
    }
    let lines = head.iter().rposition(|byte| *byte == b'\n').map_or(0, |feed| feed + 1);
    head.truncate(lines);
    // Packed bytes are no UTF-8.
    match String::from_utf8(head).ok().filter(|head| Layout::is_settled_by(head, form)) {
        Some(head) => Ok(Start::Large(head, about.len())),
        None => Ok(Start::Whole(limit::whole(path)?)),
    }
}

/// Whether bytes are neither text nor packed: one in thirty is a control character that no text has.
fn is_binary(head: &[u8]) -> bool {
    let packed = head.starts_with(&[0x1F, 0x8B]) || head.starts_with(&[0x28, 0xB5, 0x2F, 0xFD]);
    let marked = head.starts_with(&[0xFF, 0xFE]) || head.starts_with(&[0xFE, 0xFF]);
    let zeros = head.iter().filter(|byte| **byte == 0).count();
    let is_wide = zeros * 5 > head.len() * 2 && zeros * 2 <= head.len() + 1;
    let control = |byte: &&u8| matches!(**byte, 0..=8 | 14..=26 | 28..=31);
    !packed && !marked && !is_wide && head.iter().filter(control).count() * 30 > head.len()
}

/// The bytes of a file as text, unpacked, and the name of its encoding if that is guessed.
fn decoded(path: &Path, packed: Vec<u8>) -> Result<(String, Option<&'static str>), Error> {
    let compressed = |problem| Error::content(path, "content", format!("cannot be unpacked: {problem}"));
    let bytes = encoding::unpacked(&packed).map_err(compressed)?.unwrap_or(packed);
    Ok(encoding::text(bytes))
}

fn ragged(path: &Path, line: u64, cells: usize, columns: usize) -> Error {
    let problem = format!(
        "{cells} cells where the header has {columns}; complete the row or remove it; \
         --skip tells how many lines are before the header, --separator what separates cells"
    );
    Error::content(path, format!("line {line}"), problem)
}

/// Why a cell is not taken.
fn no_number(cell: &str) -> String {
    if is_complex(cell) {
        return format!("\"{cell}\" is a complex number; write real and imaginary part as two columns");
    }
    let thousands =
        cell.contains([',', '.']) && cell.chars().all(|c| c.is_ascii_digit() || matches!(c, ',' | '.' | '-'));
    let why = if thousands { "; --decimal point or comma tells which mark separates thousands" } else { "" };
    format!("\"{cell}\" is not a number{why}")
}
