//! The streaming estimator of the firmware on arrays.

use std::sync::Arc;

use model::recursive::{How, Recursive, Running};
use model::settings::Method;
use numpy::{PyArray1, PyArray2, PyArrayMethods as _, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use self_cell::self_cell;

use crate::errors::{raised, refused};
use crate::pool::detached;
use crate::signals::{order_of, trace_of};

self_cell!(
    struct State {
        owner: Arc<Recursive>,
        #[covariant]
        dependent: Running,
    }
);

/// An estimator with fading memory.
#[pyclass(module = "bearing_watch._core")]
pub(crate) struct RecursiveEstimator {
    state: State,
}

impl std::fmt::Debug for RecursiveEstimator {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("RecursiveEstimator").finish_non_exhaustive()
    }
}

fn start(own: Arc<Recursive>) -> State {
    State::new(own, |own| own.start())
}

#[pymethods]
impl RecursiveEstimator {
    /// With the scales of a reference record: a dictionary with y, u1 and perhaps u2.
    #[new]
    #[pyo3(signature = (reference, order, *, offset, method, forgetting, every))]
    fn new(
        py: Python<'_>,
        reference: &Bound<'_, PyAny>,
        order: &str,
        offset: bool,
        method: &str,
        forgetting: f64,
        every: u32,
    ) -> PyResult<Self> {
        let method = match method {
            "ls" => Method::Ls,
            "instruments" => Method::Instruments,
            other => return Err(refused(format!("no method {other}; there are ls, instruments"))),
        };
        let structure = order_of(order, offset)?;
        let trace = trace_of("reference", reference, structure)?;
        let how = How { method, forgetting, every };
        let estimator = detached(py, || Recursive::new(trace, structure, how)).map_err(raised)?;
        Ok(Self { state: start(Arc::new(estimator)) })
    }

    /// Names of the parameters.
    #[getter]
    fn names(&self) -> Vec<String> {
        self.state.borrow_owner().names()
    }

    /// Takes the next samples; returns the estimates that are due, as arrays with one row each.
    fn step<'py>(
        &mut self,
        py: Python<'py>,
        y: PyReadonlyArray1<'py, f64>,
        u1: PyReadonlyArray1<'py, f64>,
        u2: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let [y, u1, u2] = [&y, &u1, &u2].map(|signal| signal.as_array().to_vec());
        if u1.len() != y.len() || u2.len() != y.len() {
            return Err(refused("y, u1 and u2 are of one length"));
        }
        let estimates = detached(py, || self.state.with_dependent_mut(|_, running| running.take([&y, &u1, &u2])));
        let (count, n) = (estimates.len(), self.names().len());
        let theta: Vec<f64> = estimates.iter().flat_map(|estimate| estimate.theta.iter().copied()).collect();
        let covariance: Vec<f64> = estimates.iter().flat_map(|estimate| estimate.covariance.iter().copied()).collect();
        let result = PyDict::new(py);
        result
            .set_item("samples", PyArray1::from_iter(py, estimates.iter().map(|estimate| estimate.samples as i64)))?;
        let theta: Bound<'_, PyArray2<f64>> = PyArray1::from_vec(py, theta).reshape([count, n])?;
        result.set_item("theta", theta)?;
        // A covariance is symmetric: rows are columns.
        result.set_item("covariance", PyArray1::from_vec(py, covariance).reshape([count, n, n])?)?;
        result.set_item("variance", PyArray1::from_iter(py, estimates.iter().map(|estimate| estimate.variance)))?;
        result.set_item("rows", PyArray1::from_iter(py, estimates.iter().map(|estimate| i64::from(estimate.rows))))?;
        let reasons: Vec<String> = estimates.into_iter().map(|estimate| estimate.reason.unwrap_or_default()).collect();
        result.set_item("reason", reasons)?;
        Ok(result)
    }

    /// Forgets all samples.
    fn reset(&mut self) {
        self.state = start(Arc::clone(self.state.borrow_owner()));
    }
}
