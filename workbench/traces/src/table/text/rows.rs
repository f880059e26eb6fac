//! Where the rows of a text begin, by one separator, and lines before them that begin with what they say.
//!
//! ```text
//! "TraceName","Current","Speed"     names, known by their key
//! "VUnit","A","rpm"                 units
//! "SampleRate",2000,2000
//! "",0.1,17.5                       rows that begin with an empty cell
//! ```

use crate::table::text::cells::{Kind, Line, are_places, bare, clean, grouped, kind, split, with_unit};
use crate::table::text::time_groups;
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
        let first = if separator == b' ' { first } else { first_behind_keys(&all, first) };
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
        let of_rates = time_groups::cells(&all);
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

/// Keys of the names, in lower case and without marks.
const NAMES: [&str; 9] =
    ["name", "names", "tracename", "channel", "channelname", "signal", "signalname", "label", "kanalname"];
/// Parts of keys of the units.
const UNITS: [&str; 2] = ["unit", "einheit"];

/// The key of a line, in lower case and without marks.
fn key(cell: &str) -> String {
    cell.chars().filter(|c| c.is_alphanumeric()).collect::<String>().to_lowercase()
}

/// The first row behind lines with keys, some of which have as many numbers; `first` if no line of names is before it.
fn first_behind_keys(all: &[Vec<&str>], first: usize) -> usize {
    let begins_empty = |row: &Vec<&str>| row.first().is_some_and(|cell| cell.is_empty());
    let is_keyed = all[..first].iter().any(|row| row.len() > 2 && NAMES.contains(&key(row[0]).as_str()));
    let behind = (first..all.len()).find(|place| begins_empty(&all[*place]));
    behind.filter(|behind| is_keyed && all[*behind..].iter().all(begins_empty)).unwrap_or(first)
}

/// The units of columns by a line before the rows that begins with what it says, such as `Y_Unit_Label` of LabVIEW.
pub(super) fn keyed_units<'a>(before: &[Line<'a>], separator: u8, used: usize) -> Option<Vec<&'a str>> {
    before.iter().map(|line| split(line.text, separator)).find(|cells| {
        let count = cells.iter().rposition(|cell| !cell.is_empty()).map_or(0, |last| last + 1);
        used > 1 && count == used && UNITS.iter().any(|part| key(cells[0]).contains(part))
    })
}

/// The place of the names, and the names of all columns with their units, of rows from the line `first` on; `None` of
/// rows that begin with a value, or without a line of names.
pub(super) fn keyed_names(
    content: &[Line<'_>],
    (separator, columns, first): (u8, usize, usize),
    used: usize,
) -> Option<(usize, Vec<String>)> {
    let cells = |line: &Line<'_>| split(line.text, separator).into_iter().map(clean).collect::<Vec<_>>();
    let begins_empty = |line: &Line<'_>| cells(line).first().is_some_and(String::is_empty);
    if separator == b' ' || used < 2 || !content[first..].iter().all(begins_empty) {
        return None;
    }
    let keyed = |line: &Line<'_>| {
        let mut all = cells(line);
        let count = all.iter().rposition(|cell| !cell.is_empty()).map_or(0, |last| last + 1);
        all.resize(columns, String::new());
        (key(&all[0]), count, all)
    };
    let lines: Vec<_> = content[..first].iter().map(keyed).collect();
    let place = lines.iter().position(|(key, count, _)| *count == used && NAMES.contains(&key.as_str()))?;
    let units = lines.iter().find(|(key, ..)| UNITS.iter().any(|part| key.contains(part))).map(|(.., units)| units);
    let unit = |k: usize| units.and_then(|units| units.get(k)).map_or("", |unit| bare(unit));
    let named = |(k, name): (usize, &String)| if k == 0 { String::new() } else { with_unit(name, unit(k)) };
    Some((place, lines[place].2.iter().enumerate().map(named).collect()))
}
