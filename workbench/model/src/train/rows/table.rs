//! Labelled rows of features, and affine maps of them.

use nalgebra::{DMatrix, DVector};

use crate::train::distribution::moments::Observed;

/// Raw features of the training traces, with their classes.
#[derive(Clone, Debug)]
pub struct FeatureTable {
    /// One row per trace: every raw feature ([`crate::core::features::all_names`]); 0 if it is missing.
    pub rows: Vec<DVector<f64>>,
    /// What the variances of their errors exceed the usual ones; infinite if the feature is missing.
    pub variances: Vec<DVector<f64>>,
    /// The usual variances of the errors (`FeatureTable::with_usual_errors`); 0 if none are known.
    pub usual: DVector<f64>,
    /// Class of each row.
    pub classes: Vec<usize>,
    /// Class names.
    pub names: Vec<String>,
}

impl FeatureTable {
    /// Creates a table of values without errors, none missing.
    #[must_use]
    pub fn exact(rows: Vec<DVector<f64>>, classes: Vec<usize>, names: Vec<String>) -> Self {
        let variances = rows.iter().map(|row| DVector::zeros(row.len())).collect();
        let usual = DVector::zeros(rows.first().map_or(0, DVector::len));
        Self { rows, variances, usual, classes, names }
    }

    /// Takes the variances of the errors as they are, with their median as the usual one of each feature.
    ///
    /// The features of such rows scatter with their errors, whose correlations a covariance of the rows contains and
    /// a variance does not. An error below the usual one counts as usual.
    pub(crate) fn with_usual_errors(mut self) -> Self {
        for feature in 0..self.rows.first().map_or(0, DVector::len) {
            let own = self.variances.iter().map(|variance| variance[feature]).filter(|v| v.is_finite());
            let mut sorted: Vec<f64> = own.collect();
            sorted.sort_by(f64::total_cmp);
            self.usual[feature] = sorted.get(sorted.len() / 2).copied().unwrap_or(0.0);
        }
        let usual = self.usual.clone();
        self.beyond(&usual)
    }

    /// Takes these as the usual variances of the errors, as another table has found them.
    #[must_use]
    pub fn beyond(mut self, usual: &DVector<f64>) -> Self {
        for variance in &mut self.variances {
            *variance = variance.zip_map(usual, |own, usual| (own - usual).max(0.0));
        }
        self.usual.clone_from(usual);
        self
    }

    /// Returns whether no value has an error or is missing.
    #[must_use]
    pub fn is_exact(&self) -> bool {
        self.variances.iter().flatten().all(|variance| *variance <= 0.0)
    }

    /// Returns whether any value of a row is missing.
    #[must_use]
    pub fn is_partial(&self, row: usize) -> bool {
        self.variances[row].iter().any(|variance| !variance.is_finite())
    }

    /// Returns the indices of the rows of a class that have this feature.
    pub fn with(&self, class: usize, feature: usize) -> impl Iterator<Item = usize> {
        let of_class = (0..self.rows.len()).filter(move |&row| self.classes[row] == class);
        of_class.filter(move |&row| self.variances[row][feature].is_finite())
    }

    /// Returns the mean of each feature over the rows that have it; 0 for a feature that no row has.
    #[must_use]
    pub fn mean(&self) -> DVector<f64> {
        let features = self.rows.first().map_or(0, DVector::len);
        DVector::from_fn(features, |feature, _| {
            let own = self.rows.iter().zip(&self.variances).filter(|(_, variance)| variance[feature].is_finite());
            let (sum, count) = own.fold((0.0, 0.0), |(sum, count), (row, _)| (sum + row[feature], count + 1.0_f64));
            sum / count.max(1.0)
        })
    }

    /// Returns the given rows only.
    #[must_use]
    pub fn keep(&self, places: &[usize]) -> Self {
        let pick = |of: &[DVector<f64>]| places.iter().map(|&k| of[k].clone()).collect();
        let classes = places.iter().map(|&k| self.classes[k]).collect();
        let (rows, variances) = (pick(&self.rows), pick(&self.variances));
        Self { rows, variances, usual: self.usual.clone(), classes, names: self.names.clone() }
    }

    /// Returns the given features only.
    #[must_use]
    pub fn select(&self, places: &[usize]) -> Self {
        let pick = |row: &DVector<f64>| DVector::from_iterator(places.len(), places.iter().map(|&k| row[k]));
        let (rows, variances) = (self.rows.iter().map(pick).collect(), self.variances.iter().map(pick).collect());
        Self { rows, variances, usual: pick(&self.usual), classes: self.classes.clone(), names: self.names.clone() }
    }

    /// Returns the table with every row mapped, without usual variances.
    #[must_use]
    pub fn map(&self, map: &AffineMap) -> Self {
        let rows = self.rows.iter().zip(&self.variances);
        let (rows, variances) = rows.map(|(row, variance)| map.apply_with(row, variance)).unzip();
        let usual = DVector::zeros(map.matrix.nrows());
        Self { rows, variances, usual, classes: self.classes.clone(), names: self.names.clone() }
    }

    /// Returns the rows as observations.
    pub(crate) fn observed(&self) -> Vec<Observed<'_>> {
        let rows = self.rows.iter().zip(&self.variances).zip(&self.classes);
        rows.map(|((value, variance), &class)| Observed { value, variance, class }).collect()
    }
}

/// z = W (f − m).
#[derive(Clone, Debug)]
pub struct AffineMap {
    /// W, one row per coordinate.
    pub matrix: DMatrix<f64>,
    /// m.
    pub mean: DVector<f64>,
}

impl AffineMap {
    /// Applies the map.
    #[must_use]
    pub fn apply(&self, features: &DVector<f64>) -> DVector<f64> {
        &self.matrix * (features - &self.mean)
    }

    /// Applies the map to values whose errors have these variances, and returns those of the coordinates: Σ_j W_kj²
    /// v_j; infinite, and the value 0, if a missing feature has a weight.
    #[must_use]
    pub fn apply_with(&self, features: &DVector<f64>, variances: &DVector<f64>) -> (DVector<f64>, DVector<f64>) {
        let of_row = |row: usize| {
            let weights = self.matrix.row(row);
            let used = weights.iter().zip(variances.iter()).filter(|(w, _)| **w != 0.0);
            used.map(|(w, variance)| w * w * variance).sum()
        };
        let variances = DVector::from_fn(self.matrix.nrows(), |row, _| of_row(row));
        let missing = |variance: f64| !variance.is_finite();
        let values = self.apply(features).zip_map(&variances, |z, v| if missing(v) { 0.0 } else { z });
        (values, variances)
    }
}
