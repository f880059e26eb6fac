//! The end of a text: lines of words behind the rows, and a row inside which the file ends.
//!
//! ```text
//! 0.5,1            a row
//! 1.5,1            a row
//! (2 rows)         words: left out
//! 2.5,             without the end of a line: left out, as the file was cut
//! ```

use memchr::{memchr_iter, memrchr};

use crate::table::text::cells::{Kind, kind, split};
use crate::table::text::layout::Layout;

/// Lines of words behind the rows from which they are no end.
const TRAILING: usize = 5;

/// How many bytes at the end of a text are no rows, and what is said of them, by its last bytes.
pub(super) fn of(tail: &[u8], layout: &Layout) -> (usize, Vec<(&'static str, String)>) {
    let columns = layout.names.len();
    let (mut end, mut words, mut omitted) = (tail.len(), Vec::new(), Vec::new());
    while columns > 1 && words.len() < TRAILING {
        // The feed before the last line; what is before it stays.
        let body = &tail[..end];
        let line_end = if body.ends_with(b"\n") { end - 1 } else { end };
        let Some(feed) = memrchr(b'\n', &tail[..line_end]) else { break };
        let last = String::from_utf8_lossy(&tail[feed + 1..line_end]).into_owned();
        // The end of a quoted cell of several lines is no line.
        if last.matches('"').count() % 2 == 1 {
            break;
        }
        let cells = split(&last, layout.separator);
        let may_end = layout.rates.is_some();
        let is_cut = end == tail.len() && line_end == end && cells.len() < columns && !may_end;
        let is_words = cells.len() != columns && cells.iter().all(|cell| kind(cell, true) == Kind::Word);
        match last.trim() {
            "" => {}
            own if is_words => words.push(own.to_string()),
            _ if is_cut => {
                let why = format!("the file ends inside it: {} cells of {columns}", cells.len());
                omitted.push(("the last line", why));
            }
            _ => break,
        }
        end = feed + 1;
    }
    // Too many are no end.
    if words.len() == TRAILING {
        return (0, omitted);
    }
    if let Some(first) = words.last() {
        omitted.push(("the end of the file", format!("words behind the rows, from \"{first}\" on")));
    }
    (tail.len() - end, omitted)
}

/// Where the last row begins, if the text ends inside a quoted cell of it.
pub(super) fn open_quote(text: &str) -> Option<usize> {
    let bytes = text.as_bytes();
    let is_open = memchr_iter(b'"', bytes).count() % 2 == 1;
    let quote = memrchr(b'"', bytes).filter(|_| is_open)?;
    let start = memrchr(b'\n', &bytes[..quote])? + 1;
    // A quote far before the end stands for inches.
    (memchr_iter(b'\n', &bytes[start..]).count() <= TRAILING).then_some(start)
}

#[cfg(test)]
mod tests {
    use model::trace::TextForm;

    use super::*;

    fn kept(text: &str) -> (String, usize) {
        let (cut, omitted) = of(text.as_bytes(), &Layout::of(text, &TextForm::default()));
        (text[..text.len() - cut].to_string(), omitted.len())
    }

    #[test]
    fn words_and_a_cut_row_are_no_rows() {
        let rows = "t,i\n0.5,1\n1.5,1\n2.5,2\n";
        assert_eq!(kept(rows), (rows.into(), 0));
        assert_eq!(kept(&format!("{rows}(3 rows)\n\n")), (rows.into(), 1));
        assert_eq!(kept(&format!("{rows}3.5")), (rows.into(), 1));
        let quoted = "t,note,i\n0.5,\"a\nb\",1\n1.5,\"a\nb\",2\n";
        assert_eq!(kept(quoted), (quoted.into(), 0));
    }

    #[test]
    fn the_row_of_a_quote_that_stays_open_is_found() {
        let rows = "t,note\n0.5,\"a\nb\"\n";
        assert_eq!(open_quote(rows), None);
        assert_eq!(open_quote(&format!("{rows}1.5,\"a\n")), Some(rows.len()));
        assert_eq!(open_quote(&format!("5\" shaft\n{}", "0.5,1\n".repeat(20))), None);
    }
}
