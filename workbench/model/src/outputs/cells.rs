//! Text of files and names in the cells of tables that spreadsheets open.
//!
//! A spreadsheet takes a cell that begins with `=`, `+`, `-`, `@`, a tab or a carriage return for a formula, which can
//! run programs and send data. Such a text gets an apostrophe in front, which spreadsheets do not show; numbers stay.

use std::borrow::Cow;

fn is_formula(text: &str) -> bool {
    text.starts_with(['=', '+', '-', '@', '\t', '\r']) && text.trim().parse::<f64>().is_err()
}

/// A cell that is shown and not computed.
#[must_use]
pub fn cell(text: &str) -> Cow<'_, str> {
    // One that has the apostrophe already gets another one, so that reading gives back the same text.
    let guarded = text.trim_start_matches('\'');
    if is_formula(guarded) { Cow::Owned(format!("'{text}")) } else { Cow::Borrowed(text) }
}

/// The text of a cell that [`cell`] wrote.
#[must_use]
pub fn text_of(cell: &str) -> &str {
    cell.strip_prefix('\'').filter(|text| is_formula(text.trim_start_matches('\''))).unwrap_or(cell)
}

/// A number with at most so many digits behind the point.
#[must_use]
pub fn trimmed(number: f64, decimals: usize) -> String {
    let text = format!("{number:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_end_with_no_zero_behind_the_point() {
        let of = |number, decimals| trimmed(number, decimals);
        assert_eq!([of(39.04, 2), of(10.0, 2), of(120.0, 0), of(0.5, 6)], ["39.04", "10", "120", "0.5"]);
    }

    #[test]
    fn formulas_become_text_and_come_back() {
        for formula in
            ["=1+1", "+cmd", "-cmd|' /C calc'!A0", "@SUM(A1)", "\t=1", "\r=1", "'=1", "--1", "-", "=", "-1-1"]
        {
            assert_eq!(cell(formula), format!("'{formula}"));
            assert_eq!(text_of(&cell(formula)), formula);
        }
        for plain in ["-1.5", "+2e3", "-inf", "a=b", "", "'quoted'", "spall", "1-2", "NaN"] {
            assert_eq!((cell(plain), text_of(plain)), (Cow::Borrowed(plain), plain));
        }
    }
}
