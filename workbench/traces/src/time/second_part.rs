//! Times of whole seconds with the rest of the second in the next column.
//!
//! ```text
//! stamp.secs  stamp.nsecs    DateTime             Milliseconds
//! 1764200000  999500000      2026-11-26 10:00:00  999
//! 1764200001  0              2026-11-26 10:00:01  0
//! ```

/// Words for parts of a second, and their lengths in s.
const PARTS: [(&[&str], f64); 3] = [
    (&["ms", "msec", "msecs", "millis", "millisec", "millisecs", "millisecond", "milliseconds"], 1e-3),
    (&["us", "usec", "usecs", "micros", "microsec", "microsecs", "microsecond", "microseconds"], 1e-6),
    (&["ns", "nsec", "nsecs", "nanos", "nanosec", "nanosecs", "nanosecond", "nanoseconds"], 1e-9),
];

/// The column behind the time that has the rest of its seconds, with the seconds of its unit: it has such a name, it is
/// below a second, and the time stands in most rows.
pub(crate) fn of(
    names: &[String],
    rows: &[Vec<&str>],
    time: usize,
    number: impl Fn(&str) -> Option<f64>,
) -> Option<(usize, f64)> {
    let standing = rows.windows(2).filter(|pair| pair[0][time] == pair[1][time]).count();
    let name = names.get(time + 1)?.to_lowercase();
    let word = name.trim_end_matches([']', ')']).rsplit(|c: char| !c.is_alphabetic()).next()?;
    let (_, unit) = PARTS.iter().find(|(words, _)| words.contains(&word))?;
    let is_part = |row: &Vec<&str>| number(row[time + 1]).is_some_and(|value| is_below_a_second(value, *unit));
    (2 * standing > rows.len() && rows.iter().all(is_part)).then_some((time + 1, *unit))
}

/// Whether so many units are less than a second.
pub(crate) fn is_below_a_second(value: f64, unit_s: f64) -> bool {
    value >= 0.0 && value * unit_s < 1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rest_of_a_second_is_told_by_name_and_values() {
        let find = |names: [&str; 2], cells: [[&str; 2]; 4]| {
            let rows: Vec<Vec<&str>> = cells.iter().map(|row| row.to_vec()).collect();
            of(&names.map(String::from), &rows, 0, |cell| cell.parse().ok())
        };
        let good = [["7", "998"], ["7", "999"], ["8", "0"], ["8", "1"]];
        assert_eq!(find(["sec", "Milliseconds"], good), None, "half of the rows stand");
        let good = [["7", "997"], ["7", "998"], ["7", "999"], ["7", "1"]];
        assert_eq!(find(["DateTime", "Milliseconds"], good), Some((1, 1e-3)));
        assert_eq!(find(["stamp.secs", "stamp.nsecs"], good), Some((1, 1e-9)));
        assert_eq!(find(["time", "current_ma"], good), None);
        let uptime = [["7", "997"], ["7", "998"], ["7", "999"], ["7", "1000"]];
        assert_eq!(find(["sec", "t_ms"], uptime), None);
    }
}
