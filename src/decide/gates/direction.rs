//! Directions in which a defect moves the coordinates, and the law of healthy segments in each.
//!
//! Enters: z, projected coordinates with the variances v of their errors. Leaves: one value a direction, for the
//! evidence of runs ([`crate::alarm`]).
//!
//! ```text
//! y = z_k − Σ β_j z_j − c,   variance of the error v_k + Σ β_j² v_j                                   (1)
//! y = u + b + e,   u: of the drive, variance U;  b: of the run, B;  e: of the segment, W + (1)         (2)
//! ```
//!
//! A defect raises y. The background `z_j`, such as the strength of another order, explains a part of `z_k` that is no
//! defect.

use crate::decide::FeatureValue;
use crate::plan::{Array, Cells, ClassifierLengths, Fixed};
use crate::record::{LARGEST, record};
use crate::regression::factor::pairs;

/// Smallest variance of a direction.
const LEAST_VARIANCE: f32 = 1e-12;

/// Most coordinates in the background of a direction.
pub const MAX_BACKGROUND: usize = 4;

record! {
    /// A coordinate in the background of a direction.
    #[derive(Clone, Copy, Debug, Default, PartialEq)]
    #[cfg_attr(feature = "defmt", derive(defmt::Format))]
    pub struct Background: Direction {
        /// Its index.
        pub coordinate: u8,
        /// β of (1); 0 if there is none.
        pub weight: f32 in [-LARGEST, LARGEST],
    }
}

record! {
    /// A direction with its law.
    #[derive(Clone, Copy, Debug, PartialEq)]
    #[cfg_attr(feature = "defmt", derive(defmt::Format))]
    pub struct Direction: Direction {
        /// The coordinate that a defect raises.
        pub coordinate: u8,
        /// Whether it is the strength of a bearing order, which names the race. An alarm names it before friction,
        /// which a defect of a race raises too.
        pub order: bool,
        /// What explains a part of it.
        pub background: [Background; MAX_BACKGROUND],
        /// c of (1): the mean of drives.
        pub centre: f32 in [-LARGEST, LARGEST],
        /// U, the variance between drives.
        pub between: f32 in [LEAST_VARIANCE, LARGEST],
        /// B, the variance between runs of a drive.
        pub run: f32 in [LEAST_VARIANCE, LARGEST],
        /// W, the variance between segments of a run.
        pub segment: f32 in [LEAST_VARIANCE, LARGEST],
        /// Skewness of the means of runs.
        pub skewness: f32 in [0.0, 10.0],
        /// ρ, the correlation of b of (2) between successive runs of a drive.
        pub correlation: f32 in [0.0, 0.999],
    }
}

impl Direction {
    /// A direction along a coordinate, of unit variances.
    pub const UNIT: Self = Self {
        coordinate: 0,
        order: false,
        background: [Background { coordinate: 0, weight: 0.0 }; MAX_BACKGROUND],
        centre: 0.0,
        between: 1.0,
        run: 1.0,
        segment: 1.0,
        skewness: 0.0,
        correlation: 0.0,
    };

    /// (1); missing if a coordinate with a weight is.
    #[inline(never)]
    pub(crate) fn value(&self, z: &[f32], variances: &[f32]) -> FeatureValue {
        let at = |index: u8| pairs(z, variances).nth(index as usize).unwrap_or((&0.0, &f32::INFINITY));
        let (value, variance) = at(self.coordinate);
        let mut y = FeatureValue { value: value - self.centre, variance: *variance };
        for Background { coordinate, weight } in self.background {
            if weight != 0.0 {
                let (value, variance) = at(coordinate);
                y.value -= weight * value;
                y.variance += weight * weight * variance;
            }
        }
        let missing = y.is_missing() || !y.value.is_finite();
        if missing { FeatureValue::MISSING } else { y }
    }
}

/// The directions of a model; with none the evidence is that of distances and classes.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Directions<P: ClassifierLengths> {
    /// The directions.
    pub list: Array<P::Directions, Direction>,
    /// Segments of a usual run.
    pub usual_segments: f32,
    /// How many standard deviations of what is not known of a drive's own mean count as usual: 1.645 covers 95 % of the
    /// drives.
    pub margin: f32,
    /// Number of runs from which the drive's own mean is learned.
    pub most_runs: u16,
}

impl<P: ClassifierLengths> Directions<P> {
    /// No direction, or unit ones in a plan that has some.
    #[must_use]
    pub fn none(plan: P) -> Self {
        let list = Cells::filled(plan.layout().directions as usize, Direction::UNIT);
        Self { list, usual_segments: 1.0, margin: 1.645, most_runs: 60 }
    }
}

impl<P: ClassifierLengths<Directions = Fixed<0>>> Directions<P> {
    /// No direction.
    pub const NONE: Self = Self { list: [], usual_segments: 1.0, margin: 1.645, most_runs: 60 };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_background_is_subtracted_and_its_error_added() {
        let mut direction = Direction { coordinate: 2, centre: 0.5, ..Direction::UNIT };
        direction.background[0] = Background { coordinate: 0, weight: 0.25 };
        let value = direction.value(&[4.0, 100.0, 3.0], &[2.0, f32::INFINITY, 0.125]);
        assert_eq!(value, FeatureValue { value: 3.0 - 1.0 - 0.5, variance: 0.125 + 2.0 / 16.0 });
    }

    #[test]
    fn what_is_missing_has_no_value() {
        let mut direction = Direction { coordinate: 1, ..Direction::UNIT };
        assert_eq!(direction.value(&[0.0, 1.0], &[0.0, f32::INFINITY]), FeatureValue::MISSING);
        assert_eq!(direction.value(&[0.0, f32::NAN], &[0.0, 0.0]), FeatureValue::MISSING);
        assert_eq!(direction.value(&[0.0], &[0.0]), FeatureValue::MISSING, "no such coordinate");
        assert!(!direction.value(&[0.0, 1.0], &[f32::INFINITY, 0.0]).is_missing());
        direction.background[3].weight = 0.1;
        assert_eq!(direction.value(&[0.0, 1.0], &[f32::INFINITY, 0.0]), FeatureValue::MISSING);
    }
}
