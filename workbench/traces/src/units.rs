//! Units of channels: by the name of a column, and by name in a channel.

/// What is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Angle; base unit rad.
    Angle,
    /// Angular velocity; rad/s.
    AngularVelocity,
    /// Length; m.
    Length,
    /// Velocity; m/s.
    Velocity,
    /// Current; A.
    Current,
    /// Voltage; V.
    Voltage,
    /// Torque; N·m.
    Torque,
    /// Force; N.
    Force,
    /// Temperature; K.
    Temperature,
    /// Time; s.
    Time,
}

/// A unit: a value times `factor`, plus `offset`, is in the base unit of its quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// What is measured in it.
    pub quantity: Quantity,
    factor: f64,
    offset: f64,
}

const TURN: f64 = std::f64::consts::TAU;
const DEGREE: f64 = TURN / 360.0;

use Quantity::{Angle, AngularVelocity, Current, Force, Length, Temperature, Time, Torque, Velocity, Voltage};

/// Names, as they follow a number or an underscore, with quantity and factor.
const UNITS: [(&[&str], Quantity, f64); 34] = [
    (&["rad"], Angle, 1.0),
    (&["mrad"], Angle, 1e-3),
    (&["deg", "°"], Angle, DEGREE),
    (&["turn", "turns", "rev"], Angle, TURN),
    (&["rad/s", "rad_s"], AngularVelocity, 1.0),
    (&["deg/s", "deg_s", "°/s"], AngularVelocity, DEGREE),
    (
        &["rpm", "RPM", "1/min", "U/min", "r/min", "rev/min", "tr/min", "min-1", "min^-1", "min⁻¹"],
        AngularVelocity,
        TURN / 60.0,
    ),
    (&["turn/s", "turns/s", "turns_s", "rev/s", "rev_s"], AngularVelocity, TURN),
    (&["m"], Length, 1.0),
    (&["mm"], Length, 1e-3),
    (&["um", "µm", "μm"], Length, 1e-6),
    (&["in"], Length, 0.0254),
    (&["m/s", "m_s"], Velocity, 1.0),
    (&["mm/s", "mm_s"], Velocity, 1e-3),
    (&["A", "a", "A_rms"], Current, 1.0),
    (&["mA", "ma"], Current, 1e-3),
    (&["V", "v"], Voltage, 1.0),
    (&["mV", "mv"], Voltage, 1e-3),
    (&["Nm", "nm", "N·m", "N*m", "N.m"], Torque, 1.0),
    (&["mNm", "mnm", "mN·m"], Torque, 1e-3),
    (&["ozin", "oz·in"], Torque, 7.061_551_814e-3),
    (&["lbf·ft", "lbfft"], Torque, 1.355_817_948),
    (&["N", "n"], Force, 1.0),
    (&["kN", "kn"], Force, 1e3),
    (&["lbf"], Force, 4.448_221_615),
    (&["kgf"], Force, 9.806_65),
    (&["K", "k"], Temperature, 1.0),
    (&["C", "c", "°C", "degC"], Temperature, 1.0),
    (&["F", "°F", "degF"], Temperature, 5.0 / 9.0),
    (&["s", "sec"], Time, 1.0),
    (&["ms"], Time, 1e-3),
    (&["us", "µs", "μs"], Time, 1e-6),
    (&["ns"], Time, 1e-9),
    (&["min"], Time, 60.0),
];

impl Unit {
    /// The unit with this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        let (names, quantity, factor) = UNITS.iter().find(|(names, _, _)| names.contains(&name.trim()))?;
        let offset = match names[0] {
            "C" => 273.15,
            "F" => 459.67 * 5.0 / 9.0,
            _ => 0.0,
        };
        Some(Self { quantity: *quantity, factor: *factor, offset })
    }

    /// The unit that the name of a column ends with: `speed_rpm`, `speed [rpm]`, `speed (rpm)`.
    #[must_use]
    pub fn of_column(name: &str) -> Option<Self> {
        let name = name.trim();
        for (open, close) in [('[', ']'), ('(', ')')] {
            if let Some((_, unit)) = name.strip_suffix(close).and_then(|rest| rest.rsplit_once(open)) {
                return Self::named(unit);
            }
        }
        // A column may be called by its unit, and a letter says too little.
        if name.len() > 2
            && let Some(unit) = Self::named(name)
        {
            return Some(unit);
        }
        // The longest end that is a unit: m_s before s.
        name.match_indices('_').find_map(|(at, _)| Self::named(&name[at + 1..]))
    }

    /// The unit that a formula is converted to: `speed_rpm rad/s`, `(speed_rpm)rad/s`.
    #[must_use]
    pub fn of_formula(formula: &str) -> Option<Self> {
        formula.rsplit_once([' ', ')']).and_then(|(_, unit)| Self::named(unit))
    }

    /// Its usual name.
    #[must_use]
    pub fn name(&self) -> &'static str {
        let mut names = UNITS.iter().map(|(names, ..)| names[0]);
        names.find(|name| Self::named(name).as_ref() == Some(self)).unwrap_or_default()
    }

    /// Factor and offset from this unit to another one; `None` if they measure different quantities.
    #[must_use]
    pub fn to(&self, other: &Self) -> Option<(f64, f64)> {
        let same = self.quantity == other.quantity;
        same.then(|| (self.factor / other.factor, (self.offset - other.offset) / other.factor))
    }

    /// The unit of the integral over time in seconds, if the integral is another quantity.
    #[must_use]
    pub fn integral(&self) -> Option<Self> {
        let quantity = match self.quantity {
            AngularVelocity => Angle,
            Velocity => Length,
            _ => return None,
        };
        Some(Self { quantity, ..*self })
    }
}

/// The names of all units, for messages.
#[must_use]
pub fn known() -> String {
    UNITS.iter().map(|(names, _, _)| names[0]).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_name_their_units() {
        for (name, unit) in [
            ("speed_rpm", "rpm"),
            ("velocity_rad_s", "rad/s"),
            ("nut_mm_s", "mm/s"),
            ("Speed [1/min]", "rpm"),
            ("angle (deg)", "deg"),
            ("torque_Nm", "Nm"),
            ("current_a", "A"),
            ("RPM", "rpm"),
        ] {
            assert_eq!(Unit::of_column(name), Unit::named(unit), "{name}");
            assert!(Unit::of_column(name).is_some(), "{name}");
        }
        assert!(Unit::of_column("speed").is_none() && Unit::of_column("i").is_none());
    }

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
    fn units_of_other_systems_are_those_of_their_definitions() {
        // Pound 0.45359237 kg, ounce 1/16 of it, inch 0.0254 m, foot 12 inches, standard gravity 9.80665 m/s².
        const POUND: f64 = 0.453_592_37 * 9.806_65;
        let (ounce_inch, pound_foot) = (POUND / 16.0 * 0.0254, POUND * 12.0 * 0.0254);
        for (name, base, expected) in
            [("oz·in", "Nm", ounce_inch), ("lbf·ft", "Nm", pound_foot), ("lbf", "N", POUND), ("in", "mm", 25.4)]
        {
            let (factor, offset) = Unit::named(name).and_then(|unit| unit.to(&Unit::named(base)?)).expect(name);
            // Ten digits of the table.
            assert!((factor / expected - 1.0).abs() < 1e-9 && offset == 0.0, "{name}: {factor} {expected}");
        }
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
