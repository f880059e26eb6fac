//! Loggers that write a time beside each channel.
//!
//! ```text
//! Name            Axis.Current  Name            Axis.Speed     pairs: the names are of the second columns
//! SampleTime[ms]  0.5           SampleTime[ms]  0.5
//! 0.0             0.1           0.0             17.5
//! ```

use super::cells::{Line, split};

/// The names of columns in pairs of time and value, by the lines before the rows; the times have the name of the time
/// with the unit that is told, and the first of these lines is told.
pub(super) fn paired(content: &[Line<'_>], separator: u8, columns: usize) -> Option<(usize, Vec<String>)> {
    let cells = |line: &Line<'_>| -> Option<(String, Vec<String>)> {
        let mut all = split(line.text, separator);
        while all.len() > columns && all.last().is_some_and(|cell| cell.is_empty()) {
            all.pop();
        }
        let key = all.first().filter(|key| !key.is_empty())?.to_string();
        let pairs = all.len() == columns && columns >= 4 && columns.is_multiple_of(2);
        let alike = pairs && all.iter().step_by(2).all(|cell| *cell == key);
        alike.then(|| (key, all.iter().skip(1).step_by(2).map(|cell| (*cell).to_string()).collect()))
    };
    let (place, names) = content.iter().enumerate().find_map(|(place, line)| {
        let (key, names) = cells(line)?;
        key.eq_ignore_ascii_case("name").then_some((place, names))
    })?;
    let unit = content[place..].iter().filter_map(cells).find_map(|(key, _)| {
        let unit = key.to_lowercase().replace(' ', "");
        Some(unit.strip_prefix("sampletime[")?.strip_suffix(']')?.to_string())
    });
    let time = format!("time [{}]", unit.as_deref().unwrap_or("ms"));
    Some((place, names.into_iter().flat_map(|name| [time.clone(), name]).collect()))
}

/// The columns beside `time` that have its name, as they are or numbered: the same in each row, or the first row in
/// which they differ.
pub(super) fn twins(names: &[String], rows: &[Vec<&str>], time: usize) -> Vec<(usize, Option<usize>)> {
    let name = base(&names[time]);
    let others = (0..names.len()).filter(|k| *k != time && base(&names[*k]) == name);
    others.map(|k| (k, rows.iter().position(|row| row[k] != row[time]))).collect()
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
