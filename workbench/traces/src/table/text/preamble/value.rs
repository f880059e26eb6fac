//! The value behind the key of a line: one, or one for each channel.
//!
//! ```text
//! 8000 Hz        8000;8000;8000        10,000        2000 Hz, 16 bit        12,5,kHz
//! ```
//!
//! Where commas separate cells, one between digits may also be that of thousands or decimals: then the value is not
//! understood, unless the cells are equal or can be no rates.

use super::number::{Mark, Number, readings};
use super::words::{Scale, scale};
use crate::table::text::cells::split;

/// Marks between a key and its value, and those that separate cells.
pub(super) const MARKS: [char; 6] = [',', ';', '\t', '=', ':', '|'];
const CELLS: [char; 4] = [',', ';', '\t', '|'];
/// A value, the likelier reading first, and its unit.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Value {
    pub(super) numbers: Vec<Number>,
    pub(super) scale: Option<Scale>,
}

/// Whether a number is behind the marks at the start of a text.
pub(super) fn begins_with_number(rest: &str) -> bool {
    rest.trim_start_matches(MARKS).trim_start_matches([' ', '"', '+']).starts_with(|c: char| c.is_ascii_digit())
}

/// The values that the text behind a key may be: one, or one for each channel.
pub(super) fn values(rest: &str, mark: Mark) -> Result<Vec<Value>, &'static str> {
    let text = rest.trim_start_matches(|c: char| MARKS.contains(&c) || c.is_whitespace());
    let between = &rest[..rest.len() - text.len()];
    let separator = between.chars().rev().find(|c| CELLS.contains(c));
    let cells: Vec<&str> = match separator {
        Some(separator) => split(text, separator as u8),
        None => pieces(text),
    };
    let all = of_cells(&cells, mark)?;
    let Some(first) = all.first() else { return Ok(all) };
    let is_one = all.iter().all(|value| value == first);
    let joined = if separator == Some(',') && !text.contains('"') { joined(&cells) } else { None };
    let whole = joined.map(|joined| of_cells(&[&joined], mark)).filter(|whole| *whole != Ok(vec![]));
    let Some(whole) = whole else {
        return if is_one { Ok(vec![first.clone()]) } else { Err("its channels have different rates") };
    };
    let digits = |cell: &str| cell.bytes().take_while(u8::is_ascii_digit).count();
    match whole {
        // No channel has the rate 000.
        Ok(whole) if cells[1].starts_with("00") => Ok(whole),
        Ok(whole) if is_one && cells.len() == 2 && digits(cells[1]) == 3 => Ok([vec![first.clone()], whole].concat()),
        _ if is_one => Ok(vec![first.clone()]),
        _ => Err("a comma in it separates channels, thousands or decimals"),
    }
}

/// Cells of digits between commas as one number.
fn joined(cells: &[&str]) -> Option<String> {
    let is_digits = |cell: &&&str| !cell.is_empty() && cell.bytes().all(|byte| byte.is_ascii_digit());
    let begins = |cell: &&str| cell.starts_with(|c: char| c.is_ascii_digit());
    let whole = cells.iter().take_while(is_digits).count();
    let count = whole + usize::from(cells.get(whole).is_some_and(begins));
    (whole > 0 && count > 1).then(|| {
        let unit = cells.get(count).filter(|cell| scale(cell).is_some());
        let unit = unit.map_or_else(String::new, |unit| format!(" {unit}"));
        cells[..count].join(",") + &unit
    })
}

/// The parts of a text that is not in cells: a comma between digits is part of a number.
fn pieces(text: &str) -> Vec<&str> {
    let is_digit = |c: Option<char>| c.is_some_and(|c| c.is_ascii_digit());
    let ends = text.char_indices().filter(|(at, c)| match c {
        ';' | '\t' | '|' => true,
        ',' => !is_digit(text[..*at].chars().next_back()) || !is_digit(text[at + 1..].chars().next()),
        _ => false,
    });
    let (mut all, mut start) = (Vec::new(), 0);
    for (at, _) in ends {
        all.push(text[start..at].trim());
        start = at + 1;
    }
    all.push(text[start..].trim());
    all.into_iter().map(|piece| piece.trim_matches('"')).collect()
}

/// The values that cells begin with.
fn of_cells(cells: &[&str], mark: Mark) -> Result<Vec<Value>, &'static str> {
    const UNKNOWN_UNIT: &str = "its unit is not known";
    let mut all: Vec<Value> = Vec::new();
    let mut queue: Vec<&str> = cells.iter().rev().copied().collect();
    while let Some(cell) = queue.pop() {
        if cell.is_empty() {
            continue;
        }
        if all.is_empty()
            && ["~", "≈", "ca.", "ca ", "approx", "about ", "etwa "].iter().any(|near| cell.starts_with(near))
        {
            return Err("it is only near");
        }
        let (numbers, behind) = readings(cell, mark);
        // A date or a time of the day.
        let is_date = behind.starts_with([':', '/', '-']) && begins_with_number(&behind[1..]);
        if numbers.is_empty() || is_date {
            break;
        }
        let behind = behind.trim_start();
        let (scale, further) = if behind.is_empty() {
            let next = queue.last().and_then(|next| scale(next));
            if next.is_some() {
                queue.pop();
            } else if all.is_empty() && queue.last().is_some_and(|next| is_like_unit(next)) {
                return Err(UNKNOWN_UNIT);
            }
            (next, "")
        } else {
            match unit_of(behind) {
                Some((_, further)) if further.starts_with(['/', '÷', '*', '×', ':']) => {
                    return Err("it is divided or multiplied");
                }
                Some((unit, further)) => (Some(unit), further),
                // The value of the next channel.
                None if behind.starts_with(|c: char| c.is_ascii_digit()) => (None, behind),
                None if all.is_empty() => return Err(UNKNOWN_UNIT),
                None => break,
            }
        };
        all.push(Value { numbers, scale });
        if further.starts_with(|c: char| c.is_ascii_digit()) {
            queue.push(further);
        }
    }
    Ok(all)
}

/// Whether a cell behind a number is more like a unit than like the next key.
fn is_like_unit(cell: &str) -> bool {
    let lower = cell.to_lowercase();
    let is_word = lower.len() <= 12 && !lower.starts_with(|c: char| c.is_ascii_digit());
    is_word && (lower.contains('/') || ["hz", "ps", "sec"].iter().any(|end| lower.ends_with(end)))
}

/// The unit of up to four words that a text begins with, and what is behind it.
pub(super) fn unit_of(text: &str) -> Option<(Scale, &str)> {
    let ends: Vec<usize> = text.match_indices([' ', '(', ',']).map(|(at, _)| at).chain([text.len()]).take(4).collect();
    ends.iter().rev().find_map(|end| Some((scale(&text[..*end])?, text[*end..].trim_start())))
}
