//! Features → projected coordinates, by one affine map.
//!
//! Enters: f, `F` features. Leaves: z, `Z` coordinates.
//!
//! ```text
//! z = W (f − m)                                                          (1)  thesis §2.5
//! ```
//!
//! m is the training mean, W whatever the workbench chose: principal components, Fisher's directions, or the
//! identity. The mean is subtracted first, so that nothing cancels in the sums. Cost: Z·F multiply-adds.

use nalgebra::{SMatrix, SVector};

/// The map (1). Rows and columns beyond those in use are zero.
///
/// ```
/// use bearing_watch::decide::Projection;
/// let sum = Projection { matrix: [[1.0, 1.0]], mean: [1.0, 0.0], count: 1 };
/// assert_eq!(sum.project(&[3.0, 4.0]), [6.0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Projection<const F: usize, const Z: usize> {
    /// W, one row a coordinate.
    pub matrix: [[f32; F]; Z],
    /// m, the training mean.
    pub mean: [f32; F],
    /// Coordinates in use.
    pub count: u8,
}

impl<const F: usize, const Z: usize> Projection<F, Z> {
    /// Applies (1).
    #[inline]
    #[must_use]
    pub fn project(&self, features: &[f32; F]) -> [f32; Z] {
        let mut centred = *features;
        for (x, mean) in centred.iter_mut().zip(&self.mean) {
            *x -= mean;
        }
        let mut z = [0.0; Z];
        for (z, row) in z.iter_mut().zip(&self.matrix) {
            *z = row.iter().zip(&centred).fold(0.0, |sum, (w, x)| sum + w * x); // (1)
        }
        z
    }

    /// W and m as matrices.
    #[must_use]
    pub fn to_matrices(&self) -> (SMatrix<f32, Z, F>, SVector<f32, F>) {
        let w = SMatrix::from_fn(|i, j| self.matrix.get(i).and_then(|row| row.get(j)).copied().unwrap_or(0.0));
        (w, SVector::from(self.mean))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_the_matrix_form() {
        let p = Projection { matrix: [[1.0, -2.0, 0.5], [0.0, 4.0, 1.0]], mean: [1.0, 2.0, 3.0], count: 2 };
        let (w, m) = p.to_matrices();
        let f = SVector::from([0.5, -1.0, 8.0]);
        // Small dyadic numbers: every operation is exact.
        assert_eq!(SVector::from(p.project(&f.into())), w * (f - m));
    }
}
