//! Columns of a table: which are wanted, what is read, and which of their numbers are taken.

use super::lines::Lines;

/// No sensor measures larger values in any unit; their squares and products would overflow single precision.
pub const LARGEST: f64 = 1e15;

/// Columns of numbers, in the order in which they were asked for, and the cells of a column of text.
#[derive(Debug, Default)]
pub struct Columns {
    /// Columns of numbers, of one length.
    pub numbers: Vec<Vec<f64>>,
    /// The cells of the column of text, if one was asked for, in the rows that were wanted.
    pub texts: Option<Vec<String>>,
    /// Line of each row; empty if rows have no lines.
    pub(super) lines: Lines,
}

/// What is read of a file.
#[derive(Clone, Copy)]
#[expect(missing_debug_implementations, reason = "functions have none")]
pub struct Wanted<'a> {
    /// Places of columns of numbers.
    pub numbers: &'a [usize],
    /// Place of a column of text, by whose cells rows are chosen.
    pub text: Option<usize>,
    /// Whether rows with this cell are read.
    pub row: &'a (dyn Fn(&str) -> bool + Sync),
}

impl Columns {
    /// Where a row is, for messages.
    #[must_use]
    pub fn place(&self, row: usize) -> String {
        self.lines.of(row).map_or_else(|| format!("row {}", row + 1), |line| format!("line {line}"))
    }
}

/// The first row whose number is not taken.
pub(super) fn first_unusable(column: &[f64]) -> Option<usize> {
    const MANY: usize = 1024;
    let is_good = |value: &f64| value.abs() <= LARGEST;
    // Without an exit before the end of many values the compiler compares several at once.
    let is_any_bad = |values: &[f64]| !values.iter().fold(true, |good, value| good & is_good(value));
    let many = column.chunks(MANY).position(is_any_bad)?;
    let rest = &column[many * MANY..];
    Some(many * MANY + rest.iter().position(|value| !is_good(value))?)
}

/// Why a number is not taken.
pub(super) fn unusable(value: f64, cell: &str) -> String {
    if value.is_finite() {
        format!("{cell} is no measured value; repair the sample")
    } else {
        format!("{cell} is not a finite number; cut the trace there or repair the sample")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_unusable_value_is_found_anywhere() {
        for (rows, bad) in [(1, 0), (1023, 1022), (1024, 1023), (1025, 1024), (5000, 3000)] {
            let mut column = vec![-LARGEST; rows];
            assert_eq!(first_unusable(&column), None);
            column[rows - 1] = f64::NAN;
            for value in [f64::NAN, f64::NEG_INFINITY, 1.001 * LARGEST] {
                column[bad] = value;
                assert_eq!(first_unusable(&column), Some(bad), "{rows} {value}");
            }
        }
        assert_eq!(first_unusable(&[]), None);
    }
}
