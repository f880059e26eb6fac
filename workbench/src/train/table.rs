//! Labelled rows of features, and affine maps of them.

use nalgebra::{DMatrix, DVector};

use crate::core::features;
use crate::identify::Estimate;

/// Raw features of the training traces, with their classes.
#[derive(Clone, Debug)]
pub struct FeatureTable {
    /// One row per trace: every raw feature ([`features::all_names`]).
    pub rows: Vec<DVector<f64>>,
    /// Class of each row.
    pub classes: Vec<usize>,
    /// Class names.
    pub names: Vec<String>,
}

impl FeatureTable {
    /// Creates the table from estimates in the order of the traces.
    #[must_use]
    pub fn new(estimates: &[Estimate], classes: Vec<usize>, names: Vec<String>) -> Self {
        Self { rows: estimates.iter().map(features::vector).collect(), classes, names }
    }

    /// Returns the given features only.
    #[must_use]
    pub fn select(&self, places: &[usize]) -> Self {
        let pick = |row: &DVector<f64>| DVector::from_iterator(places.len(), places.iter().map(|&k| row[k]));
        Self { rows: self.rows.iter().map(pick).collect(), classes: self.classes.clone(), names: self.names.clone() }
    }

    /// Returns the table with every row mapped.
    #[must_use]
    pub fn map(&self, map: &AffineMap) -> Self {
        Self { rows: self.rows.iter().map(|row| map.apply(row)).collect(), ..self.clone() }
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
}
