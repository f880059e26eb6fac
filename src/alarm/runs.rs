//! Segments of runs, in the directions of defects → scores, one for each direction and bet.
//!
//! Enters: y of each direction, a segment at a time ([`crate::decide`]), and where a run ends. Leaves: the largest
//! score, and what each direction contributes.
//!
//! ```text
//! segment    ω = 1/(1 + v/W),   N ← N + ω,   Y ← Y + ω y                                              (1)
//! run        x = Y/N,   y = x − α,   h = 1 − c,   s² = P + W/N                                         (2)
//! reference  û = Q/Λ,   r = û + q/√Λ;   at first Λ = 1/U, Q = 0                                        (3)
//! score      t = (y − h r)/s,   z = (6/γ) (∛(1 + γ t/2) − 1) + γ/6                                       (4)
//! bet        ℓ_j = min(a_j z − a_j²/2, cap),   a_j = δ_j √(P + W/n₀)/s,   δ_j = 1, 2, 4                (5)
//! sequence   T_j = max(S_j, ln min(n, n₀)) + ℓ_j;   at the end of the run S_j ← max(0, T_j)            (6)
//! alarm      where T_j ≥ limit,   limit = ln T + ln(number of scores)                                  (7)
//! learning   at the end of a run: Λ ← Λ + h²/s²,   Q ← Q + h y/s²                                      (8)
//! guarded    after a denial only if all T_j ≤ ln min(n, n₀) and |x − û′| ≤ q √(1/Λ′ + B + W/N)         (9)
//! offset     k = P/s²,   α ← α + k (min(max(t, −4), 4) s + h r),   c ← c + k h,   P ← P (1 − k);
//!            of the next run α ← ρ α,   c ← ρ c,   P ← ρ² P + (1 − ρ²) B;   at first 0, 0, B          (10)
//! ```
//!
//! v is the variance of the error of a segment's y, and n the number of segments of the run. U, B and W are the
//! variances between drives, runs of a drive, and segments of a run; n₀ is a usual n. ρ is the correlation of the
//! offsets b of successive runs, as of weather; α − c r is the offset that is expected of a drive with the mean r, P
//! the variance of its error: (10) is Kalman's filter. With ρ = 0 nothing is expected, y = x and P = B.
//!
//! **Why this keeps the set time.** Let the drive's mean be u ≤ r. Given the runs before, y has the mean h u and the
//! variance s²: α and c hold for any mean. Then L = exp(δ s₀ (y − h r)/s² − (δ s₀)²/(2 s²)), s₀² = P + W/n₀, is at
//! most the ratio of the densities of the run's segments, given the runs before, with an offset that is δ s₀ larger
//! and without; the offset b of the run is integrated out. So L is a supermartingale in the segments, however they
//! depend on each other through b, and so is min(L, e^cap), since the minimum is concave. With R ← (R + n) L over
//! runs, E R ≤ the number of segments so far, also where one stops within a run; e^T ≤ R, as the floor and the lesser
//! of n and n₀ only lower T. Hence the mean number of segments until a score reaches the limit is at least e^limit
//! (Lorden 1971; Shin, Ramdas and Rinaldo, e-detectors, 2023), and the rates of all scores at most add up: (7). These
//! are e-processes under a normal law with random effects; they are not conformal. (10) deviates from this law where
//! a run is unexpected by more than four deviations, 1 of 16 000: its offset lasts as if it were by four. What comes
//! and does not go is a defect, and a disturbed run does not last; unlimited, the filter would expect either to stay.
//!
//! **The reference** is the posterior of the drive's offset, by the law of the fleet on the first day and sharper with
//! each run (8). What is not known of it is one offset for all runs: were it part of s², each run would be believed and
//! many would not. It is moved to its upper limit once, q = 1.645 for 95 % of the drives, and is not spent again.
//! Nothing is learned from a run while a score is above half of the limit or an alarm stands, nor after `most_runs`: a
//! defect is not followed.
//!
//! **A denied alarm** takes the reference back to û′, Λ′: what the drive had taught when the bets of the direction last
//! held no evidence. They stay until a reset, and by (9) a later run is learned only if it would have been usual then,
//! by the law that denials have widened. So no defect beyond û′ + q √(1/Λ′ + s²) is ever learned, on a drive of any
//! age; the offset of a sound drive within it is.
//!
//! (4) is the normal score of a value of skewness γ (Wilson and Hilferty 1931). Training sets the cap to 0.62 (limit −
//! ln n₀), and at most limit − ln n₀ − 2: one run, however wild, raises no alarm, and two do. A run longer than n₀ is
//! looked at after each of its segments. Three bets instead of one mixture: a mixture within a run would cost its
//! logarithm in every run, and small lasting changes would never add up. A run must be from power-up to power-up, or a
//! day, and not a part of one. Lorden's bound is one for run means: it counts segments, but a run speaks once.

mod scores;

use super::growth::{Contribution, Growth};
use crate::decide::{Direction, Directions, FeatureValue};
use crate::logarithm::ln_of_level;
use crate::plan::{Array, Cells, Plan};
use crate::regression::factor::pairs;
use crate::unroll::no_unroll;
use scores::{Lesson, Scores, Terms};

pub(in crate::alarm) use scores::WORDS;

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

impl<P: Plan> Runs<P> {
    pub(super) fn new(directions: &Directions<P>) -> Self {
        let given = directions.list.cells();
        let at = |k: usize| Scores::new(given.get(k).unwrap_or(&Direction::UNIT), directions.usual_segments);
        Self {
            list: Cells::from_fn(no_unroll(given.len()), at),
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
        pairs(no_unroll(self.list.cells_mut()), no_unroll(values)).for_each(|(direction, y)| direction.add(y));
    }

    /// Whether a run of so many segments is longer than usual.
    pub(super) fn is_long(&self, segments: u32) -> bool {
        segments as f32 >= self.usual_segments
    }

    /// The largest T of (6) of a run of so many segments, and the direction that an alarm names, with its T. An order
    /// above half of the limit precedes friction, which a defect of a race raises too, but no friction raises an order.
    /// Of directions at the cap, which have the same score, it is the one that has risen most.
    pub(super) fn largest(&self, segments: u32, cap: f32, limit: f32) -> (f32, (u8, f32)) {
        let terms = self.terms(segments, cap);
        let (mut largest, mut named) = (0.0_f32, (0, (false, 0.0, 0.0)));
        for (index, direction) in pairs(0..u8::MAX, no_unroll(self.list.cells())) {
            let (top, deviations) = direction.largest(terms);
            largest = largest.max(top);
            let rank = (direction.is_order() && top >= 0.5 * limit, top, deviations);
            if rank > named.1 {
                named = (index, rank);
            }
        }
        let (index, (_, top, _)) = named;
        (largest, (index, top))
    }

    fn terms(&self, segments: u32, cap: f32) -> Terms {
        let Self { usual_segments, margin, .. } = *self;
        let counted = if self.is_long(segments) { usual_segments } else { segments as f32 };
        Terms { usual_segments, margin, log: ln_of_level(counted), cap }
    }

    /// Ends a run of so many segments, of which `now` is the number of the last. It is learned if it is `quiet`.
    pub(super) fn end(&mut self, segments: u32, cap: f32, quiet: bool, now: u32) {
        let terms = self.terms(segments, cap);
        let learns = self.learned < self.most_runs && quiet;
        let lesson = Lesson { learns, guarded: self.are_guarded() };
        for direction in no_unroll(self.list.cells_mut()) {
            direction.grow(segments as f32 / self.usual_segments, self.usual_segments);
            direction.end(terms, lesson, now);
        }
        if learns {
            self.learned = self.learned.saturating_add(1);
        }
    }

    /// The coordinate that a defect raises in a direction.
    pub(super) fn coordinate(&self, index: u8) -> Option<u8> {
        self.at(index).map(Scores::coordinate)
    }

    fn at(&self, index: u8) -> Option<&Scores> {
        self.list.cells().get(index as usize)
    }

    /// Whether a direction watches this coordinate.
    pub(super) fn watch(&self, coordinate: u8) -> bool {
        self.list.cells().iter().any(|direction| direction.coordinate() == coordinate)
    }

    /// What a direction contributes.
    #[inline(never)]
    pub(super) fn contribution(&self, index: u8) -> Option<Contribution> {
        self.at(index).map(|direction| direction.contribution(index))
    }

    /// The contribution of a direction in the run that is not ended, with its score.
    pub(super) fn standing(&self, index: u8, score: f32) -> Option<Contribution> {
        self.at(index).map(|direction| direction.standing(index, score))
    }

    /// The growth of a direction to a size in standard deviations of usual runs, or to one that a segment shows.
    pub(super) fn growth(&self, index: u8, named: Option<f32>) -> Option<Growth> {
        self.at(index).map(|direction| direction.growth(self.usual_segments, named))
    }

    /// Segments of a usual run.
    pub(super) const fn usual_segments(&self) -> f32 {
        self.usual_segments
    }

    /// The first direction in which the drive's usual mean is more than three deviations of drives from that of the
    /// fleet, once three runs are learned.
    pub(super) fn unlike_the_fleet(&self) -> Option<u8> {
        let index = if self.learned < 3 { None } else { self.list.cells().iter().position(Scores::is_far) };
        index.and_then(|index| u8::try_from(index).ok())
    }

    /// The largest S.
    pub(super) fn score(&self) -> f32 {
        self.list.cells().iter().map(Scores::score).fold(0.0, f32::max)
    }

    /// Whether an alarm was denied since the last reset.
    fn are_guarded(&self) -> bool {
        self.list.cells().iter().any(Scores::is_denied)
    }

    /// Widens the law of a direction, whose alarm was denied, and starts all scores afresh at this segment. The first
    /// time, all directions forget what the runs have taught that supported the alarm.
    pub(super) fn deny(&mut self, index: Option<u8>, now: u32) {
        let first = !self.are_guarded();
        for (direction, at) in pairs(self.list.cells_mut(), 0..u8::MAX) {
            if first {
                direction.unlearn();
            }
            if Some(at) == index {
                direction.widen();
            }
            direction.start(now);
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
        self.list.cells().iter().for_each(|direction| direction.save(put));
    }

    /// Takes the words in their order; `None` if one is missing, or none that `segments` segments can leave.
    pub(super) fn restore(&mut self, take: &mut impl FnMut() -> Option<u32>, segments: u32) -> Option<()> {
        self.learned = u16::try_from(take()?).ok()?;
        for direction in self.list.cells_mut() {
            direction.restore(take, segments)?;
        }
        // Without directions nothing is learned.
        let most_runs = if self.are_used() { self.most_runs } else { 0 };
        (self.learned <= most_runs).then_some(())
    }
}

#[cfg(test)]
mod tests;
