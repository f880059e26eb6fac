//! Training on a matrix of features, without traces and without a detector: a classifier, and a gate.

use nalgebra::DVector;

use super::fit;
use crate::Error;
use crate::train::novelty::{Gate, gate_of_runs};
use crate::train::{Candidates, FeatureTable, Recipe};

/// Rows of features; NaN is a missing value.
#[derive(Clone, Debug)]
pub struct Matrix {
    /// Values of each row.
    pub rows: Vec<Vec<f64>>,
    /// Names of the columns.
    pub names: Vec<String>,
}

impl Matrix {
    fn table(&self, classes: Vec<usize>, names: Vec<String>) -> FeatureTable {
        let (rows, variances) = self.rows.iter().map(|row| observed(row)).unzip();
        let usual = DVector::zeros(self.names.len());
        FeatureTable { rows, variances, usual, classes, names }
    }
}

/// A row with the variances of its errors: none, or infinite for a missing value.
fn observed(row: &[f64]) -> (DVector<f64>, DVector<f64>) {
    let each = |x: &f64| if x.is_nan() { (0.0, f64::INFINITY) } else { (*x, 0.0) };
    let (values, variances): (Vec<f64>, Vec<f64>) = row.iter().map(each).unzip();
    (DVector::from_vec(values), DVector::from_vec(variances))
}

/// A classifier of rows.
#[derive(Clone, Debug)]
pub struct RowClassifier {
    fitted: fit::Fitted,
}

impl RowClassifier {
    /// Fits projection, discriminant and shrinkage of a recipe to labelled rows; each row has the index of its class,
    /// and every class has a row.
    ///
    /// # Errors
    /// Features that are constant or collinear within classes; priors or costs that do not match the classes.
    pub fn fit(matrix: &Matrix, classes: &[usize], names: &[String], recipe: &Recipe) -> Result<Self, Error> {
        let few = (0..names.len()).find(|class| !classes.contains(class));
        if let Some(class) = few {
            return Err(Error::Training(format!("class {} has no rows", names[class])));
        }
        if classes.len() != matrix.rows.len() || classes.len() <= names.len() {
            let (rows, count) = (matrix.rows.len(), names.len());
            return Err(Error::Training(format!("{rows} rows are too few for {count} classes; give more")));
        }
        let table = matrix.table(classes.to_vec(), names.to_vec());
        let groups = (0..classes.len()).collect();
        let candidates = Candidates { table, features: matrix.names.clone(), groups, covariates: None };
        Ok(Self { fitted: fit::fit(&candidates, recipe)? })
    }

    /// Returns ln P(class | row) of every class, and the class of least expected cost.
    #[must_use]
    pub fn predict(&self, row: &[f64]) -> (Vec<f64>, usize) {
        let (value, variance) = observed(row);
        let (z, variances) = self.fitted.projection.apply_with(&value, &variance);
        let log_posteriors = self.fitted.densities.log_posteriors(&z, &variances);
        let decided = self.fitted.densities.decide(&log_posteriors);
        (log_posteriors, decided)
    }
}

/// A novelty gate of rows.
#[derive(Clone, Debug)]
pub struct RowGate {
    gate: Gate,
}

impl RowGate {
    /// Fits the gate of healthy rows, each of a run if these are given, for a false-alarm rate.
    ///
    /// # Errors
    /// Too few rows or runs for the rate; features that are constant or collinear.
    pub fn fit(matrix: &Matrix, runs: Option<&[usize]>, rate: f64) -> Result<Self, Error> {
        let table = matrix.table(vec![0; matrix.rows.len()], vec!["healthy".into()]);
        Ok(Self { gate: gate_of_runs(&table, runs, rate)? })
    }

    /// The surprise at which a row is novel, nats.
    #[must_use]
    pub const fn limit(&self) -> f64 {
        self.gate.limit
    }

    /// The surprise of a row: −ln of the probability that a healthy one is as distant, nats; infinite if no value of
    /// it is there.
    #[must_use]
    pub fn surprise(&self, row: &[f64]) -> f64 {
        if row.iter().all(|x| x.is_nan()) {
            return f64::INFINITY;
        }
        let (value, variance) = observed(row);
        self.gate.surprise(&value, &variance).unwrap_or(f64::INFINITY)
    }
}
