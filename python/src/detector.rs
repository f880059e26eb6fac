//! The core's detector over whole traces, and over traces that come in pieces.

use std::path::PathBuf;
use std::sync::Arc;

use bearing_watch::FrictionTerm;
use bearing_watch::alarm::{Growth, Interval};
use model::Error;
use model::core::{Judged, SegmentReport, Stream};
use model::identify::Terms as _;
use model::session::check_rate;
use model::trace::{Recorded, Trace};
use model::train::features_of;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyList};
use self_cell::self_cell;
use traces::Source;

use crate::errors::{raised, refused};
use crate::model::{Model, Own};
use crate::pool::detached;
use crate::tables::{table, tables};

self_cell!(
    struct State {
        owner: Arc<Own>,
        #[covariant]
        dependent: Stream,
    }
);

/// The detector of a model.
#[pyclass(module = "bearing_watch._core")]
pub(crate) struct Detector {
    state: State,
    run_a_trace: bool,
    /// Why traces cannot come in pieces.
    whole_only: Option<&'static str>,
}

impl std::fmt::Debug for Detector {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Detector").field("run_a_trace", &self.run_a_trace).finish_non_exhaustive()
    }
}

fn start(own: &Arc<Own>) -> State {
    State::new(Arc::clone(own), |own| own.file.model.stream())
}

#[pymethods]
impl Detector {
    #[new]
    fn new(model: &Model, run_a_trace: bool) -> Self {
        let whole_only = model.own.file.refuses_pieces();
        Self { state: start(&model.own), run_a_trace, whole_only }
    }

    /// Runs a whole trace; the evidence goes on from the traces before.
    fn run<'py>(&mut self, py: Python<'py>, columns: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyDict>> {
        self.require_between()?;
        let table = table("trace", columns)?;
        let judged = detached(py, || {
            let source = Source::Memory(vec![Arc::clone(&table)]);
            let trace = self.state.borrow_owner().file.trace(table.name(), &source)?;
            Ok::<_, Error>(self.whole(&trace))
        });
        self.to_dict(py, &judged.map_err(raised)?)
    }

    /// Runs all traces of files, or of tables; returns a list of (name, verdicts).
    fn replay<'py>(
        &mut self,
        py: Python<'py>,
        files: Vec<PathBuf>,
        tables_in_memory: Option<&Bound<'py, PyList>>,
    ) -> PyResult<Bound<'py, PyList>> {
        self.require_between()?;
        let source = match tables_in_memory {
            Some(given) => Source::Memory(tables(given)?),
            None => Source::Files(files),
        };
        let judged = detached(py, || {
            let traces = self.state.borrow_owner().file.traces(&source)?;
            let judge = |trace: Trace| (trace.id.clone(), self.whole(&trace));
            Ok::<_, Error>(traces.into_iter().map(judge).collect::<Vec<_>>())
        });
        let judged = judged.map_err(raised)?;
        let named = |(id, judged): &(String, Vec<Judged>)| Ok((id.clone(), self.to_dict(py, judged)?));
        PyList::new(py, judged.iter().map(named).collect::<PyResult<Vec<_>>>()?)
    }

    /// Takes the next samples of a trace.
    fn step<'py>(&mut self, py: Python<'py>, columns: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyDict>> {
        if let Some(reason) = self.whole_only {
            return Err(refused(format!("this model takes whole traces (run): {reason}")));
        }
        let table = table("samples", columns)?;
        let judged = detached(py, || {
            let piece = piece(self.state.borrow_owner(), table)?;
            Ok::<_, Error>(self.state.with_dependent_mut(|_, stream| stream.take(&piece)))
        });
        self.to_dict(py, &judged.map_err(raised)?)
    }

    /// Ends the trace whose samples came by step.
    fn finish<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        if self.taken() == 0 {
            return self.to_dict(py, &[]);
        }
        let last = self.state.with_dependent_mut(|_, stream| stream.finish(self.run_a_trace));
        self.to_dict(py, last.as_slice())
    }

    /// Ends the run; gives name, deviations and score of each direction of the alarm.
    fn end_run(&mut self) -> PyResult<Vec<(String, f32, f32)>> {
        self.require_between()?;
        let ended = self.state.with_dependent_mut(|_, stream| stream.end_run());
        let file = &self.state.borrow_owner().file;
        let told = |one: &bearing_watch::alarm::Contribution| {
            (file.model.direction_name(file.orders(), one.direction), one.deviations, one.score)
        };
        Ok(ended.run.iter().map(told).collect())
    }

    /// Denies the alarm; whether there was one.
    fn deny(&mut self) -> PyResult<bool> {
        self.require_between()?;
        Ok(self.state.with_dependent_mut(|_, stream| stream.deny()))
    }

    /// Evidence and alarm as bytes, between traces.
    fn save<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        self.require_between()?;
        Ok(PyBytes::new(py, &self.state.borrow_dependent().save()))
    }

    /// Goes on from these bytes.
    fn restore(&mut self, state: &[u8]) -> PyResult<()> {
        self.require_between()?;
        let restored = self.state.with_dependent_mut(|_, stream| stream.restore(state));
        restored.map_err(|problem| refused(format!("no state of this detector: {problem}")))
    }

    /// Forgets all samples and evidence.
    fn reset(&mut self) {
        self.state = start(self.state.borrow_owner());
    }
}

/// The samples of a piece, whose time is that of the model's rate if it has steps.
fn piece(own: &Own, table: Arc<Recorded>) -> Result<Trace, Error> {
    let mut traces = traces::read_piece(&table, own.file.channels())?;
    check_rate(&own.file.model, own.file.preparation(), traces.iter())?;
    traces.pop().filter(|_| traces.is_empty()).ok_or_else(|| Error::Usage("the samples are of several traces".into()))
}

impl Detector {
    fn taken(&self) -> usize {
        self.state.borrow_dependent().taken()
    }

    fn require_between(&self) -> PyResult<()> {
        let open = "a trace is open, whose samples came by step; call finish or reset first";
        if self.taken() == 0 { Ok(()) } else { Err(refused(open)) }
    }

    fn whole(&mut self, trace: &Trace) -> Vec<Judged> {
        self.state.with_dependent_mut(|_, stream| stream.run(trace, self.run_a_trace))
    }

    fn to_dict<'py>(&self, py: Python<'py>, judged: &[Judged]) -> PyResult<Bound<'py, PyDict>> {
        let file = &self.state.borrow_owner().file;
        let model = &file.model;
        let result = PyDict::new(py);
        let column = |of: &dyn Fn(&Judged) -> f32| PyArray1::from_iter(py, judged.iter().map(of));
        let count = |of: &dyn Fn(&Judged) -> usize| PyArray1::from_iter(py, judged.iter().map(|own| of(own) as i64));
        let wide = |width: usize, of: &dyn Fn(&Judged) -> Vec<f32>| -> PyResult<Bound<'py, PyArray2<f32>>> {
            let rows = judged.iter().map(|own| {
                let mut row = of(own);
                row.resize(width, f32::NAN);
                row
            });
            rows_to_array(py, rows.collect(), width)
        };
        let classes = model.classes.len();
        result.set_item("start", count(&|(own, _)| own.start))?;
        result.set_item("length", count(&|(own, _)| own.length))?;
        let verdict = |(own, _): &Judged| {
            own.verdict.as_ref().map_or_else(|_| "undetermined".to_string(), |found| found.name(&model.classes).into())
        };
        result.set_item("verdict", judged.iter().map(verdict).collect::<Vec<_>>())?;
        let reason = |(own, _): &Judged| own.verdict.as_ref().err().cloned().unwrap_or_default();
        result.set_item("undetermined", judged.iter().map(reason).collect::<Vec<_>>())?;
        result.set_item("posterior", wide(classes, &|(own, _)| own.posteriors.clone())?)?;
        result.set_item("log_likelihood", wide(classes, &|(own, _)| own.log_likelihoods.clone())?)?;
        let judged_only = |own: &SegmentReport, value: f32| if own.verdict.is_ok() { value } else { f32::NAN };
        result.set_item("distance", column(&|(own, _)| judged_only(own, own.distance)))?;
        result.set_item("surprise", column(&|(own, _)| judged_only(own, own.surprise)))?;
        result.set_item("score", column(&|(_, watched)| watched.score))?;
        result.set_item("alarm", PyArray1::from_iter(py, judged.iter().map(|(_, own)| own.alarm.is_some())))?;
        let cause = |(_, own): &Judged| model.cause(own, file.orders()).unwrap_or_default();
        result.set_item("cause", judged.iter().map(cause).collect::<Vec<_>>())?;
        let ends = |of: Interval| vec![of.value, of.low, of.high];
        let growth = |of: &dyn Fn(Growth) -> Option<Interval>| {
            let row = |(_, own): &Judged| own.growth.and_then(|(_, growth)| of(growth)).map_or_else(Vec::new, ends);
            wide(3, &row)
        };
        let direction = |(_, own): &Judged| {
            own.growth.map_or_else(String::new, |(direction, _)| model.direction_name(file.orders(), direction))
        };
        result.set_item("direction", judged.iter().map(direction).collect::<Vec<_>>())?;
        result.set_item("size", growth(&|growth| Some(growth.size))?)?;
        result.set_item("growth", growth(&|growth| Some(growth.slope_per_hour()))?)?;
        result.set_item("hours_left", growth(&|growth| growth.left_hours())?)?;
        let names = model.structure().map_or_else(Vec::new, |own| own.names());
        let raw = |(own, _): &Judged| if own.estimated { own.raw.clone() } else { vec![] };
        result.set_item("parameters", wide(names.len(), &raw)?)?;
        result.set_item("variance", column(&|(own, _)| if own.estimated { own.variance } else { f32::NAN }))?;
        result.set_item("features", self.features(py, judged)?)?;
        let orders = file.orders().len();
        result.set_item("prominence", wide(orders, &|(own, _)| own.orders.iter().map(|o| o.prominence).collect())?)?;
        result.set_item("amplitude", wide(orders, &|(own, _)| own.orders.iter().map(|o| o.amplitude).collect())?)?;
        result.set_item("slip", wide(orders, &|(own, _)| own.orders.iter().map(|o| o.slip).collect())?)?;
        let friction = |(own, _): &Judged| {
            let of = own.friction.filter(|own| own.rows > 0);
            let each = |own: bearing_watch::shaft::Friction| {
                FrictionTerm::ALL.map(|term| own.parameter(term).map_or(f32::NAN, |own| own.value)).to_vec()
            };
            of.map_or_else(Vec::new, each)
        };
        let watched = if model.shaft().is_some() { FrictionTerm::ALL.len() } else { 0 };
        result.set_item("friction", wide(watched, &friction)?)?;
        result.set_item("rows", count(&|(own, _)| own.rows as usize))?;
        result.set_item("rejected", count(&|(own, _)| own.counts.rejected as usize))?;
        result.set_item("saturated", count(&|(own, _)| own.counts.saturated as usize))?;
        result.set_item("lacking", judged.iter().map(|(own, _)| file.lacking(own).join(" ")).collect::<Vec<_>>())?;
        result.set_item("parameter_names", names)?;
        Ok(result)
    }

    /// The features in use of each segment; NaN for missing ones.
    fn features<'py>(&self, py: Python<'py>, judged: &[Judged]) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let file = &self.state.borrow_owner().file;
        let catalogue = file.model.catalogue(file.orders());
        let names = catalogue.names();
        let places: Vec<Option<usize>> =
            file.features().iter().map(|name| names.iter().position(|own| own == name)).collect();
        let rows = judged.iter().map(|(own, _)| {
            let (values, variances) = features_of(own, &catalogue);
            let value = |place: &Option<usize>| match place.and_then(|k| Some((values.get(k)?, variances.get(k)?))) {
                Some((value, variance)) if variance.is_finite() => *value,
                _ => f64::NAN,
            };
            places.iter().map(value).collect()
        });
        rows_to_array(py, rows.collect(), places.len())
    }
}

/// Rows of this width as an array, also without rows.
fn rows_to_array<T: numpy::Element + Copy>(
    py: Python<'_>,
    rows: Vec<Vec<T>>,
    width: usize,
) -> PyResult<Bound<'_, PyArray2<T>>> {
    use numpy::PyArrayMethods as _;
    let count = rows.len();
    PyArray1::from_vec(py, rows.concat()).reshape([count, width])
}
