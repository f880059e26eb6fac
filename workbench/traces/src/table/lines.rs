//! The line of each row of a text, kept as runs of consecutive lines.

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

#[cfg(test)]
mod tests {
    use super::*;

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
