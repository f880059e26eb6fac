//! Lines before the rows that begin with what they say, above rows that begin with an empty cell.
//!
//! ```text
//! "TraceName","Current","Speed"     names
//! "VUnit","A","rpm"                 units
//! "SampleRate",2000,2000
//! "",0.1,17.5
//! ```

use super::cells::{Line, bare, clean, split, with_unit};

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
pub(super) fn first_row(all: &[Vec<&str>], first: usize) -> usize {
    let begins_empty = |row: &Vec<&str>| row.first().is_some_and(|cell| cell.is_empty());
    let is_keyed = all[..first].iter().any(|row| row.len() > 2 && NAMES.contains(&key(row[0]).as_str()));
    let behind = (first..all.len()).find(|place| begins_empty(&all[*place]));
    behind.filter(|behind| is_keyed && all[*behind..].iter().all(begins_empty)).unwrap_or(first)
}

/// The units of columns by a line before the rows that begins with what it says, such as `Y_Unit_Label` of LabVIEW.
pub(super) fn units<'a>(before: &[Line<'a>], separator: u8, used: usize) -> Option<Vec<&'a str>> {
    before.iter().map(|line| split(line.text, separator)).find(|cells| {
        let count = cells.iter().rposition(|cell| !cell.is_empty()).map_or(0, |last| last + 1);
        used > 1 && count == used && UNITS.iter().any(|part| key(cells[0]).contains(part))
    })
}

/// The place of the names, and the names of all columns with their units, of rows from the line `first` on; `None` of
/// rows that begin with a value, or without a line of names.
pub(super) fn names(
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
