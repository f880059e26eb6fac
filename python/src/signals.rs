//! Identification, structure search and validation of signals in arrays.

use std::sync::Arc;

use model::Error;
use model::identify::{Estimate, Method, Noise, Options, Structure, Terms, estimate_with, parse_order};
use model::identify::{estimate, robust as robust_of, simulate};
use model::session::refuse_gaps;
use model::structure::{Candidate, Estimator, Grid, Search, search};
use model::trace::{Channels, Preparation, Recorded, Trace};
use model::validate::roots::Root;
use model::validate::{Correlation, Errors, Test, Validation, is_white, validate as validation};
use numpy::{IntoPyArray, PyArray1, PyArray2, ToPyArray};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use traces::Source;

use crate::errors::{raised, refused};
use crate::pool::detached;
use crate::tables::{table, tables};

/// Largest lag of a residual test.
const MOST_LAGS: usize = 500;

/// Traces of tables with the columns y, u1 and perhaps u2.
fn traces(tables: Vec<Arc<Recorded>>) -> Result<Vec<Trace>, Error> {
    let second = tables.iter().all(|table| table.names().any(|name| name == "u2"));
    let command = tables.iter().all(|table| table.names().any(|name| name == "instruments"));
    let further = if command { vec!["instruments".into()] } else { vec![] };
    let channels = Channels::new("y", "u1", if second { "u2" } else { "u1" });
    Source::Memory(tables).read(&Channels { further, ..channels })
}

/// Structure by its five numbers.
pub(crate) fn order_of(order: &str, offset: bool) -> PyResult<Structure> {
    Ok(Structure { offset, ..parse_order(order).map_err(refused)? })
}

/// na, nb, nc, nkb, nkc; as bytes, Python would take them for a text.
fn numbers(structure: Structure) -> [u32; 5] {
    structure.orders().map(u32::from)
}

fn named<T: Copy>(word: &str, known: &[(&str, T)]) -> PyResult<T> {
    let found = known.iter().find(|(name, _)| *name == word);
    let names = || known.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
    found.map(|(_, value)| *value).ok_or_else(|| refused(format!("no method {word}; there are {}", names())))
}

fn method_of(word: &str) -> PyResult<Method> {
    named(
        word,
        &[
            ("ls", Method::Ls),
            ("iv", Method::Iv),
            ("iv-command", Method::IvCommand),
            ("iv4", Method::Iv4),
            ("sriv", Method::Sriv),
            ("sm", Method::Sm),
            ("oe", Method::Oe),
            ("armax", Method::Armax),
        ],
    )
}

/// The trace of a table.
pub(crate) fn trace_of(name: &str, signals: &Bound<'_, PyAny>, order: Structure) -> PyResult<Trace> {
    let signals = table(name, signals)?;
    require(&signals, order)?;
    let mut found = traces(vec![signals]).map_err(raised)?;
    found.pop().ok_or_else(|| refused("no samples"))
}

fn require(table: &Recorded, order: Structure) -> PyResult<()> {
    let nc = order.nc;
    if nc == 0 || table.names().any(|name| name == "u2") {
        return Ok(());
    }
    Err(refused(format!("the order has {nc} terms of a second input; give u2, or an order with nc = 0")))
}

/// Estimates a difference model; `signals` is a dictionary with y, u1 and perhaps u2.
#[pyfunction]
#[pyo3(signature = (name, signals, order, *, offset, method, passes, noise_order, robust))]
#[expect(clippy::too_many_arguments, reason = "named by Python's signature")]
pub(crate) fn identify<'py>(
    py: Python<'py>,
    name: &str,
    signals: &Bound<'py, PyAny>,
    order: &str,
    offset: bool,
    method: &str,
    passes: usize,
    noise_order: Option<usize>,
    robust: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let (structure, method) = (order_of(order, offset)?, method_of(method)?);
    if !(1..=3).contains(&passes) || noise_order.is_some_and(|order| order > 32) {
        return Err(refused("passes is 1 to 3, and noise_order at most 32"));
    }
    if robust && method != Method::Ls {
        return Err(refused(
            "robust goes with least squares; the deviations of iv allow for coloured residuals anyway",
        ));
    }
    let trace = trace_of(name, signals, structure)?;
    let options = Options { passes, noise_order };
    let (estimate, simulated) = detached(py, || {
        let estimate = estimate_with(&trace, structure, method, options)?;
        let estimate = if robust { robust_of(&trace, estimate)? } else { estimate };
        let simulated = simulate(&trace, structure, estimate.theta.as_slice());
        Ok((estimate, simulated))
    })
    .map_err(raised)?;
    let result = estimate_to_dict(py, &estimate)?;
    result.set_item("undetermined", estimate.undetermined(&trace))?;
    result.set_item("simulated", simulated.into_pyarray(py))?;
    Ok(result)
}

fn estimate_to_dict<'py>(py: Python<'py>, estimate: &Estimate) -> PyResult<Bound<'py, PyDict>> {
    let (kind, polynomial) = match &estimate.noise {
        Noise::Equation => ("equation", vec![]),
        Noise::Output => ("output", vec![]),
        Noise::Autoregressive(terms) => ("autoregressive", terms.clone()),
        Noise::MovingAverage { terms, .. } => ("moving_average", terms.clone()),
    };
    let convergence = estimate.convergence;
    let result = PyDict::new(py);
    result.set_item("order", numbers(estimate.structure))?;
    result.set_item("offset", estimate.structure.offset)?;
    result.set_item("names", estimate.structure.names())?;
    result.set_item("theta", estimate.theta.as_slice().to_pyarray(py))?;
    result.set_item("sd", estimate.deviations().into_pyarray(py))?;
    let rows = estimate.covariance.row_iter().map(|row| row.iter().copied().collect());
    result.set_item("covariance", PyArray2::from_vec2(py, &rows.collect::<Vec<_>>())?)?;
    result.set_item("variance", estimate.variance)?;
    result.set_item("rows", estimate.rows)?;
    result.set_item("fit_percent", estimate.fit_percent)?;
    result.set_item("prediction_fit_percent", estimate.prediction_fit_percent)?;
    result.set_item("residuals", estimate.residuals.to_pyarray(py))?;
    result.set_item("white", is_white(&estimate.residuals))?;
    result.set_item("noise", kind)?;
    result.set_item("noise_polynomial", polynomial.into_pyarray(py))?;
    result.set_item("converged", convergence.converged)?;
    result.set_item("iterations", convergence.iterations)?;
    result.set_item("stable", convergence.stable)?;
    Ok(result)
}

/// Searches structures; training and validation are lists of (name, signals).
#[pyfunction]
#[pyo3(signature = (training, validation, max_order, min_order, *, offset, method))]
pub(crate) fn structure<'py>(
    py: Python<'py>,
    training: &Bound<'py, PyList>,
    validation: &Bound<'py, PyList>,
    max_order: [u8; 5],
    min_order: [u8; 5],
    offset: bool,
    method: &str,
) -> PyResult<Bound<'py, PyDict>> {
    let estimator = named(method, &[("ls", Estimator::Ls), ("iv4", Estimator::Iv4)])?;
    if let Some(large) = max_order.iter().chain(&min_order).find(|number| **number > 32) {
        return Err(refused(format!("{large} terms or delays are more than 32")));
    }
    let (min, max) = (Structure::from_orders(min_order), Structure::from_orders(max_order));
    let structures = Grid { min, max, offset }.structures().map_err(raised)?;
    let (training, validation) = (tables(training)?, tables(validation)?);
    training.iter().chain(&validation).try_for_each(|table| require(table, max))?;
    let found = detached(py, || {
        let whole = |own: Vec<Arc<Recorded>>| {
            traces(own)?.iter().map(|trace| Preparation::NONE.apply(trace)).collect::<Result<Vec<_>, _>>()
        };
        search(&whole(training)?, &whole(validation)?, &structures, estimator)
    })
    .map_err(raised)?;
    search_to_dict(py, &found)
}

fn search_to_dict<'py>(py: Python<'py>, found: &Search) -> PyResult<Bound<'py, PyDict>> {
    let Some(best) = found.best_fit() else {
        let reason = found.refused.first().map(|own| own.reason.clone()).unwrap_or_default();
        return Err(refused(format!("no structure can be estimated ({reason}); use a richer command")));
    };
    let all = &found.candidates;
    let result = PyDict::new(py);
    let orders = all.iter().map(|own| own.fitted.structure.orders().map(i64::from).to_vec());
    result.set_item("orders", PyArray2::from_vec2(py, &orders.collect::<Vec<_>>())?)?;
    let column = |of: fn(&Candidate) -> f64| PyArray1::from_iter(py, all.iter().map(of));
    result.set_item("fit_percent", column(|own| own.fit_percent))?;
    result.set_item("aic", column(|own| own.fitted.aic()))?;
    result.set_item("mdl", column(|own| own.fitted.mdl()))?;
    result.set_item("variance", column(|own| own.fitted.variance()))?;
    let counts = all.iter().map(|own| own.fitted.parameters() as i64);
    result.set_item("parameters", PyArray1::from_iter(py, counts))?;
    result.set_item("stable", PyArray1::from_iter(py, all.iter().map(|own| own.stable)))?;
    let orders = |own: Option<&Candidate>| own.map(|own| numbers(own.fitted.structure));
    result.set_item("best_fit", orders(Some(best)))?;
    result.set_item("best_aic", orders(found.best_aic()))?;
    result.set_item("best_mdl", orders(found.best_mdl()))?;
    let refused = found.refused.iter().map(|own| (numbers(own.structure), own.reason.clone()));
    result.set_item("refused", refused.collect::<Vec<_>>())?;
    Ok(result)
}

/// Estimates a model and tests it on its own trace.
#[pyfunction]
#[pyo3(signature = (name, signals, order, *, offset, method, lags))]
pub(crate) fn validate<'py>(
    py: Python<'py>,
    name: &str,
    signals: &Bound<'py, PyAny>,
    order: &str,
    offset: bool,
    method: &str,
    lags: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let (structure, method) = (order_of(order, offset)?, method_of(method)?);
    if !(1..=MOST_LAGS).contains(&lags) {
        return Err(refused(format!("lags is 1 to {MOST_LAGS}")));
    }
    let trace = trace_of(name, signals, structure)?;
    let (estimate, found) = detached(py, || {
        refuse_gaps(&trace)?;
        let estimate = estimate(&trace, structure, method)?;
        let found = validation(&trace, &estimate, Errors::of(method), lags)?;
        Ok((estimate, found))
    })
    .map_err(raised)?;
    let result = validation_to_dict(py, &found)?;
    result.set_item("estimate", estimate_to_dict(py, &estimate)?)?;
    result.get_item("estimate")?.into_iter().try_for_each(|own| {
        own.set_item("undetermined", estimate.undetermined(&trace))?;
        own.set_item("simulated", found.simulated.to_pyarray(py))
    })?;
    Ok(result)
}

fn validation_to_dict<'py>(py: Python<'py>, found: &Validation) -> PyResult<Bound<'py, PyDict>> {
    let test = |test: &Test| {
        let own = PyDict::new(py);
        own.set_item("passed", test.passed())?;
        own.set_item("tested", test.tested)?;
        own.set_item("outside", test.outside)?;
        own.set_item("allowed", test.allowed)?;
        own.set_item("largest", test.largest)?;
        own.set_item("limit", test.limit)?;
        own.into_py_any(py)
    };
    let correlation = |own: &Correlation| {
        (own.lags.to_pyarray(py), own.value.to_pyarray(py), own.bound.to_pyarray(py)).into_py_any(py)
    };
    let roots = |roots: &[Root]| {
        let (at, covariance): (Vec<[f64; 2]>, Vec<[[f64; 2]; 2]>) = roots
            .iter()
            .map(|root| ([root.at.re, root.at.im], [0, 1].map(|i| [0, 1].map(|k| root.covariance[(i, k)]))))
            .unzip();
        let separated: Vec<bool> = roots.iter().map(|root| root.separated).collect();
        (at, covariance, separated).into_py_any(py)
    };
    let result = PyDict::new(py);
    result.set_item("independence", test(&found.independence)?)?;
    result.set_item("whiteness", test(&found.whiteness)?)?;
    result.set_item("feedback", test(&found.feedback)?)?;
    result.set_item("autocorrelation", correlation(&found.autocorrelation)?)?;
    let [of_u1, of_u2] = &found.cross_correlation;
    result.set_item("cross_correlation_u1", correlation(of_u1)?)?;
    result.set_item("cross_correlation_u2", correlation(of_u2)?)?;
    result.set_item("poles", roots(&found.map.poles)?)?;
    result.set_item("zeros_u1", roots(&found.map.zeros[0])?)?;
    result.set_item("zeros_u2", roots(&found.map.zeros[1])?)?;
    result.set_item("removable", found.map.removable.clone())?;
    Ok(result)
}
