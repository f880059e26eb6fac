//! Errors of features of which only the mean variance is known.
//!
//! ```text
//! S ≈ Σ + V̄,   t = min(1, (1 − √(2/(n−1))) / λmax(S⁻¹ V̄)),   Σ̂ = S − t V̄                                 (1)
//! ```
//!
//! S is the covariance of n rows, V̄ the mean of their errors' variances. The errors of a few rows may be far larger
//! than those of the others, and √(2/(n−1)) is the relative standard error of a variance in S. Where V̄ explains nearly
//! all of S, S − V̄ is nearly singular, and nearly all records of the class would be called novel.

use nalgebra::{DMatrix, DVector};

use crate::Closed;

/// t of (1); 1 if the rows are too few for a covariance, which then is that of more rows.
pub(super) fn allowed(rows: &Closed, errors: &[f64]) -> f64 {
    let freedom = rows.count as f64 - 1.0;
    let known = 1.0 - (2.0 / freedom).sqrt();
    let Some(factor) = (&rows.scatter / freedom).cholesky().filter(|_| known > 0.0) else { return 1.0 };
    let errors = DMatrix::from_diagonal(&DVector::from_column_slice(errors));
    // L⁻¹ V̄ L⁻ᵀ has the eigenvalues of S⁻¹ V̄.
    let half = factor.l().solve_lower_triangular(&errors).map(|half| half.transpose());
    let whole = half.and_then(|half| factor.l().solve_lower_triangular(&half));
    whole.map_or(1.0, |whole| (known / whole.symmetric_eigenvalues().max()).min(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// n rows of this covariance.
    fn rows(count: u64, covariance: &DMatrix<f64>) -> Closed {
        Closed { count, mean: DVector::zeros(covariance.nrows()), scatter: covariance * (count - 1) as f64 }
    }

    #[test]
    fn errors_leave_what_the_rows_cannot_deny() {
        let covariance = DMatrix::from_row_slice(2, 2, &[4.0, 1.8, 1.8, 1.0]);
        // √(2/(n−1)) is 1/5 of 51 rows.
        let left = |errors: [f64; 2]| {
            let errors = errors.map(|v| v * allowed(&rows(51, &covariance), &errors));
            &covariance - DMatrix::from_diagonal(&DVector::from_row_slice(&errors))
        };
        // Each alone leaves most of its feature's variance, but nothing of the direction in which both are nearly one.
        for errors in [[0.8, 0.2], [8.0, 0.1], [0.0, 40.0]] {
            let floor = left(errors) - &covariance * 0.2;
            let least = floor.symmetric_eigenvalues().min();
            assert!(least.abs() < 1e-9, "{errors:?}: the bound is reached, and not passed: {least}");
        }
        assert_eq!(allowed(&rows(51, &covariance), &[0.1, 0.02]), 1.0, "small errors count as they are");
        assert_eq!(allowed(&rows(51, &covariance), &[0.0, 0.0]), 1.0);
    }

    #[test]
    fn few_rows_and_equal_features_have_no_bound() {
        let covariance = DMatrix::from_row_slice(2, 2, &[4.0, 1.8, 1.8, 1.0]);
        let singular = DMatrix::from_element(2, 2, 1.0);
        for rows in [rows(1, &covariance), rows(3, &covariance), rows(51, &singular)] {
            assert_eq!(allowed(&rows, &[9.0, 9.0]), 1.0);
        }
    }
}
