//! Coordinates of which a larger value than usual shows a defect, such as the scores of bearing orders.
//!
//! Enters: the coordinates' scores given those before them ([`super::density`]). Leaves: the surprise of the rarest of
//! the distance of the other coordinates and each rising one, and which one it is.
//!
//! ```text
//! d²_i = y_1²/D'_1 + … + y_i²/D'_i,     y, D' of all Z coordinates, the K rising ones last       (1)
//! p_0  = P(d²_{Z−K} at least this large)
//! u_i  = y_i/√(D'_i (1 + d²_{i−1}/ν)),   p_i = min(P(U_i ≥ u_i), P(U_i ≤ u_i)/φ),   i > Z − K      (2)
//! s    = −ln(1 − (1 − min p)^M),   M: number of available values, and φ for each rising one       (3)  Tippett 1931
//! P(U_i ≤ −u) = P(U_i ≥ f_i u),   u > 0                                                           (4)
//! ```
//!
//! A distance in Z coordinates contains the noise of coordinates that a defect does not change, and does not
//! distinguish the two directions of each. For a probability of 1 %, an order by itself must be 2.3 standard deviations
//! too strong, but 3.9 in a distance in five coordinates; by (3), one of three rising coordinates beside a distance
//! needs 2.8. (2) is the score of a coordinate given those before it, independent of their distance if all are normal;
//! mean and covariance are estimated with ν degrees of freedom, which its second factor and the laws of d² and u
//! account for. Each u has a law of its own, whose knots are −ln 2 P(U ≥ u) over u², u ≥ 0.
//!
//! A fall is a finding too, though not of a bearing: the load or the belt is lost, or a sensor fails. It gets the
//! part φ = 0.1 of the false alarms of a rise, so that a rise needs 0.03 deviations more than without it. The tail
//! below the mean is that above it on another scale (4), by which the two agree where a fall reaches the limit. For
//! independent values (3) is exact; if they are correlated and their laws are known, the rate is lower than the set
//! one.

use core::f32::consts::{LN_2, LN_10};

use super::law::{Law, equivalent, surprise};
use crate::logarithm::{ln, ln_of_level};
use crate::record::record;
use crate::regression::factor::pairs;

/// A value that is not available.
pub(crate) const MISSING: f32 = f32::NEG_INFINITY;
/// φ of (2).
const FALLS: f32 = 0.1;
const LN_FALLS: f32 = -LN_10;

record! {
    /// What the gate has of a rising coordinate beside its law.
    #[derive(Clone, Copy, Debug, PartialEq)]
    #[cfg_attr(feature = "defmt", derive(defmt::Format))]
    pub struct Rise: RisingCoordinates {
        /// f of (4); 0 if a fall is no finding.
        pub fall: f32 in [0.0, 1e6],
        /// Deviations by which a defect must raise the coordinate, so that it is found with a probability of 90 %.
        pub reach: f32 in [0.0, 1e6],
    }
}

impl Rise {
    /// No fall is a finding, and no size of a defect is known.
    pub const NONE: Self = Self { fall: 0.0, reach: 0.0 };
}

/// The coordinate that departs most from healthy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Most {
    /// Its index.
    pub coordinate: u8,
    /// Whether it is below its usual value.
    pub falls: bool,
}

/// Squared distances and numbers of available coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Scores {
    /// d² of all coordinates, and the number of available ones.
    pub squared: f32,
    pub available: usize,
    /// The number of available ones before the rising coordinates.
    pub others: usize,
    /// y²/D' of the coordinate before the rising ones that departs most, and which one it is.
    farthest: (f32, Option<Most>),
}

impl Scores {
    /// Takes y and D' of the next coordinate, of which there are so many; one with an infinite D' is not available.
    /// `judged` gets d² of the others and u of each rising coordinate.
    pub(crate) fn add(&mut self, y: f32, pivot: f32, [k, all]: [usize; 2], freedom: f32, judged: &mut [f32]) {
        let first = all.wrapping_add(1).saturating_sub(judged.len());
        let is_missing = pivot >= f32::INFINITY;
        let index = k.checked_sub(first).map(|index| index.wrapping_add(1));
        let cell = index.and_then(|index| judged.get_mut(index));
        let rises = cell.is_some();
        if let Some(cell) = cell {
            let u = y / libm::sqrtf(pivot * (1.0 + self.squared / freedom)); // (2)
            *cell = if is_missing { MISSING } else { u };
        }
        if is_missing {
            return;
        }
        let squared = y * (y / pivot);
        self.squared += squared;
        self.available = self.available.saturating_add(1);
        if !rises {
            self.others = self.available;
            if squared > self.farthest.0 {
                self.farthest = (squared, most(k, y < 0.0));
            }
            if let Some(of_others) = judged.first_mut() {
                *of_others = self.squared;
            }
        }
    }

    /// The coordinate before the rising ones that departs most.
    pub(crate) const fn farthest(&self) -> Option<Most> {
        self.farthest.1
    }
}

fn most(coordinate: usize, falls: bool) -> Option<Most> {
    u8::try_from(coordinate).ok().map(|coordinate| Most { coordinate, falls })
}

/// The probabilities of the values so far: the smallest with its coordinate, and M of (3).
#[derive(Clone, Copy, Debug, PartialEq)]
struct Smallest {
    p: f32,
    count: f32,
    most: Option<Most>,
}

impl Smallest {
    /// Takes a probability of this share of the false alarms; a NaN stays.
    fn take(&mut self, p: f32, share: f32, most: Option<Most>) {
        self.count += share;
        // `clamp` may panic, and a NaN is no maximum.
        let p = if p > 1.0 { 1.0 } else { p };
        if p < self.p || p.is_nan() {
            (self.p, self.most) = (p, most);
        }
    }
}

/// The rarest fall by itself.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Fall {
    /// −ln of the probability that any of the rising coordinates of a healthy segment is so far below its mean, over
    /// φ; 0 if that is not rare.
    pub surprise: f32,
    /// Its coordinate.
    pub coordinate: u8,
}

/// What is rare about a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rarest {
    /// s of (3).
    pub surprise: f32,
    /// The rarest coordinate.
    pub most: Option<Most>,
    pub fall: Fall,
}

/// Of d² of the others and u of each rising coordinate.
#[inline(never)]
pub(crate) fn rarest(laws: &[Law], rises: &[Rise], judged: &[f32], scores: &Scores, all: usize) -> Rarest {
    let (mut fallen, mut fall) = (0.0, Fall::default());
    let first = all.saturating_sub(laws.len().saturating_sub(1));
    let mut smallest = Smallest { p: 1.0, count: 0.0, most: None };
    for (k, (law, (value, rise))) in pairs(0..usize::MAX, pairs(laws, pairs(judged, rises))) {
        if *value == MISSING {
            continue;
        }
        if k == 0 {
            let of_others = surprise(law, equivalent(*value, scores.others, first));
            smallest.take(libm::expf(-of_others), 1.0, scores.farthest());
            continue;
        }
        let (u, index) = (value.abs(), first.wrapping_add(k).wrapping_sub(1));
        let beyond = libm::expf(-far(law, u));
        let falls = *value < 0.0;
        smallest.take(if falls { 1.0 - beyond } else { beyond }, 1.0, most(index, false));
        // −ln of p/φ.
        let below = if falls { far(law, rise.fall * u) + LN_FALLS } else { 0.0 };
        let fallen_here = most(index, true);
        smallest.take(libm::expf(-below), FALLS, fallen_here);
        fallen += 1.0;
        if let Some(Most { coordinate, .. }) = fallen_here
            && below > fall.surprise
        {
            fall = Fall { surprise: below, coordinate };
        }
    }
    let surprise = fall.surprise - ln_of_level(fallen);
    fall.surprise = if surprise > 0.0 { surprise } else { 0.0 };
    Rarest { surprise: together(smallest.p, smallest.count), most: smallest.most, fall }
}

/// −ln P(U ≥ u), u ≥ 0.
#[inline(never)]
fn far(law: &Law, u: f32) -> f32 {
    surprise(law, u * u) + LN_2
}

/// (3).
#[inline(never)]
fn together(p: f32, count: f32) -> f32 {
    if count * p < RARE {
        if count > 0.0 { -ln(p * count) } else { 0.0 }
    } else if p >= 1.0 {
        // A NaN is not.
        0.0
    } else {
        -ln(1.0 - libm::expf(count * ln(1.0 - p)))
    }
}

/// Below this probability p, the difference of 1 − (1 − p)^M and M p is negligible.
const RARE: f32 = 1e-3;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decide::KNOTS;
    use std::vec;
    use std::vec::Vec;

    /// Surprise d²/2 of the others, u² and then 2 u² of the rising ones.
    fn laws(count: usize) -> Vec<Law> {
        let line = |slope: f32| core::array::from_fn(|k| [k as f32, slope * k as f32]);
        (0..=count).map(|k| line(0.5 * 2.0_f32.powi(k as i32))).collect()
    }

    /// The surprise of (y, D') of two others and then of rising ones, with ν = 10 and f = 2, and the rarest one.
    fn rarest_of(values: &[[f32; 2]]) -> (f32, Option<Most>) {
        let Rarest { surprise, most, .. } = all_of(values);
        (surprise, most)
    }

    fn all_of(values: &[[f32; 2]]) -> Rarest {
        let laws = laws(values.len() - 2);
        let (mut judged, mut scores) = (vec![MISSING; laws.len()], Scores::default());
        for (k, [y, pivot]) in values.iter().enumerate() {
            scores.add(*y, *pivot, [k, values.len()], 10.0, &mut judged);
        }
        rarest(&laws, &vec![Rise { fall: 2.0, reach: 0.0 }; laws.len()], &judged, &scores, values.len())
    }

    fn judged(values: &[[f32; 2]]) -> f32 {
        rarest_of(values).0
    }

    fn near(surprise: f32, expected: f64) {
        // Half of `RARE`.
        assert!((f64::from(surprise) - expected).abs() < 5e-4, "{surprise} for {expected}");
    }

    /// (3) of the smallest of so many probabilities, of which so many rise.
    fn of(p: f64, count: f64) -> f64 {
        -(1.0 - (1.0 - p).powf(count)).ln()
    }

    const MISS: [f32; 2] = [3.0, f32::INFINITY];

    #[test]
    fn the_rarer_of_distance_and_coordinate_counts() {
        assert_eq!(laws(1)[1].len(), KNOTS);
        // d² = 4/4 + 9/3 = 4: p₀ = e⁻². u² = 16/2/(1 + 4/10) = 40/7.
        let rising = [[2.0, 4.0], [3.0, 3.0], [4.0, 2.0]];
        near(judged(&rising), of(0.5 * (-40.0_f64 / 7.0).exp(), 2.1));
        assert_eq!(rarest_of(&rising).1, Some(Most { coordinate: 2, falls: false }));
        // A coordinate near its mean leaves the distance, in which the second one is farthest.
        let others = [[2.0, 4.0], [-3.0, 3.0], [0.5, 2.0]];
        near(judged(&others), of((-2.0_f64).exp(), 2.1));
        assert_eq!(rarest_of(&others).1, Some(Most { coordinate: 1, falls: true }));
        // Without the rising one, without the others, and without any.
        near(judged(&[[2.0, 4.0], [3.0, 3.0], MISS]), 2.0);
        near(judged(&[MISS, MISS, [4.0, 2.0]]), of(0.5 * (-8.0_f64).exp(), 1.1));
        near(judged(&[MISS; 3]), 0.0);
        assert_eq!(rarest_of(&[MISS; 3]).1, None);
        let sum = judged(&[[2.0, 4.0], [f32::NAN, 3.0], [4.0, 2.0]]);
        assert!(sum.is_nan(), "{sum}");
    }

    #[test]
    fn a_fall_counts_on_its_own_scale_for_a_tenth() {
        // u² = 16/2 = 8, four times as far below the mean: p = e⁻³²/2 of which φ is a tenth.
        let fallen = [[0.0, 1.0], [0.0, 1.0], [-4.0, 2.0]];
        near(judged(&fallen), 32.0 + 2.0_f64.ln() + 0.1_f64.ln() - 2.1_f64.ln());
        assert_eq!(rarest_of(&fallen).1, Some(Most { coordinate: 2, falls: true }));
        let Fall { surprise, coordinate } = all_of(&fallen).fall;
        near(surprise, 32.0 + 2.0_f64.ln() + 0.1_f64.ln());
        assert_eq!((coordinate, all_of(&[[0.0, 1.0], [0.0, 1.0], [4.0, 2.0]]).fall), (2, Fall::default()));
        // Any of two that could have fallen does so twice as often; one that is missing could not.
        let beside = |other: [f32; 2]| {
            let [none, also, fallen] = fallen;
            all_of(&[none, also, fallen, other]).fall.surprise
        };
        near(beside([0.5, 1.0]), 32.0 + 0.1_f64.ln());
        near(beside(MISS), 32.0 + 2.0_f64.ln() + 0.1_f64.ln());
        // A small fall is usual: e⁻¹/2 is more than φ.
        near(judged(&[[0.0, 1.0], [0.0, 1.0], [-0.5, 1.0]]), of(1.0 - 0.5 * (-0.25_f64).exp(), 2.1));
    }

    #[test]
    fn each_coordinate_has_a_law_of_its_own() {
        // No distance; u² = 1 with the surprise 1, and 4/(1 + 1/10) with twice as much.
        let [none, other] = [[0.0, 1.0]; 2];
        near(judged(&[none, other, [1.0, 1.0], [2.0, 1.0]]), of(0.5 * (-80.0_f64 / 11.0).exp(), 3.2));
        // So small that a sum of probabilities is enough.
        near(judged(&[none, other, [3.0, 1.0], [-0.1, 1.0]]), 9.0 + 2.0_f64.ln() - 3.2_f64.ln());
        // A coordinate that is missing does not count.
        near(judged(&[none, other, [1.0, 1.0], MISS]), of(0.5 * (-1.0_f64).exp(), 2.1));
    }

    #[test]
    fn far_values_stay_finite() {
        let far = judged(&[[1e18, 1.0], [0.0, 1.0], [1e18, 1e-3]]);
        assert!(far > 30.0 && far.is_finite(), "{far}");
        let fallen = judged(&[[0.0, 1.0], [0.0, 1.0], [-1e18, 1e-3]]);
        assert!(fallen > 30.0 && fallen.is_finite(), "{fallen}");
    }
}
