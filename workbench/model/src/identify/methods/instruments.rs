//! The linear system of instrumental variables, from orthogonally triangularised instruments.
//!
//! ```text
//! Z = [shared columns, own columns] = Q R      (1)  only Z is triangularised
//! [Z, X's own columns, y] → Qᵀ[…]              (2)  the same reflections are applied to the other columns
//! (QᵀX) θ = Qᵀy                                (3)
//! (ZᵀX)⁻¹ ZᵀZ (XᵀZ)⁻¹ = (QᵀX)⁻¹ (XᵀQ)⁻¹        (4)
//! ```
//!
//! X and Z share the columns of the inputs and the constant, so these columns are transformed only once. The parameters
//! of X are ordered a, b, c, constant: the columns that differ from those of Z come first.
//!
//! And the autoregressive model that whitens residuals, for their covariance.

use nalgebra::{DMatrix, DVector, Dyn, LU};

use crate::identify::kernel::triangle::Triangle;

/// The left side of (3), factored, and the right side.
pub(crate) struct System {
    lu: LU<f64, Dyn, Dyn>,
    rotated: DVector<f64>,
}

impl System {
    /// Builds (3) from (2); the first `own` columns of X and Z differ. If `negative`, these columns hold the signals
    /// with + sign, although the model has −.
    ///
    /// # Errors
    /// The index of the first parameter whose column of Z depends linearly on the columns before it.
    pub(crate) fn new(triangle: &Triangle, own: usize, negative: bool) -> Result<Self, usize> {
        let n = triangle.rows();
        if let Some(column) = triangle.dependent() {
            return Err((column + own) % n);
        }
        let mut matrix = DMatrix::zeros(n, n);
        for (k, mut column) in matrix.column_iter_mut().enumerate() {
            column.copy_from_slice(triangle.column(if k < own { n + k } else { k - own }));
        }
        if negative {
            matrix.columns_mut(0, own).neg_mut();
        }
        Ok(Self { lu: matrix.lu(), rotated: DVector::from_column_slice(triangle.column(n + own)) })
    }

    /// θ of (3), if finite.
    pub(crate) fn theta(&self) -> Option<DVector<f64>> {
        self.lu.solve(&self.rotated).filter(|theta| theta.iter().all(|p| p.is_finite()))
    }

    /// (QᵀX)⁻¹ of (4), if finite.
    pub(crate) fn inverse(&self) -> Option<DMatrix<f64>> {
        self.lu.try_inverse().filter(|inverse| inverse.iter().all(|p| p.is_finite()))
    }
}

/// (1) and (2) for one record.
pub(crate) fn rotate(shared: &[&[f64]], own: &[&[f64]], measured: &[&[f64]], y: &[f64]) -> Triangle {
    let n = shared.len() + own.len();
    let mut triangle = Triangle::new(n, n + measured.len() + 1);
    triangle.absorb_columns(&[shared, own, measured, &[y]].concat(), &mut Vec::new());
    triangle
}

/// AR polynomial `1 + l₁ q⁻¹ + … + l_n q⁻ⁿ` that whitens the noise, by least squares from the n-th sample of each
/// record.
pub(crate) fn autoregression(noise: &[&[f64]], n: usize) -> Option<Vec<f64>> {
    let mut triangle = Triangle::new(n, n + 1);
    let mut block = Vec::new();
    for w in noise {
        if w.len() <= 2 * n {
            return None;
        }
        let columns: Vec<&[f64]> = (1..=n).chain([0]).map(|lag| &w[n - lag..w.len() - lag]).collect();
        triangle.absorb_columns(&columns, &mut block);
    }
    if triangle.dependent().is_some() {
        return None;
    }
    let mut taps = triangle.column(n).to_vec();
    triangle.substitute(&mut taps);
    Some(std::iter::once(1.0).chain(taps.iter().map(|l| -l)).collect())
}
