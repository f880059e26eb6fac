//! Units of channels: by the name of a column, and as they are written.
//!
//! | module | content |
//! |---|---|
//! | `grammar` | a unit as it is written: prefixes, factors, products, words of several languages |
//! | `column` | where the name of a column has its unit |
//! | `unit` | what is measured, and conversions |

mod column;
mod grammar;
mod unit;

pub(crate) use column::stated;
pub use unit::{Quantity, Unit};

/// Usual names, as messages list them.
const USUAL: [&str; 29] = [
    "rad", "mrad", "deg", "turn", "rad/s", "deg/s", "rpm", "turn/s", "m", "mm", "um", "in", "m/s", "mm/s", "A", "mA",
    "V", "mV", "Nm", "mNm", "N", "kN", "lbf", "K", "C", "F", "s", "ms", "us",
];

impl Unit {
    /// The unit that is written so, such as `rpm`, `0.1 A`, `turn/4096`.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        grammar::parse(name)
    }

    /// Whether a text is written as a unit is, of whatever it is one: also `rad.s` and `1/s`.
    pub(crate) fn is_written(text: &str) -> bool {
        grammar::is_written(text)
    }

    /// The unit that the name of a column has: `speed_rpm`, `speed [rpm]`, `speed in rpm`.
    #[must_use]
    pub fn of_column(name: &str) -> Option<Self> {
        column::of(name)
    }

    /// The unit that a formula is converted to: `speed_rpm rad/s`, `(speed_rpm)rad/s`.
    #[must_use]
    pub fn of_formula(formula: &str) -> Option<Self> {
        formula.rsplit_once([' ', ')']).and_then(|(_, unit)| Self::named(unit))
    }

    /// Its usual name.
    #[must_use]
    pub fn name(&self) -> &'static str {
        USUAL.iter().find(|name| Self::named(name).as_ref() == Some(self)).copied().unwrap_or_default()
    }
}

/// The usual names, for messages.
#[must_use]
pub fn known() -> String {
    format!("{}, and factors, products and quotients of them", USUAL.join(", "))
}

#[cfg(test)]
mod tests {
    use super::unit::TURN;
    use super::*;
    use Quantity::{Angle, Length};

    #[test]
    fn conversions_have_factor_and_offset() {
        let convert = |from: &str, to: &str, x: f64| {
            let (factor, offset) = Unit::named(from).expect(from).to(&Unit::named(to).expect(to))?;
            Some(factor * x + offset)
        };
        // Rounding of one multiplication and one addition.
        let near =
            |found: Option<f64>, expected: f64| found.is_some_and(|x| (x - expected).abs() < 1e-9 * expected.abs());
        assert!(near(convert("rpm", "rad/s", 60.0), TURN) && near(convert("rad", "deg", TURN), 360.0));
        assert!(near(convert("F", "C", 212.0), 100.0) && near(convert("C", "K", 20.0), 293.15));
        assert!(near(convert("lbf", "N", 3700.0), 16_458.419_975_5) && convert("rpm", "rad", 1.0).is_none());
    }

    #[test]
    fn integrals_of_velocities_are_angle_and_travel() {
        for (of, integral) in [("rpm", None), ("turn/s", Some("turn")), ("mm/s", Some("mm")), ("m/s", Some("m"))] {
            let found = Unit::named(of).expect(of).integral().expect("a quantity of its own");
            assert!(integral.is_none_or(|name| Unit::named(name) == Some(found)), "{of}: {found:?}");
            assert!(matches!(found.quantity, Angle | Length), "{of}");
        }
        assert!(["A", "m", "Nm"].iter().all(|name| Unit::named(name).expect(name).integral().is_none()));
    }
}
