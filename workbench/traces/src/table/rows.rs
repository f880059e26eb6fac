//! Where the rows of a text begin, by one separator.

use super::cells::{Kind, Line, are_places, grouped, kind, split};
use super::keyed;
use super::twins;
use model::trace::{Decimal, TextForm};

/// The rows by one separator.
pub(super) struct Rows {
    pub(super) separator: u8,
    /// Number of cells, and the columns of numbers or times.
    pub(super) cells: usize,
    numeric: Vec<bool>,
    /// Place of the first one among the lines.
    pub(super) first: usize,
    /// Whether it is given that the line before has units.
    pub(super) has_units: bool,
}

impl Rows {
    /// The rows by this separator; `None` if no column has numbers.
    pub(super) fn of(content: &[Line<'_>], separator: u8, form: &TextForm) -> Option<Self> {
        // Of given places the first rows are not looked for.
        let before = if form.units_row { 2 } else { 0 };
        let content = content.get(before..)?;
        let (all, of_rates) = Self::cells_of(content, separator);
        let count = |cells: usize| all.iter().filter(|row| row.len() == cells).count();
        let usual = || {
            let mut lengths: Vec<usize> = all.iter().map(Vec::len).collect();
            lengths.sort_unstable();
            lengths.dedup();
            lengths.into_iter().max_by_key(|cells| (count(*cells), *cells))
        };
        let cells = of_rates.or_else(usual)?;
        // A single column has no separator but one that is given: only the comma stands for none.
        if cells == 1 && separator != b',' && form.separator.is_none() {
            return None;
        }
        let is_grouped = |cell: &str| form.decimal.is_some_and(|mark| grouped(cell, mark == Decimal::Comma).is_some());
        let kind = |cell: &str| if is_grouped(cell) { Kind::Number } else { kind(cell, true) };
        let kinds = |row: &Vec<&str>| row.iter().map(|cell| kind(cell)).collect::<Vec<_>>();
        let late = &all[all.len() / 3..];
        let of_late: Vec<Vec<Kind>> = late.iter().filter(|row| row.len() == cells).map(kinds).collect();
        let numeric = |k: usize| {
            let is = |wanted: fn(Kind) -> bool| of_late.iter().filter(|row| wanted(row[k])).count();
            let numbers = is(|kind| matches!(kind, Kind::Number | Kind::Time));
            numbers > 0 && numbers >= is(|kind| kind == Kind::Word)
        };
        let numeric: Vec<bool> = (0..cells).map(numeric).collect();
        let fits = |row: &Vec<&str>| {
            let kinds = kinds(row);
            row.len() == cells
                && kinds.iter().zip(&numeric).all(|(kind, numeric)| !numeric || *kind != Kind::Word)
                && kinds
                    .iter()
                    .zip(&numeric)
                    .any(|(kind, numeric)| *numeric && matches!(kind, Kind::Number | Kind::Time))
        };
        // A line of numbers before the header is followed by others.
        let last = all.len().saturating_sub(2);
        let begins = |first: &usize| fits(&all[*first]) && (*first >= last || fits(&all[*first + 1]));
        // LabVIEW writes a number for each channel in lines of its header.
        let header = content.iter().rposition(|line| line.text.starts_with("***End_of_Header***"));
        let first = (header.map_or(0, |last| last + 1)..all.len()).find(begins)?;
        // A row with a bad cell is no header: its first number says so, and reading names the cell.
        let place = numeric.iter().position(|numeric| *numeric)?;
        let is_row = |row: &Vec<&str>| row.len() == cells && matches!(kind(row[place]), Kind::Number | Kind::Time);
        let first = first - all[..first].iter().rev().take_while(|row| is_row(row)).count();
        let first = if separator == b' ' { first } else { keyed::first_row(&all, first) };
        let found = Self { separator, cells, numeric, first, has_units: form.units_row };
        if form.units_row {
            return (found.columns() > 0).then_some(Self { first: before, ..found });
        }
        // pandas writes the places of columns without names.
        let is_header = first == 0 && cells > 2 && all.len() > first + 1 && are_places(&all[first]);
        let first = first + usize::from(is_header);
        (found.columns() > 0).then_some(Self { first, ..found })
    }

    /// The cells of each line, and their number if lines before the rows tell several times: such rows may end early.
    fn cells_of<'a>(content: &[Line<'a>], separator: u8) -> (Vec<Vec<&'a str>>, Option<usize>) {
        let mut all: Vec<Vec<&str>> = content.iter().map(|line| split(line.text, separator)).collect();
        let of_rates = twins::cells(&all);
        if let Some(cells) = of_rates {
            all.iter_mut().filter(|row| row.len() < cells).for_each(|row| row.resize(cells, ""));
        }
        (all, of_rates)
    }

    /// Number of columns of numbers.
    pub(super) fn columns(&self) -> usize {
        self.numeric.iter().filter(|numeric| **numeric).count()
    }
}
