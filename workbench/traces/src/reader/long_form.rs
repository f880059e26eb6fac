//! Tables in long form: the values of several signals below each other, as data bases of time series export them.
//!
//! ```text
//! time  channel    value            time  current_a  speed_rpm
//! 0     current_a  1.2      ─►      0     1.2        1500
//! 0     speed_rpm  1500
//! ```

use crate::table::{Table, Wanted};

/// Names of columns of the values, and of the names of the signals.
const VALUES: [&str; 4] = ["value", "_value", "val", "values"];
const SIGNALS: [&str; 16] = [
    "channel",
    "_field",
    "field",
    "signal",
    "sensor",
    "sensor_id",
    "metric",
    "tag",
    "tagname",
    "tag_name",
    "variable",
    "measurement",
    "_measurement",
    "series",
    "name",
    "point",
];

/// Why a table is in long form, and what to do; `None` of another one.
pub(crate) fn problem(table: &Table) -> Option<String> {
    let place = |wanted: &[&str]| table.names().iter().position(|name| wanted.contains(&name.to_lowercase().as_str()));
    let value = &table.names()[place(&VALUES)?];
    let is_of_several = |place: &usize| {
        let Ok(read) = table.read(Wanted { numbers: &[], text: Some(*place), row: &|_| true }) else { return false };
        let mut cells = read.texts.unwrap_or_default().into_iter().filter(|cell| !cell.is_empty());
        let Some(first) = cells.next().filter(|first| first.parse::<f64>().is_err()) else { return false };
        cells.any(|cell| cell != first)
    };
    let mut named = (0..table.names().len()).filter(|k| SIGNALS.contains(&table.names()[*k].to_lowercase().as_str()));
    let signal = &table.names()[named.find(is_of_several)?];
    Some(format!(
        "several signals are below each other, named by column {signal}, with their values in column {value}; write a \
         column for each signal, such as by pivot(columns=\"{signal}\", values=\"{value}\", …) of pandas"
    ))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use model::trace::{Cells, Recorded};

    use super::*;

    #[test]
    fn names_of_several_signals_beside_values_are_a_long_form() {
        let table = |signals: [&str; 4], name: &str| {
            let texts = Cells::Texts(signals.map(String::from).to_vec());
            let values = Cells::Numbers(vec![1.0, 2.0, 3.0, 4.0]);
            let columns = vec![(name.to_string(), texts), ("Value".to_string(), values)];
            problem(&Table::of(&Arc::new(Recorded::new("t", columns).expect("equal lengths"))))
        };
        let found = table(["i", "v", "i", "v"], "_field").expect("two signals");
        assert!(found.contains("named by column _field, with their values in column Value"), "{found}");
        for (signals, name) in
            [(["i"; 4], "_field"), (["1", "2", "1", "2"], "channel"), (["i", "v", "i", "v"], "state")]
        {
            assert_eq!(table(signals, name), None);
        }
    }
}
