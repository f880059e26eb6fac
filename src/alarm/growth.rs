//! Means of runs in a direction → size of a defect, its slope, and the time until a named size.
//!
//! Enters: x and s² of each run ([`super::runs`]), in standard deviations s₀ of a usual run, and the drive's reference
//! û with its variance 1/Λ. Leaves: a [`Growth`].
//!
//! ```text
//! path       g = m − û,   dg/dt = v,   dv/dt = κ v²/g;   then v ∝ g^κ                                 (1)
//! prediction m ← m + v τ + ½ κ v² τ²/g,   v ← v + κ v² τ/g                                            (2)
//!            P ← F P Fᵀ + Q,   F = [1, τ + κρτ; 0, 1 + 2κρ],   ρ = v τ/g                              (3)
//!            Q = w [τ²/3, τ/2; τ/2, 1],   w = q τ + η ρ v² + (σ ρ v)²                                 (4)
//! update     ν = x − m,   S = P_m + s²,   m ← m + P_m ν/S,   v ← v + P_mv ν/S,   P ← P − P e eᵀ P/S   (5)
//! jump       |ν| > 5 √S:   no update,   P_m ← P_m + ν²;   up: P_v ← P_v + (ν/10)²,   down: v = 0      (6)
//! drift      c ← max(0, c + ν/√S − ¼);   c > 7 over n runs: P ← P + b² [n²/4, n/2; n/2, 1],
//!            b = min(1, 2 (c + n/4)/n²)                                                               (7)
//! distance   D = g h,   h = ((L/g)^(1−κ) − 1)/(1 − κ),   time left = D/v                              (8)
//!            σ_D² = (κh − 1)² (P_m + 1/Λ) + g² (∂h/∂κ)² σ² + ζ D² ln(L/g)/3,   σ_Dv = (κh − 1) P_mv   (9)
//! interval   (D − v T)² ≤ z² (σ_D² − 2 T σ_Dv + T² P_v)                                               (10)
//!            lower end at most 0.6 (L − g) A/(g − 1),   A: runs since g was last below 1                (11)
//! ```
//!
//! t and τ count usual runs: a run of n segments takes n/n₀. κ is 0 for a straight line, 1 for an exponential, and
//! negative where a feature saturates; runs before the half of the life hardly tell which, so (1) has κ = 0.1 with the
//! deviation σ = 0.6, in (4) and (9), and does not learn it. (10) is Fieller's interval (1954) of the ratio (8), the
//! first passage of the level through the size L, with z = 1.645 for 90 %. ζ is the spread of a slope that changes
//! while the size grows by a factor of e. (11) is the mean slope since the start: a pause is not taken for the end of
//! growth.
//!
//! Bends are followed where v > 0 and g is above 1 and two of its deviations only, and otherwise κ and ρ are 0. A run
//! that jumps (6) is not believed, but the next one is, whatever it says: a chip raises the level, a disturbed run
//! changes nothing, and after a repair the slope starts anew. (7) is a CUSUM (Page 1954), by which a small q, quiet
//! while healthy, does not delay the slope of a fast growth: its bump is that of a line which began n runs ago.
//!
//! A bearing grows if the interval of the slope is above zero, the size above four of its deviations, and its lower end
//! above two deviations of a usual run; otherwise there is no time left. Offsets that last for many runs, as of weather,
//! are not in s², and then a healthy drive may be said to grow: `bearing-watch-studies campaign --field --growth`
//! counts how often. Cost: 32 bytes a direction, about 60 operations and two roots at the end of a run, and three
//! exponentials for an answer.

use crate::logarithm::ln;

/// Size from which growth is followed.
const START: f32 = 1.0;
/// Part of the time left by the mean slope which the lower end does not exceed.
const STEADY: f32 = 0.6;
/// κ of (1), and its deviation σ.
const BEND: [f32; 2] = [0.1, 0.6];
/// q, η and ζ of (4) and (9).
const RESTLESS: f32 = 2.5e-7;
const TURNS: f32 = 0.05;
const UNSTEADY: f32 = 0.35;
/// Deviation of the slope at first, a run.
const FIRST_SLOPE: f32 = 0.02;
/// Largest ρ of a step.
const FASTEST: f32 = 0.5;
/// Deviations of a jump (6), and the part of it that the slope may have.
const JUMP: f32 = 5.0;
const JUMP_SLOPE: f32 = 0.1;
/// Allowance and limit of (7).
const ALLOWANCE: f32 = 0.25;
const LIMIT: f32 = 7.0;
/// z of (10).
const NORMAL_90: f32 = 1.645;
/// A smaller size, in its deviations, does not grow.
const LEAST_SIZE: f32 = 4.0;
/// Nor one whose lower end is below this: offsets that last for many runs are about as large as those of single runs.
const LEAST_LOW: f32 = 2.0;
/// A larger value is that of a broken sensor, deviations.
const LARGEST: f32 = 1e6;
/// Most usual runs that a run counts for.
const LONGEST: f32 = 16.0;

/// A value with its 90 % interval.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Interval {
    /// The value.
    pub value: f32,
    /// Lower end.
    pub low: f32,
    /// Upper end.
    pub high: f32,
}

/// What a direction says of the size of a defect; an estimate from the past, and no promise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Growth {
    /// By how much the runs exceed the drive's usual mean, in standard deviations of a usual run.
    pub size: Interval,
    /// Its change in a usual run.
    pub slope: Interval,
    /// The named size L, in the same deviations.
    pub named: f32,
    /// Usual runs until the named size, 0 if it is reached; `None` if the size is not growing, or too small to tell.
    pub left: Option<Interval>,
    /// Hours of the segments of a usual run, by which slope and time left are per hour and in hours.
    pub run_hours: f32,
}

/// What a direction contributes to the evidence.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Contribution {
    /// Place of the direction in the model.
    pub direction: u8,
    /// The mean of the last run less the drive's usual mean, in standard deviations of runs.
    pub deviations: f32,
    /// The largest score of the direction, nats.
    pub score: f32,
    /// Number of the last segment before the change.
    pub since: u32,
}

/// Level and slope of a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Course {
    /// m and v.
    level: f32,
    slope: f32,
    /// P: of the level, joint, of the slope.
    variance: f32,
    joint: f32,
    slope_variance: f32,
    /// c and n of (7).
    drift: f32,
    drift_runs: f32,
    /// A: usual runs since the size was last below its start.
    age: f32,
}

/// Words of a course in a saved state.
pub(super) const WORDS: usize = 8;

impl Interval {
    const fn about(value: f32, half: f32) -> Self {
        Self { value, low: value - half, high: value + half }
    }

    /// Times a positive factor.
    #[must_use]
    pub const fn times(self, factor: f32) -> Self {
        Self { value: factor * self.value, low: factor * self.low, high: factor * self.high }
    }
}

impl Growth {
    /// Whether the size grows.
    #[must_use]
    pub const fn is_growing(&self) -> bool {
        self.left.is_some()
    }

    /// Hours until the named size, of segments and not of the time between runs.
    #[must_use]
    pub fn left_hours(&self) -> Option<Interval> {
        self.left.map(|left| left.times(self.run_hours))
    }

    /// Change of the size in an hour.
    #[must_use]
    pub fn slope_per_hour(&self) -> Interval {
        self.slope.times(1.0 / self.run_hours)
    }
}

impl Course {
    /// Nothing known of a drive among drives of this variance.
    pub(super) const fn new(between: f32) -> Self {
        let slope_variance = FIRST_SLOPE * FIRST_SLOPE;
        Self {
            level: 0.0,
            slope: 0.0,
            variance: between,
            joint: 0.0,
            slope_variance,
            drift: 0.0,
            drift_runs: 0.0,
            age: 0.0,
        }
    }

    /// (2) to (4): so many usual runs pass.
    pub(super) fn pass(&mut self, runs: f32, reference: f32) {
        let tau = if runs < LONGEST { runs } else { LONGEST };
        let Self { level, slope, variance, joint, slope_variance, .. } = *self;
        let size = level - reference;
        let bends = slope > 0.0 && size > 2.0 * libm::sqrtf(variance).max(0.5);
        let rate = if bends { (slope * tau / size).min(FASTEST) } else { 0.0 };
        let [bend, spread] = BEND;
        let rise = bend * rate * slope;
        let (a, e) = (tau * (1.0 + bend * rate), 1.0 + 2.0 * bend * rate);
        let turn = spread * rate * slope;
        let noise = RESTLESS * tau + TURNS * rate * slope * slope + turn * turn;
        self.age = if size > START { self.age + tau } else { 0.0 };
        self.level = level + (slope + 0.5 * rise) * tau;
        self.slope = slope + rise;
        self.variance = variance + a * (2.0 * joint + a * slope_variance) + noise * tau * tau / 3.0;
        self.joint = e * (joint + a * slope_variance) + 0.5 * noise * tau;
        self.slope_variance = e * e * slope_variance + noise;
    }

    /// (5) to (7): takes the mean of a run and its variance. Not a number counts as none.
    pub(super) fn take(&mut self, mean: f32, variance: f32) {
        if !mean.is_finite() || !variance.is_finite() {
            return;
        }
        let innovation = (mean - self.level).clamp(-LARGEST, LARGEST);
        let total = self.variance + variance;
        let score = innovation / libm::sqrtf(total);
        if score.abs() > JUMP {
            self.jump(innovation);
            return;
        }
        let gain = self.joint / total;
        self.level += self.variance / total * innovation;
        self.slope += gain * innovation;
        self.slope_variance = (self.slope_variance - gain * self.joint).max(RESTLESS);
        self.joint *= variance / total;
        self.variance *= variance / total;
        self.follow(score);
    }

    /// (6).
    fn jump(&mut self, innovation: f32) {
        (self.drift, self.drift_runs) = (0.0, 0.0);
        if innovation < 0.0 {
            *self = Self { level: self.level, ..Self::new(self.variance) };
        } else {
            let part = JUMP_SLOPE * innovation;
            self.slope_variance += part * part;
        }
        self.variance = (self.variance + innovation * innovation).min(LARGEST * LARGEST);
        self.slope_variance = self.slope_variance.min(LARGEST);
    }

    /// (7).
    fn follow(&mut self, score: f32) {
        let drift = self.drift + score - ALLOWANCE;
        (self.drift, self.drift_runs) = if drift > 0.0 { (drift, self.drift_runs + 1.0) } else { (0.0, 0.0) };
        if drift > LIMIT {
            let n = self.drift_runs;
            let bump = (2.0 * (drift + ALLOWANCE * n) / (n * n)).min(1.0);
            self.slope_variance += bump * bump;
            self.joint += 0.5 * n * bump * bump;
            self.variance += 0.25 * n * n * bump * bump;
            (self.drift, self.drift_runs) = (0.0, 0.0);
        }
    }

    /// Size, slope and time left, relative to a reference with its variance.
    pub(super) fn growth(&self, reference: f32, unknown: f32, named: f32) -> Growth {
        let size = self.level - reference;
        let deviation = libm::sqrtf(self.variance + unknown);
        let size_of = Interval::about(size, NORMAL_90 * deviation);
        let slope = Interval::about(self.slope, NORMAL_90 * libm::sqrtf(self.slope_variance));
        let large = size > LEAST_SIZE * deviation && size_of.low > LEAST_LOW;
        let grows = slope.low > 0.0 && large && named > 0.0;
        let left = grows.then(|| self.left(size, unknown, named));
        Growth { size: size_of, slope, named, left, run_hours: 0.0 }
    }

    /// (8) to (10) of a significant size and slope.
    fn left(&self, size: f32, unknown: f32, named: f32) -> Interval {
        let ratio = named.min(LARGEST) / size;
        if ratio <= 1.0 {
            return Interval::default();
        }
        let path = ln(ratio);
        let [bend, spread] = BEND;
        let stretch = |bend: f32| (libm::expf((1.0 - bend) * path) - 1.0) / (1.0 - bend);
        let (h, v) = (stretch(bend), self.slope);
        let bends = 0.5 * size * (stretch(bend + spread) - stretch(bend - spread));
        let (distance, by_level) = (size * h, bend * h - 1.0);
        let spread = by_level * by_level * (self.variance + unknown)
            + bends * bends
            + UNSTEADY * distance * distance * path / 3.0;
        let z2 = NORMAL_90 * NORMAL_90;
        let first = v * v - z2 * self.slope_variance;
        let middle = v * distance - z2 * by_level * self.joint;
        let last = distance * distance - z2 * spread;
        let root = libm::sqrtf((middle * middle - first * last).max(0.0));
        let low = ((middle - root) / first).max(0.0);
        let steady = STEADY * (named - size) * self.age / (size - START); // (11)
        Interval { value: distance / v, low: low.min(steady), high: (middle + root) / first }
    }

    /// Hands out the words in their order.
    pub(super) fn save(&self, put: &mut impl FnMut(u32)) {
        let Self { level, slope, variance, joint, slope_variance, drift, drift_runs, age } = *self;
        [level, slope, variance, joint, slope_variance, drift, drift_runs, age].iter().for_each(|x| put(x.to_bits()));
    }

    /// Takes the words in their order; `None` if one is missing, or none that runs can leave.
    pub(super) fn restore(take: &mut impl FnMut() -> Option<u32>) -> Option<Self> {
        let mut float = || take().map(f32::from_bits);
        let (level, slope) = (float()?, float()?);
        let (variance, joint, slope_variance) = (float()?, float()?, float()?);
        let (drift, drift_runs, age) = (float()?, float()?, float()?);
        let numbers = [level, slope, variance, joint, slope_variance].iter().all(|x| x.is_finite());
        let spread = variance > 0.0 && slope_variance > 0.0;
        let drifts =
            (0.0..=LIMIT).contains(&drift) && [drift_runs, age].iter().all(|x| (0.0..f32::INFINITY).contains(x));
        let course = Self { level, slope, variance, joint, slope_variance, drift, drift_runs, age };
        (numbers && spread && drifts).then_some(course)
    }
}

#[cfg(test)]
mod tests;
