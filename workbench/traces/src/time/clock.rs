//! Times of a log → seconds from the first row.
//!
//! ```text
//! 2026-11-26 00:00:00.0005   2026-11-26T00:00:00Z   26.10.2022 08:17:00   11/26/2026 8:17   08:17:00,250
//! 26-Nov-2026 08:17:00.250   08:17:00:250           0 days 00:00:00.0005  0.0005 sec
//! 1764200000000250000        1764200000.00025       123456789              in the unit of the column
//! ```
//!
//! Seconds since 1970 with their decimals need more digits than a double has. So all are integers until the first one
//! is subtracted. A clock of a day goes on behind midnight in the reader.

/// Nanoseconds of a second and of a day.
const SECOND: i128 = 1_000_000_000;
const DAY: i128 = 86_400 * SECOND;
/// Months in words, as MATLAB and oscilloscopes write them.
const MONTHS: [&str; 12] = ["jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec"];
/// Decimals of numbers that are kept.
const DECIMALS: usize = 12;

/// How a column tells the time, and its first value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Clock {
    /// A date and a time of the day, or the latter alone: ns.
    Calendar(i128),
    /// A number in units of so many seconds: 10⁻¹² units.
    Number(i128, f64),
}

impl Clock {
    /// By the cells of the first rows, if all of them are dates or times of the day.
    pub(crate) fn of_words<'a>(mut cells: impl Iterator<Item = &'a str>) -> Option<Self> {
        let first = nanoseconds(cells.next()?)?;
        cells.all(|cell| nanoseconds(cell).is_some()).then_some(Self::Calendar(first))
    }

    /// Of numbers in units of so many seconds, from this one on.
    pub(crate) fn of_numbers(first: &str, unit_s: f64, decimal_comma: bool) -> Option<Self> {
        Some(Self::Number(decimal(first, decimal_comma)?, unit_s))
    }

    /// Seconds of its unit, if it counts units.
    pub(crate) const fn unit_s(self) -> Option<f64> {
        match self {
            Self::Calendar(_) => None,
            Self::Number(_, unit_s) => Some(unit_s),
        }
    }

    /// Seconds from the first row; `None` if the cell is no time.
    pub(crate) fn seconds(self, cell: &str, decimal_comma: bool) -> Option<f64> {
        match self {
            Self::Calendar(first) => Some((nanoseconds(cell)? - first) as f64 / SECOND as f64),
            Self::Number(first, unit_s) => {
                Some((decimal(cell, decimal_comma)? - first) as f64 / 10_f64.powi(DECIMALS as i32) * unit_s)
            }
        }
    }
}

/// A decimal number in 10⁻¹²; one with an exponent has no more digits than a double.
fn decimal(cell: &str, decimal_comma: bool) -> Option<i128> {
    if cell.contains(['e', 'E']) {
        let scaled = cell.replacen(',', ".", usize::from(decimal_comma)).parse::<f64>().ok()? * 1e12;
        return (scaled.abs() < 1e36).then_some(scaled.round() as i128);
    }
    let (negative, digits) = match cell.strip_prefix('-') {
        Some(rest) => (true, rest),
        None => (false, cell.strip_prefix('+').unwrap_or(cell)),
    };
    let (whole, part) = digits.split_once(if decimal_comma { ',' } else { '.' }).unwrap_or((digits, ""));
    let is_number = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    if digits.is_empty() || whole.len() + part.len() == 0 || whole.len() > 20 || !is_number(whole) || !is_number(part) {
        return None;
    }
    let part: String = part.chars().chain("000000000000".chars()).take(DECIMALS).collect();
    let value = format!("{whole}{part}").parse::<i128>().ok()?;
    Some(if negative { -value } else { value })
}

/// Date and time of the day, or the latter alone, in ns.
pub(crate) fn nanoseconds(cell: &str) -> Option<i128> {
    let cell = cell.trim();
    let starts = |c: char| c.is_ascii_digit();
    if !cell.starts_with(starts) || cell.len() > 40 {
        return None;
    }
    if let Some(span) = span(cell) {
        return Some(span);
    }
    let date_end = cell.find([' ', 'T']);
    let (date, time) = match date_end {
        Some(end) => (Some(&cell[..end]), cell[end + 1..].trim_start()),
        None if cell.contains(':') => (None, cell),
        None => (Some(cell), ""),
    };
    let days = match date {
        Some(date) => days(date)?,
        None => 0,
    };
    let of_day = if time.is_empty() { 0 } else { of_day(time)? };
    Some(i128::from(days) * DAY + of_day)
}

/// A span in ns: `0 days 00:00:00.0005` of pandas, `0.0005 sec` of MATLAB.
fn span(cell: &str) -> Option<i128> {
    let (number, rest) = cell.split_once(' ')?;
    let (unit, time) = rest.split_once(' ').unwrap_or((rest, ""));
    if matches!(unit, "day" | "days") {
        let of_day = if time.is_empty() { Some(0) } else { of_day(time.trim_start()) };
        return Some(number.parse::<i128>().ok()? * DAY + of_day?);
    }
    let unit = match unit {
        "sec" => SECOND,
        "min" => 60 * SECOND,
        "hr" => 3600 * SECOND,
        _ => return None,
    };
    // 10⁻¹² of a unit.
    time.is_empty().then(|| decimal(number, false)).flatten().map(|value| value * unit / 1_000_000_000_000)
}

/// The same of a date with a time of the day in the forms of ISO 8601, such as `2026-11-26T01:00:00,5+01:00`.
pub(crate) fn iso_nanoseconds(text: &str) -> Option<i128> {
    let marks = [(4, b'-'), (7, b'-'), (13, b':')];
    let bytes = text.trim().as_bytes();
    nanoseconds(text).filter(|_| marks.iter().all(|(place, mark)| bytes.get(*place) == Some(mark)))
}

/// Days since 1970 of 2026-11-26, 2026/11/26, 26.11.2026, 11/26/2026 and 26/11/2026; the month comes first where a
/// stroke separates and both are possible, which only tells at midnight.
fn days(date: &str) -> Option<i64> {
    let mark = date.find(['-', '.', '/']).and_then(|at| date[at..].chars().next())?;
    let parts: Vec<&str> = date.split(mark).collect();
    let [a, b, c] = parts[..] else { return None };
    let of_month = MONTHS.iter().position(|name| b.eq_ignore_ascii_case(name)).map(|place| (place + 1).to_string());
    let b = of_month.as_deref().unwrap_or(b);
    let is_number = |text: &str| (1..=4).contains(&text.len()) && text.bytes().all(|byte| byte.is_ascii_digit());
    if ![a, b, c].into_iter().all(is_number) {
        return None;
    }
    let number = |text: &str| text.parse::<i64>().ok();
    let (year, month, day) = match (a.len(), c.len(), mark) {
        (4, ..) => (number(a)?, number(b)?, number(c)?),
        (_, 2 | 4, '/') if number(a)? <= 12 => (number(c)?, number(a)?, number(b)?),
        (_, 2 | 4, _) => (number(c)?, number(b)?, number(a)?),
        _ => return None,
    };
    let year = if c.len() == 2 && a.len() != 4 { year + 2000 } else { year };
    let is_leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    let length = match month {
        2 => 28 + i64::from(is_leap),
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    };
    if !(1..=12).contains(&month) || !(1..=length).contains(&day) || !(1900..=9999).contains(&year) {
        return None;
    }
    // Days of the civil calendar, whose years begin in March (Richards 2013, *Calendars*).
    let (years, months) = if month > 2 { (year, month - 3) } else { (year - 1, month + 9) };
    let of_year = (153 * months + 2) / 5 + day - 1;
    Some(365 * years + years.div_euclid(4) - years.div_euclid(100) + years.div_euclid(400) + of_year - 719_468)
}

/// Nanoseconds of 08:17, 08:17:00, 08:17:00.25, 8:17:00,25 PM, with Z or an offset such as +01:00.
fn of_day(time: &str) -> Option<i128> {
    let (time, afternoon) = match time.to_ascii_uppercase() {
        upper if upper.ends_with("PM") => (time[..time.len() - 2].trim_end(), Some(true)),
        upper if upper.ends_with("AM") => (time[..time.len() - 2].trim_end(), Some(false)),
        _ => (time, None),
    };
    let time = time.trim_end_matches("UTC").trim_end();
    let (time, offset) = match time.find(['Z', 'z', '+']).or_else(|| time.rfind('-')) {
        Some(at) => (&time[..at], minutes(&time[at..])?),
        None => (time, 0),
    };
    let (clock, part) = match time.split_once(['.', ',']) {
        Some((_, "")) => return None,
        Some(parts) => parts,
        // Controllers write milliseconds behind a third colon.
        None => match time.rsplit_once(':') {
            Some((clock, part)) if part.len() == 3 && clock.matches(':').count() == 2 => (clock, part),
            _ => (time, ""),
        },
    };
    let mut numbers = clock.split(':');
    let mut next = |most: i128| -> Option<i128> {
        let text = numbers.next().unwrap_or("0");
        let is_number = (1..=2).contains(&text.len()) && text.bytes().all(|byte| byte.is_ascii_digit());
        text.parse().ok().filter(|number| is_number && *number <= most)
    };
    let (hour, minute, second) = (next(23)?, next(59)?, next(59)?);
    if numbers.next().is_some() || !clock.contains(':') || !part.bytes().all(|byte| byte.is_ascii_digit()) {
        return None;
    }
    let hour = match afternoon {
        Some(true) => hour % 12 + 12,
        Some(false) => hour % 12,
        None => hour,
    };
    let part: String = part.chars().chain("000000000".chars()).take(9).collect();
    let seconds = (hour * 60 + minute) * 60 + second - offset * 60;
    Some(seconds * SECOND + part.parse::<i128>().ok()?)
}

/// Minutes of Z, +01:00, −0130 and +01.
fn minutes(zone: &str) -> Option<i128> {
    if zone.eq_ignore_ascii_case("z") {
        return Some(0);
    }
    let digits: String = zone.get(1..)?.chars().filter(|c| *c != ':').collect();
    let number = |text: &str| text.parse::<i128>().ok();
    let found = match digits.len() {
        2 => number(&digits)? * 60,
        4 => number(&digits[..2])? * 60 + number(&digits[2..])?,
        _ => return None,
    };
    Some(if zone.starts_with('-') { -found } else { found })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Counted with the calendar of a spreadsheet.
    #[test]
    fn dates_and_times_of_the_day_are_told() {
        let day = |days: i128| days * DAY;
        let of = |seconds: f64| (seconds * 1e9).round() as i128;
        for (text, expected) in [
            ("1970-01-01 00:00:00", day(0)),
            ("2000-03-01", day(11_017)),
            ("2024-02-29T12:00:00Z", day(19_782) + of(43_200.0)),
            ("2026-11-26 00:00:00.000500000", day(20_783) + of(0.0005)),
            ("2026/11/26 00:00:01", day(20_783) + of(1.0)),
            ("26.11.2026 08:17:00,25", day(20_783) + of(29_820.25)),
            ("11/26/2026 8:17:00 PM", day(20_783) + of(73_020.0)),
            ("26/11/2026 08:17", day(20_783) + of(29_820.0)),
            ("2026-11-26T08:17:00+01:00", day(20_783) + of(26_220.0)),
            ("2026-11-26T08:17:00-0130", day(20_783) + of(35_220.0)),
            ("08:17:00.125", of(29_820.125)),
            ("08:17:00:125", of(29_820.125)),
            ("26-Nov-2026 08:17:00.250", day(20_783) + of(29_820.25)),
            ("0 days 00:00:00.000500", of(0.0005)),
            ("2 days 01:00:00", day(2) + of(3600.0)),
            ("0.0005 sec", of(0.0005)),
            ("1e-05 sec", of(1e-5)),
        ] {
            assert_eq!(nanoseconds(text), Some(expected), "{text}");
        }
        for text in [
            "",
            "12",
            "1.5",
            "-3.5",
            "1.2.3",
            "2026-13-01",
            "10:75",
            "2026-02-29",
            "2026-11-26 24:00",
            "1e5",
            "spall",
            "3.8953+4.1456i",
            "12:30x",
            "12:30:125",
            "5 A",
            "5 secs",
            "26-Abc-2026",
        ] {
            assert_eq!(nanoseconds(text), None, "{text}");
        }
    }

    #[test]
    fn dates_with_times_are_those_of_iso_8601() {
        let midnight = 20_783 * DAY;
        for (text, later) in [
            ("2026-11-26 00:00:00", 0),
            ("2026-11-26T00:00:00,000000001Z", 1),
            ("2026-11-26 01:00:00.5+01:00", 500_000_000),
            ("2026-11-25T19:00-0500", 0),
            ("2026-11-26 00:00:00+00", 0),
            (" 2026-11-26 00:00:00 UTC ", 0),
        ] {
            assert_eq!(iso_nanoseconds(text), Some(midnight + later), "{text}");
        }
        for text in ["2026-11-26", "2026-11-26 00:00:00.", "run 2026-11-26 00:00:00", "äöüäöüä 1", "2026-11-26 x"]
        {
            assert_eq!(iso_nanoseconds(text), None, "{text}");
        }
    }

    #[test]
    fn large_numbers_keep_their_decimals() {
        let clock = Clock::of_numbers("1764200000.00000", 1.0, false).expect("a number");
        assert_eq!(clock.seconds("1764200000.00005", false), Some(5e-5));
        let clock = Clock::of_numbers("1764200000000000000", 1e-9, false).expect("a number");
        assert!((clock.seconds("1764200000000250000", false).expect("a number") - 2.5e-4).abs() < 1e-18);
        assert_eq!(Clock::of_numbers("1,5", 1.0, true).and_then(|clock| clock.seconds("-0,25", true)), Some(-1.75));
        assert_eq!(Clock::of_numbers("5e-1", 1.0, false).and_then(|clock| clock.seconds("1e0", false)), Some(0.5));
        for text in ["", "-", ".", "x", "1ex", "1.5.2"] {
            assert_eq!(Clock::of_numbers(text, 1.0, false), None, "{text}");
        }
    }
}
