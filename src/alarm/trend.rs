//! Distances from the healthy class → their slope, as an early sign of wear.
//!
//! Enters: a distance a decided segment. Leaves: a [`Trend`].
//!
//! ```text
//! t = 0, 1, …, n−1;   S_tt = n(n²−1)/12                                  (1)
//! S_td ← S_td + (t − t̄)(d − d̄),   S_dd ← S_dd + (d − d̄)(d − d̄₊)          (2)  d̄₊: the mean with d; t̄: with t
//! slope b = S_td/S_tt,   se² = (S_dd − b S_td)/((n−2) S_tt)              (3)
//! interval b ± t₀.₉₇₅(n−2) se                                            (4)
//! ```
//!
//! Two parts of a course, of n' and n'' segments, together, with n = n' + n'' and D = d̄'' − d̄':
//!
//! ```text
//! S_td = S'_td + S''_td + n' n'' D/2,   S_dd = S'_dd + S''_dd + n' n'' D²/n                  (5)
//! ```
//!
//! Centred sums (Welford 1962) lose no digits by cancellation, however large the mean distance. (1) has a closed form
//! because only decided segments count. A segment would change sums of 10⁶ segments in `f32` by a few roundings only:
//! then new sums start, and the trend is that of the last 10⁶ segments and the new ones (5), so that it follows a drive
//! for as long as it lives. The interval assumes independent segments of equal spread about a straight line.

/// Number of segments for which sums in `f32` are accurate.
pub const MAX_TREND_SEGMENTS: u32 = 1_000_000;

/// Slope of the distance over the decided segments. If `low` is above zero, the distance grows (97.5 % confidence).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Trend {
    /// Number of segments.
    pub segments: u32,
    /// Mean distance.
    pub mean: f32,
    /// b of (3), distance a segment.
    pub slope: f32,
    /// Its standard error.
    pub standard_error: f32,
    /// Lower end of the 95 % interval (4).
    pub low: f32,
    /// Upper end.
    pub high: f32,
}

/// The running sums of a part of the course.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Sums {
    count: u32,
    mean: f32,
    /// `S_td`.
    joint: f32,
    /// `S_dd`.
    spread: f32,
}

/// The sums of the last [`MAX_TREND_SEGMENTS`] segments, once there are so many, and of those after them.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Drift {
    older: Sums,
    newer: Sums,
}

impl Sums {
    const NONE: Self = Self { count: 0, mean: 0.0, joint: 0.0, spread: 0.0 };

    fn add(&mut self, distance: f32) {
        let before = distance - self.mean;
        let from_mid = 0.5 * self.count as f32; // t − t̄ = (n−1)/2 with n the new count
        self.count = self.count.saturating_add(1);
        self.mean += before / self.count as f32;
        self.joint += from_mid * before; // (2)
        self.spread += before * (distance - self.mean);
    }

    /// (5).
    fn then(self, later: Self) -> Self {
        if self.count == 0 {
            return later;
        }
        let (before, after) = (self.count as f32, later.count as f32);
        let (rise, share) = (later.mean - self.mean, after / (before + after));
        Self {
            count: self.count.saturating_add(later.count),
            mean: self.mean + share * rise,
            joint: self.joint + later.joint + 0.5 * before * after * rise,
            spread: self.spread + later.spread + before * share * rise * rise,
        }
    }

    /// The sums as words.
    const fn words(&self) -> [u32; 4] {
        [self.count, self.mean.to_bits(), self.joint.to_bits(), self.spread.to_bits()]
    }

    /// The sums of these words; `None` if distances cannot have them.
    fn from_words([count, mean, joint, spread]: [u32; 4]) -> Option<Self> {
        let [mean, joint, spread] = [mean, joint, spread].map(f32::from_bits);
        let finite = mean.is_finite() && joint.is_finite() && spread.is_finite();
        let counted = count <= MAX_TREND_SEGMENTS && mean >= 0.0 && spread >= 0.0;
        // Without segments nothing is summed; of one the deviations are zero.
        let plain = (count > 0 || mean <= 0.0) && (count > 1 || (joint.abs() <= 0.0 && spread <= 0.0));
        (finite && counted && plain).then_some(Self { count, mean, joint, spread })
    }
}

impl Drift {
    pub(super) const NONE: Self = Self { older: Sums::NONE, newer: Sums::NONE };

    /// Takes a distance; a value that is not finite is left out.
    pub(super) fn add(&mut self, distance: f32) {
        if !distance.is_finite() {
            return;
        }
        if self.newer.count >= MAX_TREND_SEGMENTS {
            *self = Self { older: self.newer, newer: Sums::NONE };
        }
        self.newer.add(distance);
    }

    /// The sums as words: the newer ones, and the older ones.
    pub(super) const fn words(&self) -> [[u32; 4]; 2] {
        [self.newer.words(), self.older.words()]
    }

    /// The sums of these words; `None` if distances cannot have them.
    pub(super) fn from_words([newer, older]: [[u32; 4]; 2]) -> Option<Self> {
        let (newer, older) = (Sums::from_words(newer)?, Sums::from_words(older)?);
        // The older sums are complete, and the newer ones have begun.
        let follows = older.count == 0 || (older.count == MAX_TREND_SEGMENTS && newer.count > 0);
        follows.then_some(Self { older, newer })
    }

    /// Number of segments.
    pub(super) const fn count(&self) -> u32 {
        self.older.count.saturating_add(self.newer.count)
    }

    pub(super) fn trend(&self) -> Option<Trend> {
        let Sums { count, mean, joint, spread } = self.older.then(self.newer);
        let n = count as f32;
        if count < 4 {
            return None;
        }
        let span = n * (n * n - 1.0) / 12.0; // (1)
        let slope = joint / span;
        let left = (spread - slope * joint).max(0.0);
        let standard_error = libm::sqrtf(left / (n - 2.0) / span); // (3)
        let half = student(n - 2.0) * standard_error;
        Some(Trend { segments: count, mean, slope, standard_error, low: slope - half, high: slope + half })
    }
}

/// 97.5 % quantile of Student's distribution by its expansion about the normal one (Abramowitz and Stegun 26.7.5);
/// 0.8 % short with two degrees of freedom, 0.1 % with three.
fn student(degrees: f32) -> f32 {
    let x = 1.0 / degrees;
    1.959_964 + x * (2.372_271 + x * (2.822_499 + x * (2.555_854 + x * 1.589_535)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn five_points_by_hand() {
        let mut drift = Drift::NONE;
        for distance in [1.0, 3.0, 2.0, 5.0, 4.0] {
            drift.add(distance);
        }
        // t̄ = 2, d̄ = 3: S_td = 8, S_tt = 10, S_dd = 10; b = 0.8, se = sqrt((10 − 6.4)/3/10), t = 3.182446
        let trend = drift.trend().unwrap();
        assert_eq!((trend.segments, trend.mean), (5, 3.0));
        assert!((trend.slope - 0.8).abs() < 1e-6 && (trend.standard_error - 0.346_41).abs() < 1e-5, "{trend:?}");
        assert!((trend.high - 0.8 - 3.182_446 * 0.346_41).abs() < 2e-3 && trend.low < 0.0, "{trend:?}");
    }

    #[test]
    fn four_are_needed_and_nan_is_left_out() {
        let mut drift = Drift::NONE;
        for distance in [1.0, f32::NAN, 2.0, f32::INFINITY, 3.0] {
            drift.add(distance);
        }
        assert_eq!(drift.trend(), None);
        drift.add(4.0);
        let trend = drift.trend().unwrap();
        assert_eq!((trend.slope, trend.standard_error), (1.0, 0.0));
    }

    #[test]
    fn a_slope_that_begins_after_a_million_segments_is_found() {
        let (mut drift, mut n) = (Drift::NONE, 0.0_f64);
        let (mut sum_t, mut sum_d, mut joint, mut squares) = (0.0_f64, 0.0, 0.0, 0.0);
        for k in 0..1_900_000_u32 {
            // Constant for a million segments, then by a unit in a million; ±1/4 about it.
            let distance = 2.0 + f64::from(k.saturating_sub(1_000_000)) * 1e-6 + if k % 2 == 0 { 0.25 } else { -0.25 };
            drift.add(distance as f32);
            n += 1.0;
            let t = f64::from(k);
            (sum_t, sum_d) = (sum_t + t, sum_d + distance);
            (joint, squares) = (joint + t * distance, squares + t * t);
        }
        let slope = (joint - sum_t * sum_d / n) / (squares - sum_t * sum_t / n);
        let trend = drift.trend().unwrap();
        assert_eq!(trend.segments, 1_900_000);
        // A step of the mean, 0.25 in a million, is about the size of its last digit, 2.4e-7: after a million steps the
        // error of the mean is some thousand last digits, and that of the sum of products follows from it.
        assert!((f64::from(trend.slope) / slope - 1.0).abs() < 2e-3 && trend.low > 0.0, "{trend:?} {slope}");
        assert!((f64::from(trend.mean) - sum_d / n).abs() < 1e-3, "{trend:?}");
        assert_eq!(Drift::from_words(drift.words()), Some(drift));
        // After another million the constant part is forgotten.
        (0..1_200_000_u32).for_each(|k| drift.add(3.0 + 1e-6 * k as f32));
        assert!((drift.trend().unwrap().slope / 1e-6 - 1.0).abs() < 0.05, "{:?}", drift.trend());
    }

    #[test]
    fn students_quantiles_as_tabulated() {
        let tabulated =
            [(2.0, 4.302_653, 8e-3), (3.0, 3.182_446, 2e-3), (10.0, 2.228_139, 1e-5), (1e6, 1.959_966, 1e-6)];
        for (degrees, quantile, within) in tabulated {
            assert!((student(degrees) / quantile - 1.0).abs() < within, "{degrees}");
        }
    }
}
