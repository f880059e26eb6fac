//! The names of the columns of a text, and their units.

use crate::table::columns::About;
use crate::table::text::cells::{Kind, Line, are_places, bare, clean, kind, split, with_unit};
use crate::table::text::preamble::{self, Mark};
use crate::table::text::rows::{Rows, keyed_names, keyed_units};
use crate::table::text::time_groups::{Keyed, Rates, keyed};
use crate::units::Unit;

/// The header.
pub(super) struct Head {
    pub(super) names: Vec<String>,
    /// Its cells, none without a header.
    pub(super) cells: Vec<String>,
    /// Number of lines before it.
    pub(super) before: usize,
    /// Start and step of the time that its units tell.
    pub(super) step_s: Option<f64>,
    /// The times of the columns, if they have several rates.
    pub(super) rates: Option<Rates>,
    /// Names of columns that no row has.
    further: Vec<String>,
}

impl Head {
    /// The header of rows of which the first `used` columns are not empty.
    pub(super) fn of(
        (content, comments): (&[Line<'_>], &[Line<'_>]),
        rows: &Rows,
        (used, mark): (usize, Mark),
    ) -> Self {
        let cells = |place: usize| content.get(place).map(|line| split(line.text, rows.separator));
        let of_place = |place: Option<usize>, counts: bool| {
            place.and_then(|place| Some((place, fitting(cells(place)?, [used, rows.cells], counts)?)))
        };
        if let Some(Keyed { before, names, rates }) = keyed(content, rows.first, rows.separator, used) {
            return Self { cells: names.clone(), names, before, step_s: None, rates, further: vec![] };
        }
        if let Some((before, names)) = keyed_names(content, (rows.separator, rows.cells, rows.first), used) {
            return Self { cells: names.clone(), names, before, step_s: None, rates: None, further: vec![] };
        }
        let mut last = rows.first.checked_sub(1);
        let counts = counts(content, rows);
        // Below names of several lines pandas writes the name of the first column in a line of its own.
        let index = last.and_then(&cells).filter(|row| {
            rows.separator != b' '
                && row.len() > 2
                && row.len() == rows.cells
                && row[1..].iter().all(|cell| cell.is_empty())
        });
        if index.is_some() {
            last = last.and_then(|last| last.checked_sub(1));
        }
        let units = last.and_then(&cells).filter(|row| rows.has_units || is_units(row, used));
        let given = || cells(0).map(|row| (0, row.into_iter().map(clean).collect::<Vec<_>>()));
        let (found, units) = match (units, of_place(last.and_then(|last| last.checked_sub(1)), counts)) {
            (Some(units), Some(found)) => (Some(found), Some(units)),
            (units, _) if rows.has_units => (given(), units),
            _ => (of_place(last, counts), None),
        };
        let Some((before, mut all)) = found else {
            return Self::of_comment(comments, content[rows.first].before, (rows, used));
        };
        if let (Some(index), Some(first)) = (&index, all.first_mut()) {
            *first = clean(index[0]);
        }
        let step_s = units
            .as_ref()
            .and_then(|units| increment(&all, units, mark))
            .or_else(|| all[used.min(all.len())..].iter().find_map(|cell| preamble::of_cell(cell, mark)));
        // Also in a line above the names.
        let units = units.or_else(|| keyed_units(&content[..rows.first], rows.separator, used));
        let unit = |k: usize| units.as_ref().and_then(|units| units.get(k)).map(|unit| bare(unit));
        let named = |(k, name): (usize, &String)| {
            unit(k).map_or_else(|| name.clone(), |unit| with_unit(name, long_unit(unit).unwrap_or(unit)))
        };
        // A column may be empty in the rows that are looked at, and have numbers later.
        let kept = if step_s.is_some() { used } else { rows.cells };
        let names = all.iter().take(kept).enumerate().map(named).collect();
        let further = if step_s.is_some() { vec![] } else { all[kept.min(all.len())..].to_vec() };
        Self { names, cells: all, before, step_s, rates: None, further }
    }

    /// The header in the last comment before the rows, or in the one before it if the last has units; or none.
    fn of_comment(comments: &[Line<'_>], before: usize, (rows, used): (&Rows, usize)) -> Self {
        let text = |line: &Line<'_>| line.text.trim_start_matches(['#', '%', ';']).trim().to_string();
        let texts = comments.iter().filter(|line| line.before < before).map(text).filter(|line| !line.is_empty());
        let texts: Vec<String> = texts.collect();
        let cells = |back: usize| {
            let text = texts.get(texts.len().checked_sub(back)?)?;
            Some(split(text, rows.separator)).filter(|cells| cells.len() == used)
        };
        let units = cells(1).filter(|cells| cells.iter().all(|cell| is_bracketed(cell)) || is_units(cells, used));
        let names = match &units {
            Some(units) => cells(2).map(|names| {
                let named = |(name, unit): (&str, &&str)| with_unit(&clean(name), bare(unit));
                names.into_iter().zip(units).map(named).collect::<Vec<_>>()
            }),
            None => cells(1).map(|names| names.into_iter().map(clean).collect()),
        };
        match names {
            Some(names) => Self { cells: names.clone(), names, before: 0, step_s: None, rates: None, further: vec![] },
            None => {
                let names = (1..=used).map(|k| format!("c{k}")).collect();
                Self { names, cells: vec![], before: rows.first, step_s: None, rates: None, further: vec![] }
            }
        }
    }

    /// Says what was left out.
    pub(super) fn doubts(&self, content: &[Line<'_>], first: usize, about: &mut About) {
        let lines = if self.cells.is_empty() { first } else { self.before };
        if lines > 0 {
            let last = content[lines - 1].end;
            let place = if last == 1 { "line 1".into() } else { format!("lines {} to {last}", content[0].before + 1) };
            about.omit(place, "before the header");
        }
        for name in self.further.iter().filter(|name| !name.is_empty()) {
            about.omit(format!("column {name}"), "no row has it");
        }
    }
}

/// The cells of a line as names of the columns, the first `used` of which are not empty; `None` if the numbers of cells
/// and columns differ.
///
/// A name may be missing before the others only if the rows count in the first column.
fn fitting(cells: Vec<&str>, [used, columns]: [usize; 2], counts: bool) -> Option<Vec<String>> {
    let count = cells.iter().rposition(|cell| !cell.is_empty()).map_or(0, |last| last + 1);
    // A date or a time is no name.
    if cells.iter().any(|cell| kind(cell, false) == Kind::Time) {
        return None;
    }
    if cells.iter().all(|cell| kind(cell, false) != Kind::Word) && !are_places(&cells) {
        return None;
    }
    let all: Vec<String> = cells.into_iter().map(clean).collect();
    // Names that no row has: of the time in units, and of notes that are rare.
    let rare = ["start", "t0", "increment", "tinc", "comment", "comments", "note", "notes"];
    let word = |name: &str| name.split('=').next().unwrap_or_default().trim().to_lowercase();
    let is_rare = |name: &String| name.is_empty() || rare.contains(&word(name).as_str());
    match count {
        _ if count == used || all.len() == used || all.len() == columns => Some(all),
        _ if count > used && all[used..].iter().all(is_rare) => Some(all),
        // Tables of R have no name for their row names.
        _ if count + 1 == used && used > 2 && counts => {
            Some(std::iter::once("row".to_string()).chain(all).take(used).collect())
        }
        _ => None,
    }
}

/// Whether the first column is words, or counts the rows.
fn counts(content: &[Line<'_>], rows: &Rows) -> bool {
    let first = |place: usize| content.get(place).and_then(|line| split(line.text, rows.separator).first().copied());
    let numbers = [first(rows.first), first(rows.first + 1)].map(|cell| cell.and_then(|cell| cell.parse::<f64>().ok()));
    match numbers {
        [Some(one), Some(next)] => next - one == 1.0,
        _ => true,
    }
}

/// Units of oscilloscopes in words.
fn long_unit(unit: &str) -> Option<&'static str> {
    match unit.to_lowercase().as_str() {
        "volt" | "volts" => Some("V"),
        "ampere" | "amperes" | "amp" | "amps" => Some("A"),
        "second" | "seconds" => Some("s"),
        _ => None,
    }
}

fn is_bracketed(cell: &str) -> bool {
    cell.starts_with(['[', '(']) && cell.ends_with([']', ')'])
}

/// Whether the first `used` cells of a line are units, or words that stand for none.
fn is_units(cells: &[&str], used: usize) -> bool {
    let is_unit = |cell: &str| Unit::is_written(cell);
    let filler = [
        "", "-", "1", "%", "value", "values", "unit", "units", "einheit", "sequence", "none", "bool", "counts",
        "count", "w", "hz", "ohm", "date", "datetime",
    ];
    let own: Vec<&str> = cells.iter().take(used).map(|cell| bare(cell)).collect();
    let known = |cell: &&str| is_unit(cell) || filler.contains(&cell.to_lowercase().as_str());
    // What all cells have in brackets are units, whether each is known or not.
    let bracketed = cells.iter().take(used).all(|cell| is_bracketed(cell) || cell.is_empty());
    own.len() == used && (bracketed || own.iter().all(known)) && own.iter().any(|cell| is_unit(cell))
}

/// The step of the time, s, by the columns Start and Increment of a header and the numbers below them.
fn increment(names: &[String], units: &[&str], mark: Mark) -> Option<f64> {
    let place = |wanted: &[&str]| names.iter().position(|name| wanted.contains(&name.to_lowercase().as_str()));
    let step = units.get(place(&["increment", "tinc", "delta t", "dt"])?)?;
    place(&["start", "t0"]).and(preamble::of_cell(&format!("dt={step}"), mark))
}
