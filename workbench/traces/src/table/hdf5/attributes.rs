//! What the attributes of a dataset of HDF5 say of its values, as netCDF and its users write them.
//!
//! ```text
//! _FillValue, missing_value   stored values that stand for a missing one
//! scale_factor, add_offset    value = stored × scale_factor + add_offset
//! units                       A, rad s-1, ms since 2026-01-01: of the name of the column
//! ```
//!
//! Stored values are compared before they are scaled (CF conventions 1.11, §2.5 and §8.1).

use hdf5_pure::{AttrValue, Dataset};

use crate::table::text::with_unit;

/// What the attributes of a dataset say.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Attributes {
    scale: Option<f64>,
    offset: Option<f64>,
    missing: Vec<f64>,
    unit: Option<String>,
}

impl Attributes {
    /// Those of a dataset.
    ///
    /// # Errors
    /// One that is no number.
    pub(super) fn of(dataset: &Dataset) -> Result<Self, String> {
        let all = dataset.attrs().map_err(|error| error.to_string())?;
        let one = |name: &str| match all.get(name).map(numbers) {
            None => Ok(None),
            Some(Some(values)) if values.len() == 1 && values[0].is_finite() => Ok(Some(values[0])),
            Some(_) => Err(format!("its attribute {name} is not a number: write the values without it")),
        };
        let missing = ["_FillValue", "missing_value"].into_iter().filter_map(|name| numbers(all.get(name)?)).flatten();
        Ok(Self {
            scale: one("scale_factor")?,
            offset: one("add_offset")?,
            missing: missing.filter(|value| !value.is_nan()).collect(),
            unit: ["units", "unit", "Units", "Unit"].into_iter().find_map(|name| text(all.get(name)?)),
        })
    }

    /// Makes values of stored ones; returns how many were missing.
    pub(super) fn apply(&self, stored: &mut [f64]) -> usize {
        let mut missing = 0;
        for value in stored.iter_mut().filter(|value| self.missing.contains(value)) {
            (*value, missing) = (f64::NAN, missing + 1);
        }
        if self.scale.is_some() || self.offset.is_some() {
            let (scale, offset) = (self.scale.unwrap_or(1.0), self.offset.unwrap_or(0.0));
            stored.iter_mut().for_each(|value| *value = *value * scale + offset);
        }
        missing
    }

    /// The name of a column with the unit.
    pub(super) fn named(&self, name: &str) -> String {
        self.unit.as_ref().map_or_else(|| name.to_string(), |unit| with_unit(name, unit))
    }

    /// What is said of the column `name`, if values are changed.
    pub(super) fn told(&self, name: &str, missing: usize) -> Option<String> {
        let part = |what: &str, value: Option<f64>| value.map(|value| format!("{what} {value}"));
        let mut parts: Vec<String> =
            [part("scale_factor", self.scale), part("add_offset", self.offset)].into_iter().flatten().collect();
        parts.extend((missing > 0).then(|| format!("{missing} values that its attributes call missing")));
        (!parts.is_empty()).then(|| format!("column {name}: with {}", parts.join(", ")))
    }
}

fn numbers(value: &AttrValue) -> Option<Vec<f64>> {
    let signed = || Some(value.to_i64s()?.into_iter().map(|x| x as f64).collect());
    let unsigned = || Some(value.to_u64s()?.into_iter().map(|x| x as f64).collect());
    value.to_f64s().or_else(signed).or_else(unsigned)
}

/// A unit in the spelling of the names of columns: powers of −1 are divisors, and times have no date.
fn text(value: &AttrValue) -> Option<String> {
    let [text] = value.as_strings()? else { return None };
    let text = text.trim_end_matches('\0').trim();
    let text = text.split_once(" since ").map_or(text, |(unit, _)| unit.trim());
    if text.is_empty() || text.contains(['[', ']']) {
        return None;
    }
    let long = match text.to_lowercase().as_str() {
        "second" | "seconds" => "s",
        "millisecond" | "milliseconds" | "msec" => "ms",
        "microsecond" | "microseconds" | "usec" => "us",
        "nanosecond" | "nanoseconds" => "ns",
        "minute" | "minutes" => "min",
        "ampere" | "amperes" | "amp" | "amps" => "A",
        "volt" | "volts" => "V",
        "radian" | "radians" => "rad",
        "degree" | "degrees" => "deg",
        "degree_celsius" | "degrees_celsius" | "celsius" | "degree_c" | "degrees_c" => "°C",
        "kelvin" => "K",
        "n m" | "newton meter" | "newton metre" | "newton meters" => "Nm",
        _ => "",
    };
    if !long.is_empty() {
        return Some(long.to_string());
    }
    let inverse = ["^-1", "**-1", "⁻¹", "-1"].into_iter().find_map(|power| text.strip_suffix(power));
    let divided = inverse.and_then(|rest| rest.rsplit_once([' ', '.', '*', '·']));
    Some(divided.map_or_else(|| text.to_string(), |(unit, divisor)| format!("{}/{}", long_of(unit), divisor.trim())))
}

/// An angle in words in front of a divisor.
fn long_of(unit: &str) -> &str {
    match unit.trim() {
        "radian" | "radians" => "rad",
        "degree" | "degrees" => "deg",
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_of_netcdf_are_those_of_columns() {
        for (units, name) in [
            ("A", "x [A]"),
            ("rad s-1", "x [rad/s]"),
            ("radians s^-1", "x [rad/s]"),
            ("rad.s-1", "x [rad/s]"),
            ("m/s", "x [m/s]"),
            ("min-1", "x [min-1]"),
            ("milliseconds since 2026-01-01 00:00:00", "x [ms]"),
            ("seconds", "x [s]"),
            ("N m", "x [Nm]"),
            ("degrees_celsius", "x [°C]"),
            ("1", "x"),
            ("", "x"),
        ] {
            let unit = text(&AttrValue::String(units.into()));
            let own = Attributes { unit, ..Attributes::default() };
            assert_eq!(own.named("x"), name, "{units}");
        }
    }

    #[test]
    fn stored_values_are_compared_and_then_scaled() {
        let own = Attributes { scale: Some(0.5), offset: Some(-1.0), missing: vec![-32768.0, 9.0], unit: None };
        let mut values = [2.0, -32768.0, 9.0, 0.0];
        assert_eq!(own.apply(&mut values), 2);
        assert!(values[1].is_nan() && values[2].is_nan());
        assert_eq!((values[0], values[3]), (0.0, -1.0));
        let told = own.told("i", 2).expect("changed");
        assert_eq!(told, "column i: with scale_factor 0.5, add_offset -1, 2 values that its attributes call missing");
        assert_eq!(Attributes::default().told("i", 0), None);
    }
}
