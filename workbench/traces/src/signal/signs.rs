//! Channels of columns whose signed numbers are written without their sign.

use std::collections::BTreeMap;

use super::Signal;
use crate::describe::guess::Guess;
use model::audit::signs::Signs;

/// How numbers are written, by the names of the columns.
pub(crate) type ByName = BTreeMap<String, Signs>;

/// How the numbers of a column are written, if they are signed ones without their sign; an angle goes on where it
/// begins anew, whatever its sign is.
pub(crate) fn of_column(name: &str, values: &[f64]) -> Option<Signs> {
    Signs::of(values).filter(|_| Guess::of(&[name.to_string()]).angle.is_none())
}

/// A channel with its columns decoded, each with the unit that is stated behind it; what is decoded stays so.
pub(crate) fn decoded(channel: &str, signs: &ByName) -> String {
    let (mut text, mut rest) = (String::new(), channel);
    while !rest.is_empty() {
        // Of names of which one begins with another one, the longest.
        let begins = |(name, _): &(&String, &Signs)| {
            let joins = |c: char| c.is_alphanumeric() || c == '_';
            let behind = rest[name.len().min(rest.len())..].chars().next();
            let is_part = text.ends_with(joins) || behind.is_some_and(joins) && name.ends_with(joins);
            rest.starts_with(name.as_str()) && !is_part
        };
        let Some((name, own)) = signs.iter().filter(begins).max_by_key(|(name, _)| name.len()) else {
            let next = rest.chars().next().map_or(1, char::len_utf8);
            text += &rest[..next];
            rest = &rest[next..];
            continue;
        };
        let behind = &rest[name.len()..];
        let unit = behind.strip_prefix('[').and_then(|unit| unit.find(']')).map_or(0, |end| end + 2);
        let column = &rest[..name.len() + unit];
        let start = format!("{}(", own.word());
        text += &if text.ends_with(&start) { column.to_string() } else { format!("{start}{column})") };
        rest = &rest[column.len()..];
    }
    text
}

/// What is said of the columns of these signals whose signs are missing, but for those of the angle.
pub(crate) fn told<'a>(
    signals: &[Signal],
    names: &[String],
    column: impl Fn(usize) -> Option<&'a Vec<f64>>,
) -> Vec<String> {
    let mut places = Vec::new();
    signals.iter().for_each(|signal| signal.plain_columns(&mut places));
    places.sort_unstable();
    places.dedup();
    let each = |place: usize| Some(of_column(&names[place], column(place)?)?.told(&names[place]));
    places.into_iter().filter_map(each).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_are_decoded_with_their_units_and_once() {
        let signs = ByName::from([
            ("speed".to_string(), Signs::Complement(16)),
            ("speed_ref".to_string(), Signs::Magnitude(16)),
            ("iq [mA]".to_string(), Signs::Complement(12)),
        ]);
        for (channel, expected) in [
            ("speed", "signed16(speed)"),
            ("speed[?]", "signed16(speed[?])"),
            ("(speed[rpm] rad/s)/7", "(signed16(speed[rpm]) rad/s)/7"),
            ("speed_ref-speed", "magnitude16(speed_ref)-signed16(speed)"),
            ("(iq [mA])A", "(signed12(iq [mA]))A"),
            ("signed16(speed)", "signed16(speed)"),
            ("integrate(signed16(speed[rpm])) rad", "integrate(signed16(speed[rpm])) rad"),
            ("motor_speed + speed2", "motor_speed + speed2"),
        ] {
            assert_eq!(decoded(channel, &signs), expected);
        }
    }
}
