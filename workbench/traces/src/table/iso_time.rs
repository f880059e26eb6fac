//! Dates with times as text, in the forms of ISO 8601 and of its relatives.

use chrono::{FixedOffset, NaiveDate};

/// Nanoseconds in a second.
const SECOND: i128 = 1_000_000_000;

/// Nanoseconds since 1970 of a date with a time, such as `2026-11-26 00:00:00.0005`, `2026-11-26T01:00:00,5+01:00` or
/// `2026-11-26T00:00Z`; without a zone it is taken as that of Greenwich.
pub(super) fn nanoseconds(text: &str) -> Option<i128> {
    let bytes = text.trim().as_bytes();
    let (date, rest) = bytes.split_first_chunk::<10>()?;
    let [y, e, a, r, b'-', m, n, b'-', d, k] = *date else { return None };
    let date = NaiveDate::from_ymd_opt(number(&[y, e, a, r])? as i32, number(&[m, n])?, number(&[d, k])?)?;
    let [b'T' | b't' | b' ', h, g, b':', m, n, rest @ ..] = rest else { return None };
    let (hours, minutes) = (number(&[*h, *g])?, number(&[*m, *n])?);
    let (seconds, rest) = match rest {
        [b':', s, t, rest @ ..] => (number(&[*s, *t])?, rest),
        rest => (0, rest),
    };
    let (part, rest) = match rest {
        [b'.' | b',', rest @ ..] => {
            let digits = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
            let (part, rest) = rest.split_at(digits);
            // What is finer than a nanosecond is left out.
            let part = &part[..digits.min(9)];
            (number(part)? * 10_u32.pow(9 - part.len() as u32), rest)
        }
        rest => (0, rest),
    };
    let time = date.and_hms_opt(hours, minutes, seconds)?.and_utc().timestamp();
    let ahead = match rest.trim_ascii() {
        b"" | b"Z" | b"z" | b"UTC" => 0,
        zone => offset(str::from_utf8(zone).ok()?)?,
    };
    Some((i128::from(time) - i128::from(ahead)) * SECOND + i128::from(part))
}

/// A number of at least one digit and at most nine.
fn number(digits: &[u8]) -> Option<u32> {
    let add = |sum: u32, digit: &u8| digit.is_ascii_digit().then(|| sum * 10 + u32::from(digit - b'0'));
    if digits.is_empty() { None } else { digits.iter().try_fold(0, add) }
}

/// Seconds ahead of Greenwich of `+01:00`, `+0100` or `+01`.
fn offset(zone: &str) -> Option<i32> {
    let full = if zone.len() == 3 { format!("{zone}:00") } else { zone.to_string() };
    full.parse::<FixedOffset>().ok().map(|own| own.local_minus_utc())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_with_times_are_read_to_the_nanosecond() {
        let midnight = 1_795_651_200 * 1_000_000_000;
        for (text, later) in [
            ("2026-11-26 00:00:00", 0),
            ("2026-11-26T00:00:00.000500", 500_000),
            ("2026-11-26T00:00:00,000000001Z", 1),
            ("2026-11-26 01:00:00.5+01:00", 500_000_000),
            ("2026-11-25T19:00-0500", 0),
            ("2026-11-26 00:00:00+00", 0),
            (" 2026-11-26 00:00:00 UTC ", 0),
        ] {
            assert_eq!(nanoseconds(text), Some(midnight + later), "{text}");
        }
        for text in [
            "",
            "2026-11-26",
            "2026-13-26 00:00:00",
            "2026-11-26 24:00:00",
            "2026-11-26 00:00:00.",
            "run 2026-11-26 00:00:00",
            "äöüäöüä 1",
            "1.5",
            "2026-11-26 x",
        ] {
            assert_eq!(nanoseconds(text), None, "{text}");
        }
    }
}
