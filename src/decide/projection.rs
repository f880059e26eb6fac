//! Features → projected coordinates, by one affine map.
//!
//! Enters: f, `F` features. Leaves: z, `Z` coordinates.
//!
//! ```text
//! z = W (f − m)                                                          (1)  thesis §2.5
//! ```
//!
//! m is the training mean; W contains principal components, Fisher's directions, or the identity, as the workbench
//! chose. The mean is subtracted first, so that no digits cancel in the sums. Cost: Z·F multiply-adds.

use crate::factor::pairs;
use crate::plan::{Array, Cells, Plan};

/// The map (1).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Projection<P: Plan> {
    /// W, one row of F a coordinate.
    pub matrix: Array<P::Map, f32>,
    /// m, the training mean.
    pub mean: Array<P::Features, f32>,
}

impl<P: Plan> Projection<P> {
    /// Coordinate `k` of (1).
    #[inline(never)]
    #[must_use]
    pub fn coordinate(&self, features: &[f32], k: usize) -> f32 {
        let row = self.matrix.cells().get(k.wrapping_mul(features.len())..).unwrap_or(&[]);
        weighted_sum(row, features, self.mean.cells()) // (1)
    }

    /// W and m as matrices; `None` if `Z` and `F` are not the numbers of coordinates and features.
    #[cfg(feature = "nalgebra")]
    #[must_use]
    pub fn to_matrices<const Z: usize, const F: usize>(
        &self,
    ) -> Option<(nalgebra::SMatrix<f32, Z, F>, nalgebra::SVector<f32, F>)> {
        let (matrix, mean) = (self.matrix.cells(), self.mean.cells());
        let fits = mean.len() == F && matrix.len() == Z.wrapping_mul(F);
        fits.then(|| {
            (nalgebra::SMatrix::from_row_iterator(matrix.iter().copied()), nalgebra::SVector::from_row_slice(mean))
        })
    }
}

/// Σ w (x − m).
#[inline(never)]
pub(super) fn weighted_sum(weights: &[f32], x: &[f32], mean: &[f32]) -> f32 {
    pairs(weights, pairs(x, mean)).fold(0.0, |sum, (w, (x, mean))| sum + w * (x - mean))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::RunTime;
    use std::vec;

    #[test]
    fn two_coordinates_by_hand() {
        let projection =
            Projection::<RunTime> { matrix: vec![1.0, -2.0, 0.5, 0.0, 4.0, 1.0], mean: vec![1.0, 2.0, 3.0] };
        // f − m = (−0.5, −3, 5): dyadic numbers, so every operation is exact.
        let features = [0.5, -1.0, 8.0];
        assert_eq!([0, 1].map(|k| projection.coordinate(&features, k)), [-0.5 + 6.0 + 2.5, -12.0 + 5.0]);
        #[cfg(feature = "nalgebra")]
        {
            let (w, m) = projection.to_matrices::<2, 3>().unwrap();
            assert_eq!(w * (nalgebra::SVector::from(features) - m), nalgebra::SVector::from([8.0, -7.0]));
            assert_eq!(projection.to_matrices::<3, 2>(), None);
        }
    }
}
