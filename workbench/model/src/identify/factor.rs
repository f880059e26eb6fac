//! The triangular factor of a regression, its solution, and the columns that depend on others.

use nalgebra::{DMatrix, DVector};

use super::kernel::sums::dot;
use super::kernel::triangle::Triangle;

/// A factored regression.
pub(super) struct Factor {
    triangle: Triangle,
    negative: usize,
    pub(super) theta: DVector<f64>,
}

/// The first linearly dependent column, and the earlier columns of which it is a combination.
pub(super) struct Dependent {
    pub(super) column: usize,
    pub(super) partners: Vec<usize>,
}

impl Factor {
    /// Factors the columns together with the target; the first `negative` columns have − sign in the model.
    pub(super) fn new<'a>(mut columns: Vec<&'a [f64]>, negative: usize, target: &'a [f64]) -> Result<Self, Dependent> {
        let n = columns.len();
        columns.push(target);
        let mut triangle = Triangle::new(n, n + 1);
        triangle.absorb_columns(&columns, &mut Vec::new());
        if let Some(column) = triangle.dependent() {
            return Err(Dependent { column, partners: partners(&triangle, column) });
        }
        let mut theta = DVector::from_column_slice(triangle.column(n));
        triangle.substitute(theta.as_mut_slice());
        theta.iter_mut().take(negative).for_each(|a| *a = -*a);
        Ok(Self { triangle, negative, theta })
    }

    /// (XᵀX)⁻¹.
    pub(super) fn cofactor(&self) -> DMatrix<f64> {
        let n = self.theta.len();
        let mut inverse = DMatrix::identity(n, n);
        for k in 0..n {
            self.triangle.substitute(&mut inverse.as_mut_slice()[k * n..][..=k]);
        }
        inverse.rows_mut(0, self.negative).neg_mut();
        &inverse * inverse.transpose()
    }
}

/// The earlier columns of which a dependent column is a linear combination.
fn partners(triangle: &Triangle, dependent: usize) -> Vec<usize> {
    let norm = |k: usize| dot(&triangle.column(k)[..=k], &triangle.column(k)[..=k]).sqrt();
    let mut shares = triangle.column(dependent)[..dependent].to_vec();
    triangle.substitute(&mut shares);
    // Rounding errors, amplified by near-dependence among the earlier columns, stay below this limit.
    let least = 1e-6 * norm(dependent);
    (0..dependent).filter(|&k| (shares[k] * norm(k)).abs() > least).collect()
}
