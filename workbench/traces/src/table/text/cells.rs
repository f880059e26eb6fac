//! Lines and cells of the start of a text, and what a cell may be.

use crate::table::columns::is_missing;
use crate::time::clock::nanoseconds;
use crate::units::Unit;
use model::outputs::text_of;

/// Lines that a quoted name may have.
const LONGEST_NAME: usize = 8;

/// A line, or several with a quoted cell over their ends.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Line<'a> {
    pub(super) text: &'a str,
    /// The lines of the text before it, and behind it.
    pub(super) before: usize,
    pub(super) end: usize,
}

/// The lines of a text that are neither empty, comments nor rules, and those that are comments, up to `most` of both.
pub(super) fn lines(text: &str, comment: Option<u8>, most: usize) -> (Vec<Line<'_>>, Vec<Line<'_>>) {
    let (mut content, mut comments) = (Vec::new(), Vec::new());
    let feeds: Vec<usize> = text.match_indices('\n').map(|(at, _)| at).take(most + LONGEST_NAME).collect();
    let count = feeds.len() + usize::from(!text.ends_with('\n') && feeds.len() < most + LONGEST_NAME);
    let start = |line: usize| line.checked_sub(1).map_or(0, |before| feeds[before] + 1);
    let end = |line: usize| feeds.get(line).copied().unwrap_or(text.len());
    let mut line = 0;
    while line < count.min(most) {
        let is_open = |to: usize| text[start(line)..end(to)].bytes().filter(|byte| *byte == b'"').count() % 2 == 1;
        let last = (line..count.min(line + LONGEST_NAME)).find(|to| !is_open(*to)).unwrap_or(line);
        let own = text[start(line)..end(last)].trim_end_matches('\r').trim_start_matches('\u{feff}');
        let found = Line { text: own, before: line, end: last + 1 };
        if comment.is_some_and(|mark| own.as_bytes().first() == Some(&mark)) {
            comments.push(found);
        } else if !own.trim().is_empty() && !is_rule(own) {
            content.push(found);
        }
        line = last + 1;
    }
    (content, comments)
}

/// Whether a line only separates names and rows: -----+-----, or ---,---.
fn is_rule(line: &str) -> bool {
    ["---", "==="].iter().any(|mark| line.contains(mark)) && !line.contains(char::is_alphanumeric)
}

/// Whether a semicolon ends most lines, and separates nothing in them: 0.1,2.5;
pub(super) fn row_ends(content: &[Line<'_>]) -> bool {
    let is_ended = |line: &&Line<'_>| {
        let text = without_end(line.text);
        // With two cells a comma may be decimal.
        let separates = text.contains(['\t', '|', '.']) || text.matches(',').count() != 1;
        text.len() < line.text.len() && !text.contains(';') && separates
    };
    let ended = content.iter().filter(is_ended).count();
    ended > 1 && 2 * ended > content.len()
}

/// A row without the semicolon that ends it.
pub(super) fn without_end(row: &str) -> &str {
    row.trim_end().strip_suffix(';').map_or(row, str::trim_end)
}

/// The cells of a line, without blanks and quotes around them.
pub(super) fn split(line: &str, separator: u8) -> Vec<&str> {
    if separator == b' ' {
        return blank_separated(line);
    }
    let (mut cells, mut quoted, mut start) = (Vec::new(), false, 0);
    for (at, byte) in line.bytes().enumerate() {
        quoted ^= byte == b'"';
        if byte == separator && !quoted {
            cells.push(&line[start..at]);
            start = at + 1;
        }
    }
    cells.push(&line[start..]);
    cells.into_iter().map(|cell| cell.trim().trim_matches('"').trim()).collect()
}

/// The cells of a line between blanks that are not quoted.
fn blank_separated(line: &str) -> Vec<&str> {
    let mut quoted = false;
    let is_end = |c: char| {
        quoted ^= c == '"';
        !quoted && c.is_ascii_whitespace()
    };
    line.split(is_end).filter(|cell| !cell.is_empty()).map(|cell| cell.trim_matches('"').trim()).collect()
}

/// The number of a cell as computers write it, also with the exponent of Fortran, 1.5D+02.
pub(super) fn plain_number(cell: &str) -> Option<f64> {
    let is_of_fortran =
        || cell.bytes().any(|byte| matches!(byte, b'D' | b'd')) && cell.ends_with(|c: char| c.is_ascii_digit());
    let of_fortran = || is_of_fortran().then(|| cell.replace(['D', 'd'], "e"));
    cell.parse().ok().or_else(|| of_fortran()?.parse().ok())
}

/// The number in a cell in which marks can only separate thousands: 1.015,25 and 1,015.25 have both marks, and
/// 1'015.25 and numbers with narrow blanks have one that is nothing else.
pub(super) fn plainly_grouped(cell: &str, decimal_comma: bool) -> Option<f64> {
    const GROUPS: [char; 5] = ['\'', '’', '\u{a0}', '\u{202f}', '\u{2009}'];
    // Most cells are ASCII, which is searched by bytes.
    let has_groups = if cell.is_ascii() { cell.contains('\'') } else { cell.contains(GROUPS) };
    if has_groups {
        let group = if decimal_comma { "." } else { "," };
        return grouped(&cell.replace(GROUPS, group), decimal_comma);
    }
    let both = cell.contains(',') && cell.contains('.');
    both.then(|| grouped(cell, decimal_comma)).flatten()
}

/// What a cell says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Number,
    Missing,
    Time,
    Word,
}

/// The number of a truth value.
pub(super) fn truth(cell: &str) -> Option<f64> {
    let is = |word: &str| cell.eq_ignore_ascii_case(word);
    if is("true") { Some(1.0) } else { is("false").then_some(0.0) }
}

/// What a cell says, with decimal points or commas.
pub(super) fn kind(cell: &str, commas: bool) -> Kind {
    let is_grouped = |comma: bool| plainly_grouped(cell, comma).is_some();
    if plain_number(cell).is_some_and(f64::is_finite)
        || commas && has_comma(cell)
        || truth(cell).is_some()
        || [false, true].into_iter().any(is_grouped)
    {
        Kind::Number
    } else if is_missing(cell) || cell.parse::<f64>().is_ok() {
        Kind::Missing
    } else if nanoseconds(cell).is_some() {
        Kind::Time
    } else {
        Kind::Word
    }
}

/// Whether a cell is a number with one comma.
fn has_comma(cell: &str) -> bool {
    cell.split_once(',').is_some_and(|(whole, part)| {
        let digits = |text: &str| text.bytes().any(|byte| byte.is_ascii_digit());
        digits(whole) && digits(part) && !whole.contains('.') && cell.replacen(',', ".", 1).parse::<f64>().is_ok()
    })
}

/// Whether a cell can only be a number with a decimal comma: 0,125 or 1,5, not 2,000, which may be two thousand.
pub(super) fn is_decimal_comma(cell: &str) -> bool {
    let one = has_comma(cell)
        && cell.split_once(',').is_some_and(|(whole, part)| {
            let whole = whole.trim_start_matches(['-', '+']);
            whole == "0" || whole.len() > 3 || part.len() != 3 || !part.bytes().all(|byte| byte.is_ascii_digit())
        });
    one || cell.contains(',') && plainly_grouped(cell, true).is_some()
}

/// The same of a decimal point.
pub(super) fn is_decimal_point(cell: &str) -> bool {
    cell.contains('.') && !cell.contains(',') && is_decimal_comma(&cell.replace('.', ","))
}

/// The number in a cell with marks between thousands, such as 12,345.6 or, with a decimal comma, 12.345,6.
pub(super) fn grouped(cell: &str, decimal_comma: bool) -> Option<f64> {
    let (group, point) = if decimal_comma { ('.', ',') } else { (',', '.') };
    let unsigned = cell.trim_start_matches(['-', '+']);
    let (whole, part) = unsigned.split_once(point).unwrap_or((unsigned, ""));
    let digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    let (first, others) = whole.split_once(group)?;
    let fits = !first.is_empty() && first.len() <= 3 && others.split(group).all(|own| own.len() == 3 && digits(own));
    if !fits || !digits(first) || !digits(part) {
        return None;
    }
    cell.replace(group, "").replace(point, ".").parse().ok()
}

/// Where a line begins, by the number of lines before it.
pub(super) fn start_of_line(text: &str, lines: usize) -> usize {
    lines.checked_sub(1).map_or(0, |last| text.match_indices('\n').nth(last).map_or(text.len(), |(at, _)| at + 1))
}

/// Whether the cells of a line count the columns, from 0 or from 1 on.
pub(super) fn are_places(cells: &[&str]) -> bool {
    (0..=1).any(|from| cells.iter().enumerate().all(|(k, cell)| *cell == (k + from).to_string()))
}

/// A name with the unit of another cell; a name may have it already.
pub(in crate::table) fn with_unit(name: &str, unit: &str) -> String {
    let unit_of_cell = Unit::named(unit);
    if unit_of_cell.is_none() || Unit::of_column(name) == unit_of_cell {
        return name.to_string();
    }
    format!("{name} [{unit}]")
}

/// A name in one line.
pub(super) fn clean(name: &str) -> String {
    let one_line: Vec<&str> = name.split_whitespace().collect();
    text_of(one_line.join(" ").trim_start_matches('\u{feff}')).to_string()
}

/// A unit without brackets.
pub(super) fn bare(unit: &str) -> &str {
    unit.trim().trim_start_matches(['[', '(']).trim_end_matches([']', ')']).trim()
}

/// Whether a cell is a complex number such as 3.9+4.1i.
pub(super) fn is_complex(cell: &str) -> bool {
    let Some(rest) = cell.trim_matches(['(', ')']).strip_suffix(['i', 'j']) else { return false };
    let sign = |(at, _): &(usize, &str)| *at > 0 && !rest[..*at].ends_with(['e', 'E']);
    let parts = rest.match_indices(['+', '-']).rfind(sign);
    parts.is_some_and(|(at, _)| {
        rest[..at].trim().parse::<f64>().is_ok() && rest[at..].replace(' ', "").parse::<f64>().is_ok()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_have_quoted_feeds_and_numbers() {
        let (content, comments) = lines("# a\n\"t\n[s]\",i\r\n\n1,2\n3,4", Some(b'#'), 100);
        let texts: Vec<(&str, usize, usize)> = content.iter().map(|line| (line.text, line.before, line.end)).collect();
        assert_eq!(texts, [("\"t\n[s]\",i", 1, 3), ("1,2", 4, 5), ("3,4", 5, 6)]);
        assert_eq!(comments[0].text, "# a");
        assert_eq!(split("\"a;b\" ; c", b';'), ["a;b", "c"]);
        assert_eq!(lines("a|b\n---+---\n1|2\n", None, 100).0.len(), 2);
    }

    #[test]
    fn semicolons_may_end_rows() {
        let ends = |text: &str| row_ends(&lines(text, None, 100).0);
        for text in ["t,i\n0.1,2;\n0.2,3;\n", "t\ti\n0,1\t2,5;\n0,2\t3;\n0,3\t4;\n", "a,b,c;\n1,2,3;\n4,5,6;\n"] {
            assert!(ends(text), "{text}");
        }
        for text in ["t;i;\n0,1;2;\n0,2;3;\n", "t;\n0,1;\n0,2;\n", "t,i\n0.1,2\n0.2,3;\n", "t,i\n0.1,2\n"] {
            assert!(!ends(text), "{text}");
        }
        assert_eq!(["1.5;", "1.5 ;\r", "1.5", "a;b"].map(without_end), ["1.5", "1.5", "1.5", "a;b"]);
    }

    #[test]
    fn cells_are_numbers_times_or_words() {
        for (cell, expected) in [
            ("1.5", Kind::Number),
            ("-1,5", Kind::Number),
            ("1,12E-44", Kind::Number),
            ("nan", Kind::Missing),
            ("", Kind::Missing),
            ("26.10.2022 08:17:00", Kind::Time),
            ("spall", Kind::Word),
            ("TRUE", Kind::Number),
            ("--", Kind::Missing),
            ("1.2.3", Kind::Word),
        ] {
            assert_eq!(kind(cell, true), expected, "{cell}");
        }
        assert_eq!(kind("1,5", false), Kind::Word);
        for (cell, settled) in [("1,5", true), ("0,125", true), ("2,000", false), ("12345,678", true), ("1.5", false)] {
            assert_eq!(is_decimal_comma(cell), settled, "{cell}");
        }
        for (cell, comma, number) in [
            ("2,000", false, Some(2000.0)),
            ("-12,345.5", false, Some(-12_345.5)),
            ("1.234.567,5", true, Some(1_234_567.5)),
            ("1,5", false, None),
            ("1234,567", false, None),
            ("1,2345", false, None),
            ("1.5", false, None),
            (",123", false, None),
        ] {
            assert_eq!(grouped(cell, comma), number, "{cell}");
        }
        for (cell, comma, number) in [
            ("1.015,25", true, Some(1015.25)),
            ("1,015.25", false, Some(1015.25)),
            ("1'015.25", false, Some(1015.25)),
            ("1\u{202f}015,25", true, Some(1015.25)),
            ("1.015", true, None),
            ("1,015", false, None),
        ] {
            assert_eq!(plainly_grouped(cell, comma), number, "{cell}");
        }
        assert_eq!((plain_number("-1.5D+02"), plain_number("D"), plain_number("3D")), (Some(-150.0), None, None));
        assert_eq!(split("\"a b\"  c", b' '), ["a b", "c"]);
        for (cell, complex) in
            [("3.9+4.1i", true), ("5.0286-0.10214i", true), ("1e-3-2e-4j", true), ("3i", false), ("hi", false)]
        {
            assert_eq!(is_complex(cell), complex, "{cell}");
        }
    }
}
