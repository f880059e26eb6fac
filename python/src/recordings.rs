//! Recordings of files: their columns, an audit, and the description of a drive.

use std::path::PathBuf;

use model::session::{Log, Quiet};
use model::settings::{Data, Settings, TIMES, Use};
use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use serde::Deserialize;
use traces::audit::{Audit, USE as AUDIT};
use traces::describe::{Asked, USE as INIT, describe};
use traces::reader::{self, Series};
use traces::table::Table;
use traces::units::Unit;

use crate::errors::raised;
use crate::options::call;
use crate::pool::detached;

/// Traces, the units of their columns, and what was left out or guessed.
type Read<'py> = (Bound<'py, PyList>, Vec<(String, String)>, Vec<String>);

/// What a reading of a file is asked for beside its channels.
const READ: Use = Use { name: "read", keys: &[TIMES], required: &[] };

/// Reads channels of every trace of a file, all columns of numbers if none are named. Returns a list of (name, time or
/// None, columns), the units of the columns, and what was left out or guessed.
#[pyfunction]
pub(crate) fn read<'py>(
    py: Python<'py>,
    file: PathBuf,
    channels: Option<Vec<String>>,
    options: &Bound<'py, PyDict>,
) -> PyResult<Read<'py>> {
    let data = settings_of(&READ, None, options)?.data;
    let form = data.text_form();
    let Data { time, rate_hz, .. } = data;
    let read = || {
        let table = Table::open_as(&file, &form)?;
        let (names, problems) = match channels {
            Some(names) => (names, vec![]),
            None => reader::numeric(&table, time.as_deref())?,
        };
        let notes: Vec<String> = table.about().told().chain(problems.iter().map(ToString::to_string)).collect();
        let series = reader::series(&table, (time.as_deref(), rate_hz), &names)?;
        let unit = |name: &String| {
            let is_column = table.names().contains(name);
            let unit = if is_column { Unit::of_column(name) } else { Unit::of_formula(name) };
            Some((name.clone(), unit?.name().to_string()))
        };
        let units = names.iter().filter_map(unit).collect();
        Ok((names, units, series, notes))
    };
    type Found = (Vec<String>, Vec<(String, String)>, Vec<Series>, Vec<String>);
    let (names, units, series, notes): Found = detached(py, read).map_err(raised)?;
    let to_python = |Series { id, times_s, columns }: Series| {
        let by_name = PyDict::new(py);
        for (name, column) in names.iter().zip(columns) {
            by_name.set_item(name, column.into_pyarray(py))?;
        }
        Ok((id, times_s.map(|times| times.into_pyarray(py)), by_name))
    };
    let traces = PyList::new(py, series.into_iter().map(to_python).collect::<PyResult<Vec<_>>>()?)?;
    Ok((traces, units, notes))
}

/// Settings of a job over those of a drive file.
fn settings_of(job: &Use, drive: Option<PathBuf>, options: &Bound<'_, PyDict>) -> PyResult<Settings> {
    let understood = call(drive, options, None, None)?.understood(job);
    let (settings, further, _) = understood.map_err(raised)?;
    further.end().map_err(raised)?;
    Ok(settings)
}

/// What an audit finds: lines, JSON, and warnings.
#[pyfunction]
pub(crate) fn audit(
    py: Python<'_>,
    drive: Option<PathBuf>,
    options: &Bound<'_, PyDict>,
) -> PyResult<(Vec<String>, String, Vec<String>)> {
    let audit = Audit { settings: settings_of(&AUDIT, drive, options)? };
    detached(py, || {
        let log = Log::new(&Quiet);
        let outcome = audit.audit(&audit.listing(&log)?, &log)?;
        Ok((outcome.lines(audit.false_alarm()), outcome.to_json().to_string(), log.take()))
    })
    .map_err(raised)
}

/// The further options of a description.
#[derive(Deserialize)]
struct Further {
    labels: Option<PathBuf>,
    labels_from_names: Option<PathBuf>,
    out: Option<PathBuf>,
    front_end: Option<PathBuf>,
    #[serde(default)]
    force: bool,
}

/// Describes recordings: writes a drive file; returns its path and what was found, in a line.
#[pyfunction]
pub(crate) fn init(py: Python<'_>, options: &Bound<'_, PyDict>) -> PyResult<(PathBuf, Vec<String>)> {
    let (settings, mut further, _) = call(None, options, None, None)?.understood(&INIT).map_err(raised)?;
    let options: Further = further.take().map_err(raised)?;
    further.end().map_err(raised)?;
    detached(py, || {
        let asked = Asked {
            data: &settings.data,
            labels: options.labels.as_deref(),
            labels_from_names: options.labels_from_names.as_deref(),
            out: options.out.as_deref(),
            front_end: options.front_end.as_deref(),
            force: options.force,
        };
        let log = Log::new(&Quiet);
        let description = describe(&asked, &log)?.accepted()?;
        Ok((description.file, log.take().into_iter().chain(description.question).collect()))
    })
    .map_err(raised)
}
