//! Columns that are times by their names, and the unit of times without one.

use crate::time::usual_rate::is_plausible;
use crate::units::{Quantity, Unit};

/// Units of times that are tried, and the power of ten of the seconds since 1970 in each.
const UNITS: [(&str, f64, i32); 4] = [("s", 1.0, 9), ("ms", 1e-3, 12), ("us", 1e-6, 15), ("ns", 1e-9, 18)];

/// Ticks of Windows and of .NET from 1980 to 2100, and their length.
const TICKS: [[f64; 2]; 2] = [[1.196e17, 1.575e17], [6.24e17, 6.63e17]];
const TICK_S: f64 = 1e-7;
/// Days of spreadsheets and of MATLAB from 1980 to 2100.
const DAYS: [[f64; 2]; 2] = [[29_221.0, 73_051.0], [723_181.0, 767_011.0]];
const DAY_S: f64 = 86_400.0;
/// Rows a second from which numbers in these ranges are days: 5 rows a second as days would be 432 000 as seconds.
const FASTEST_HZ: f64 = 4e5;

/// Seconds of the unit that the name of a column ends with.
pub(crate) fn seconds(name: &str) -> Option<f64> {
    // Oscilloscopes write: in s.
    let unit = Unit::of_column(name).or_else(|| Unit::named(name.trim().strip_prefix("in ")?));
    let unit = unit.filter(|unit| unit.quantity == Quantity::Time)?;
    unit.to(&Unit::named("s")?).map(|(factor, _)| factor)
}

/// The factor to seconds, if this is the name of a time column; `None` for the unit if the name has none.
pub(crate) fn usual(name: &str) -> Option<Option<f64>> {
    let trimmed = name.trim().trim_start_matches(['_', '%', '#', '/']);
    // A lone T is a temperature or a torque.
    if trimmed == "T" {
        return None;
    }
    let lower = trimmed.to_lowercase();
    // Units alone, also as the last part of a path: header.stamp.secs.
    match lower.rsplit('.').next().unwrap_or_default() {
        "seconds" | "secs" | "sec" => return Some(Some(1.0)),
        "ms_today" | "milliseconds" | "millis" | "msec" => return Some(Some(1e-3)),
        "microseconds" | "micros" | "usec" => return Some(Some(1e-6)),
        _ => {}
    }
    let is_mark = |c: char| matches!(c, '_' | '[' | '(' | ' ' | '/');
    let word = lower.split(is_mark).next().unwrap_or_default();
    let known =
        ["t", "time", "timestamp", "timestamps", "zeit", "temps", "tijd", "tiempo", "datetime", "datenum", "x_value"];
    let is_time = known.contains(&word) || known.contains(&lower.as_str());
    let rest = lower.strip_prefix(word).unwrap_or_default();
    // Elapsed Time [s]
    let (before, unit) = lower.split_once(['[', '(']).unwrap_or((&lower, ""));
    let last = before.trim_end().rsplit(is_mark).next().unwrap_or_default();
    if !is_time && ["time", "zeit", "temps"].contains(&last) && !unit.is_empty() {
        return seconds(&lower).map(Some);
    }
    if !is_time || !rest.chars().next().is_none_or(is_mark) {
        // The last part of a path: run_1/time, log/t_s. A lone t behind a slash is a unit as well.
        let (place, last) = lower.rsplit_once('/')?;
        let is_path = last != "t" && !place.contains(['[', '(']);
        return if is_path { usual(last) } else { None };
    }
    let rest = rest.trim();
    if rest.is_empty() || known.contains(&lower.as_str()) {
        return Some(None);
    }
    seconds(&format!("t_{}", rest.trim_matches(['_', '[', ']', '(', ')', ' ', '/']))).map(Some)
}

/// Whether this is the name of a counter that may be a time: timestep, ticks, cycle_count.
pub(crate) fn may_count(name: &str) -> bool {
    let lower = name.to_lowercase();
    ["timestep", "time step", "time_step", "tick", "cycle", "counter", "count", "clock", "sample"]
        .iter()
        .any(|word| lower.starts_with(word))
}

/// Whether values rise from row to row, and do not count the rows.
pub(crate) fn rises(values: &[f64]) -> bool {
    let steps = || values.windows(2).map(|pair| pair[1] - pair[0]);
    steps().all(|step| step > 0.0) && !steps().all(|step| step == 1.0)
}

/// What is said where a column without a name is taken for the time since its values rise.
pub(crate) fn by_rise(lacks: &str, name: &str) -> String {
    format!("no {lacks}; column {name} rises in each row and is taken as the time in s, --time none leaves it out")
}

/// What is said where a column is taken for the time by its unit.
pub(crate) fn by_unit(name: &str) -> String {
    format!(
        "column {name} has a unit of time and rises in each row, and is taken as the time; --time none leaves it out"
    )
}

/// The unit of times whose column has none.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Guess {
    /// Seconds.
    Seconds,
    /// Another unit, in seconds, and its name.
    Other(f64, &'static str),
    /// They count rows.
    Counter,
}

/// By the first value, the usual step, and whether all are integers.
pub(crate) fn unit(first: f64, step: f64, integers: bool) -> Guess {
    let plausible = |unit: f64| is_plausible(1.0 / (step * unit));
    let since_1970 = |power: i32| (1.0..=4.0).contains(&(first / 10_f64.powi(power)));
    if let Some((name, unit, _)) = UNITS.iter().find(|(_, unit, power)| since_1970(*power) && plausible(*unit)) {
        return if *unit == 1.0 { Guess::Seconds } else { Guess::Other(*unit, name) };
    }
    let is_since = |ranges: [[f64; 2]; 2]| ranges.iter().any(|range| (range[0]..range[1]).contains(&first));
    // Ticks of 100 ns since 1601 or since the year 1.
    if integers && is_since(TICKS) && plausible(TICK_S) {
        return Guess::Other(TICK_S, "ticks of 100 ns");
    }
    // As seconds such steps would be rows of a rate that no drive records.
    if !integers && is_since(DAYS) && 1.0 / step > FASTEST_HZ && plausible(DAY_S) {
        return Guess::Other(DAY_S, "days");
    }
    if !integers || step < 1.0 {
        return Guess::Seconds;
    }
    if step == 1.0 && first.abs() <= 1.0 {
        return Guess::Counter;
    }
    let found = UNITS.iter().find(|(_, unit, _)| plausible(*unit));
    found.map_or(Guess::Seconds, |(name, unit, _)| Guess::Other(*unit, name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn usual_names_are_times() {
        for (name, unit) in [
            ("t", None),
            ("time", None),
            ("__time", None),
            ("%time", None),
            ("Time(S)", Some(1.0)),
            ("Time [ms]", Some(1e-3)),
            ("t_s", Some(1.0)),
            ("time_us", Some(1e-6)),
            ("timestamp", None),
            ("ms_today", Some(1e-3)),
            ("Elapsed Time [s]", Some(1.0)),
            ("t/ms", Some(1e-3)),
            ("seconds", Some(1.0)),
            ("X_Value", None),
            ("run_1/time", None),
            ("log/t_s", Some(1.0)),
        ] {
            assert_eq!(usual(name), Some(unit), "{name}");
        }
        for name in [
            "T",
            "torque",
            "temperature",
            "timer_state",
            "time_constant",
            "t1",
            "tt",
            "rise time",
            "uptime",
            "cycle_time_s",
            "load/t",
            "torque/rated",
            "level [V/time]",
        ] {
            assert_eq!(usual(name), None, "{name}");
        }
    }

    #[test]
    fn units_follow_from_steps_and_the_year() {
        assert_eq!(unit(0.0, 0.001, false), Guess::Seconds);
        assert_eq!(unit(123_456_789.0, 250.0, true), Guess::Other(1e-6, "us"));
        assert_eq!(unit(0.0, 1.0, true), Guess::Counter);
        assert_eq!(unit(53_211.0, 1.0, true), Guess::Other(1e-3, "ms"));
        assert_eq!(unit(0.0, 10.0, true), Guess::Other(1e-3, "ms"));
        assert_eq!(unit(1_764_200_000.0, 5e-5, false), Guess::Seconds);
        assert_eq!(unit(1_764_200_000_000.0, 1.0, true), Guess::Other(1e-3, "ms"));
        assert_eq!(unit(1.7642e15, 250.0, true), Guess::Other(1e-6, "us"));
        assert_eq!(unit(1.7642e18, 250_000.0, true), Guess::Other(1e-9, "ns"));
        assert_eq!(unit(1.340_856_72e17, 5000.0, true), Guess::Other(1e-7, "ticks of 100 ns"));
        assert_eq!(unit(46_352.4, 0.01 / 86_400.0, false), Guess::Other(86_400.0, "days"));
        assert_eq!(unit(740_312.4, 0.01 / 86_400.0, false), Guess::Other(86_400.0, "days"));
        assert_eq!(unit(46_352.4, 5e-5, false), Guess::Seconds);
    }
}
