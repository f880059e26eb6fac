//! Subtracts from the features the part that temperature, speed or load explains.
//!
//! Enters: the covariates of a segment (features, such as the mean of a channel) with the variances of their errors.
//! Leaves: for each its departure from the healthy mean; and features without the part that the covariates explain.
//!
//! ```text
//! c  = z − z̄                                                             (1)  if low − m ≤ z ≤ high + m, else missing
//! m  = (high − low)/10                                                   (2)
//! f' = f − Σ_k (a_k c_k + b_k c_k²)                                      (3)
//! v' = v + Σ_k (a_k + 2 b_k c_k)² max(v_k − u_k, 0)                      (4)
//! ```
//!
//! z̄ is the mean of the healthy training segments, [low, high] their range, u the usual variance of the covariate's
//! error: a and b were estimated from covariates with such errors. A feature with a coefficient of a covariate that is
//! missing, or outside its range, is missing too: (3) is not extrapolated. With values spread evenly over the range, at
//! the margin (2) the standard error of a straight line is 15 % larger than at the end of the range, that of a parabola
//! 46 %. Cost: 6 V operations a feature.

use super::features::{Feature, FeatureValue};
use crate::plan::{Array, Cells, Plan};
use crate::regression::factor::pairs;

/// (2), as part of the range.
const MARGIN: f32 = 0.1;

/// A covariate.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Covariate {
    /// The feature z.
    pub feature: Feature,
    /// z̄, its mean over the healthy training segments.
    pub centre: f32,
    /// Its least value in them.
    pub low: f32,
    /// Its largest value in them.
    pub high: f32,
    /// u, the usual variance of its error.
    pub usual: f32,
}

impl Covariate {
    /// A placeholder, to be overwritten.
    pub const BLANK: Self = Self { feature: Feature::LogVariance, centre: 0.0, low: 0.0, high: 0.0, usual: 0.0 };

    /// c of (1) with the variance of its error beyond the usual one; missing outside the range.
    #[must_use]
    pub fn departure(&self, z: FeatureValue) -> FeatureValue {
        let margin = MARGIN * (self.high - self.low); // (2)
        // Written so that NaN is outside.
        if z.value >= self.low - margin && z.value <= self.high + margin && !z.is_missing() {
            FeatureValue { value: z.value - self.centre, variance: (z.variance - self.usual).max(0.0) }
        } else {
            FeatureValue::MISSING
        }
    }
}

/// The covariates of a classifier.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Covariates<P: Plan> {
    /// The covariates.
    pub list: Array<P::Covariates, Covariate>,
    /// [a, b] of (3), one row of V a feature; zeros if the covariate explains nothing of it.
    pub map: Array<P::CovariateMap, [f32; 2]>,
}

impl<P: Plan> Covariates<P> {
    /// (3) and (4) of feature `k`, by the departures of all covariates.
    #[must_use]
    pub fn corrected(&self, feature: FeatureValue, k: usize, departures: &[FeatureValue]) -> FeatureValue {
        if departures.is_empty() {
            return feature;
        }
        let mut corrected = feature;
        let row = self.map.cells().get(k.wrapping_mul(departures.len())..).unwrap_or(&[]);
        for ([a, b], c) in pairs(row, departures) {
            if *a == 0.0 && *b == 0.0 {
                continue;
            }
            corrected.value -= (a + b * c.value) * c.value; // (3)
            let slope = a + 2.0 * b * c.value;
            corrected.variance += if c.is_missing() { f32::INFINITY } else { slope * slope * c.variance }; // (4)
        }
        if corrected.is_missing() { FeatureValue::MISSING } else { corrected }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::RunTime;
    use std::vec;

    const WARM: Covariate = Covariate { centre: 50.0, low: 20.0, high: 100.0, usual: 0.25, ..Covariate::BLANK };

    fn at(value: f32, variance: f32) -> FeatureValue {
        FeatureValue { value, variance }
    }

    #[test]
    fn departures_within_a_tenth_of_the_range() {
        assert_eq!(WARM.departure(at(54.0, 0.125)), at(4.0, 0.0));
        assert_eq!(WARM.departure(at(54.0, 1.25)), at(4.0, 1.0));
        // The margin is 8.
        assert_eq!([12.0, 108.0].map(|z| WARM.departure(at(z, 0.0)).value), [-38.0, 58.0]);
        let outside = [11.9, 108.1, f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
        assert!(outside.iter().all(|z| WARM.departure(at(*z, 0.0)) == FeatureValue::MISSING));
        assert_eq!(WARM.departure(FeatureValue::MISSING), FeatureValue::MISSING);
        assert_eq!(WARM.departure(at(50.0, f32::NAN)), FeatureValue::MISSING);
    }

    #[test]
    fn features_by_hand() {
        // The first feature by both covariates, the second by the second one, the third by none.
        let map = vec![[0.5, 0.25], [-1.0, 0.0], [0.0, 0.0], [0.0, 2.0], [0.0; 2], [0.0; 2]];
        let covariates = Covariates::<RunTime> { list: vec![WARM; 2], map };
        let of = |departures: [FeatureValue; 2]| [0, 1, 2].map(|k| covariates.corrected(at(8.0, 1.0), k, &departures));
        // 8 − (0.5·4 + 0.25·16) + 3 = 5, slope 0.5 + 2·0.25·4 = 2.5; 8 − 2·9 = −10, slope 12.
        let [first, second, third] = of([at(4.0, 2.0), at(3.0, 0.5)]);
        assert_eq!((first, second, third), (at(5.0, 1.0 + 12.5 + 0.5), at(-10.0, 1.0 + 72.0), at(8.0, 1.0)));
        let [first, second, third] = of([FeatureValue::MISSING, at(3.0, 0.5)]);
        assert_eq!((first, second, third), (FeatureValue::MISSING, at(-10.0, 73.0), at(8.0, 1.0)));
        let missing = covariates.corrected(FeatureValue::MISSING, 1, &[at(4.0, 0.0), at(3.0, 0.0)]);
        assert_eq!(missing, FeatureValue::MISSING);
    }
}
