//! The classifier and the novelty gate on matrices of features, for estimators in the style of scikit-learn.

use bearing_watch::plan::Kind;
use model::identify::Structure;
use model::train::{self, Keep, Matrix, ProjectionKind, Recipe, Shrink, Shrinkage};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::errors::{raised, refused};
use crate::pool::detached;

fn matrix(x: &PyReadonlyArray2<'_, f64>, names: Vec<String>) -> PyResult<Matrix> {
    let rows: Vec<Vec<f64>> = x.as_array().rows().into_iter().map(|row| row.to_vec()).collect();
    if rows.iter().any(|row| row.len() != names.len()) {
        return Err(refused("one name for each feature"));
    }
    Ok(Matrix { rows, names })
}

/// Logarithms of posteriors, and indices of decided classes.
type Predicted<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<i64>>);

/// A Gaussian classifier.
#[pyclass(frozen, module = "bearing_watch._core")]
#[derive(Debug)]
pub(crate) struct RowClassifier {
    own: train::RowClassifier,
    width: usize,
}

#[pymethods]
impl RowClassifier {
    /// Fits; classes are indices into the names.
    #[new]
    #[expect(clippy::too_many_arguments, reason = "called by the package alone")]
    fn new(
        py: Python<'_>,
        x: PyReadonlyArray2<'_, f64>,
        classes: Vec<usize>,
        class_names: Vec<String>,
        names: Vec<String>,
        discriminant: &str,
        shrinkage: Option<[f64; 2]>,
        projection: &str,
        components: Option<usize>,
        priors: Vec<f64>,
        cost: Vec<Vec<f64>>,
    ) -> PyResult<Self> {
        let keep = components.map_or(Keep::Variance(0.99), Keep::Components);
        let projection = match projection {
            "none" => ProjectionKind::None,
            "pca" => ProjectionKind::Pca { keep, standardised: true },
            "pca-raw" => ProjectionKind::Pca { keep, standardised: false },
            "fisher" => ProjectionKind::Fisher { components },
            other => return Err(refused(format!("no projection {other}; there are none, pca, pca-raw, fisher"))),
        };
        let (discriminant, shrink) = match (discriminant, shrinkage) {
            (_, Some([lambda, gamma])) => (Kind::Linear, Shrink::To(Shrinkage { lambda, gamma })),
            ("linear", None) => (Kind::Linear, Shrink::Not),
            ("quadratic", None) => (Kind::Quadratic, Shrink::Not),
            ("shrunk", None) => (Kind::Linear, Shrink::Chosen),
            (other, None) => {
                return Err(refused(format!("no discriminant {other}; there are linear, quadratic, shrunk")));
            }
        };
        let plain = Recipe::new(Structure::new(0, 0, 0, 0, 0));
        let recipe = Recipe { projection, discriminant, shrink, priors, cost, ..plain };
        let (matrix, width) = (matrix(&x, names)?, x.as_array().ncols());
        let own =
            detached(py, || train::RowClassifier::fit(&matrix, &classes, &class_names, &recipe)).map_err(raised)?;
        Ok(Self { own, width })
    }

    /// Logarithms of the posteriors (rows × classes), and the index of the decided class of each row.
    fn predict<'py>(&self, py: Python<'py>, x: PyReadonlyArray2<'py, f64>) -> PyResult<Predicted<'py>> {
        let matrix = matrix(&x, vec![String::new(); self.width])?;
        let found: Vec<(Vec<f64>, usize)> =
            detached(py, || matrix.rows.par_iter().map(|row| self.own.predict(row)).collect());
        let (posteriors, decided): (Vec<Vec<f64>>, Vec<i64>) =
            found.into_iter().map(|(posteriors, class)| (posteriors, class as i64)).unzip();
        Ok((PyArray2::from_vec2(py, &posteriors)?, decided.into_pyarray(py)))
    }
}

/// A novelty gate.
#[pyclass(frozen, module = "bearing_watch._core")]
#[derive(Debug)]
pub(crate) struct RowGate {
    own: train::RowGate,
    width: usize,
}

#[pymethods]
impl RowGate {
    /// Fits; runs are numbers in the order of time.
    #[new]
    fn new(
        py: Python<'_>,
        x: PyReadonlyArray2<'_, f64>,
        runs: Option<Vec<usize>>,
        names: Vec<String>,
        false_alarm: f64,
    ) -> PyResult<Self> {
        let (matrix, width) = (matrix(&x, names)?, x.as_array().ncols());
        let own = detached(py, || train::RowGate::fit(&matrix, runs.as_deref(), false_alarm)).map_err(raised)?;
        Ok(Self { own, width })
    }

    /// The surprise from which on a row is novel, nats.
    #[getter]
    const fn limit(&self) -> f64 {
        self.own.limit()
    }

    /// The surprise of each row, nats.
    fn surprise<'py>(&self, py: Python<'py>, x: PyReadonlyArray2<'py, f64>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let matrix = matrix(&x, vec![String::new(); self.width])?;
        let found: Vec<f64> = detached(py, || matrix.rows.par_iter().map(|row| self.own.surprise(row)).collect());
        Ok(found.into_pyarray(py))
    }
}
