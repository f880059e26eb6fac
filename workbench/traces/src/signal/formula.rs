//! How a signal follows from columns: sums, multiples, integrals, and angles without their wraps.

use std::collections::BTreeMap;

use model::audit::signs::Signs;

/// The time from one row to another, s.
pub(crate) type Elapsed<'a> = &'a dyn Fn(usize, usize) -> f64;

/// How a channel follows from columns, which have places.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Signal {
    Column(usize),
    Constant(f64),
    /// factor · signal + offset.
    Scaled(f64, f64, Box<Self>),
    Sum(Box<Self>, Box<Self>),
    Integral(Box<Self>),
    /// Without jumps by whole multiples of a period.
    Unwrapped(f64, Box<Self>),
    /// Signed numbers that are written without their sign.
    Signed(Signs, Box<Self>),
}

impl Signal {
    /// What it is made of.
    fn parts(&self) -> Vec<&Self> {
        match self {
            Self::Column(_) | Self::Constant(_) => vec![],
            Self::Scaled(_, _, own) | Self::Integral(own) | Self::Unwrapped(_, own) | Self::Signed(_, own) => vec![own],
            Self::Sum(one, other) => vec![one, other],
        }
    }

    /// The places of its columns.
    fn columns(&self, found: &mut Vec<usize>) {
        if let Self::Column(place) = self {
            found.push(*place);
        }
        self.parts().into_iter().for_each(|part| part.columns(found));
    }

    /// The places of columns whose values are taken as they are written, signs and turns among them.
    pub(crate) fn plain_columns(&self, found: &mut Vec<usize>) {
        match self {
            Self::Column(place) => found.push(*place),
            Self::Signed(..) | Self::Unwrapped(..) => {}
            other => other.parts().into_iter().for_each(|part| part.plain_columns(found)),
        }
    }

    /// Whether it takes an integral over time.
    pub(crate) fn integrates(&self) -> bool {
        matches!(self, Self::Integral(_)) || self.parts().into_iter().any(Self::integrates)
    }

    /// The same signal of columns at other places.
    pub(crate) fn at(&self, place: &mut impl FnMut(usize) -> usize) -> Self {
        match self {
            Self::Column(own) => Self::Column(place(*own)),
            Self::Constant(value) => Self::Constant(*value),
            Self::Scaled(factor, offset, own) => Self::Scaled(*factor, *offset, Box::new(own.at(place))),
            Self::Integral(own) => Self::Integral(Box::new(own.at(place))),
            Self::Unwrapped(period, own) => Self::Unwrapped(*period, Box::new(own.at(place))),
            Self::Signed(signs, own) => Self::Signed(*signs, Box::new(own.at(place))),
            Self::Sum(one, other) => Self::Sum(Box::new(one.at(place)), Box::new(other.at(place))),
        }
    }

    /// The values, `rows` of them, by the columns and the time from one row to another one. A missing value is NaN.
    pub(crate) fn values<'c>(
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
            Self::Signed(signs, own) => {
                own.values(rows, column, elapsed_s).into_iter().map(|x| signs.decoded(x)).collect()
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
pub(crate) fn places_of(signals: &[Signal]) -> Vec<usize> {
    let mut places = Vec::new();
    signals.iter().for_each(|signal| signal.columns(&mut places));
    places
}

/// The values of signals, `rows` of each, by columns at their places. A column that is a signal itself, and that
/// nothing else needs, is moved.
pub(crate) fn values_of(
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
