//! The numbers that a text before the rows may mean.
//!
//! ```text
//! 8.000      8, or 8000        1.250,5    1250.5        10 000   10000     1,250000E-4   0.000125
//! ```
//!
//! The decimal mark of the rows says which; if they show none, a mark before three digits has two readings.

use std::num::NonZero;

/// Marks that separate nothing but thousands.
const GROUPS: [char; 7] = [' ', '\'', '’', '\u{a0}', '\u{202f}', '\u{2009}', '\u{2007}'];

/// The decimal mark that the rows of a file show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::table) enum Mark {
    Point,
    Comma,
    /// No row has a decimal mark.
    Unknown,
}

/// A number, and half a unit of its last digit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Number {
    pub(super) value: f64,
    pub(super) half: f64,
}

/// The numbers that the start of a text may mean, the likelier one first, and the text behind it; none if the text
/// begins otherwise.
pub(super) fn readings(text: &str, mark: Mark) -> (Vec<Number>, &str) {
    let text = text.trim_start();
    let digits = text.strip_prefix('+').unwrap_or(text);
    let mantissa = &digits[..mantissa_end(digits)];
    let (exponent, rest) = exponent(&digits[mantissa.len()..]);
    let ungrouped: String = mantissa.chars().filter(|c| !GROUPS.contains(c)).collect();
    let mut all = plain(&ungrouped, mark, exponent.is_some());
    if all.is_empty() {
        return (all, text);
    }
    let scale = 10_f64.powi(exponent.unwrap_or(0));
    all.iter_mut().for_each(|Number { value, half }| (*value, *half) = (*value * scale, *half * scale));
    match fraction(&all, rest) {
        Some((number, rest)) => (vec![number], rest),
        None => (all, rest),
    }
}

/// Where digits and marks end; a mark that is not before a digit is none of the number.
fn mantissa_end(text: &str) -> usize {
    let mut end = 0;
    for (at, c) in text.char_indices() {
        let behind = &text[at + c.len_utf8()..];
        let digits = behind.bytes().take_while(u8::is_ascii_digit).count();
        let is_part = c.is_ascii_digit()
            || matches!(c, '.' | ',') && digits > 0
            || GROUPS.contains(&c) && end == at && at > 0 && digits == 3;
        if !is_part {
            break;
        }
        end = at + c.len_utf8();
    }
    end
}

/// The exponent at the start of a text, and the text behind it.
fn exponent(text: &str) -> (Option<i32>, &str) {
    let none = (None, text);
    let Some(signed) = text.strip_prefix(['e', 'E', 'd', 'D']) else { return none };
    let digits = signed.strip_prefix(['+', '-']).unwrap_or(signed);
    let count = digits.bytes().take_while(u8::is_ascii_digit).count();
    let length = signed.len() - digits.len() + count;
    match signed[..length].parse::<i32>() {
        Ok(exponent) if count > 0 && exponent.abs() < 100 => (Some(exponent), &signed[length..]),
        _ => none,
    }
}

/// The readings of digits with points and commas.
fn plain(text: &str, mark: Mark, has_exponent: bool) -> Vec<Number> {
    let marks: Vec<char> = text.chars().filter(|c| !c.is_ascii_digit()).collect();
    let decimal = |point: char| {
        let places = text.rsplit_once(point).map_or(0, |(_, places)| places.len());
        let digits: String = text.chars().filter(|c| c.is_ascii_digit() || *c == point).collect();
        let value = digits.replace(point, ".").parse::<f64>().ok()?;
        Some(Number { value, half: 0.5 * 10_f64.powi(-i32::try_from(places).ok()?) })
    };
    let grouped = |group: char| {
        let whole: String = text.chars().filter(char::is_ascii_digit).collect();
        is_grouped(text, group).then(|| Some(Number { value: whole.parse().ok()?, half: 0.5 })).flatten()
    };
    let both = match marks[..] {
        [] => [decimal('.'), None],
        [own] if has_exponent => [decimal(own), None],
        [own] => match (mark, grouped(own)) {
            // The mark is not that of decimals in the rows.
            (Mark::Point, grouped) if own == ',' => [grouped, decimal(own)],
            (Mark::Comma, grouped) if own == '.' => [grouped, decimal(own)],
            (_, grouped) => [decimal(own), grouped],
        },
        [first, .., last] if first == last => [grouped(first), None],
        [first, .., last] => {
            let whole = text.rsplit_once(last).map_or(text, |(whole, _)| whole);
            [is_grouped(whole, first).then(|| decimal(last)).flatten(), None]
        }
    };
    both.into_iter().flatten().collect()
}

/// Whether a mark separates thousands.
fn is_grouped(text: &str, group: char) -> bool {
    let mut parts = text.split(group);
    let digits = |part: &str| part.bytes().all(|byte| byte.is_ascii_digit());
    let first = parts.next().unwrap_or_default();
    (1..=3).contains(&first.len()) && !first.starts_with('0') && parts.all(|part| part.len() == 3 && digits(part))
}

/// The quotient of a number and that behind a stroke: 1/8000.
fn fraction<'a>(all: &[Number], rest: &'a str) -> Option<(Number, &'a str)> {
    let behind = rest.trim_start().strip_prefix('/')?.trim_start();
    let count = behind.bytes().take_while(u8::is_ascii_digit).count();
    let divisor: NonZero<u32> = behind[..count].parse().ok()?;
    let [one] = all else { return None };
    Some((Number { value: one.value / f64::from(divisor.get()), half: 0.0 }, &behind[count..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_digit_tells_how_exact_a_number_is() {
        for (text, half) in [("125", 0.5), ("62.5", 0.05), ("0,000500", 5e-7), ("1.250000E-4", 5e-11)] {
            let found = readings(text, Mark::Unknown).0[0].half;
            assert!((found / half - 1.0).abs() < 1e-9, "{text}: {found}");
        }
    }
}
