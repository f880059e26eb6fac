//! How a text file separates cells, which lines are comments, and where its header is.
//!
//! The separator is the one by which the first lines have as many cells as the header, more than one: semicolon, tab,
//! bar, comma or blanks, tried in this order, since with decimal commas a comma separates the same number of cells in
//! each line too.

/// Lines that are looked at.
const LINES: usize = 12;

/// The layout of a text file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Layout {
    /// Separator; a blank stands for any number of blanks and tabs.
    pub(super) separator: u8,
    pub(super) decimal_comma: bool,
    /// The first character of lines that are skipped.
    pub(super) comment: Option<u8>,
    /// Where the header is.
    pub(super) header: Header,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Header {
    /// The first line that is no comment.
    First,
    /// The last comment before the first line.
    Comment(String),
    /// None: columns are called c1, c2 and so on.
    None,
}

impl Layout {
    /// Finds the layout of a text.
    pub(super) fn of(text: &str) -> Self {
        let comment = text.lines().find(|line| !line.trim().is_empty()).and_then(|line| {
            let first = line.trim_start_matches('\u{feff}').bytes().next()?;
            matches!(first, b'#' | b'%').then_some(first)
        });
        let is_comment = |line: &&str| comment.is_some_and(|mark| line.as_bytes().first() == Some(&mark));
        let lines = || text.lines().map(|line| line.trim_start_matches('\u{feff}'));
        let comments: Vec<&str> = lines().take_while(|line| is_comment(line) || line.trim().is_empty()).collect();
        let content = lines().filter(|line| !is_comment(line) && !line.trim().is_empty());
        let content: Vec<&str> = content.take(LINES).collect();
        let separator = separator(&content);
        let first_data = content.get(1).or(content.first()).copied().unwrap_or("");
        let decimal_comma = separator != b',' && has_decimal_commas(first_data, separator);
        let header = header(&content, &comments, (separator, decimal_comma));
        Self { separator, decimal_comma, comment, header }
    }

    /// Whether a text has all lines that are looked at.
    pub(super) fn is_settled_by(head: &str) -> bool {
        head.lines().filter(|line| !line.trim().is_empty() && !line.starts_with(['#', '%'])).count() > LINES
    }

    /// The number in a cell.
    pub(super) fn number(&self, cell: &str) -> Option<f64> {
        if self.decimal_comma { cell.replacen(',', ".", 1).parse().ok() } else { cell.parse().ok() }
    }
}

/// Number of cells of a line, separators in quotes left out.
fn cells(line: &str, separator: u8) -> usize {
    if separator == b' ' {
        return line.split_ascii_whitespace().count();
    }
    let mut quoted = false;
    let separators = line.bytes().filter(|byte| {
        quoted ^= *byte == b'"';
        !quoted && *byte == separator
    });
    1 + separators.count()
}

fn separator(content: &[&str]) -> u8 {
    let Some((first, rest)) = content.split_first() else { return b',' };
    let fits = |separator: &u8| {
        let own = cells(first, *separator);
        own > 1 && rest.iter().all(|line| cells(line, *separator) == own)
    };
    let most = |separators: &[u8]| separators.iter().copied().max_by_key(|separator| cells(first, *separator));
    let known = [b';', b'\t', b'|', b',', b' '];
    // Of lines that differ, the header decides; a single column has none.
    known.into_iter().find(fits).or_else(|| most(b"|\t;,").filter(|found| cells(first, *found) > 1)).unwrap_or(b',')
}

/// The cells of a line.
fn split(line: &str, separator: u8) -> Vec<&str> {
    if separator == b' ' {
        return line.split_ascii_whitespace().collect();
    }
    line.split(char::from(separator)).map(|cell| cell.trim().trim_matches('"')).collect()
}

/// Whether a line has cells such as −1,5 and none such as −1.5.
fn has_decimal_commas(line: &str, separator: u8) -> bool {
    let parts = |cell: &&str, mark: char| {
        let digits = |part: &str| part.bytes().any(|byte| byte.is_ascii_digit());
        cell.split_once(mark).is_some_and(|(whole, part)| digits(whole) && digits(part))
    };
    let cells = split(line, separator);
    cells.iter().any(|cell| parts(cell, ',')) && !cells.iter().any(|cell| parts(cell, '.'))
}

fn header(content: &[&str], comments: &[&str], (separator, decimal_comma): (u8, bool)) -> Header {
    let Some(first) = content.first() else { return Header::First };
    let number = |cell: &&str| {
        let cell = if decimal_comma { cell.replacen(',', ".", 1) } else { (*cell).to_string() };
        cell.parse::<f64>().is_ok()
    };
    let own = split(first, separator);
    if !own.iter().all(number) {
        return Header::First;
    }
    let names =
        comments.iter().rev().map(|line| line.trim_start_matches(['#', '%']).trim()).find(|line| !line.is_empty());
    match names {
        Some(names) if split(names, separator).len() == own.len() => Header::Comment(names.to_string()),
        _ => Header::None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layout(text: &str) -> (char, bool, Header) {
        let Layout { separator, decimal_comma, header, .. } = Layout::of(text);
        (char::from(separator), decimal_comma, header)
    }

    #[test]
    fn separators_and_decimal_commas_are_told_apart() {
        assert_eq!(layout("t,i\n0.1,2.5\n"), (',', false, Header::First));
        assert_eq!(layout("t;i\n0,1;2,5\n0,2;1\n"), (';', true, Header::First));
        assert_eq!(layout("t;i\n0.1;2.5\n"), (';', false, Header::First));
        assert_eq!(layout("t\ti\n0,1\t2,5\n"), ('\t', true, Header::First));
        assert_eq!(layout("t  i\n0.1   2.5\n"), (' ', false, Header::First));
        assert_eq!(layout("\"a;b\",i\n1,2\n"), (',', false, Header::First));
        assert_eq!(layout("only\n1.5\n"), (',', false, Header::First));
        assert_eq!(layout(""), (',', false, Header::First));
        // A short row leaves the separator of the header.
        assert_eq!(layout("a,b,c\n1,2\n"), (',', false, Header::First));
    }

    #[test]
    fn headers_are_lines_comments_or_missing() {
        assert_eq!(layout("# logger 3\n# t, i\n0.1,2\n0.2,3\n"), (',', false, Header::Comment("t, i".into())));
        assert_eq!(layout("% logger 3\nt,i\n0.1,2\n"), (',', false, Header::First));
        assert_eq!(layout("# logger 3\n0.1 2 7\n0.2 3 8\n"), (' ', false, Header::None));
        assert_eq!(layout("1,2\n3,4\n"), (',', false, Header::None));
    }
}
