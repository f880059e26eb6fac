//! Rows of one class as their count, mean and scatter.

use nalgebra::{DMatrix, DVector};

/// Rows of one class whose values have the same variances of their errors.
#[derive(Clone, Debug)]
pub struct Cell {
    /// Index of the class.
    pub class: usize,
    /// Number of rows.
    pub count: f64,
    /// Variances of the errors.
    pub variance: DVector<f64>,
    /// Mean of the rows; of missing values any number.
    pub mean: DVector<f64>,
    /// Scatter of the rows about it; of missing values any number.
    pub scatter: DMatrix<f64>,
}

/// Weighted scatter about the weighted means of the classes.
pub(super) fn within(cells: &[(f64, &Cell)], classes: usize) -> DMatrix<f64> {
    let features = cells.first().map_or(0, |(_, cell)| cell.mean.len());
    let mut scatter = DMatrix::zeros(features, features);
    for class in 0..classes {
        let own = || cells.iter().filter(move |(_, cell)| cell.class == class);
        let sum = own().map(|(weight, cell)| weight * cell.count).sum::<f64>();
        let mean = own().fold(DVector::zeros(features), |mean, (w, cell)| mean + &cell.mean * (w * cell.count / sum));
        for (weight, cell) in own() {
            let away = &cell.mean - &mean;
            scatter.ger(weight * cell.count, &away, &away, 1.0);
            scatter += &cell.scatter * *weight;
        }
    }
    scatter
}
