//! Covariance matrices: factors, refusal of singular ones, and the Gaussian density.

use nalgebra::DMatrix;

use crate::Error;

/// Returns the inverse of the Cholesky factor, U with UᵀU = Σ⁻¹, and ln |Σ|; the error is the index of the first
/// feature that is constant or a linear combination of those before it.
///
/// Computed from the correlation matrix, so that the rank test does not depend on units.
pub fn whitening(covariance: &DMatrix<f64>) -> Result<(DMatrix<f64>, f64), usize> {
    /// Smallest pivot of a correlation matrix above rounding errors: below it a feature is a combination of others.
    const SINGULAR: f64 = 1e-10;
    let n = covariance.nrows();
    let deviation = covariance.diagonal().map(f64::sqrt);
    if let Some(constant) = deviation.iter().position(|&d| d.is_nan() || d <= 0.0) {
        return Err(constant);
    }
    let correlation = DMatrix::from_fn(n, n, |i, j| covariance[(i, j)] / (deviation[i] * deviation[j]));
    let regular = |size: usize| {
        let factor = correlation.view((0, 0), (size, size)).into_owned().cholesky()?.l();
        factor.diagonal().iter().all(|pivot| pivot * pivot >= SINGULAR).then_some(factor)
    };
    let factor = regular(n).ok_or_else(|| (1..n).find(|&size| regular(size + 1).is_none()).unwrap_or(0))?;
    let log_determinant = 2.0 * factor.diagonal().iter().zip(deviation.iter()).map(|(l, d)| (l * d).ln()).sum::<f64>();
    let mut inverse = factor.solve_lower_triangular(&DMatrix::identity(n, n)).ok_or(n - 1)?;
    for (mut column, d) in inverse.column_iter_mut().zip(deviation.iter()) {
        column /= *d;
    }
    Ok((inverse, log_determinant))
}

/// Returns the error for a singular covariance of `traces` rows around `classes` means; `dependent` is the first
/// dependent feature.
pub(crate) fn singular(what: &str, traces: usize, classes: usize, names: &[String], dependent: usize) -> Error {
    let (features, needed) = (names.len(), names.len() + classes);
    let reason = if traces < needed {
        format!("{traces} traces are too few for {features} features; give at least {needed}, or use fewer features")
    } else {
        format!("feature {} is constant or a combination of those before it; leave it out", names[dependent])
    };
    Error::Training(format!("the covariance of {what} is singular: {reason}"))
}

/// The matrix without the asymmetry of its roundings.
#[must_use]
pub fn symmetric(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    (matrix + matrix.transpose()) * 0.5
}

/// Returns ln p of a Gaussian density from ln |Σ| and the squared distance.
pub(crate) fn log_density(coordinates: usize, log_determinant: f64, squared: f64) -> f64 {
    -0.5 * (coordinates as f64 * std::f64::consts::TAU.ln() + log_determinant + squared)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_determinant_and_the_whitened_covariance_are_those_of_the_matrix() {
        // 4 · 9 − 3² = 27.
        let covariance = DMatrix::from_row_slice(2, 2, &[4.0, 3.0, 3.0, 9.0]);
        let (u, log_determinant) = whitening(&covariance).expect("regular");
        assert!((log_determinant - 27.0_f64.ln()).abs() < 1e-12, "{log_determinant}"); // rounding
        assert!((&u * &covariance * u.transpose() - DMatrix::identity(2, 2)).amax() < 1e-12, "{u}");
    }

    #[test]
    fn a_dependent_feature_is_refused_also_in_small_units() {
        // Deviations 1 and 1e-6; what the second one adds has 1e-11 of its variance.
        let correlation = (1.0 - 1e-11_f64).sqrt();
        let covariance =
            |size: f64| DMatrix::from_row_slice(2, 2, &[1.0, correlation * size, correlation * size, size * size]);
        assert_eq!([1.0, 1e-6].map(|size| whitening(&covariance(size)).err()), [Some(1), Some(1)]);
        assert_eq!(whitening(&DMatrix::from_diagonal_element(2, 2, 1e-30)).err(), None);
    }
}
