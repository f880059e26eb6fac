//! Loggers that write a time beside each channel, or beside each group of channels.
//!
//! ```text
//! Name            Axis.Current  Name            Axis.Speed  Axis.Angle     the names follow the key of their time
//! SampleTime[ms]  0.5           SampleTime[ms]  1           1
//! Unit            A             Unit            rpm         rad
//! 0.0             0.1           0.0             17.5        3.5
//! ```
//!
//! Of several rates, the columns of slower groups are held at the times of the fastest one:
//!
//! ```text
//! 0.0  0.1   0.0  17.5         0.0  0.1  17.5
//! 0.5  0.2   1.0  17.6    ─►   0.5  0.2  17.5
//! 1.0  0.3   2.0  17.7         1.0  0.3  17.6
//! ```
//!
//! A row of such a text is no instant: each group has its own time, and ends by itself.

use std::collections::BTreeMap;

use crate::table::text::cells::{Line, bare, plain_number, split, with_unit};
use crate::units::Unit;
use model::outputs::trimmed;
use model::trace::median;

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

/// Steps of a group over which its last value is held; behind them it is missing.
const HELD: f64 = 1.5;
/// Part of a step by which times may differ that are the same.
const SAME: f64 = 1e-6;

/// The times of the columns of a text.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Rates {
    /// Of each column the place of its time, and the step of that in its unit.
    times: Vec<(usize, f64)>,
    /// The time of the fastest group.
    fastest: usize,
    /// Seconds of the unit of the times.
    unit_s: f64,
}

impl Rates {
    /// By the place of the time of each column and its step in this unit; `None` of one rate.
    pub(super) fn of(times: Vec<(usize, f64)>, unit: &str) -> Option<Self> {
        let unit_s = Unit::named(unit)?.to(&Unit::named("s")?)?.0;
        let (fastest, least) = times.iter().copied().min_by(|one, other| one.1.total_cmp(&other.1))?;
        let is_slower = |(_, step): &(usize, f64)| *step > (1.0 + SAME) * least;
        (least > 0.0 && times.iter().any(is_slower)).then_some(Self { times, fastest, unit_s })
    }

    /// The place of the time of all columns.
    pub(super) const fn time(&self) -> usize {
        self.fastest
    }

    /// What is said of the columns.
    pub(super) fn told(&self, names: &[String]) -> String {
        let rate = |step: f64| trimmed(1.0 / (step * self.unit_s), 6);
        let fastest = self.times[self.fastest].1;
        let mut slow: Vec<(f64, Vec<&str>)> = Vec::new();
        for (name, (_, step)) in
            names.iter().zip(&self.times).filter(|(name, (_, step))| !name.is_empty() && *step > fastest)
        {
            match slow.iter_mut().find(|(own, _)| own == step) {
                Some((_, all)) => all.push(name),
                None => slow.push((*step, vec![name])),
            }
        }
        let each = |(step, names): &(f64, Vec<&str>)| format!("{} ({} a second)", names.join(", "), rate(*step));
        let slow: Vec<String> = slow.iter().map(each).collect();
        format!(
            "several rates in one file: the rows are those of the fastest channels, {} a second, and the last values of \
             slower ones are held: {}; to have these as they were recorded, export the channels of each rate in a file",
            rate(fastest),
            slow.join("; ")
        )
    }

    /// The columns that are read for these ones: these and their times.
    pub(super) fn needed(&self, wanted: &[usize]) -> Vec<usize> {
        let times = wanted.iter().map(|k| self.times[*k].0);
        let mut all: Vec<usize> = wanted.iter().copied().chain(times).chain([self.fastest]).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// The wanted columns at the times of the fastest group, and the seconds by which a group goes on behind it.
    pub(super) fn held(&self, wanted: &[usize], read: &dyn Fn(usize) -> Vec<f64>) -> (Vec<Vec<f64>>, f64) {
        let mut base = read(self.fastest);
        let end = base.iter().rposition(|time| time.is_finite()).map_or(0, |last| last + 1);
        base.truncate(end);
        let mut further = 0.0_f64;
        let mut column = |place: &usize| {
            let (time, step) = self.times[*place];
            let mut values = read(*place);
            if time == self.fastest {
                values.truncate(end);
                return values;
            }
            let times = read(time);
            let last = |times: &[f64]| times.iter().rfind(|time| time.is_finite()).copied();
            if let Some((own, all)) = last(&times).zip(last(&base)) {
                further = further.max((own - all - step) * self.unit_s);
            }
            held_at(&base, (&times, &values), step)
        };
        (wanted.iter().map(&mut column).collect(), further)
    }
}

/// The last of these values at each time; missing before the first one, and where it is older than its steps allow.
fn held_at(at: &[f64], (times, values): (&[f64], &[f64]), step: f64) -> Vec<f64> {
    let (mut next, mut last) = (0, None);
    let value = |at: &f64| {
        while next < times.len() && (times[next].is_nan() || times[next] <= at + SAME * step) {
            if times[next].is_finite() {
                last = Some((times[next], values[next]));
            }
            next += 1;
        }
        // A row without a time has no values.
        let (time, value) = last.filter(|_| at.is_finite())?;
        (at - time < HELD * step).then_some(value)
    };
    at.iter().map(value).map(|value| value.unwrap_or(f64::NAN)).collect()
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

    fn rates(fast: f64, slow: f64) -> Option<Rates> {
        Rates::of(vec![(0, fast), (0, fast), (2, slow), (2, slow), (2, slow)], "ms")
    }

    #[test]
    fn slower_columns_are_held_at_the_times_of_the_fastest() {
        let own = rates(0.5, 1.0).expect("two rates");
        assert_eq!((own.time(), own.needed(&[3])), (0, vec![0, 2, 3]));
        let nan = f64::NAN;
        let table = [
            vec![0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, nan],
            vec![7.0; 8],
            vec![0.5, 1.5, nan, nan, nan, nan, nan, nan],
            vec![10.0, 11.0, nan, nan, nan, nan, nan, nan],
            vec![nan, 21.0, nan, nan, nan, nan, nan, nan],
        ];
        let (columns, further) = own.held(&[0, 3, 4], &|k| table[k].clone());
        let told: Vec<String> = columns[1].iter().map(ToString::to_string).collect();
        assert_eq!(told, ["NaN", "10", "10", "11", "11", "11", "NaN"]);
        assert_eq!((columns[0].len(), columns[2][3], further <= 0.0), (7, 21.0, true));
        let told = own.told(&["time [ms]", "i", "", "w", "q"].map(String::from));
        assert!(told.contains("2000 a second") && told.contains("w, q (1000 a second)"), "{told}");
    }

    #[test]
    fn one_rate_is_none_of_several() {
        assert_eq!((rates(1.0, 1.0), rates(0.0, 1.0)), (None, None));
    }
}
