//! Text files: a header, and one row a line.

use std::borrow::Cow;
use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use crate::table::columns::{Columns, LARGEST, Wanted, is_missing, too_large};
use crate::table::layout::{Header, Layout};
use crate::table::limit;
use crate::table::lines::Lines;
use crate::table::plain::{self, Failure, Form, Refusal};
use crate::table::source::Source;
use crate::table::unpack::unpacked;
use model::Error;
use model::outputs::text_of;

/// Bytes of a file from which it is read in pieces, and of its start, which has the layout.
const LARGE: u64 = 4 << 20;
const HEAD: u64 = 64 << 10;

/// A text file and its layout.
#[derive(Debug)]
pub(super) struct Text {
    content: Content,
    layout: Layout,
}

#[derive(Debug)]
enum Content {
    Whole(String),
    /// The first lines of a large file, and its size in bytes.
    Large(String, u64),
}

impl Text {
    pub(super) fn open(path: &Path) -> Result<Self, Error> {
        let content = match large(path).map_err(Error::io(path))? {
            Some((head, bytes)) => Content::Large(head, bytes),
            None => Content::Whole(whole(path)?),
        };
        let layout = Layout::of(content.head());
        Ok(Self { content, layout })
    }

    /// Names of the columns.
    pub(super) fn names(&self, path: &Path) -> Result<Vec<String>, Error> {
        let clean = |name: &str| text_of(name.trim().trim_start_matches('\u{feff}')).to_string();
        let first = |line: &str| -> Result<Vec<String>, Error> {
            let mut reader = self.reader(line);
            let mut record = csv::StringRecord::new();
            reader.read_record(&mut record).map_err(|error| csv_error(path, &error))?;
            Ok(record.iter().map(clean).collect())
        };
        match &self.layout.header {
            Header::Comment(line) => first(line),
            Header::First => first(self.content.head()),
            Header::None => Ok((1..=first(self.content.head())?.len()).map(|k| format!("c{k}")).collect()),
        }
    }

    fn reader<'a>(&self, text: &'a str) -> csv::Reader<Blanks<'a>> {
        let mut builder = csv::ReaderBuilder::new();
        builder.flexible(true).has_headers(false).comment(self.layout.comment);
        builder.delimiter(if self.layout.separator == b' ' { b',' } else { self.layout.separator });
        builder.from_reader(Blanks { rest: text.as_bytes(), squeeze: self.layout.separator == b' ', inside: false })
    }

    pub(super) fn read(&self, (path, names): (&Path, &[String]), wanted: Wanted<'_>) -> Result<Columns, Error> {
        let is_twice = |k: usize| wanted.numbers[..k].contains(&wanted.numbers[k]);
        let spaced = self.layout.separator == b' ';
        let (header, first) = self.header();
        if !spaced && plain::plain(header.as_bytes()).is_some() && !(0..wanted.numbers.len()).any(is_twice) {
            let source = match &self.content {
                Content::Whole(text) => Source::Memory(&text[header.len()..]),
                Content::Large(_, end) => Source::File { path, start: header.len() as u64, end: *end },
            };
            if let Some(columns) = self.read_plain((path, names), (source, first), wanted)? {
                return Ok(columns);
            }
        }
        let text = match &self.content {
            Content::Whole(text) => Cow::Borrowed(text),
            Content::Large(..) => Cow::Owned(whole(path)?),
        };
        let mut reader = self.reader(&text);
        let mut record = csv::StringRecord::new();
        let mut read =
            |record: &mut csv::StringRecord| reader.read_record(record).map_err(|error| csv_error(path, &error));
        if self.layout.header == Header::First {
            read(&mut record)?;
        }
        let mut columns = Columns {
            numbers: vec![Vec::new(); wanted.numbers.len()],
            texts: wanted.text.map(|_| Vec::new()),
            lines: Lines::default(),
        };
        let mut rows = 0;
        while read(&mut record)? {
            let line = record.position().map_or(0, csv::Position::line);
            rows += 1;
            if record.len() != names.len() {
                return Err(ragged(path, line, record.len(), names.len()));
            }
            if let Some(place) = wanted.text {
                let text = record[place].trim();
                if !(wanted.row)(text) {
                    continue;
                }
                columns.texts.get_or_insert_default().push(text.to_string());
            }
            for (column, place) in columns.numbers.iter_mut().zip(wanted.numbers) {
                let number = self.number(record[*place].trim());
                let wrong = |problem| Error::content(path, format!("line {line}, column {}", names[*place]), problem);
                column.push(number.map_err(wrong)?);
            }
            columns.lines.push(line);
        }
        if rows == 0 { Err(no_rows(path)) } else { Ok(columns) }
    }

    /// The same for text without quotes; `None` if it has some.
    fn read_plain(
        &self,
        (path, names): (&Path, &[String]),
        (source, first): (Source<'_>, u64),
        wanted: Wanted<'_>,
    ) -> Result<Option<Columns>, Error> {
        let Wanted { numbers, text, row } = wanted;
        let Layout { separator, decimal_comma, comment, .. } = self.layout;
        let number = |cell: &str| self.number(cell);
        let (point, cells) = (if decimal_comma { b',' } else { b'.' }, names.len());
        let form = Form { separator, point, comment, cells, numbers, text, row, number: &number };
        let rows = plain::rows(source, first, &form).map_err(|failure| match failure {
            Failure::File(error) => Error::io(path)(error),
            Failure::Row(line, Refusal::Cells(count)) => ragged(path, line, count, names.len()),
            Failure::Row(line, Refusal::Number(place, problem)) => {
                Error::content(path, format!("line {line}, column {}", names[place]), problem)
            }
        })?;
        let Some(rows) = rows else { return Ok(None) };
        if rows.count == 0 {
            return Err(no_rows(path));
        }
        Ok(Some(Columns { numbers: rows.numbers, texts: text.map(|_| rows.texts), lines: rows.lines }))
    }

    /// The text up to the end of the header, and the line of the header; nothing if rows start at once.
    fn header(&self) -> (&str, u64) {
        let text = self.content.head();
        let mut line = 0;
        if self.layout.header != Header::First {
            return ("", line);
        }
        let mut rest = text;
        while !rest.is_empty() {
            let (own, later) = rest.split_once('\n').unwrap_or((rest, ""));
            (rest, line) = (later, line + 1);
            let own = own.strip_suffix('\r').unwrap_or(own);
            let is_comment = self.layout.comment.is_some_and(|mark| own.as_bytes().first() == Some(&mark));
            if !own.is_empty() && !is_comment {
                break;
            }
        }
        (&text[..text.len() - rest.len()], line)
    }

    fn number(&self, cell: &str) -> Result<f64, String> {
        match self.layout.number(cell) {
            Some(value) if value.abs() <= LARGEST => Ok(value),
            Some(value) if value.is_finite() => Err(too_large(cell)),
            Some(_) => Ok(f64::NAN),
            None if is_missing(cell) => Ok(f64::NAN),
            None => Err(format!("\"{cell}\" is not a number")),
        }
    }
}

impl Content {
    /// The text, or its first lines.
    fn head(&self) -> &str {
        let (Self::Whole(text) | Self::Large(text, _)) = self;
        text
    }
}

/// The first lines of a file and its size, if it is large and not packed, and these lines have the layout.
fn large(path: &Path) -> std::io::Result<Option<(String, u64)>> {
    let file = File::open(path)?;
    let about = file.metadata()?;
    if !about.is_file() || about.len() < LARGE {
        return Ok(None);
    }
    let mut head = Vec::new();
    file.take(HEAD).read_to_end(&mut head)?;
    let lines = head.iter().rposition(|byte| *byte == b'\n').map_or(0, |feed| feed + 1);
    head.truncate(lines);
    // Packed bytes are no UTF-8.
    Ok(String::from_utf8(head).ok().filter(|head| Layout::is_settled_by(head)).map(|head| (head, about.len())))
}

/// All of a file as text, unpacked.
fn whole(path: &Path) -> Result<String, Error> {
    let packed = limit::whole(path)?;
    let compressed = |problem| Error::content(path, "content", format!("cannot be unpacked: {problem}"));
    let bytes = unpacked(&packed).map_err(compressed)?.unwrap_or(packed);
    String::from_utf8(bytes).map_err(|error| {
        let valid = error.utf8_error().valid_up_to();
        let line = error.as_bytes()[..valid].iter().filter(|byte| **byte == b'\n').count() + 1;
        Error::content(path, format!("line {line}"), "the text is not UTF-8; save it as UTF-8")
    })
}

fn ragged(path: &Path, line: u64, cells: usize, columns: usize) -> Error {
    let problem = format!("{cells} cells where the header has {columns}; complete the row or remove it");
    Error::content(path, format!("line {line}"), problem)
}

fn no_rows(path: &Path) -> Error {
    Error::content(path, "line 2", "no rows after the header; record the trace again")
}

/// Text whose blanks between cells become commas.
struct Blanks<'a> {
    rest: &'a [u8],
    squeeze: bool,
    /// Whether a cell of this line has begun.
    inside: bool,
}

impl std::io::Read for Blanks<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        if !self.squeeze {
            return self.rest.read(buffer);
        }
        let mut written = 0;
        while let ([first, rest @ ..], Some(cell)) = (self.rest, buffer.get_mut(written)) {
            self.rest = rest;
            match first {
                b' ' | b'\t' => {
                    // Blanks at the ends of a line separate nothing.
                    let next = rest.first().copied().unwrap_or(b'\n');
                    if !self.inside || matches!(next, b' ' | b'\t' | b'\r' | b'\n') {
                        continue;
                    }
                    *cell = b',';
                }
                other => {
                    self.inside = *other != b'\n';
                    *cell = *other;
                }
            }
            written += 1;
        }
        Ok(written)
    }
}

/// Returns the error of a text file, with its line.
#[must_use]
pub fn csv_error(path: &Path, error: &csv::Error) -> Error {
    let line = error.position().map_or_else(|| "content".into(), |p| format!("line {}", p.line()));
    let problem = match error.kind() {
        csv::ErrorKind::Utf8 { .. } => "the text is not UTF-8".into(),
        csv::ErrorKind::Io(io) => io.to_string(),
        _ => error.to_string(),
    };
    Error::content(path, line, format!("not readable as CSV: {problem}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::Table;

    fn table(name: &str, content: &[u8]) -> Result<(Vec<String>, Columns), String> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join(name);
        std::fs::write(&path, content).expect("writable");
        let table = Table::open(&path).map_err(|error| error.to_string())?;
        let numbers: Vec<usize> = (0..table.names().len()).collect();
        let wanted = Wanted { numbers: &numbers, text: None, row: &|_| true };
        let columns = table.read(wanted).map_err(|error| error.to_string())?;
        Ok((table.names().to_vec(), columns))
    }

    #[test]
    fn the_same_numbers_in_every_layout() {
        let layouts = [
            ("a.csv", "t,i\n0.5,-1\n1.5,2e-3\n"),
            ("a.csv", "\u{feff}t;i\r\n0,5;-1\r\n1,5;2e-3\r\n"),
            ("a.tsv", "t\ti\n0.5\t-1\n1.5\t0.002\n"),
            ("a.txt", "  t   i \n 0.5  -1\n1.5 \t 0.002  \n"),
            ("a.dat", "# logger\n# t i\n0.5 -1\n1.5 0.002\n"),
            ("a.csv", "% logger\nt|i\n0.5|-1\n\n% gap\n1.5|0.002\n"),
        ];
        for (name, text) in layouts {
            let (names, columns) = table(name, text.as_bytes()).expect(text);
            assert_eq!(names, ["t", "i"], "{text}");
            assert_eq!(columns.numbers, [vec![0.5, 1.5], vec![-1.0, 0.002]], "{text}");
        }
        let (names, columns) = table("a.csv", b"1,2\n3,4\n").expect("without a header");
        assert_eq!((names, columns.numbers[0].len()), (vec!["c1".to_string(), "c2".into()], 2));
    }

    /// A large file is read in pieces, and as one text if it has to be; the numbers and messages are the same.
    #[test]
    fn large_files_are_read_like_small_ones() {
        let rows: String = (0..400_000).map(|k| format!("{k},{}.25\n", k % 97)).collect();
        assert!(rows.len() as u64 > LARGE);
        for (head, count) in [("# a logger\nt,i\n", 400_000), ("t,i\n1,\"2\"\n", 400_001)] {
            let (names, columns) = table("a.csv", format!("{head}{rows}").as_bytes()).expect("good");
            assert_eq!((names, columns.numbers[0].len()), (vec!["t".to_string(), "i".into()], count));
            assert_eq!((columns.numbers[0][count - 1], columns.numbers[1][count - 1]), (399_999.0, 68.25));
            assert_eq!(columns.lines.of(count - 1), Some(400_002));
            let wrong = format!("{head}{rows}1,2\n3,x\n");
            let message = table("a.csv", wrong.as_bytes()).expect_err("a word");
            assert!(message.contains("line 400004, column i: \"x\" is not a number"), "{message}");
        }
        let mut bytes = format!("t,i\n{rows}").into_bytes();
        bytes[5_000_000] = 0xb0;
        assert!(table("a.csv", &bytes).expect_err("Latin-1").contains("the text is not UTF-8"));
    }

    #[test]
    fn compressed_text_is_unpacked_and_broken_text_refused() {
        use std::io::Write as _;
        let text = b"t,i\n0.5,-1\n";
        let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        gzip.write_all(text).expect("in memory");
        let packed = gzip.finish().expect("in memory");
        assert_eq!(table("a.csv.gz", &packed).expect("gzip").1.numbers[1], [-1.0]);
        let zst = zstd::encode_all(&text[..], 1).expect("in memory");
        assert_eq!(table("a.csv.zst", &zst).expect("zstd").1.numbers[0], [0.5]);
        assert!(table("a.csv.gz", &packed[..packed.len() - 9]).expect_err("cut").contains("cannot be unpacked"));
        assert!(table("a.csv", b"t,\xb0C\n1,2\n").expect_err("Latin-1").contains("line 1: the text is not UTF-8"));
        let wrong = table("a.csv", b"# note\nt;i\n0,5;1\n0,6;x\n").expect_err("a word");
        assert!(wrong.contains("line 4, column i: \"x\" is not a number"), "{wrong}");
    }
}
