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
//! Centred sums (Welford 1962) lose no digits by cancellation, however large the mean distance. (1) has a closed form
//! because only decided segments count. Beyond 10⁶ segments a segment would change the sums of `f32` by a few roundings
//! only; from there on the trend stays constant. The interval assumes independent segments of equal spread about a
//! straight line.

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

/// The running sums.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Drift {
    count: u32,
    mean: f32,
    /// `S_td`.
    joint: f32,
    /// `S_dd`.
    spread: f32,
}

impl Drift {
    pub(super) const NONE: Self = Self { count: 0, mean: 0.0, joint: 0.0, spread: 0.0 };

    /// Takes a distance; a value that is not finite is left out.
    pub(super) fn add(&mut self, distance: f32) {
        if !distance.is_finite() || self.count >= MAX_TREND_SEGMENTS {
            return;
        }
        let before = distance - self.mean;
        let from_mid = 0.5 * self.count as f32; // t − t̄ = (n−1)/2 with n the new count
        self.count = self.count.saturating_add(1);
        self.mean += before / self.count as f32;
        self.joint += from_mid * before; // (2)
        self.spread += before * (distance - self.mean);
    }

    /// The sums as words.
    pub(super) const fn words(&self) -> [u32; 4] {
        [self.count, self.mean.to_bits(), self.joint.to_bits(), self.spread.to_bits()]
    }

    /// The sums of these words; `None` if distances cannot have them.
    pub(super) fn from_words([count, mean, joint, spread]: [u32; 4]) -> Option<Self> {
        let [mean, joint, spread] = [mean, joint, spread].map(f32::from_bits);
        let finite = mean.is_finite() && joint.is_finite() && spread.is_finite();
        (finite && count <= MAX_TREND_SEGMENTS && mean >= 0.0 && spread >= 0.0).then_some(Self {
            count,
            mean,
            joint,
            spread,
        })
    }

    pub(super) fn trend(&self) -> Option<Trend> {
        let n = self.count as f32;
        if self.count < 4 {
            return None;
        }
        let span = n * (n * n - 1.0) / 12.0; // (1)
        let slope = self.joint / span;
        let left = (self.spread - slope * self.joint).max(0.0);
        let standard_error = libm::sqrtf(left / (n - 2.0) / span); // (3)
        let half = student(n - 2.0) * standard_error;
        Some(Trend {
            segments: self.count,
            mean: self.mean,
            slope,
            standard_error,
            low: slope - half,
            high: slope + half,
        })
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
    fn students_quantiles_as_tabulated() {
        let tabulated =
            [(2.0, 4.302_653, 8e-3), (3.0, 3.182_446, 2e-3), (10.0, 2.228_139, 1e-5), (1e6, 1.959_966, 1e-6)];
        for (degrees, quantile, within) in tabulated {
            assert!((student(degrees) / quantile - 1.0).abs() < within, "{degrees}");
        }
    }
}
