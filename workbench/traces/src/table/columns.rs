//! Columns of a table: which are wanted, what is read, on which lines, which of their numbers are taken, and what the
//! table says beside them.

/// No sensor measures larger values in any unit; their squares and products would overflow single precision.
pub const LARGEST: f64 = 1e15;

/// Columns of numbers, in the order in which they were asked for, and the cells of a column of text.
#[derive(Debug, Default)]
pub struct Columns {
    /// Columns of numbers, of one length; NaN where a value is missing.
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

/// Why a column is not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unusable {
    /// The number in this row is larger than any measured value.
    Large(usize),
    /// No row has a number.
    Empty,
}

/// Makes NaN, a missing value, of what is no finite number.
pub(super) fn settle(column: &mut [f64]) -> Result<(), Unusable> {
    const MANY: usize = 1024;
    let is_good = |value: &f64| value.abs() <= LARGEST;
    // Without an exit before the end of many values the compiler compares several at once.
    let is_any_bad = |values: &[f64]| !values.iter().fold(true, |good, value| good & is_good(value));
    if !column.chunks(MANY).any(is_any_bad) {
        return Ok(());
    }
    if let Some(row) = column.iter().position(|value| value.is_finite() && !is_good(value)) {
        return Err(Unusable::Large(row));
    }
    column.iter_mut().filter(|value| !value.is_finite()).for_each(|value| *value = f64::NAN);
    if column.iter().any(|value| value.is_finite()) { Ok(()) } else { Err(Unusable::Empty) }
}

/// Why a number is not taken.
pub(super) fn too_large(cell: &str) -> String {
    const LONGEST: usize = 24;
    // Memory that was never written may have hundreds of digits.
    let end = if cell.is_ascii() && cell.len() > LONGEST { LONGEST / 2 } else { cell.len() };
    let cell =
        if end < cell.len() { format!("{}… ({} characters)", &cell[..end], cell.len()) } else { cell.to_string() };
    format!("{cell} is no measured value; repair the sample, or write nan for a missing one")
}

/// Why a column is not taken in which nothing is a number.
pub(super) const NO_NUMBER: &str = "no number in any row; leave the column out, or record it again";

/// Whether a cell says that there is no value, in the words of loggers and spreadsheets.
pub(super) fn is_missing(cell: &str) -> bool {
    const WORDS: [&str; 20] = [
        "", "na", "<na>", "n/a", "#n/a", "null", "none", "nil", "nat", "#num!", "#div/0!", "#value!", "-", "--", "---",
        "\\n", "#nv", "#wert!", "∞", "-∞",
    ];
    // 1.#QNAN, -1.#IND and 1.#INF are those of older C libraries.
    WORDS.iter().any(|word| cell.eq_ignore_ascii_case(word)) || cell.trim_start_matches('-').starts_with("1.#")
}

/// Lines of rows.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Lines {
    /// First row of a run, and its line.
    runs: Vec<(usize, u64)>,
    rows: usize,
}

impl Lines {
    /// Adds the line of the next row.
    pub(super) fn push(&mut self, line: u64) {
        let follows = |(first, own): &(usize, u64)| *own + (self.rows - first) as u64 == line;
        if !self.runs.last().is_some_and(follows) {
            self.runs.push((self.rows, line));
        }
        self.rows += 1;
    }

    /// Adds the lines of later rows.
    pub(super) fn append(&mut self, later: &Self) {
        self.runs.extend(later.runs.iter().map(|(row, line)| (self.rows + row, *line)));
        self.rows += later.rows;
    }

    /// Number of rows.
    pub(super) fn rows(&self) -> usize {
        self.rows
    }

    /// The line of a row.
    pub(super) fn of(&self, row: usize) -> Option<u64> {
        let run = self.runs.partition_point(|(first, _)| *first <= row).checked_sub(1)?;
        let (first, line) = self.runs[run];
        (row < self.rows).then(|| line + (row - first) as u64)
    }
}

/// What was left out of a file, and why.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Omitted {
    /// Line, column or array.
    pub place: String,
    /// Why, and what to do about it.
    pub reason: String,
}

/// Columns that are times, and what was left out or guessed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct About {
    /// Places of columns whose numbers are seconds from the first row, whatever their names say.
    pub clocks: Vec<usize>,
    /// Seconds of a step of the integers that some of them are.
    pub ticks_s: Vec<(usize, f64)>,
    /// Places of columns that have the name of a time and count rows.
    pub counters: Vec<usize>,
    /// Places of columns that repeat the time for another channel.
    pub twins: Vec<usize>,
    /// A column with the part of a second that the time lacks: its place, and the seconds of its unit.
    pub fraction: Option<(usize, f64)>,
    /// A channel that has other times: its place, and the line where they differ first.
    pub other_times: Option<(usize, u64)>,
    /// Seconds from row to row, if the file tells them and has no column of times.
    pub step_s: Option<f64>,
    /// What was left out.
    pub omitted: Vec<Omitted>,
    /// What was guessed, a sentence each.
    pub notes: Vec<String>,
}

impl About {
    /// What was left out or guessed, a sentence each.
    pub fn told(&self) -> impl Iterator<Item = String> + '_ {
        let omitted = self.omitted.iter().map(|Omitted { place, reason }| format!("{place}: left out: {reason}"));
        omitted.chain(self.notes.iter().cloned())
    }

    /// Adds what was left out.
    pub fn omit(&mut self, place: impl Into<String>, reason: impl Into<String>) {
        self.omitted.push(Omitted { place: place.into(), reason: reason.into() });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_that_are_not_finite_are_missing_and_large_ones_are_found_anywhere() {
        for (rows, bad) in [(2, 0), (1023, 1022), (1024, 1023), (1025, 1024), (5000, 3000)] {
            let good = vec![-LARGEST; rows];
            assert_eq!((settle(&mut good.clone()), settle(&mut vec![f64::NAN; rows])), (Ok(()), Err(Unusable::Empty)));
            for value in [f64::NAN, f64::NEG_INFINITY, f64::INFINITY] {
                let mut column = good.clone();
                column[bad] = value;
                assert_eq!(settle(&mut column), Ok(()));
                let missing: Vec<usize> = (0..rows).filter(|row| column[*row].is_nan()).collect();
                assert_eq!(missing, [bad], "{rows} {value}");
                column[rows - 1 - bad] = 1.001 * LARGEST;
                assert_eq!(settle(&mut column), Err(Unusable::Large(rows - 1 - bad)));
            }
        }
        assert_eq!(settle(&mut []), Ok(()));
    }

    #[test]
    fn words_for_a_missing_value_are_known() {
        for cell in ["", "NA", "n/a", "#N/A", "NULL", "None", "<NA>", "#DIV/0!", "1.#QNAN", "-1.#IND", "-", "\\N"] {
            assert!(is_missing(cell), "{cell}");
        }
        for cell in ["x", "0", "start", "missing", "12:30", "nanometre", "1.2.3"] {
            assert!(!is_missing(cell), "{cell}");
        }
    }

    #[test]
    fn lines_of_rows_with_gaps() {
        let of = |all: &[u64]| {
            let mut lines = Lines::default();
            all.iter().for_each(|line| lines.push(*line));
            lines
        };
        let all = [2, 3, 4, 7, 9, 10, 11, 15];
        let mut joined = of(&all[..5]);
        joined.append(&of(&all[5..]));
        for lines in [of(&all), joined] {
            assert!((0..all.len()).all(|row| lines.of(row) == Some(all[row])));
            assert_eq!((lines.of(all.len()), lines.rows()), (None, all.len()));
        }
        assert_eq!(Lines::default().of(0), None);
    }
}
