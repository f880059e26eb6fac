//! A model that `identify` wrote.

use std::collections::HashMap;
use std::path::Path;

use nalgebra::{DMatrix, DVector};
use serde_json::Value;

use crate::command_line::output;
use model::Error;
use model::identify::{Estimate, Structure, Terms};
use model::trace::stem;
use traces::table::csv_error;

/// A row of the file: parameters by name, and the covariance in the order of the file.
struct Row {
    trace: String,
    parameters: HashMap<String, f64>,
    covariance: Option<Vec<Vec<f64>>>,
}

/// Reads the model of a trace, or the only one.
pub(super) fn read(path: &Path, trace: Option<&str>, structure: Structure) -> Result<Estimate, Error> {
    let text = std::fs::read_to_string(path).map_err(Error::io(path))?;
    let rows = if text.trim_start().starts_with(['[', '{']) { of_json(path, &text) } else { of_table(path, &text) }?;
    let known = || rows.iter().map(|row| row.trace.as_str()).take(6).collect::<Vec<_>>().join(", ");
    let wrong = |problem: String| Error::content(path, "traces", problem);
    let row = match (trace, &rows[..]) {
        (Some(trace), rows) => rows
            .iter()
            .find(|row| stem(&row.trace) == stem(trace))
            .ok_or_else(|| wrong(format!("no model of {trace}; there are {}", known())))?,
        (None, [row]) => row,
        (None, rows) => {
            return Err(wrong(format!("{} models; name one by --params-of, e.g. {}", rows.len(), known())));
        }
    };
    let names = structure.names();
    let unknown = row.parameters.keys().find(|name| !names.contains(name));
    let missing = names.iter().find(|name| !row.parameters.contains_key(*name));
    if let Some(name) = unknown.or(missing) {
        let what = if unknown.is_some() { "has" } else { "lacks" };
        let problem = format!("the model {what} {name}: its order is not that of --order and --offset");
        return Err(Error::content(path, format!("model of {}", row.trace), problem));
    }
    let theta = DVector::from_iterator(names.len(), names.iter().map(|name| row.parameters[name]));
    let n = names.len();
    let covariance = match &row.covariance {
        Some(rows) if rows.len() == n && rows.iter().all(|row| row.len() == n) => {
            DMatrix::from_fn(n, n, |i, j| rows[i][j])
        }
        Some(_) => return Err(Error::content(path, format!("model of {}", row.trace), "its covariance is not square")),
        None => {
            output::warn(
                "the table has no covariance: bounds and regions are those of exact parameters; use --json of identify",
            );
            DMatrix::zeros(n, n)
        }
    };
    Ok(Estimate::given(structure, theta, covariance))
}

fn of_table(path: &Path, text: &str) -> Result<Vec<Row>, Error> {
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
    let columns: Vec<String> =
        reader.headers().map_err(|error| csv_error(path, &error))?.iter().map(String::from).collect();
    if columns.first().is_none_or(|first| first != "trace") {
        return Err(Error::content(path, "header", "no column trace: this is no table of `identify`"));
    }
    let is_parameter = |name: &str| name != "trace" && name != "fit_percent" && !name.starts_with("sd_");
    let mut rows = vec![];
    for (line, record) in reader.records().enumerate() {
        let record = record.map_err(|error| csv_error(path, &error))?;
        let mut parameters = HashMap::new();
        for (name, cell) in columns.iter().zip(&record).filter(|(name, _)| is_parameter(name)) {
            let value = cell.parse::<f64>().ok().filter(|value| value.is_finite()).ok_or_else(|| {
                Error::content(path, format!("line {}, column {name}", line + 2), format!("\"{cell}\" is no number"))
            })?;
            parameters.insert(name.clone(), value);
        }
        rows.push(Row { trace: record[0].to_string(), parameters, covariance: None });
    }
    Ok(rows)
}

fn of_json(path: &Path, text: &str) -> Result<Vec<Row>, Error> {
    let wrong = |problem: &str| Error::content(path, "content", format!("{problem}; give the JSON of `identify`"));
    let value: Value = serde_json::from_str(text).map_err(|error| wrong(&error.to_string()))?;
    let models = match value {
        Value::Array(models) => models,
        model => vec![model],
    };
    let number = |value: &Value| value.as_f64().filter(|value| value.is_finite());
    let one = |model: &Value| {
        let parameters = model["parameters"].as_object()?;
        let parameters = parameters.iter().map(|(name, value)| Some((name.clone(), number(value)?)));
        let covariance = model["covariance"].as_array().and_then(|rows| {
            rows.iter().map(|row| row.as_array()?.iter().map(number).collect::<Option<Vec<_>>>()).collect()
        });
        Some(Row { trace: model["trace"].as_str()?.into(), parameters: parameters.collect::<Option<_>>()?, covariance })
    };
    models.iter().map(one).collect::<Option<Vec<_>>>().ok_or_else(|| wrong("no trace or parameters"))
}
