//! Loggers that write a time beside each channel, or beside each group of channels.
//!
//! ```text
//! Name            Axis.Current  Name            Axis.Speed  Axis.Angle     the names follow the key of their time
//! SampleTime[ms]  0.5           SampleTime[ms]  1           1
//! Unit            A             Unit            rpm         rad
//! 0.0             0.1           0.0             17.5        3.5
//! ```

use std::collections::BTreeMap;

use model::trace::median;

use super::cells::{Line, bare, plain_number, split, with_unit};
use super::rates::Rates;

/// What the lines before the rows say of columns with several times.
pub(super) struct Keyed {
    /// The place of the line of names.
    pub(super) before: usize,
    /// The times have the name of the time with the unit that is told; those of slower groups have none.
    pub(super) names: Vec<String>,
    /// The times and rates of the columns, if there are several rates.
    pub(super) rates: Option<Rates>,
}

/// Key of the line of names.
const NAME: &str = "name";

/// The number of cells of a line of names, if another line has keys at the same places, or sample times.
pub(super) fn cells(all: &[Vec<&str>]) -> Option<usize> {
    let is_keyed = |names: &&Vec<&str>| {
        let times: Vec<usize> = (0..names.len()).filter(|k| names[*k].eq_ignore_ascii_case(NAME)).collect();
        let alike = |row: &&Vec<&str>| {
            row.len() == names.len() && row[0] != names[0] && times.iter().all(|k| row[*k] == row[0])
        };
        let has_key =
            |row: &&Vec<&str>| times.len() > 1 && number_of(row[0]).is_none() || unit_of_times(row[0]).is_some();
        names.len() > 2
            && times.first() == Some(&0)
            && all.iter().filter(alike).any(|row| !row[0].is_empty() && has_key(&row))
    };
    all.iter().find(is_keyed).map(Vec::len)
}

/// The number in a cell, with a point or a comma.
fn number_of(cell: &str) -> Option<f64> {
    plain_number(&cell.replace(',', "."))
}

/// The unit in the key of a line of sample times.
fn unit_of_times(key: &str) -> Option<String> {
    let key = key.to_lowercase().replace(' ', "");
    Some(key.strip_prefix("sampletime[")?.strip_suffix(']')?.to_string())
}

/// The columns by lines before the row `first` that begin with a key which comes again at each time; `None` without
/// such lines.
pub(super) fn keyed(content: &[Line<'_>], first: usize, separator: u8, columns: usize) -> Option<Keyed> {
    let cells = |line: &Line<'_>| -> Vec<String> {
        let mut all = split(line.text, separator);
        while all.len() > columns && all.last().is_some_and(|cell| cell.is_empty()) {
            all.pop();
        }
        all.into_iter().map(String::from).collect()
    };
    let lines: Vec<Vec<String>> = content[..first].iter().map(cells).collect();
    let before = lines.iter().position(|all| all.len() == columns && all[0].eq_ignore_ascii_case(NAME))?;
    let names = &lines[before];
    let times: Vec<usize> = (0..columns).filter(|k| names[*k].eq_ignore_ascii_case(NAME)).collect();
    let is_time = |k: &usize| times.contains(k);
    let is_keyed = |all: &&Vec<String>| all.len() == columns && times.iter().all(|k| all[*k] == all[0]);
    let keyed = || lines[before..].iter().filter(is_keyed);
    let steps = keyed().find_map(|all| Some((unit_of_times(&all[0])?, all)));
    // Two columns, or one time without its rate, may be anything.
    if columns < 4 && steps.is_none() || times.len() < 2 && steps.is_none() || times.len() == columns {
        return None;
    }
    let units = keyed().find(|all| all[0].eq_ignore_ascii_case("unit"));
    // V (Voltage)
    let unit = |k: usize| units.map_or("", |all| bare(all[k].split(" (").next().unwrap_or_default()));
    let time = format!("time [{}]", steps.as_ref().map_or("ms", |(unit, _)| unit));
    let time_of: Vec<usize> =
        (0..columns).map(|k| times.iter().copied().rfind(|time| *time <= k).unwrap_or_default()).collect();
    let rates = rates(&time_of, steps.as_ref(), (&content[first..], separator));
    let named = |k: usize| match &rates {
        Some(rates) if is_time(&k) && k != rates.time() => String::new(),
        _ if is_time(&k) => time.clone(),
        _ => with_unit(&names[k], unit(k)),
    };
    let names = (0..columns).map(named).collect();
    Some(Keyed { before, names, rates })
}

/// The rates of columns with these times: as they are told in a unit, or by the times of the rows.
fn rates(
    time_of: &[usize],
    told: Option<&(String, &Vec<String>)>,
    (rows, separator): (&[Line<'_>], u8),
) -> Option<Rates> {
    // With commas between cells and in numbers the line of sample times has more cells.
    let measured = |time: usize| {
        let times = rows.iter().map_while(|line| number_of(split(line.text, separator).get(time)?));
        let times: Vec<f64> = times.collect();
        let steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        (!steps.is_empty()).then(|| median(&steps))
    };
    let mut of_time: BTreeMap<usize, Option<f64>> = BTreeMap::new();
    for (k, time) in time_of.iter().enumerate().filter(|(k, time)| k != *time) {
        of_time
            .entry(*time)
            .or_insert_with(|| told.and_then(|(_, all)| number_of(&all[k])).or_else(|| measured(*time)));
    }
    let all: Option<Vec<(usize, f64)>> = time_of.iter().map(|time| Some((*time, (*of_time.get(time)?)?))).collect();
    Rates::of(all?, told.map_or("ms", |(unit, _)| unit))
}

/// The columns beside `time` that have its name, as they are or numbered: the same in each row, or the first row in
/// which they differ.
pub(super) fn twins(names: &[String], rows: &[Vec<&str>], time: usize) -> Vec<(usize, Option<usize>)> {
    let name = base(&names[time]);
    let others = (0..names.len()).filter(|k| *k != time && base(&names[*k]) == name);
    // 0.0 is 0
    let differs =
        |one: &str, other: &str| one != other && (number_of(one) != number_of(other) || number_of(one).is_none());
    others.map(|k| (k, rows.iter().position(|row| differs(row[k], row[time])))).collect()
}

/// A name without the number that makes it single: Time.1, Time 2, Time_3, Time (4).
fn base(name: &str) -> &str {
    let cut = name.trim_end_matches(')').trim_end_matches(|c: char| c.is_ascii_digit());
    if cut.len() < name.len() { cut.trim_end_matches(['.', '_', ' ', '(']) } else { name }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_without_their_numbers() {
        for (name, expected) in
            [("Time.1", "Time"), ("Time (2)", "Time"), ("t_3", "t"), ("Time [ms]", "Time [ms]"), ("Time", "Time")]
        {
            assert_eq!(base(name), expected);
        }
    }
}
