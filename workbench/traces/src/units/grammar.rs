//! Units as they are written: symbols, words of several languages, prefixes, factors, products and quotients.
//!
//! ```text
//! unit   = part { ("/" | "per" | "pro" | "·" | "*" | "." | "-" | blank) part }
//! part   = number | [prefix] symbol [exponent] | word [exponent] | "(" unit ")"
//!          0.1 A, krpm, rad/s, rad.s⁻¹, N-m, m/s^2, s^{-1}, 1/(min), turn/4096
//! ```
//!
//! Each symbol has the exponents of angle, length, mass, time, current and temperature; these tell the quantity. A
//! number by a time is a speed of rotation in `1/min`, as data sheets write it; `1/s` is none, since it stands for
//! turns and for radians. Effective values (`A rms`) are no unit: what is meant by them depends on the drive. Nor is an
//! angle times a time (`rad.s`), which is no measured quantity: `rad/s` may be meant, and the unit is not known.

use super::unit::{DEGREE, Quantity, TURN, Unit};

/// Exponents of angle, length, mass, time, current and temperature.
type Dimension = [i8; 6];

const NUMBER: Dimension = [0; 6];
const ANGLE: Dimension = [1, 0, 0, 0, 0, 0];
const LENGTH: Dimension = [0, 1, 0, 0, 0, 0];
const MASS: Dimension = [0, 0, 1, 0, 0, 0];
const TIME: Dimension = [0, 0, 0, 1, 0, 0];
const CURRENT: Dimension = [0, 0, 0, 0, 1, 0];
const TEMPERATURE: Dimension = [0, 0, 0, 0, 0, 1];
const FREQUENCY: Dimension = [0, 0, 0, -1, 0, 0];
const ROTATION: Dimension = [1, 0, 0, -1, 0, 0];
const ANGLE_BY_TIME: Dimension = [1, 0, 0, 1, 0, 0];
const SPEED: Dimension = [0, 1, 0, -1, 0, 0];
const FORCE: Dimension = [0, 1, 1, -2, 0, 0];
const TORQUE: Dimension = [0, 2, 1, -2, 0, 0];
const POWER: Dimension = [0, 2, 1, -3, 0, 0];
const VOLTAGE: Dimension = [0, 2, 1, -3, -1, 0];
const RESISTANCE: Dimension = [0, 2, 1, -3, -2, 0];
const PRESSURE: Dimension = [0, -1, 1, -2, 0, 0];

/// Force of a pound, N.
const POUND: f64 = 0.453_592_37 * 9.806_65;
const INCH: f64 = 0.0254;

/// Symbols that take prefixes, by their letters as they are.
const SYMBOLS: [(&str, Dimension, f64); 13] = [
    ("rad", ANGLE, 1.0),
    ("m", LENGTH, 1.0),
    ("g", MASS, 1e-3),
    ("s", TIME, 1.0),
    ("A", CURRENT, 1.0),
    ("K", TEMPERATURE, 1.0),
    ("V", VOLTAGE, 1.0),
    ("N", FORCE, 1.0),
    ("Nm", TORQUE, 1.0),
    ("W", POWER, 1.0),
    ("Pa", PRESSURE, 1.0),
    ("Ω", RESISTANCE, 1.0),
    ("Hz", ROTATION, TURN),
];
const PREFIXES: [(&str, f64); 8] =
    [("n", 1e-9), ("u", 1e-6), ("m", 1e-3), ("c", 1e-2), ("d", 1e-1), ("h", 1e2), ("k", 1e3), ("M", 1e6)];

/// Symbols as some write them that mean something else by the rules.
const AS_WRITTEN: [(&str, Dimension, f64); 16] = [
    ("a", CURRENT, 1.0),
    ("MA", CURRENT, 1e-3),
    ("NM", TORQUE, 1.0),
    ("ma", CURRENT, 1e-3),
    ("v", VOLTAGE, 1.0),
    ("mv", VOLTAGE, 1e-3),
    ("n", FORCE, 1.0),
    ("kn", FORCE, 1e3),
    ("nm", TORQUE, 1.0),
    ("mnm", TORQUE, 1e-3),
    ("k", TEMPERATURE, 1.0),
    ("U", ANGLE, TURN),
    ("C", TEMPERATURE, 1.0),
    ("c", TEMPERATURE, 1.0),
    ("F", TEMPERATURE, 5.0 / 9.0),
    ("Ohm", RESISTANCE, 1.0),
];

/// Words, in lower case.
const WORDS: [(&[&str], Dimension, f64); 33] = [
    (&["radian", "radians", "radiant", "ラジアン", "弧度"], ANGLE, 1.0),
    (&["deg", "degree", "degrees", "grad", "winkelgrad", "degré", "degrés", "grados", "°", "度"], ANGLE, DEGREE),
    (&["arcmin"], ANGLE, DEGREE / 60.0),
    (&["arcsec"], ANGLE, DEGREE / 3600.0),
    (&["gon"], ANGLE, TURN / 400.0),
    (
        &[
            "turn",
            "turns",
            "rev",
            "revs",
            "revolution",
            "revolutions",
            "rotation",
            "rotations",
            "umdrehung",
            "umdrehungen",
            "umdr",
            "umd",
            "tr",
            "tour",
            "tours",
            "r",
            "rot",
            "回転",
            "圈",
            "转",
            "回",
        ],
        ANGLE,
        TURN,
    ),
    (&["cycle", "cycles"], ANGLE, TURN),
    (&["rpm", "回毎分"], ROTATION, TURN / 60.0),
    (&["krpm"], ROTATION, TURN / 0.06),
    (&["rps", "回毎秒"], ROTATION, TURN),
    (&["hertz"], ROTATION, TURN),
    (&["khz"], ROTATION, 1e3 * TURN),
    (&["dps"], ROTATION, DEGREE),
    (&["cdeg"], ANGLE, DEGREE / 100.0),
    (&["mdeg"], ANGLE, DEGREE / 1000.0),
    (&["meter", "meters", "metre", "metres", "mètre"], LENGTH, 1.0),
    (&["millimeter", "millimetre", "millimeters"], LENGTH, 1e-3),
    (&["in", "inch", "inches", "zoll"], LENGTH, INCH),
    (&["ft", "foot", "feet"], LENGTH, 12.0 * INCH),
    (&["sec", "secs", "second", "seconds", "sek", "sekunde", "sekunden", "seconde", "secondes", "秒"], TIME, 1.0),
    (&["msec", "millisecond", "milliseconds", "millisekunden", "ミリ秒", "毫秒"], TIME, 1e-3),
    (&["usec", "microsecond", "microseconds", "マイクロ秒"], TIME, 1e-6),
    (&["min", "minute", "minutes", "minuten", "分"], TIME, 60.0),
    (&["h", "hr", "hour", "hours", "stunde", "stunden", "時間"], TIME, 3600.0),
    (&["amp", "amps", "ampere", "amperes", "ampère", "ampères", "アンペア", "安培"], CURRENT, 1.0),
    (&["milliamp", "milliamps", "milliampere", "milliamperes"], CURRENT, 1e-3),
    (&["volt", "volts", "ボルト"], VOLTAGE, 1.0),
    (&["newton", "newtons"], FORCE, 1.0),
    (&["newtonmeter", "newtonmeters", "newtonmetre", "newton-meter"], TORQUE, 1.0),
    (&["lbf", "lb"], FORCE, POUND),
    (&["ozf", "oz"], FORCE, POUND / 16.0),
    (&["kgf", "kp"], FORCE, 9.806_65),
    (&["kelvin", "celsius", "fahrenheit"], TEMPERATURE, 1.0),
];

/// Products of a force and a length that are written as one word.
const TORQUES: [(&[&str], f64); 6] = [
    (&["nmm"], 1e-3),
    (&["ncm"], 1e-2),
    (&["ozin"], POUND / 16.0 * INCH),
    (&["lbfft", "ftlb", "ftlbf", "lbft"], POUND * 12.0 * INCH),
    (&["inlb", "lbin", "lbfin", "inlbf"], POUND * INCH),
    (&["kgfcm", "kgcm"], 9.806_65e-2),
];

/// A factor with its dimension.
#[derive(Clone, Copy)]
struct Part {
    dimension: Dimension,
    factor: f64,
    /// Whether it is minutes, by which a number is a speed of rotation.
    is_minute: bool,
}

/// The unit that is written so.
pub(super) fn parse(text: &str) -> Option<Unit> {
    let text = normal(text);
    let temperature = |offset: f64, factor: f64| Unit::new(Quantity::Temperature, factor, offset);
    match text.as_str() {
        "C" | "c" | "°C" | "degC" | "celsius" | "Celsius" | "Grad Celsius" | "deg C" | "℃" => {
            return Some(temperature(273.15, 1.0));
        }
        "F" | "°F" | "degF" | "fahrenheit" | "Fahrenheit" | "deg F" => {
            return Some(temperature(459.67 * 5.0 / 9.0, 5.0 / 9.0));
        }
        _ => {}
    }
    let Whole { part: Part { dimension, factor, is_minute }, is_number } = whole(&text, 0)?;
    if is_number || dimension == ANGLE_BY_TIME {
        return None;
    }
    let turns = if dimension == FREQUENCY && is_minute { TURN } else { 1.0 };
    let quantity = quantity(dimension).or((turns != 1.0).then_some(Quantity::AngularVelocity))?;
    let factor = factor * turns;
    (factor > 0.0 && factor.is_finite()).then_some(Unit::new(quantity, factor, 0.0))
}

/// Whether this is a product of known parts, of whatever quantity.
pub(super) fn is_written(text: &str) -> bool {
    parse(text).is_some() || whole(&normal(text), 0).is_some_and(|whole| !whole.is_number)
}

/// A product, and whether it is a number alone.
struct Whole {
    part: Part,
    is_number: bool,
}

/// The product of the parts of a text within so many brackets.
fn whole(text: &str, depth: u8) -> Option<Whole> {
    /// Brackets in brackets.
    const DEEPEST: u8 = 2;
    let mut all: Option<Whole> = None;
    let (mut rest, mut divides) = (text, false);
    while !rest.is_empty() {
        let (own, behind) = match rest.strip_prefix('(') {
            Some(open) if depth < DEEPEST => {
                let (inner, behind) = open.split_once(')')?;
                (whole(inner.trim(), depth + 1)?, behind)
            }
            _ => {
                let (word, behind) = first(rest);
                // In a product a small letter is an abbreviation rather than a unit: n.a.
                if matches!(word, "a" | "v" | "n" | "k" | "c") && word.len() < text.len() {
                    return None;
                }
                let (part, is_number) = part(word)?;
                (Whole { part, is_number }, behind)
            }
        };
        let is_number = own.is_number && all.as_ref().is_none_or(|all| all.is_number);
        all = Some(Whole { part: joined(all.map(|all| all.part), own.part, divides), is_number });
        (rest, divides) = operator(behind)?;
    }
    all.filter(|_| !divides)
}

/// One spelling of signs that are written in several ways.
fn normal(text: &str) -> String {
    // An abbreviation ends with a point, or has one behind each letter: sec., r.p.m.
    let text = text.trim();
    let short = text.replace('.', "");
    let is_abbreviated = text.ends_with('.') && symbol(&short).is_some();
    let text = if is_abbreviated { short.as_str() } else { text.strip_suffix('.').unwrap_or(text) };
    let mut normal = String::new();
    let mut rest = text.chars().peekable();
    while let Some(c) = rest.next() {
        match c {
            '{' | '}' => {}
            '-' if normal.ends_with(char::is_alphabetic) && rest.peek().is_some_and(|c| c.is_alphabetic()) => {
                normal.push('*');
            }
            '−' => normal.push('-'),
            'µ' | 'μ' => normal.push('u'),
            '⁻' => normal.push('-'),
            '¹' => normal.push('1'),
            '²' => normal.push('2'),
            '³' => normal.push('3'),
            '·' | '∙' | '⋅' | '×' => normal.push('*'),
            '.' if !normal.ends_with(|c: char| c.is_ascii_digit()) => normal.push('*'),
            ',' => normal.push('.'),
            'º' => normal.push('°'),
            '÷' | '／' => normal.push('/'),
            '\u{2126}' => normal.push('Ω'),
            '\u{a0}' | '\u{202f}' => normal.push(' '),
            c => normal.push(c),
        }
    }
    normal.replace("**", "^")
}

/// The first part and what follows.
fn first(text: &str) -> (&str, &str) {
    let is_end = |c: char| matches!(c, '/' | '*' | ' ' | '(' | ')');
    // A number and a symbol may stand together: 0.1A. An exponent of ten belongs to the number.
    let digits = text.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(text.len());
    if digits > 0 {
        let power = text[digits..].strip_prefix(['e', 'E']).map(|rest| {
            let sign = usize::from(rest.starts_with(['+', '-']));
            sign + rest[sign..].find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len() - sign)
        });
        let end = digits + power.filter(|length| *length > 0).map_or(0, |length| 1 + length);
        return text.split_at(end);
    }
    text.split_at(text.find(is_end).unwrap_or(text.len()))
}

/// Whether the next part divides, and that part; `None` if nothing joins them.
fn operator(rest: &str) -> Option<(&str, bool)> {
    let trimmed = rest.trim_start();
    if let Some(next) = trimmed.strip_prefix('/') {
        return Some((next.trim_start(), true));
    }
    let word = ["per ", "pro ", "je ", "par "].iter().find_map(|word| trimmed.strip_prefix(word));
    match word {
        Some(next) => Some((next.trim_start(), true)),
        None => {
            let next = trimmed.trim_start_matches('*').trim_start();
            (trimmed.is_empty() || !next.is_empty()).then_some((next, false))
        }
    }
}

/// The product or the quotient.
fn joined(whole: Option<Part>, part: Part, divides: bool) -> Part {
    let Some(whole) = whole else { return part };
    let (sign, factor) = if divides { (-1, 1.0 / part.factor) } else { (1, part.factor) };
    let dimension = std::array::from_fn(|k| whole.dimension[k] + sign * part.dimension[k]);
    Part { dimension, factor: whole.factor * factor, is_minute: whole.is_minute || part.is_minute }
}

/// A number, or a symbol or word with its exponent; whether it is a number.
fn part(text: &str) -> Option<(Part, bool)> {
    if let Ok(factor) = text.parse::<f64>() {
        return Some((Part { dimension: NUMBER, factor, is_minute: false }, true));
    }
    let at = text.char_indices().rfind(|(_, c)| !(c.is_ascii_digit() || matches!(c, '-' | '^' | '+')));
    let end = at.map_or(0, |(at, c)| at + c.len_utf8());
    let (name, power) = text.split_at(end);
    let power: i8 = if power.is_empty() { 1 } else { power.trim_start_matches('^').parse().ok()? };
    if !(1..=4).contains(&power.unsigned_abs()) {
        return None;
    }
    let (base, factor) = symbol(name)?;
    let dimension = base.map(|exponent| exponent * power);
    Some((Part { dimension, factor: factor.powi(i32::from(power)), is_minute: base == TIME && factor == 60.0 }, false))
}

/// The dimension and factor of a symbol or a word.
fn symbol(name: &str) -> Option<(Dimension, f64)> {
    let of = |list: &[(&str, Dimension, f64)]| {
        list.iter().find(|(own, ..)| *own == name).map(|(_, dimension, factor)| (*dimension, *factor))
    };
    if let Some(found) = of(&SYMBOLS).or_else(|| of(&AS_WRITTEN)) {
        return Some(found);
    }
    let lower = name.to_lowercase();
    let word = WORDS.iter().find(|(names, ..)| names.contains(&lower.as_str()));
    if let Some((_, dimension, factor)) = word {
        return Some((*dimension, *factor));
    }
    if let Some((_, factor)) = TORQUES.iter().find(|(names, _)| names.contains(&lower.as_str())) {
        return Some((TORQUE, *factor));
    }
    let prefixed = |(prefix, power): &(&str, f64)| {
        let rest = name.strip_prefix(prefix)?;
        let (_, dimension, factor) = SYMBOLS.iter().find(|(own, ..)| *own == rest)?;
        Some((*dimension, factor * power))
    };
    PREFIXES.iter().find_map(prefixed)
}

/// The quantity of a dimension.
fn quantity(dimension: Dimension) -> Option<Quantity> {
    Some(match dimension {
        ANGLE => Quantity::Angle,
        ROTATION => Quantity::AngularVelocity,
        LENGTH => Quantity::Length,
        SPEED => Quantity::Velocity,
        CURRENT => Quantity::Current,
        VOLTAGE => Quantity::Voltage,
        TORQUE => Quantity::Torque,
        FORCE => Quantity::Force,
        TEMPERATURE => Quantity::Temperature,
        TIME => Quantity::Time,
        FREQUENCY | NUMBER => return None,
        _ => Quantity::Other,
    })
}

#[cfg(test)]
mod tests;
