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
//! signed16(speed_rpm)           numbers of 16 bits in two's complement that are written without their sign
//! magnitude16(speed_rpm)        the same, whose highest bit is the sign
//! ```
//!
//! A question mark in the place of a unit or a number, as `init` writes it, is an error that repeats the question. The
//! signals of a shaft are converted to rad, rad/s and A by their units.
//!
//! A value is missing where one of its columns is. An integral goes on behind missing values with the mean of those at
//! both sides of them, as between any two samples.

mod formula;
mod parser;
pub(crate) mod signs;

pub(crate) use formula::{Elapsed, Signal, places_of, values_of};
pub(crate) use parser::missing;

use crate::units::{Quantity, stated};
use parser::parsed;

/// A signal of a shaft.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
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
    pub(crate) fn parse(text: &str, names: &[String]) -> Result<Self, String> {
        Ok(parsed(text, names)?.0)
    }

    /// Parses a signal of a shaft; one in another unit than its base unit is converted.
    ///
    /// # Errors
    /// What is wrong, for a message; a unit in brackets of another quantity.
    pub(crate) fn of_role(text: &str, names: &[String], role: Role) -> Result<Self, String> {
        let (signal, unit) = parsed(text, names)?;
        let Some(unit) = unit else { return Ok(signal) };
        if role.quantities().contains(&unit.quantity) {
            let (factor, offset) = unit.to_base();
            let is_base = (factor, offset) == (1.0, 0.0);
            return Ok(if is_base { signal } else { Self::Scaled(factor, offset, Box::new(signal)) });
        }
        // A single letter at the end of a name need not be a unit.
        match stated(text) {
            Some(unit) => {
                let of = format!("{role:?}").to_lowercase();
                Err(format!("channel {text}: {unit} is no unit of the {of}"))
            }
            None => Ok(signal),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

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
            ("signed8(50*load)", [-56.0, 1744.0]),
            ("magnitude8(50*load)/2", [-36.0, -936.0]),
            ("(signed8(speed_rpm)) rad/s", [0.209_439_510_239_319_53, 2.094_395_102_393_195_3]),
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
