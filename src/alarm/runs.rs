//! Segments of runs, in the directions of defects → scores, one for each direction and bet.
//!
//! Enters: y of each direction, a segment at a time ([`crate::decide`]), and where a run ends. Leaves: the largest
//! score, and what each direction contributes.
//!
//! ```text
//! segment    ω = 1/(1 + v/W),   N ← N + ω,   Y ← Y + ω y                                              (1)
//! run        x = Y/N,   s² = B + W/N                                                                   (2)
//! reference  û = Q/Λ,   r = û + q/√Λ;   at first Λ = 1/U, Q = 0                                        (3)
//! score      t = (x − r)/s,   z = (6/γ) (∛(1 + γ t/2) − 1) + γ/6                                       (4)
//! bet        ℓ_j = min(a_j z − a_j²/2, cap),   a_j = δ_j √(B + W/n₀)/s,   δ_j = 1, 2, 4                (5)
//! sequence   T_j = max(S_j, ln min(n, n₀)) + ℓ_j;   at the end of the run S_j ← max(0, T_j)            (6)
//! alarm      where T_j ≥ limit,   limit = ln T + ln(number of scores)                                  (7)
//! learning   at the end of a run: Λ ← Λ + 1/s²,   Q ← Q + x/s²                                         (8)
//! ```
//!
//! v is the variance of the error of y, and n the number of segments of the run. U, B and W are the variances between
//! drives, runs of a drive, and segments of a run; n₀ is a usual n.
//!
//! **Why this keeps the set time.** Let the drive's offset be at most r. Then
//! L = exp(δ s₀ (x − r)/s² − (δ s₀)²/(2 s²)) is the ratio of the densities of the run's segments with an offset that is
//! δ s₀ larger, and r; the offset b of the run is integrated out. So L is a supermartingale in the segments, however
//! they depend on each other through b, and so is min(L, e^cap), since the minimum is concave. With R ← (R + n) L over
//! runs, E R ≤ the number of segments so far, also where one stops within a run; e^T ≤ R, as the floor and the lesser
//! of n and n₀ only lower T. Hence the mean number of segments until a score reaches the limit is at least e^limit
//! (Lorden 1971; Shin, Ramdas and Rinaldo, e-detectors, 2023), and the rates of all scores at most add up: (7). These
//! are e-processes under a normal law with random effects; they are not conformal.
//!
//! **The reference** is the posterior of the drive's offset, by the law of the fleet on the first day and sharper with
//! each run (8). What is not known of it is one offset for all runs: were it part of s², each run would be believed and
//! many would not. It is moved to its upper limit once, q = 1.645 for 95 % of the drives, and is not spent again.
//! Nothing is learned from a run while a score is above half of the limit, nor after `most_runs`: a defect is not
//! followed.
//!
//! (4) is the normal score of a value of skewness γ (Wilson and Hilferty 1931). Training sets the cap to 0.62 (limit −
//! ln n₀), and at most limit − ln n₀ − 2: one run, however wild, raises no alarm, and two do. A run longer than n₀ is
//! looked at after each of its segments. Three bets instead of one mixture: a mixture within a run would cost its
//! logarithm in every run, and small lasting changes would never add up. Not covered are offsets that last for several
//! runs, as of weather that is no covariate; a run must be from power-up to power-up, or a day, and not a part of one.

use super::growth::{self, Course, Growth};
use crate::decide::{Direction, Directions, FeatureValue};
use crate::logarithm::{ln, ln_of_level};
use crate::plan::{Array, Cells, Plan};
use crate::regression::factor::pairs;
use crate::unroll::rolled;

/// δ of (5), in standard deviations of a usual run.
const BETS: [f32; 3] = [1.0, 2.0, 4.0];
/// A smaller skewness has no effect.
const SKEWED: f32 = 0.05;
/// The variance of runs is wider by this factor for each alarm of a direction that was denied, and by so many at most.
/// Half as wide again each time, the law is then 3.4 times as wide: it hides no defect that is larger.
const WIDER: f32 = 2.25;
const MOST_DENIED: u8 = 3;
/// Standard deviations by which a size is plain in a segment.
const PLAIN: f32 = 4.0;
/// A bet counts for the onset if its score is at least this part of the direction's largest.
const SUPPORTS: f32 = 0.7;

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

/// The scores of all directions.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Runs<P: Plan> {
    list: Array<P::Directions, Scores>,
    /// n₀, q, and the number of runs that are learned.
    usual_segments: f32,
    margin: f32,
    most_runs: u16,
    /// Number of runs learned so far.
    pub(super) learned: u16,
}

/// A direction.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Scores {
    /// The coordinate that a defect raises.
    coordinate: u8,
    /// U, B as trained, W and γ.
    between: f32,
    run: f32,
    segment: f32,
    skewness: f32,
    /// N and Y of (1).
    count: f32,
    sum: f32,
    /// Λ and Q of (3).
    precision: f32,
    weighted: f32,
    /// S of (6), and the number of the segment at which it was last zero.
    scores: [f32; BETS.len()],
    since: [u32; BETS.len()],
    /// (x − û)/s of the last run.
    deviations: f32,
    /// How many alarms were denied, up to [`MOST_DENIED`].
    denied: u8,
    course: Course,
}

/// Words of a direction in a saved state.
pub(super) const WORDS: usize = 12 + growth::WORDS;

/// What the bets of a run are judged by: ln min(n, n₀), and the cap of (5).
#[derive(Clone, Copy)]
struct Length {
    log: f32,
    cap: f32,
}

impl<P: Plan> Runs<P> {
    pub(super) fn new(directions: &Directions<P>) -> Self {
        let given = directions.list.cells();
        let at = |k: usize| Scores::new(given.get(k).unwrap_or(&Direction::UNIT), directions.usual_segments);
        Self {
            list: Cells::from_fn(rolled(given.len()), at),
            usual_segments: directions.usual_segments,
            margin: directions.margin,
            most_runs: directions.most_runs,
            learned: 0,
        }
    }

    /// Whether the model has directions; known at compile time.
    #[inline(always)]
    pub(super) fn are_used(&self) -> bool {
        !self.list.cells().is_empty()
    }

    /// (1) of each direction.
    pub(super) fn add(&mut self, values: &[FeatureValue]) {
        for (direction, y) in pairs(rolled(self.list.cells_mut()), rolled(values)) {
            if !y.is_missing() {
                let weight = 1.0 / (1.0 + y.variance / direction.segment);
                direction.count += weight;
                direction.sum += weight * y.value;
            }
        }
    }

    /// Whether a run of so many segments is longer than usual.
    pub(super) fn is_long(&self, segments: u32) -> bool {
        segments as f32 >= self.usual_segments
    }

    /// The largest T of (6) of a run of so many segments, and its direction. Of directions at the cap, which have the
    /// same score, it is the one that has risen most.
    pub(super) fn largest(&self, segments: u32, cap: f32) -> (f32, u8) {
        let length = self.length(segments, cap);
        let (mut largest, mut risen) = ((0.0, 0), 0.0);
        for (place, direction) in pairs(0..u8::MAX, rolled(self.list.cells())) {
            let scores = direction.sequence(self.usual_segments, self.margin, length);
            let top = scores.into_iter().fold(0.0, f32::max);
            let deviations = direction.mean().map_or(0.0, |mean| direction.deviations_of(mean));
            if top > largest.0 || (top >= largest.0 && deviations > risen) {
                (largest, risen) = ((top, place), deviations);
            }
        }
        largest
    }

    fn length(&self, segments: u32, cap: f32) -> Length {
        let counted = if self.is_long(segments) { self.usual_segments } else { segments as f32 };
        Length { log: ln_of_level(counted), cap }
    }

    /// Ends a run of so many segments, of which `now` is the number of the last. It is learned if it is `quiet`.
    pub(super) fn end(&mut self, segments: u32, cap: f32, quiet: bool, now: u32) {
        let length = self.length(segments, cap);
        let learns = self.learned < self.most_runs && quiet;
        for direction in rolled(self.list.cells_mut()) {
            direction.grow(segments as f32 / self.usual_segments, self.usual_segments);
            direction.end(self.usual_segments, self.margin, length, learns, now);
        }
        if learns {
            self.learned = self.learned.saturating_add(1);
        }
    }

    /// The coordinate that a defect raises in a direction.
    pub(super) fn coordinate(&self, place: u8) -> Option<u8> {
        self.list.cells().get(place as usize).map(|direction| direction.coordinate)
    }

    /// Whether a direction watches this coordinate.
    pub(super) fn watch(&self, coordinate: u8) -> bool {
        self.list.cells().iter().any(|direction| direction.coordinate == coordinate)
    }

    /// What a direction contributes.
    #[inline(never)]
    pub(super) fn contribution(&self, place: u8) -> Option<Contribution> {
        let Scores { scores, since, deviations, .. } = self.list.cells().get(place as usize)?;
        let score = scores.iter().copied().fold(0.0, f32::max);
        let mut latest = 0;
        for (s, segment) in scores.iter().zip(since) {
            if *s >= SUPPORTS * score && *segment > latest {
                latest = *segment;
            }
        }
        Some(Contribution { direction: place, deviations: *deviations, score, since: latest })
    }

    /// The contribution of a direction in the run that is not ended, with its score.
    pub(super) fn standing(&self, place: u8, score: f32) -> Option<Contribution> {
        let direction = self.list.cells().get(place as usize)?;
        let deviations = direction.mean().map_or(direction.deviations, |mean| direction.deviations_of(mean));
        Some(Contribution { deviations, score, ..self.contribution(place)? })
    }

    /// The growth of a direction to a size in standard deviations of usual runs, or to one that a segment shows.
    pub(super) fn growth(&self, place: u8, named: Option<f32>) -> Option<Growth> {
        let direction = self.list.cells().get(place as usize)?;
        let s = direction.usual(direction.run, self.usual_segments);
        let named = named.unwrap_or_else(|| direction.plain() / s);
        let reference = direction.weighted / direction.precision / s;
        Some(direction.course.growth(reference, 1.0 / direction.precision / (s * s), named))
    }

    /// Segments of a usual run.
    pub(super) const fn usual_segments(&self) -> f32 {
        self.usual_segments
    }

    /// The first direction in which the drive's usual mean is more than three deviations of drives from that of the
    /// fleet, once three runs are learned.
    pub(super) fn unlike_the_fleet(&self) -> Option<u8> {
        let far = |direction: &Scores| {
            (direction.weighted / direction.precision).abs() > 3.0 * libm::sqrtf(direction.between)
        };
        let place = if self.learned < 3 { None } else { self.list.cells().iter().position(far) };
        place.and_then(|place| u8::try_from(place).ok())
    }

    /// The largest S.
    pub(super) fn score(&self) -> f32 {
        let all = self.list.cells().iter().flat_map(|direction| direction.scores);
        all.fold(0.0, f32::max)
    }

    /// Widens the law of a direction, whose alarm was denied, and starts all scores afresh at this segment.
    pub(super) fn deny(&mut self, place: Option<u8>, now: u32) {
        for (direction, at) in pairs(self.list.cells_mut(), 0..u8::MAX) {
            if Some(at) == place && direction.denied < MOST_DENIED {
                direction.denied = direction.denied.wrapping_add(1);
            }
            (direction.count, direction.sum) = (0.0, 0.0);
            (direction.scores, direction.since) = ([0.0; BETS.len()], [now; BETS.len()]);
        }
    }

    /// Forgets all, also what was learned of the drive.
    pub(super) fn reset(&mut self) {
        self.learned = 0;
        let usual_segments = self.usual_segments;
        self.list.cells_mut().iter_mut().for_each(|direction| direction.reset(usual_segments));
    }

    /// Hands out the words in their order.
    pub(super) fn save(&self, put: &mut impl FnMut(u32)) {
        put(self.learned.into());
        for direction in self.list.cells() {
            let Scores { count, sum, precision, weighted, scores, since, deviations, course, .. } = direction;
            [*count, *sum, *precision, *weighted].iter().chain(scores).for_each(|x| put(x.to_bits()));
            since.iter().for_each(|segment| put(*segment));
            put(deviations.to_bits());
            put(direction.denied.into());
            course.save(put);
        }
    }

    /// Takes the words in their order; `None` if one is missing, or none that `segments` segments can leave.
    pub(super) fn restore(&mut self, take: &mut impl FnMut() -> Option<u32>, segments: u32) -> Option<()> {
        self.learned = u16::try_from(take()?).ok()?;
        let most = segments as f32;
        for direction in self.list.cells_mut() {
            let mut float = || take().map(f32::from_bits);
            (direction.count, direction.sum) = (float()?, float()?);
            (direction.precision, direction.weighted) = (float()?, float()?);
            for score in &mut direction.scores {
                *score = float()?;
            }
            for since in &mut direction.since {
                *since = take()?;
            }
            (direction.deviations, direction.denied) = (f32::from_bits(take()?), u8::try_from(take()?).ok()?);
            direction.course = Course::restore(take)?;
            let Scores { count, sum, precision, weighted, scores, since, deviations, between, .. } = *direction;
            let numbers = [sum, weighted, deviations].iter().all(|x| x.is_finite()) && direction.denied <= MOST_DENIED;
            let least = 0.99 / between;
            let good =
                numbers && (0.0..=1.01 * most + 1.0).contains(&count) && precision >= least && precision.is_finite();
            let scored = scores.iter().all(|score| (0.0..f32::INFINITY).contains(score));
            if !(good && scored && since.iter().all(|segment| *segment <= segments)) {
                return None;
            }
        }
        // Without directions nothing is learned.
        let most_runs = if self.are_used() { self.most_runs } else { 0 };
        (self.learned <= most_runs).then_some(())
    }
}

impl Scores {
    fn new(direction: &Direction, usual_segments: f32) -> Self {
        let Direction { coordinate, between, run, segment, skewness, .. } = *direction;
        let mut scores = Self {
            coordinate,
            between,
            run,
            segment,
            skewness,
            count: 0.0,
            sum: 0.0,
            precision: 1.0,
            weighted: 0.0,
            scores: [0.0; BETS.len()],
            since: [0; BETS.len()],
            deviations: 0.0,
            denied: 0,
            course: Course::new(between),
        };
        scores.reset(usual_segments);
        scores
    }

    fn reset(&mut self, usual_segments: f32) {
        (self.count, self.sum, self.deviations, self.denied) = (0.0, 0.0, 0.0, 0);
        (self.precision, self.weighted) = (1.0 / self.between, 0.0);
        (self.scores, self.since) = ([0.0; BETS.len()], [0; BETS.len()]);
        let s = self.usual(self.run, usual_segments);
        self.course = Course::new(self.between / (s * s));
    }

    /// x and s² of (2); `None` if the direction had no value.
    fn mean(&self) -> Option<(f32, f32)> {
        (self.count > 0.0).then(|| (self.sum / self.count, self.run_variance() + self.segment / self.count))
    }

    /// B, wider after alarms that were denied.
    fn run_variance(&self) -> f32 {
        match self.denied {
            0 => self.run,
            1 => self.run * WIDER,
            2 => self.run * (WIDER * WIDER),
            _ => self.run * (WIDER * WIDER * WIDER),
        }
    }

    /// T of (6) for each bet.
    #[inline(never)]
    fn sequence(&self, usual_segments: f32, margin: f32, length: Length) -> [f32; BETS.len()] {
        let Some((x, variance)) = self.mean() else { return self.scores };
        let s = libm::sqrtf(variance);
        let reference = self.weighted / self.precision + margin / libm::sqrtf(self.precision);
        let z = normal_score((x - reference) / s, self.skewness);
        let usual = self.usual(self.run_variance(), usual_segments) / s;
        let mut all = self.scores;
        for (score, bet) in pairs(&mut all, BETS) {
            let a = bet * usual;
            let gain = a * z - 0.5 * a * a;
            // Written so that NaN adds nothing.
            let gain = if gain < length.cap {
                gain
            } else if gain >= length.cap {
                length.cap
            } else {
                0.0
            };
            *score = score.max(length.log) + gain;
        }
        all
    }

    /// The standard deviation of usual runs with this variance between runs; s₀ with B.
    fn usual(&self, between_runs: f32, usual_segments: f32) -> f32 {
        libm::sqrtf(between_runs + self.segment / usual_segments)
    }

    /// The size by which one segment of an unknown drive is four deviations from those of healthy drives.
    fn plain(&self) -> f32 {
        PLAIN * libm::sqrtf(self.between + self.run + self.segment)
    }

    /// Takes the run that ends into the course of the size, after so many usual runs.
    fn grow(&mut self, passed: f32, usual_segments: f32) {
        let s = self.usual(self.run, usual_segments);
        self.course.pass(passed, self.weighted / self.precision / s);
        if let Some((x, variance)) = self.mean() {
            self.course.take(x / s, variance / (s * s));
        }
    }

    /// (x − û)/s.
    fn deviations_of(&self, (x, variance): (f32, f32)) -> f32 {
        (x - self.weighted / self.precision) / libm::sqrtf(variance)
    }

    fn end(&mut self, usual_segments: f32, margin: f32, length: Length, learns: bool, now: u32) {
        let Some((x, variance)) = self.mean() else { return };
        let all = self.sequence(usual_segments, margin, length);
        for ((score, since), t) in pairs(pairs(&mut self.scores, &mut self.since), all) {
            *score = t.max(0.0);
            if *score <= 0.0 {
                *since = now;
            }
        }
        self.deviations = self.deviations_of((x, variance));
        if learns {
            self.precision += 1.0 / variance;
            self.weighted += x / variance;
        }
        (self.count, self.sum) = (0.0, 0.0);
    }
}

/// z of (4).
#[inline(never)]
fn normal_score(t: f32, skewness: f32) -> f32 {
    if skewness < SKEWED {
        return t;
    }
    let level = 1.0 + 0.5 * skewness * t;
    // The cube root of libm works in double precision, which the chip does in software.
    let root = if level > f32::MIN_POSITIVE { libm::expf(ln(level) / 3.0) } else { 0.0 };
    (6.0 / skewness) * (root - 1.0) + skewness / 6.0
}

#[cfg(test)]
mod tests;
