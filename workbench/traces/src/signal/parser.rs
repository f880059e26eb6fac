//! The text of a channel as a signal with its unit.

use std::f64::consts::TAU;

use super::formula::Signal;
use crate::units::{Quantity, Unit, known};
use model::audit::signs::Signs;
use model::near::{among, list};
use model::trace::composed;

/// The signal of a text with its unit, by the names of the columns.
///
/// # Errors
/// What is wrong, for a message.
pub(super) fn parsed(text: &str, names: &[String]) -> Result<Found, String> {
    let text = &*composed(text);
    if let Some(place) = place(names, text.trim()) {
        return Ok((Signal::Column(place), Unit::of_column(text)));
    }
    Parser { text, rest: text, names }.whole(true)
}

/// Says that there is no such column.
pub(crate) fn missing(name: &str, names: &[String]) -> String {
    let asked = name.split_once('?').and_then(|(start, rest)| Some((start, rest.split('?').next()?)));
    let fits = |(start, end): (&str, &str)| {
        let behind = |own: &&String| own.strip_prefix(start).is_some_and(|rest| rest.contains(end));
        names.iter().filter(behind).cloned().collect::<Vec<_>>()
    };
    if let Some(columns) = asked.map(fits).filter(|columns| !columns.is_empty()) {
        return format!("{name} is a question: write a column of the motor with the bearing: {}", list(&columns));
    }
    format!("no column (or difference of columns) {name}{}", among(name, names))
}

fn place(names: &[String], name: &str) -> Option<usize> {
    names.iter().position(|column| column == name)
}

fn scaled(factor: f64, signal: Signal) -> Signal {
    match signal {
        Signal::Constant(value) => Signal::Constant(factor * value),
        other => Signal::Scaled(factor, 0.0, Box::new(other)),
    }
}

/// Whether a text is a number without sign, or the start of one with an exponent.
fn is_number(text: &str) -> bool {
    let plain = text.trim_end_matches(['+', '-']).trim_end_matches(['e', 'E']);
    text.starts_with(|c: char| c.is_ascii_digit() || c == '.') && (plain == "." || plain.parse::<f64>().is_ok())
}

struct Parser<'a> {
    text: &'a str,
    rest: &'a str,
    names: &'a [String],
}

type Found = (Signal, Option<Unit>);

/// What opens a bracket, and what is made of its content.
type Bracket = (&'static str, fn(&Parser<'_>, Found) -> Result<Found, String>);
const BRACKETS: [Bracket; 3] = [
    ("integrate(", |_, (signal, unit)| Ok((Signal::Integral(Box::new(signal)), unit.and_then(|unit| unit.integral())))),
    ("unwrap(", |parser, content| parser.unwrapped(content)),
    ("(", |_, content| Ok(content)),
];

impl Parser<'_> {
    fn wrong(&self, problem: &str) -> String {
        format!("channel {}: {problem}", self.text)
    }

    fn skip(&mut self) {
        self.rest = self.rest.trim_start();
    }

    fn take(&mut self, mark: char) -> bool {
        self.skip();
        let found = self.rest.strip_prefix(mark);
        self.rest = found.unwrap_or(self.rest);
        found.is_some()
    }

    /// A sum and its unit, up to the end or to a bracket.
    fn whole(&mut self, to_end: bool) -> Result<Found, String> {
        let negative = self.take('-');
        let (mut sum, mut unit) = self.product()?;
        if negative {
            sum = scaled(-1.0, sum);
        }
        loop {
            let minus = if self.take('+') {
                false
            } else if self.take('-') {
                true
            } else {
                break;
            };
            let (other, other_unit) = self.product()?;
            let factor = unit.zip(other_unit).and_then(|(one, other)| one.to(&other));
            if factor.is_some_and(|factor| factor != (1.0, 0.0)) {
                return Err(self.wrong("the two columns have different units; convert one, e.g. (speed_rpm rad/s)"));
            }
            let other = if minus { scaled(-1.0, other) } else { other };
            (sum, unit) = (Signal::Sum(Box::new(sum), Box::new(other)), unit.or(other_unit));
        }
        self.skip();
        let end = if to_end { self.rest.len() } else { self.rest.find(')').unwrap_or(self.rest.len()) };
        let (name, rest) = self.rest.split_at(end);
        self.rest = rest;
        if name.trim().is_empty() { Ok((sum, unit)) } else { self.convert((sum, unit), name.trim()) }
    }

    fn convert(&self, (signal, unit): Found, name: &str) -> Result<Found, String> {
        let wanted =
            Unit::named(name).ok_or_else(|| self.wrong(&format!("\"{name}\" is no unit; there are {}", known())))?;
        let own = unit.ok_or_else(|| {
            self.wrong(&format!(
                "the column has no unit in its name to convert to {name}; multiply by a number instead"
            ))
        })?;
        let (factor, offset) = own.to(&wanted).ok_or_else(|| self.wrong(&format!("the column cannot be in {name}")))?;
        Ok((Signal::Scaled(factor, offset, Box::new(signal)), Some(wanted)))
    }

    /// Factors of which one at most has columns.
    fn product(&mut self) -> Result<Found, String> {
        let (mut signal, mut unit) = self.factor()?;
        loop {
            let divide = if self.take('*') {
                false
            } else if self.take('/') {
                true
            } else {
                return Ok((signal, unit));
            };
            self.skip();
            if self.rest.starts_with('?') {
                return Err(self.wrong("the number is a question: write the pole pairs of the motor in the place of ?"));
            }
            let (other, other_unit) = self.factor()?;
            (signal, unit) = match (signal, other) {
                (one, Signal::Constant(value)) if divide => (scaled(1.0 / value, one), unit.filter(|_| value == 1.0)),
                (one, Signal::Constant(value)) => (scaled(value, one), None),
                (Signal::Constant(value), one) if !divide => (scaled(value, one), other_unit.filter(|_| value == 1.0)),
                _ => return Err(self.wrong("only products with a number and quotients by one are possible")),
            };
        }
    }

    fn factor(&mut self) -> Result<Found, String> {
        self.skip();
        if let Some(length) = self.name() {
            let (name, rest) = self.rest.split_at(length);
            self.rest = rest;
            let place = place(self.names, name).unwrap_or(0);
            let unit = self.stated()?.or_else(|| Unit::of_column(name));
            return Ok((Signal::Column(place), unit));
        }
        for (start, of) in BRACKETS {
            if let Some(rest) = self.rest.strip_prefix(start) {
                self.rest = rest;
                return self.bracket(&of);
            }
        }
        let signs = self.rest.split_once('(').and_then(|(word, rest)| Some((Signs::of_word(word)?, rest)));
        if let Some((signs, rest)) = signs {
            self.rest = rest;
            return self.bracket(&|_, (signal, unit)| Ok((Signal::Signed(signs, Box::new(signal)), unit)));
        }
        let ends = |at: &usize| self.rest.is_char_boundary(*at);
        let begins = (1..=self.rest.len()).filter(ends).take_while(|at| is_number(&self.rest[..*at]));
        if let Some((at, value)) = begins.filter_map(|at| Some((at, self.rest[..at].parse().ok()?))).last() {
            self.rest = &self.rest[at..];
            return Ok((Signal::Constant(value), None));
        }
        let end = self.rest.find([' ', '+', '*', ')', '(']).unwrap_or(self.rest.len());
        let word = &self.rest[..end];
        Err(missing(if word.is_empty() || self.text.contains('-') { self.text } else { word }, self.names))
    }

    /// What is made of the content of a bracket that is open, in the unit behind it.
    fn bracket(&mut self, of: &dyn Fn(&Self, Found) -> Result<Found, String>) -> Result<Found, String> {
        let whole = self.whole(false)?;
        if !self.take(')') {
            return Err(self.wrong("a bracket is not closed"));
        }
        let found = of(self, whole)?;
        let Some(length) = self.unit() else { return Ok(found) };
        let (name, rest) = self.rest.split_at(length);
        self.rest = rest;
        self.convert(found, name.trim())
    }

    /// The unit that is stated in brackets behind a column.
    fn stated(&mut self) -> Result<Option<Unit>, String> {
        let Some((name, rest)) = self.rest.strip_prefix('[').and_then(|rest| rest.split_once(']')) else {
            return Ok(None);
        };
        if name.contains('?') {
            return Err(self.wrong("the unit is a question: write it in the place of ?, such as [rad], [turn], [rpm]"));
        }
        let unit =
            Unit::named(name).ok_or_else(|| self.wrong(&format!("\"{name}\" is no unit; there are {}", known())))?;
        self.rest = rest;
        Ok(Some(unit))
    }

    /// Without jumps by whole turns.
    fn unwrapped(&self, (signal, unit): Found) -> Result<Found, String> {
        let unit = unit.filter(|unit| unit.quantity == Quantity::Angle);
        let unit = unit.ok_or_else(|| self.wrong("unwrap takes an angle with its unit, such as unwrap(theta[rad])"))?;
        Ok((Signal::Unwrapped(TAU / unit.to_base().0, Box::new(signal)), Some(unit)))
    }

    /// Length of the unit behind a bracket.
    fn unit(&self) -> Option<usize> {
        let start = self.rest.len() - self.rest.trim_start().len();
        let ends = |at: &usize| {
            let next = self.rest.get(*at..).map(|rest| rest.chars().next());
            next.is_some_and(|next| next.is_none_or(|c| matches!(c, ' ' | '+' | '-' | '*' | ')')))
        };
        let is_unit = |at: &usize| self.rest.get(start..*at).is_some_and(|name| Unit::named(name).is_some());
        (start + 1..=self.rest.len()).rev().filter(ends).find(is_unit)
    }

    /// Length of the longest name of a column that the rest begins with.
    fn name(&self) -> Option<usize> {
        let ends = |name: &&String| {
            let next = self.rest[name.len()..].chars().next();
            let joins = |c: char| c.is_alphanumeric() || matches!(c, '_' | '.' | '(');
            !(next.is_some_and(joins) && name.ends_with(|c: char| joins(c)))
        };
        let own = self.names.iter().filter(|name| !name.is_empty() && self.rest.starts_with(name.as_str()));
        own.filter(ends).map(String::len).max()
    }
}
