//! Features → projected coordinates, by one affine map.
//!
//! Enters: f, `F` features with the variances v of their errors. Leaves: z, `Z` coordinates with their variances.
//!
//! ```text
//! z = W (f − m)                                                          (1)  thesis §2.5
//! var z_k = Σ_j W_kj² max(v_j − u_j, 0)                                  (2)
//! ```
//!
//! The covariances of the classes contain the usual errors of the training features, of variances u, with their
//! correlations. A segment with little motion has larger errors; only the excess of their variance over u is added, by
//! (2). A coordinate in which a missing feature has a weight is missing: its variance is infinite. (2) regards the
//! excess errors of features as independent, and those of coordinates too. The latter holds for a diagonal W, as of the
//! projection `none`; if several coordinates contain one feature, their errors are correlated, which (2) neglects.
//!
//! m is the training mean; W contains principal components, Fisher's directions, or the identity, as the workbench
//! chose. The mean is subtracted first, so that no digits cancel in the sums. Cost: 2 Z·F multiply-adds.

use super::features::FeatureValue;
use crate::plan::{Array, Cells, Plan};
use crate::regression::factor::pairs;
use crate::unroll::no_unroll;

/// The map (1).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Projection<P: Plan> {
    /// W, one row of F a coordinate.
    pub matrix: Array<P::Map, f32>,
    /// m, the training mean.
    pub mean: Array<P::Features, f32>,
    /// u, the usual variances of the features' errors.
    pub usual: Array<P::Features, f32>,
}

impl<P: Plan> Projection<P> {
    /// Feature `k` with the excess of the variance of its error over the usual one, as in (2).
    #[must_use]
    pub fn excess(&self, feature: FeatureValue, k: usize) -> FeatureValue {
        let usual = self.usual.cells().get(k).copied().unwrap_or(0.0);
        FeatureValue { variance: (feature.variance - usual).max(0.0), ..feature }
    }

    /// Coordinate `k` of (1) with its variance (2), of features with their [`excess`](Self::excess); missing if a
    /// feature with a weight is missing.
    #[must_use]
    pub fn coordinate(&self, features: &[FeatureValue], k: usize) -> FeatureValue {
        let row = self.matrix.cells().get(k.wrapping_mul(features.len())..).unwrap_or(&[]);
        weighted_sum(row, features, self.mean.cells())
    }

    /// The only feature of coordinate `k` with its weight; `None` if it contains none or several.
    #[must_use]
    pub fn only(&self, k: usize) -> Option<(usize, f32)> {
        let features = self.mean.cells().len();
        let row = self.matrix.cells().get(k.wrapping_mul(features)..).unwrap_or(&[]);
        let mut only = None;
        for (index, weight) in pairs(0..no_unroll(features), row) {
            if *weight != 0.0 && only.replace((index, *weight)).is_some() {
                return None;
            }
        }
        only
    }

    /// The feature that alone has a weight in coordinate `k`, above 0; `None` if the coordinate is another combination.
    #[cfg(any(test, feature = "telemetry"))]
    pub(crate) fn feature(&self, k: usize) -> Option<u8> {
        let (index, weight) = self.only(k)?;
        if weight > 0.0 { u8::try_from(index).ok() } else { None }
    }
}

/// (1) and (2) of one row of W.
fn weighted_sum(weights: &[f32], features: &[FeatureValue], mean: &[f32]) -> FeatureValue {
    let mut z = FeatureValue { value: 0.0, variance: 0.0 };
    for (w, (feature, mean)) in pairs(weights, pairs(features, mean)) {
        z.value += w * (feature.value - mean); // (1)
        // Without a weight, an infinite variance has no effect either.
        z.variance += if *w == 0.0 { 0.0 } else { w * w * feature.variance }; // (2)
    }
    if z.is_missing() { FeatureValue::MISSING } else { z }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::RunTime;
    use std::vec;

    #[test]
    fn a_coordinate_of_one_feature_is_that_feature() {
        let projection = Projection::<RunTime> {
            matrix: vec![0.0, 0.0, 2.0, 0.5, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0],
            mean: vec![0.0; 3],
            usual: vec![0.0; 3],
        };
        assert_eq!([0, 1, 2, 3, 4, 5].map(|k| projection.feature(k)), [Some(2), Some(0), None, None, None, None]);
    }

    #[test]
    fn two_coordinates_by_hand() {
        let projection = Projection::<RunTime> {
            matrix: vec![1.0, -2.0, 0.5, 0.0, 4.0, 1.0],
            mean: vec![1.0, 2.0, 3.0],
            usual: vec![0.0, 0.25, 3.0],
        };
        // f − m = (−0.5, −3, 5): dyadic numbers, so every operation is exact.
        let features = [0.5, -1.0, 8.0];
        let with = |variances: [f32; 3]| {
            let index = |k: usize| projection.excess(FeatureValue { value: features[k], variance: variances[k] }, k);
            [0, 1].map(|k| projection.coordinate(&[0, 1, 2].map(index), k))
        };
        let [first, second] = [-0.5 + 6.0 + 2.5, -12.0 + 5.0];
        assert_eq!(with([0.0; 3]).map(|z| (z.value, z.variance)), [(first, 0.0), (second, 0.0)]);
        assert_eq!(with([1.0, 0.5, 2.0]).map(|z| z.variance), [1.0 + 4.0 * 0.25, 16.0 * 0.25]);
        let single = Projection::<RunTime> { matrix: vec![0.0, 3.0, 0.0, 1.0, 1.0, 0.0], ..projection.clone() };
        assert_eq!([0, 1, 2].map(|k| single.only(k)), [Some((1, 3.0)), None, None]);
        // The second coordinate does not contain the first feature.
        let [missing, present] = with([f32::INFINITY, 0.5, 0.0]);
        assert_eq!((missing, present.value, present.variance), (FeatureValue::MISSING, second, 4.0));
    }
}
