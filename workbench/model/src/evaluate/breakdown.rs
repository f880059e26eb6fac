//! Rates of right decisions by the value of a column of the labels.

use std::cmp::Ordering;
use std::fmt::Write as _;

use serde_json::{Map, Value, json};

use super::{Judged, Rate};

/// The rate of right decisions of each class, for each value of a column.
#[derive(Clone, Debug, PartialEq)]
pub struct Breakdown {
    /// The column.
    pub column: String,
    /// Names of the classes.
    pub classes: Vec<String>,
    /// The values in order: number of traces, and the rate of each class, `None` for a class that did not occur.
    pub rows: Vec<(String, usize, Vec<Option<Rate>>)>,
}

impl Breakdown {
    /// Breaks down by the cells of a column, one for each verdict.
    #[must_use]
    pub fn of(judged: &Judged<'_>, column: &str, cells: &[String]) -> Self {
        let mut values: Vec<&String> = cells.iter().collect();
        values.sort_by(|one, other| in_order(one, other));
        values.dedup();
        let row = |value: &String| {
            let is_of = |k: usize, class: usize| cells[k] == *value && judged.verdicts[k].class == class;
            let rates = (0..judged.classes.len()).map(|class| judged.right(|k| is_of(k, class)));
            (value.clone(), cells.iter().filter(|cell| *cell == value).count(), rates.collect())
        };
        Self { column: column.into(), classes: judged.classes.to_vec(), rows: values.into_iter().map(row).collect() }
    }

    /// JSON list with an object per value: `value`, `traces`, `right` by class.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let row = |(value, traces, rates): &(String, usize, Vec<Option<Rate>>)| {
            let seen = self.classes.iter().zip(rates).filter_map(|(class, rate)| Some((class, (*rate)?)));
            let right: Map<String, Value> = seen.map(|(class, rate)| (class.clone(), rate.to_json())).collect();
            json!({ "value": value, "traces": traces, "right": right })
        };
        self.rows.iter().map(row).collect()
    }
}

/// Numbers in their order, before texts in theirs.
fn in_order(one: &str, other: &str) -> Ordering {
    match (one.parse::<f64>(), other.parse::<f64>()) {
        (Ok(one), Ok(other)) => one.total_cmp(&other),
        (Ok(_), Err(_)) => Ordering::Less,
        (Err(_), Ok(_)) => Ordering::Greater,
        (Err(_), Err(_)) => one.cmp(other),
    }
}

impl std::fmt::Display for Breakdown {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "right by {}", self.column)?;
        for (value, traces, rates) in &self.rows {
            let mut line = format!("\n  {value}, {traces} traces:");
            for (class, rate) in self.classes.iter().zip(rates) {
                if let Some(rate) = rate {
                    let _never_fails = write!(line, "  {class} {rate}");
                }
            }
            f.write_str(&line)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_in_their_order_and_before_texts() {
        let mut values = ["b", "10", "9", "-1", "a", "9.5"];
        values.sort_by(|one, other| in_order(one, other));
        assert_eq!(values, ["-1", "9", "9.5", "10", "a", "b"]);
    }
}
