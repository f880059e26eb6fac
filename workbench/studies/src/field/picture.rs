//! The plot of the table: detected records over the size of a defect, one panel a row.
//!
//! Enters: the table as [`super::render::text`] prints it, so that a table in a document can be drawn.

use crate::campaign::render::grid_cells;
use model::Error;
use model::evaluate::Rate;
use pages::plot::{SizeSeries, multiples};

/// The caption of the figure.
const TITLE: &str = "Detected records over the size of the defect (1 is full size), with 95 % intervals";

/// A row of the table.
#[derive(Clone, Debug)]
pub struct FieldRow {
    /// The condition.
    pub name: String,
    /// Rate of false alarms; `None` if training refused the set.
    pub false_alarms: Option<Rate>,
    /// Kind and size of each defect, and the rate of detected records.
    pub defects: Vec<(String, f64, Rate)>,
}

/// Reads the table in this text.
///
/// # Errors
/// [`Error::Usage`] if there is no such table, or a cell is no rate.
pub fn table(text: &str) -> Result<Vec<FieldRow>, Error> {
    let mut lines = text.lines().skip_while(|line| !line.trim_start().starts_with("false alarms"));
    let head: Vec<&str> = grid_cells(lines.next().ok_or_else(|| refused("no column `false alarms`"))?);
    let mut rows = Vec::new();
    for line in lines.take_while(|line| line.starts_with("  ")) {
        let row = grid_cells(line);
        let Some((name, values)) = row.split_first() else { continue };
        let mut own = FieldRow { name: (*name).to_owned(), false_alarms: None, defects: vec![] };
        for (heading, value) in head.iter().zip(values).filter(|(_, value)| **value != "refused") {
            let rate = || interval(value).ok_or_else(|| refused(&format!("{name}, {heading}: {value}")));
            match heading.split_once(' ').and_then(|(kind, size)| Some((kind, fraction(size)?))) {
                Some((kind, size)) => own.defects.push((kind.to_owned(), size, rate()?)),
                None if *heading == "false alarms" => own.false_alarms = Some(rate()?),
                None => {}
            }
        }
        rows.push(own);
    }
    if rows.is_empty() { Err(refused("no rows")) } else { Ok(rows) }
}

/// Draws the table in this text.
///
/// # Errors
/// Those of [`table`].
pub fn rates(text: &str) -> Result<String, Error> {
    let panel = |row: FieldRow| {
        let mut series: Vec<SizeSeries> = Vec::new();
        for (kind, size, rate) in row.defects {
            if series.last().is_none_or(|last| last.name != kind) {
                series.push(SizeSeries { name: kind, rates: vec![] });
            }
            if let Some(last) = series.last_mut() {
                last.rates.push((size, rate));
            }
        }
        (row.name, series)
    };
    let panels: Vec<_> = table(text)?.into_iter().map(panel).collect();
    multiples(TITLE, "detected records / %", &panels).map_err(|error| refused(&error.to_string()))
}

fn refused(what: &str) -> Error {
    Error::Usage(format!("no table of the field: {what}"))
}

/// `1` or `1/8`.
fn fraction(text: &str) -> Option<f64> {
    match text.split_once('/') {
        Some((one, whole)) => Some(one.parse::<f64>().ok()? / whole.parse::<f64>().ok()?),
        None => text.parse().ok(),
    }
}

/// `92.5 [80.1, 97.0]`, percent.
fn interval(text: &str) -> Option<Rate> {
    let (value, interval) = text.strip_suffix(']')?.split_once(" [")?;
    let (low, high) = interval.split_once(", ")?;
    let part = |text: &str| Some(text.parse::<f64>().ok()? / 100.0);
    Some(Rate { value: part(value)?, low: part(low)?, high: part(high)? })
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: &str = "Gate: detected\n        false alarms    spall 1              spall 1/2          roughness 1\n  \
                         mix   1.0 [0.5, 2.2]  100.0 [96.9, 100.0]  50.0 [40.0, 60.0]  5.0 [1.0, 9.0]\n\nnext\n  x  1\n";

    #[test]
    fn the_rows_of_a_printed_table_are_drawn() {
        let drawn = rates(TABLE).expect("a table");
        assert!(
            drawn.contains("\"mix\"") && drawn.contains("\"roughness\"") && drawn.contains("\"y\":[100.0,50.0]"),
            "{drawn}"
        );
        // The intervals, one after the other.
        assert!(drawn.contains("\"y\":[96.9,100.0,null,40.0,60.0,null]"), "{drawn}");
        assert!(rates("nothing").is_err() && rates(&TABLE.replace("50.0 [", "50.0 (")).is_err());
    }
}
