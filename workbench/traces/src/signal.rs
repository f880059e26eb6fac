//! A channel: a column, or sums, differences, multiples and integrals of columns.
//!
//! ```text
//! current_a                     a column
//! velocity_ref-velocity         a difference; a column whose name contains the dash goes first
//! iq1_A + iq2_A                 a sum
//! 0.5*(a + b), force/1000       multiples
//! speed_rpm rad/s               another unit than the one at the end of the column's name
//! position[turn]                the unit of a column whose name has none, or another one
//! integrate(speed_rpm) rad      the integral over time, from 0 at the first sample on
//! unwrap(theta_e[rad])/7        an angle without its jumps by whole turns: of an electrical one over the pole pairs
//! ```
//!
//! A question mark in the place of a unit or a number, as `init` writes it, is an error that repeats the question. The
//! signals of a shaft are converted to rad, rad/s and A by their units.
//!
//! A value is missing where one of its columns is. An integral goes on behind missing values with the mean of those at
//! both sides of them, as between any two samples.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use crate::units::{Quantity, Unit, known, stated};
use model::near::among;
use model::trace::composed;

/// The time from one row to another, s.
pub(super) type Elapsed<'a> = &'a dyn Fn(usize, usize) -> f64;

/// How a channel follows from columns, which have places.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Signal {
    Column(usize),
    Constant(f64),
    /// factor · signal + offset.
    Scaled(f64, f64, Box<Self>),
    Sum(Box<Self>, Box<Self>),
    Integral(Box<Self>),
    /// Without jumps by whole multiples of a period.
    Unwrapped(f64, Box<Self>),
}

/// A signal of a shaft.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    Current,
    Angle,
    Velocity,
    Load,
}

impl Role {
    /// What it may be, in whose base unit it is taken.
    const fn quantities(self) -> &'static [Quantity] {
        match self {
            Self::Current => &[Quantity::Current],
            Self::Angle => &[Quantity::Angle],
            Self::Velocity => &[Quantity::AngularVelocity],
            Self::Load => &[Quantity::Torque, Quantity::Force],
        }
    }
}

impl Signal {
    /// Parses a channel by the names of the columns.
    ///
    /// # Errors
    /// What is wrong, for a message.
    pub(super) fn parse(text: &str, names: &[String]) -> Result<Self, String> {
        Ok(Self::with_unit(text, names)?.0)
    }

    /// Parses a signal of a shaft; one in another unit than its base unit is converted.
    ///
    /// # Errors
    /// What is wrong, for a message; a unit in brackets of another quantity.
    pub(super) fn of_role(text: &str, names: &[String], role: Role) -> Result<Self, String> {
        let (signal, unit) = Self::with_unit(text, names)?;
        let Some(unit) = unit else { return Ok(signal) };
        if role.quantities().contains(&unit.quantity) {
            let (factor, offset) = unit.to_base();
            let is_base = (factor, offset) == (1.0, 0.0);
            return Ok(if is_base { signal } else { Self::Scaled(factor, offset, Box::new(signal)) });
        }
        // A single letter at the end of a name need not be a unit.
        match stated(text) {
            Some(unit) => Err(format!("channel {text}: {unit} is no unit of the {role:?}").to_lowercase()),
            None => Ok(signal),
        }
    }

    fn with_unit(text: &str, names: &[String]) -> Result<Found, String> {
        let text = &*composed(text);
        if let Some(place) = place(names, text.trim()) {
            return Ok((Self::Column(place), Unit::of_column(text)));
        }
        Parser { text, rest: text, names }.whole(true)
    }

    /// The places of its columns.
    fn columns(&self, found: &mut Vec<usize>) {
        match self {
            Self::Column(place) => found.push(*place),
            Self::Constant(_) => {}
            Self::Scaled(_, _, own) | Self::Integral(own) | Self::Unwrapped(_, own) => own.columns(found),
            Self::Sum(one, other) => {
                one.columns(found);
                other.columns(found);
            }
        }
    }

    /// Whether it takes an integral over time.
    pub(super) fn integrates(&self) -> bool {
        match self {
            Self::Column(_) | Self::Constant(_) => false,
            Self::Integral(_) => true,
            Self::Scaled(_, _, own) | Self::Unwrapped(_, own) => own.integrates(),
            Self::Sum(one, other) => one.integrates() || other.integrates(),
        }
    }

    /// The same signal of columns at other places.
    pub(super) fn at(&self, place: &mut impl FnMut(usize) -> usize) -> Self {
        match self {
            Self::Column(own) => Self::Column(place(*own)),
            Self::Constant(value) => Self::Constant(*value),
            Self::Scaled(factor, offset, own) => Self::Scaled(*factor, *offset, Box::new(own.at(place))),
            Self::Integral(own) => Self::Integral(Box::new(own.at(place))),
            Self::Unwrapped(period, own) => Self::Unwrapped(*period, Box::new(own.at(place))),
            Self::Sum(one, other) => Self::Sum(Box::new(one.at(place)), Box::new(other.at(place))),
        }
    }

    /// The values, `rows` of them, by the columns and the time from one row to another one. A missing value is NaN.
    pub(super) fn values<'c>(
        &self,
        rows: usize,
        column: &dyn Fn(usize) -> &'c [f64],
        elapsed_s: Elapsed<'_>,
    ) -> Vec<f64> {
        match self {
            Self::Column(place) => column(*place).to_vec(),
            Self::Constant(value) => vec![*value; rows],
            Self::Scaled(factor, offset, own) => {
                own.values(rows, column, elapsed_s).into_iter().map(|x| factor * x + offset).collect()
            }
            Self::Sum(one, other) => {
                let other = other.values(rows, column, elapsed_s);
                one.values(rows, column, elapsed_s).into_iter().zip(other).map(|(a, b)| a + b).collect()
            }
            Self::Integral(own) => {
                let own = own.values(rows, column, elapsed_s);
                let (mut sum, mut last): (f64, Option<usize>) = (0.0, None);
                // The trapezoidal rule, from one value to the next one that is not missing.
                let each = |row: usize| {
                    let passed_s = last.map_or(0.0, |last| elapsed_s(last, row));
                    if !(own[row].is_finite() && passed_s.is_finite()) {
                        return f64::NAN;
                    }
                    if let Some(last) = last.replace(row) {
                        sum += 0.5 * (own[last] + own[row]) * passed_s;
                    }
                    sum
                };
                (0..own.len()).map(each).collect()
            }
            Self::Unwrapped(period, own) => {
                let (mut turns, mut last) = (0.0, f64::NAN);
                let each = |value: f64| {
                    let jump = ((value - last) / period).round();
                    if value.is_finite() {
                        last = value;
                    }
                    turns -= if jump.is_finite() { jump } else { 0.0 };
                    value + turns * period
                };
                own.values(rows, column, elapsed_s).into_iter().map(each).collect()
            }
        }
    }
}

/// The places of the columns of signals, each as often as it is needed.
pub(super) fn places_of(signals: &[Signal]) -> Vec<usize> {
    let mut places = Vec::new();
    signals.iter().for_each(|signal| signal.columns(&mut places));
    places
}

/// The values of signals, `rows` of each, by columns at their places. A column that is a signal itself, and that
/// nothing else needs, is moved.
pub(super) fn values_of(
    signals: &[Signal],
    mut columns: BTreeMap<usize, Vec<f64>>,
    rows: usize,
    elapsed_s: Elapsed<'_>,
) -> Vec<Vec<f64>> {
    let mut counts: BTreeMap<usize, usize> = BTreeMap::new();
    places_of(signals).into_iter().for_each(|place| *counts.entry(place).or_default() += 1);
    let once = |place: &usize| counts[place] == 1;
    let of = |signal: &Signal| match signal {
        Signal::Column(place) if once(place) => columns.remove(place).unwrap_or_default(),
        _ => signal.values(rows, &|place| &columns[&place], elapsed_s),
    };
    signals.iter().map(of).collect()
}

/// Says that there is no such column.
pub(super) fn missing(name: &str, names: &[String]) -> String {
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
            let Some(rest) = self.rest.strip_prefix(start) else { continue };
            self.rest = rest;
            let whole = self.whole(false)?;
            if !self.take(')') {
                return Err(self.wrong("a bracket is not closed"));
            }
            let found = of(self, whole)?;
            let Some(length) = self.unit() else { return Ok(found) };
            let (name, rest) = self.rest.split_at(length);
            self.rest = rest;
            return self.convert(found, name.trim());
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

#[cfg(test)]
mod tests {
    use super::*;

    fn names() -> Vec<String> {
        ["i", "speed_rpm", "load-cell", "load", "cell", "iq1_A", "iq2_A", "pos [mm]", "2f", "v_mm_s"]
            .map(String::from)
            .into()
    }

    fn value(text: &str) -> Result<Vec<f64>, String> {
        let names = names();
        let columns: Vec<Vec<f64>> = (0..names.len()).map(|k| vec![k as f64 + 1.0, 10.0 * (k as f64 + 1.0)]).collect();
        let signal = Signal::parse(text, &names)?;
        Ok(signal.values(2, &|place| &columns[place], &|from, to| 0.5 * (to - from) as f64))
    }

    #[test]
    fn sums_multiples_integrals_and_units() {
        for (text, expected) in [
            ("i", [1.0, 10.0]),
            ("load-cell", [3.0, 30.0]),
            ("load - cell", [-1.0, -10.0]),
            ("load -cell", [-1.0, -10.0]),
            ("iq1_A + iq2_A", [13.0, 130.0]),
            ("-i", [-1.0, -10.0]),
            ("2*i+1", [3.0, 21.0]),
            ("0.5*(iq1_A + iq2_A)/2", [3.25, 32.5]),
            ("i*1e-3", [0.001, 0.01]),
            ("2f", [9.0, 90.0]),
            ("integrate(i)", [0.0, 2.75]),
            ("integrate(v_mm_s) m", [0.0, 0.0275]),
            ("pos [mm] m", [0.008, 0.08]),
            ("(pos [mm] m) - 1", [-0.992, -0.92]),
            ("(speed_rpm)rad/s-(speed_rpm)rad/s", [0.0, 0.0]),
            ("(speed_rpm)rad/s - 2*(speed_rpm) rad/s", [-0.209_439_510_239_319_53, -2.094_395_102_393_195_3]),
            ("speed_rpm rad/s", [0.209_439_510_239_319_53, 2.094_395_102_393_195_3]),
            ("integrate(speed_rpm) turn", [0.0, 11.0 / 120.0]),
            ("i[mA] A", [0.001, 0.01]),
            ("load[turn] deg", [1440.0, 14_400.0]),
            ("unwrap(load[deg])/2", [2.0, 20.0]),
            ("unwrap((load[turn]) deg)", [1440.0, 1440.0]),
        ] {
            let found = value(text).expect(text);
            let near = found.iter().zip(expected).all(|(one, other)| (one - other).abs() < 1e-12);
            assert!(near, "{text}: {found:?} for {expected:?}"); // rounding
        }
    }

    #[test]
    fn values_are_missing_where_a_column_is_and_integrals_go_on() {
        let names = ["v", "w"].map(String::from);
        let columns = [vec![f64::NAN, 1.0, f64::NAN, f64::NAN, 3.0, 5.0], vec![1.0, f64::NAN, 1.0, 1.0, 1.0, 1.0]];
        let of = |text: &str| {
            let signal = Signal::parse(text, &names).expect(text);
            let found = signal.values(6, &|place| &columns[place], &|from, to| (to - from) as f64);
            found.iter().map(|x| if x.is_nan() { -1.0 } else { *x }).collect::<Vec<_>>()
        };
        assert_eq!(of("integrate(v)"), [-1.0, 0.0, -1.0, -1.0, 6.0, 10.0]);
        assert_eq!(of("v + w"), [-1.0, -1.0, -1.0, -1.0, 4.0, 6.0]);
    }

    #[test]
    fn a_column_is_moved_only_if_nothing_else_needs_it() {
        let names = ["a", "b", "c"].map(String::from);
        let signals: Vec<Signal> =
            ["c", "a", "2*c", "b", "a"].iter().map(|text| Signal::parse(text, &names).expect(text)).collect();
        let columns = vec![vec![1.0], vec![2.0], vec![3.0]];
        let moved = columns[1].as_ptr();
        let values = values_of(&signals, columns.into_iter().enumerate().collect(), 1, &|_, _| 1.0);
        assert_eq!(values, [[3.0], [1.0], [6.0], [2.0], [1.0]]);
        assert_eq!(values[3].as_ptr(), moved);
    }

    #[test]
    fn wrong_channels_are_named() {
        for (text, problem) in [
            ("v", "no column (or difference of columns) v; there are i, speed_rpm"),
            ("i - nothing", "no column (or difference of columns) i - nothing"),
            ("i*load", "only products with a number"),
            ("(i", "a bracket is not closed"),
            ("i rad", "the column has no unit in its name"),
            ("speed_rpm Nm", "the column cannot be in Nm"),
            ("speed_rpm rqm", "\"rqm\" is no unit"),
            ("(speed_rpm rad/s) - speed_rpm", "different units"),
            ("load[?]", "the unit is a question"),
            ("unwrap(load[rad])/?", "the number is a question: write the pole pairs"),
            ("load[foo]", "\"foo\" is no unit"),
            ("unwrap(load)", "unwrap takes an angle with its unit"),
            // A letter at the end of a name need not be a unit.
            ("speed_rpm + iq1_A", ""),
        ] {
            match value(text) {
                Err(found) => assert!(found.contains(problem), "{text}: {found}"),
                Ok(found) => assert!(problem.is_empty(), "{text}: {found:?}"),
            }
        }
    }

    #[test]
    fn an_integral_takes_each_step_of_time() {
        let names = ["v".to_string()];
        let signal = Signal::parse("integrate(v)", &names).expect("a channel");
        let (column, steps) = ([1.0, 3.0, 5.0, 5.0], [0.1, 0.2, 0.4]);
        let found = signal.values(4, &|_| &column, &|row, next| steps[row..next].iter().sum());
        // Trapezia: 2 · 0.1, 4 · 0.2, 5 · 0.4.
        let near = found.iter().zip([0.0, 0.2, 1.0, 3.0]).all(|(one, other)| (one - other).abs() < 1e-12); // rounding
        assert!(near, "{found:?}");
    }

    #[test]
    fn signals_of_a_shaft_are_in_base_units() {
        let names = ["position", "theta_deg", "speed_rpm", "iq_mA", "i_s", "v [mm/s]"].map(String::from);
        let of = |text: &str, role: Role| {
            Signal::of_role(text, &names, role).map(|signal| signal.values(1, &|_| &[60.0], &|_, _| 1.0)[0])
        };
        for (text, role, expected) in [
            ("position", Role::Angle, 60.0),
            ("position[turn]", Role::Angle, 60.0 * TAU),
            ("theta_deg", Role::Angle, TAU / 6.0),
            ("theta_deg rad", Role::Angle, TAU / 6.0),
            ("speed_rpm", Role::Velocity, TAU),
            ("(speed_rpm)rad/s", Role::Velocity, TAU),
            ("iq_mA", Role::Current, 0.06),
            // Of a stator, not in seconds.
            ("i_s", Role::Current, 60.0),
        ] {
            let value = of(text, role).expect(text);
            assert!((value / expected - 1.0).abs() < 1e-12, "{text}: {value} for {expected}"); // rounding
        }
        let refused = of("v [mm/s]", Role::Velocity).expect_err("a length by time");
        assert!(refused.contains("mm/s is no unit of the velocity"), "{refused}");
    }

    #[test]
    fn an_angle_goes_on_over_its_wraps_and_missing_values() {
        let names = ["theta".to_string()];
        let column = [350.0, f64::NAN, 10.0, 170.0, 340.0, 5.0];
        let signal = Signal::parse("unwrap(theta[deg])/5", &names).expect("a channel");
        let values = signal.values(6, &|_| &column, &|_, _| 1.0);
        let expected = [70.0, f64::NAN, 74.0, 106.0, 140.0, 145.0];
        let near = |(one, other): (&f64, &f64)| (one - other).abs() < 1e-9 || one.is_nan() && other.is_nan(); // rounding
        assert!(values.iter().zip(&expected).all(near), "{values:?}");
    }

    #[test]
    fn units_that_differ_by_an_offset_alone_are_different() {
        let names = ["motor_degC", "air_K"].map(String::from);
        let problem = Signal::parse("motor_degC - air_K", &names).expect_err("an offset of 273.15");
        assert!(problem.contains("different units"), "{problem}");
        assert!(Signal::parse("(motor_degC K) - air_K", &names).is_ok());
    }
}
