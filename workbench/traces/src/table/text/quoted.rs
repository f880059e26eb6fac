//! Text with quoted cells, or with blanks between cells, by the reader of the crate `csv`.

use std::path::Path;

use crate::table::text::layout::Layout;
use model::Error;

/// The records of a text of this layout.
pub(super) fn reader<'a>(text: &'a str, layout: &Layout) -> csv::Reader<Blanks<'a>> {
    let (squeeze, row_ends) = (layout.separator == b' ', layout.row_ends);
    let mut builder = csv::ReaderBuilder::new();
    builder.flexible(true).has_headers(false).comment(layout.comment);
    builder.delimiter(if squeeze { b',' } else { layout.separator });
    builder.from_reader(Blanks { rest: text.as_bytes(), squeeze, row_ends, inside: false })
}

/// Text whose blanks between cells become commas.
pub(super) struct Blanks<'a> {
    rest: &'a [u8],
    squeeze: bool,
    /// Whether semicolons end the rows.
    row_ends: bool,
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
                    let is_end = self.row_ends && next == b';';
                    if !self.inside || is_end || matches!(next, b' ' | b'\t' | b'\r' | b'\n') {
                        continue;
                    }
                    *cell = b',';
                }
                b';' if self.row_ends => continue,
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
