//! The variables of a MATLAB file, or of Octave's text, as columns.
//!
//! ```text
//! x, y            vectors of one length     columns x, y
//! m               a matrix                  columns m_1, m_2, …, along its longer side
//! s.a, s.b        fields of a structure     columns s.a, s.b; a, b if s is the only variable
//! s.signals(k)    "structure with time"     column of the signal's label, beside s.time
//! s.Y(k)          channels with Name, Data  column of the channel's name; those of s.X are times
//! r               a number                  a constant column
//! z               complex numbers           columns z_re, z_im
//! data(k).a       a structure array         traces, if these are records ([`crate::table::arrays::records`])
//! ```
//!
//! The longest arrays are the columns; arrays of other lengths, text and objects are left out, and named.

use std::path::Path;

use crate::table::arrays::columns::{matrix, without_variable};
use crate::table::arrays::groups::Named;
use crate::table::arrays::records::{Arrays, columns_of};
use crate::table::columns::About;
use crate::table::matlab::value::{OBJECT, Value};
use crate::time::names::rises;
use model::Error;

/// Elements of a list of single numbers or texts that become constant columns, at most.
const FEW: usize = 64;

/// The columns of variables, of one record or of several.
///
/// # Errors
/// No arrays of numbers, or more than the limit.
pub(super) fn columns_of_variables(
    path: &Path,
    variables: &[(String, Value)],
    about: &mut About,
) -> Result<Arrays, Error> {
    let mut found = Found { columns: Vec::new(), axes: Vec::new(), about };
    for (name, value) in variables {
        found.add(name, value);
    }
    let Found { mut columns, mut axes, about } = found;
    let objects = about.omitted.iter().filter(|own| own.reason == OBJECT);
    if let Some(first) = objects.clone().next().filter(|_| columns.is_empty()) {
        let problem = format!("nothing but {OBJECT}");
        return Err(Error::content(path, first.place.clone(), problem));
    }
    without_variable(&mut columns, &mut axes);
    let own = columns_of(path, columns, about)?;
    let is_axis = |place: &usize| axes.contains(&own.names[*place]) && rises(&own.columns[*place]);
    about.clocks.extend((0..own.names.len()).find(is_axis));
    Ok(own)
}

/// What is found of a file.
struct Found<'a> {
    columns: Named,
    /// Names of the columns that are channels of a field X, which are the times of those of Y.
    axes: Vec<String>,
    about: &'a mut About,
}

impl Found<'_> {
    /// Adds the columns of a value.
    fn add(&mut self, name: &str, value: &Value) {
        if let Some((label, data)) = channel(value) {
            // Beside its list, if no other column has its name there.
            let list = name.split_once('(').map_or(name, |(list, _)| list);
            let short = list.rsplit_once('.').map_or(label.to_string(), |(outer, _)| format!("{outer}.{label}"));
            let is_taken = self.columns.iter().any(|(own, _)| *own == short);
            let name = if is_taken { format!("{list}.{label}") } else { short };
            if list.ends_with(".X") {
                self.axes.push(name.clone());
            }
            return self.add(&name, data);
        }
        match value {
            Value::Numbers { rows, values } => self.columns.extend(arrays(name, *rows, values)),
            Value::Complex { rows, re, im } => {
                self.columns.extend(arrays(&format!("{name}_re"), *rows, re));
                self.columns.extend(arrays(&format!("{name}_im"), *rows, im));
            }
            Value::Fields(fields) => {
                for (field, value) in fields {
                    if field == "signals" {
                        self.signals(name, value);
                    } else {
                        self.add(&format!("{name}.{field}"), value);
                    }
                }
            }
            Value::List(elements) if elements.len() > FEW && elements.iter().all(is_single) => {
                self.omit(name, &format!("a list of {} single values: save it as a vector", elements.len()));
            }
            Value::List(elements) => {
                for (k, element) in elements.iter().enumerate() {
                    self.add(&format!("{name}({})", k + 1), element);
                }
            }
            Value::Text(_) => self.omit(name, "text"),
            Value::Other(reason) => self.omit(name, reason),
        }
    }

    fn omit(&mut self, name: &str, reason: &str) {
        self.about.omit(format!("array {name}"), reason);
    }

    /// The signals of a "structure with time", by their labels.
    fn signals(&mut self, name: &str, value: &Value) {
        let one = std::slice::from_ref(value);
        let list = if let Value::List(list) = value { list } else { one };
        for (k, signal) in list.iter().enumerate() {
            let Value::Fields(fields) = signal else { continue };
            let field = |wanted: &str| fields.iter().find(|(name, _)| name == wanted).map(|(_, value)| value);
            let label = match field("label") {
                Some(Value::Text(label)) if !label.trim().is_empty() => label.trim().to_string(),
                _ => format!("signal_{}", k + 1),
            };
            if let Some(values) = field("values") {
                self.add(&format!("{name}.{label}"), values);
            }
        }
    }
}

/// Name and data of a channel.
fn channel(value: &Value) -> Option<(&str, &Value)> {
    let Value::Fields(fields) = value else { return None };
    let field = |wanted: &str| fields.iter().find(|(name, _)| name.eq_ignore_ascii_case(wanted)).map(|(_, own)| own);
    match (field("name")?, field("data")?) {
        (Value::Text(label), data @ Value::Numbers { .. }) if !label.trim().is_empty() => Some((label.trim(), data)),
        _ => None,
    }
}

/// Whether a value has no array.
fn is_single(value: &Value) -> bool {
    match value {
        Value::Numbers { values, .. } => values.len() == 1,
        Value::Complex { re, .. } => re.len() == 1,
        Value::Fields(fields) => fields.iter().all(|(_, own)| is_single(own)),
        Value::List(_) => false,
        Value::Text(_) | Value::Other(_) => true,
    }
}

/// The columns of an array, along its longer side.
fn arrays(name: &str, rows: usize, values: &[f64]) -> Named {
    match values.len().checked_div(rows) {
        _ if values.is_empty() => vec![],
        Some(across) if rows > 1 && across > 1 => matrix(name, [rows, across], false, values),
        _ => vec![(name.to_string(), values.to_vec())],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn structures_with_time_and_plain_vectors_become_columns() {
        let signal = |label: &str, values: Vec<f64>| {
            let numbers = Value::Numbers { rows: values.len(), values };
            Value::Fields(vec![("values".into(), numbers), ("label".into(), Value::Text(label.into()))])
        };
        let with_time = Value::Fields(vec![
            ("time".into(), Value::Numbers { rows: 2, values: vec![0.0, 0.1] }),
            ("signals".into(), Value::List(vec![signal("i", vec![1.0, 2.0]), signal("", vec![3.0, 4.0])])),
            ("blockName".into(), Value::Text("model".into())),
        ]);
        let mut about = About::default();
        let mut found = Found { columns: vec![], axes: vec![], about: &mut about };
        found.add("log", &with_time);
        let mut found = found.columns;
        let names = |found: &Named| found.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
        assert_eq!(names(&found), ["log.time", "log.i", "log.signal_2"]);
        without_variable(&mut found, &mut []);
        assert_eq!(names(&found), ["time", "i", "signal_2"]);
        assert_eq!(about.omitted.iter().map(|own| own.place.as_str()).collect::<Vec<_>>(), ["array log.blockName"]);
        let mut found = arrays("m", 3, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        found.extend(arrays("w", 2, &[1.0, 4.0, 2.0, 5.0, 3.0, 6.0]));
        let columns = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]].map(|column| column.to_vec());
        assert_eq!(
            found.iter().map(|(_, column)| column.clone()).collect::<Vec<_>>(),
            [columns.clone(), columns].concat()
        );
    }

    #[test]
    fn channels_of_a_structure_are_columns_of_their_names() {
        let channel = |name: &str, values: &[f64]| {
            let data = Value::Numbers { rows: values.len(), values: values.to_vec() };
            let text = |text: &str| Value::Text(text.into());
            Value::Fields(vec![("Name".into(), text(name)), ("Type".into(), text("f")), ("Data".into(), data)])
        };
        let fast = [channel("phase_current_1", &[1.0, 2.0]), channel("force", &[3.0]), channel("t", &[7.0, 8.0])];
        let run = Value::Fields(vec![
            ("X".into(), Value::List(vec![channel("t", &[0.0, 0.5])])),
            ("Y".into(), Value::List(fast.to_vec())),
        ]);
        let mut about = About::default();
        let mut found = Found { columns: vec![], axes: vec![], about: &mut about };
        found.add("N09_1", &run);
        let names: Vec<&str> = found.columns.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["N09_1.t", "N09_1.phase_current_1", "N09_1.force", "N09_1.Y.t"]);
        assert_eq!(found.axes, ["N09_1.t"]);
        assert_eq!((found.columns[1].1.clone(), about.omitted.len()), (vec![1.0, 2.0], 0));
    }
}
