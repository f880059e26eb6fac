//! The least maximum error of a linear combination.

use nalgebra::{DMatrix, DVector};

/// Returns the coefficients x for which the largest element of |`columns` x − `wanted`| is about the least, by least
/// squares whose weights increase where the error is large (Lawson's method).
pub(super) fn minimax(columns: &DMatrix<f64>, wanted: &DVector<f64>) -> DVector<f64> {
    const ROUNDS: usize = 200;
    let (rows, unknowns) = columns.shape();
    let mut weights = DVector::from_element(rows, 1.0 / rows as f64);
    let mut x = DVector::zeros(unknowns);
    for _ in 0..ROUNDS {
        let roots = weights.map(f64::sqrt);
        let weighted = DMatrix::from_fn(rows, unknowns, |row, k| roots[row] * columns[(row, k)]);
        let (q, r) = weighted.qr().unpack();
        let target = q.transpose() * roots.component_mul(wanted);
        x = r.solve_upper_triangular(&target).unwrap_or(x);
        weights.component_mul_assign(&(columns * &x - wanted).abs());
        weights /= weights.sum();
    }
    x
}
