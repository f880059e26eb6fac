//! Which columns are temperatures, by their names and units.

use rayon::prelude::*;

use crate::Source;
use crate::listing::{Candidate, Listing, has_columns};
use crate::reader::header::{header_of, is_wanted};
use crate::table::Table;
use crate::units::{Quantity, Unit};
use model::Error;
use model::session::TemperatureColumn;
use model::trace::Channels;
use model::trace::{is_reference, words};

/// Parts of words of a temperature, in any language.
const PARTS: [&str; 2] = ["temperatur", "thermocouple"];
/// Whole words of it.
const WORDS: [&str; 7] = ["temp", "temps", "tmp", "thermistor", "ntc", "ptc", "rtd"];
/// What a temperature is of, after the symbol `t`: `t_winding`.
const PLACES: [&str; 18] = [
    "winding", "windings", "housing", "case", "oil", "grease", "ambient", "amb", "air", "motor", "stator", "rotor",
    "bearing", "coolant", "gearbox", "magnet", "mosfet", "board",
];
/// Units that are of a temperature wherever they stand; `c` and `k` end other names too.
const UNITS: [&str; 4] = ["degC", "°C", "degF", "°F"];
/// The same in brackets.
const IN_BRACKETS: [&str; 3] = ["K", "C", "F"];

/// Whether a column is a measured temperature.
pub(crate) fn is_temperature(name: &str) -> bool {
    // A name with a comma cannot be given in a list.
    if is_reference(name) || name.contains(',') {
        return false;
    }
    let words = words(name);
    let symbol = words.first().is_some_and(|first| first == "t");
    let of_place = symbol && words.get(1).is_some_and(|second| PLACES.contains(&second.as_str()));
    let is_word = |word: &String| WORDS.contains(&word.as_str()) || PARTS.iter().any(|part| word.contains(part));
    let by_word = words.iter().any(is_word);
    let has = |unit: &&str| Unit::of_column(name) == Unit::named(unit);
    let ends = |unit: &&&str| name.trim_end_matches([']', ')']).ends_with(**unit);
    let by_unit =
        UNITS.iter().filter(ends).any(has) || name.ends_with([']', ')']) && IN_BRACKETS.iter().filter(ends).any(has);
    // A thermistor in volts, or the time of a measurement.
    let other = Unit::of_column(name).is_some_and(|unit| unit.quantity != Quantity::Temperature);
    by_unit || (by_word || of_place) && !other
}

/// The temperatures among the columns of a table with these channels; `None` if it has no wanted trace.
fn temperatures(
    table: &Table,
    channels: &Channels,
    wanted: &(dyn Fn(&str) -> bool + Sync),
) -> Result<Option<Vec<String>>, Error> {
    if !has_columns(table, channels) {
        return Ok(None);
    }
    let header = header_of(table, channels.time.as_deref())?;
    let own = header.names().iter().enumerate().filter(|(place, _)| Some(*place) != header.time());
    let names = own.map(|(_, name)| name).filter(|name| is_temperature(name)).cloned();
    Ok(is_wanted(&header, table, wanted).then(|| names.collect()))
}

impl Source {
    /// The temperatures among the columns of the files or tables with these channels that may have wanted traces.
    pub(super) fn temperature_columns(
        &self,
        channels: &Channels,
        wanted: &(dyn Fn(&str) -> bool + Sync),
    ) -> Result<Vec<TemperatureColumn>, Error> {
        let of_table = |table: &Table| temperatures(table, channels, wanted);
        // A file that cannot be opened is an error where it is read, if it is wanted.
        let of_file = |own: &Candidate| own.open(&channels.text).map_or(Ok(None), |table| of_table(&table));
        let all: Vec<Result<Option<Vec<String>>, Error>> = match self {
            Self::Files(paths) | Self::Labelled(paths, _) => {
                Listing::of(paths, self.names())?.candidates.par_iter().map(of_file).collect()
            }
            Self::Memory(tables) => tables.iter().map(|table| of_table(&Table::of(table))).collect(),
        };
        let all: Vec<Option<Vec<String>>> = all.into_iter().collect::<Result<_, _>>()?;
        let of = all.iter().flatten().count();
        let mut found: Vec<TemperatureColumn> = vec![];
        for name in all.into_iter().flatten().flatten() {
            match found.iter_mut().find(|own| own.name == name) {
                Some(own) => own.lacking -= 1,
                None => found.push(TemperatureColumn { name, lacking: of - 1, of }),
            }
        }
        Ok(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn temperatures_are_known_by_words_and_units() {
        for name in [
            "temp",
            "temperature_degc",
            "temperature_c",
            "t_winding",
            "T_ambient_C",
            "winding_temp",
            "Motor Temp [°C]",
            "Motor [°C]",
            "Housing (K)",
            "oil_degC",
            "MotorTemperature",
            "thermocouple2",
            "Wicklungstemperatur",
            "stator_winding_degC",
        ] {
            assert!(is_temperature(name), "{name}");
        }
        for name in [
            "t_s",
            "t",
            "time",
            "i_c",
            "current_c",
            "v_f",
            "attempt",
            "template",
            "temp_setpoint",
            "temp_v",
            "torque_k",
            "motor",
            "thermal,1",
            "tempo_s",
            "ambient_pressure",
            "T_load",
            "x_K",
        ] {
            assert!(!is_temperature(name), "{name}");
        }
    }
}
