//! Decisions of many segments → one alarm, with a set mean time between false ones.
//!
//! Enters: a [`Decision`] a segment. Leaves: an [`Alarm`], once, latched until [`Evidence::reset`].
//!
//! ```text
//! novelty    ln e₀ = ln κ + (1 − κ) s                                    (1)  s: surprise, nats; 0 < κ < 1
//! class k    ln e_k = ln p(z|k) − ln p(z|healthy)                        (2)
//! capped     ln e₀ ← min(ln e₀, cap) − ln μ,   ln e_k ← min(ln e_k, cap) (3)  μ: mean of the capped e₀ while healthy
//! scores     S_i ← max(0, S_i + ln e_i)
//! alarm      where any S_i ≥ limit                                       (4)
//! ```
//!
//! While the drive is healthy every e has mean at most 1: (1) since the surprise's probability e^−s is uniform, and
//! ∫ κ p^(κ−1) dp = 1, of which a cap leaves
//!
//! ```text
//! μ = 1 − p*^κ + p* e^cap,   ln p* = (ln κ − cap)/(1 − κ)                (6)  p*: the probability at the cap
//! ```
//!
//! and (3) takes that back; (2) as a ratio of densities. Then the mean number of segments until `S_i` first reaches a limit h
//! is at least e^h, for any h and however small the defect (Lorden 1971; Shin, Ramdas and Rinaldo, e-detectors, 2023).
//! K scores watch together (the novelty's and one for each trained defect), and their false alarms at most add up: each
//! gets a K-th part of the rate,
//!
//! ```text
//! limit = ln(K T),   T the mean segments between false alarms            (5)
//! ```
//!
//! so the mean *time* is what is set. κ near 0 waits for few large surprises, κ near 1 sums many small ones; a mean
//! surprise of 1/κ is found soonest. A cap of half the limit asks for two segments at least, so that one disturbed
//! record is no alarm. The bound holds where (2) of [`Novelty`](super::Novelty) is exact and segments are independent:
//! few training segments put one drive's whole series off to the same side, which averages out over drives, not over
//! segments.
//! The alarm names the defect that the segments since the first suspicion speak for most,
//! and [`Cause::Unknown`] where only the novelty is conclusive.
//!
//! Cost: a handful of operations a class. Undetermined segments bring nothing, and what is not a number counts as one.

use super::Classifier;
use super::discriminant::Decision;
use super::novelty::NO_CLASS;
use super::trend::{Drift, Trend};

/// Constants of the evidence.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct EvidencePlan {
    /// κ of (1), between 0 and 1.
    pub bet: f32,
    /// (5), nats; infinite for no alarm.
    pub limit: f32,
    /// The most that one segment brings, nats.
    pub cap: f32,
}

impl EvidencePlan {
    /// No alarm ever.
    pub const NONE: Self = Self { bet: 0.5, limit: f32::INFINITY, cap: 1.0 };
}

/// What an alarm points to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Cause {
    /// The trained defect that the evidence speaks for most.
    Class(u8),
    /// Not healthy, and like no trained defect.
    Unknown,
}

/// An alarm, as it was raised.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Alarm {
    /// Number of the segment that raised it; the first is 1.
    pub segment: u32,
    /// What it points to.
    pub cause: Cause,
}

/// Running state of the alarm, beside a detector or wherever its reports arrive. `C` classes.
///
/// Without a healthy class in the [`Classifier`] there is never an alarm.
///
/// ```
/// use bearing_watch::decide::{Cause, Evidence, EvidencePlan};
/// # use bearing_watch::decide::{Classifier, Decision, Discriminant, Features, Kind, Novelty, Projection};
/// # let healthy_only = Classifier::<1, 1, 1> {
/// #     features: Features { index: [0], count: 1 },
/// #     projection: Projection { matrix: [[1.0]], mean: [0.0], count: 1 },
/// #     discriminant: Discriminant { kind: Kind::Linear, classes: 1, mean: [[0.0]], whitening: [[[1.0]]],
/// #         log_normaliser: [0.0], log_prior: [0.0], cost: [[0.0]], reject_cost: f32::INFINITY },
/// #     novelty: Novelty { class: 0, ..Novelty::NONE },
/// # };
/// # let decision = |surprise| Decision { class: 0, log_likelihoods: [0.0], posteriors: [1.0], expected_costs: [0.0],
/// #     distance: 3.0, surprise };
/// // One false alarm in a million segments: ln 1e6 = 13.8.
/// let plan = EvidencePlan { bet: 0.2, limit: 13.8, cap: 6.9 };
/// let mut evidence = Evidence::new(plan, &healthy_only);
/// // as reports come: evidence.observe(report.decision.as_ref())
/// assert_eq!(evidence.observe(Some(&decision(0.7))), None);
/// assert_eq!(evidence.observe(None), None);
/// assert_eq!(evidence.observe(Some(&decision(12.0))), None);
/// let alarm = evidence.observe(Some(&decision(12.0))).expect("two large surprises");
/// assert_eq!((alarm.segment, alarm.cause), (4, Cause::Unknown));
/// // It stays until the bearing has been seen to.
/// assert_eq!(evidence.observe(Some(&decision(0.0))), Some(alarm));
/// evidence.reset();
/// assert_eq!(evidence.alarm(), None);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Evidence<const C: usize> {
    plan: EvidencePlan,
    healthy: u8,
    classes: u8,
    novelty: f32,
    /// S of each defect; zero for the healthy class and those not in use.
    defects: [f32; C],
    /// Log-likelihood of each defect beside the likeliest of them, summed since all scores were last zero.
    support: [f32; C],
    alarm: Option<Alarm>,
    segments: u32,
    undetermined: u32,
    drift: Drift,
}

impl<const C: usize> Evidence<C> {
    /// No evidence yet.
    #[must_use]
    pub const fn new<const F: usize, const Z: usize>(plan: EvidencePlan, classifier: &Classifier<F, Z, C>) -> Self {
        Self::of(plan, classifier.novelty.class, classifier.discriminant.classes)
    }

    const fn of(plan: EvidencePlan, healthy: u8, classes: u8) -> Self {
        Self {
            plan,
            healthy,
            classes,
            novelty: 0.0,
            defects: [0.0; C],
            support: [0.0; C],
            alarm: None,
            segments: 0,
            undetermined: 0,
            drift: Drift::NONE,
        }
    }

    /// Takes the decision of the next segment, nothing where it had none; gives the alarm that stands.
    pub fn observe(&mut self, decision: Option<&Decision<C>>) -> Option<Alarm> {
        self.segments = self.segments.saturating_add(1);
        let Some(decision) = decision.filter(|decision| decision.surprise.is_finite()) else {
            self.undetermined = self.undetermined.saturating_add(1);
            return self.alarm;
        };
        if self.healthy == NO_CLASS {
            return None;
        }
        self.drift.add(decision.distance);
        let EvidencePlan { bet, limit, cap } = self.plan;
        let novelty = libm::logf(bet) + (1.0 - bet) * decision.surprise; // (1)
        self.novelty = raised(self.novelty, novelty.min(cap) - ln_capped_mean(bet, cap)); // (3)
        self.weigh_defects(&decision.log_likelihoods);
        if self.alarm.is_none() && self.score() >= limit {
            let conclusive = self.defects.iter().any(|score| *score >= limit); // (4)
            let cause = if conclusive { self.likeliest() } else { Cause::Unknown };
            self.alarm = Some(Alarm { segment: self.segments, cause });
        }
        self.alarm
    }

    /// (2), (3) and the support.
    fn weigh_defects(&mut self, log_likelihoods: &[f32; C]) {
        let healthy_class = self.healthy as usize;
        let healthy = log_likelihoods.get(healthy_class).copied().unwrap_or(f32::NAN);
        let cap = self.plan.cap;
        let in_use = |k: usize| k != healthy_class && k < self.classes as usize;
        let defects = || log_likelihoods.iter().enumerate().filter(|(k, _)| in_use(*k)).map(|(_, value)| *value);
        let largest = defects().fold(f32::NEG_INFINITY, f32::max);
        let states = self.defects.iter_mut().zip(&mut self.support).zip(log_likelihoods);
        for (k, ((score, support), own)) in states.enumerate() {
            if in_use(k) {
                let ratio = own - healthy; // (2)
                *score = raised(*score, if ratio.is_nan() { 0.0 } else { ratio.min(cap) });
                let beside = own - largest;
                // A cap on this too: one wild segment shall not outvote the rest.
                *support += if beside.is_nan() { 0.0 } else { beside.max(-cap) };
            }
        }
        if self.score() <= 0.0 {
            self.support = [0.0; C];
        }
    }

    fn likeliest(&self) -> Cause {
        let mut best = (Cause::Unknown, f32::NEG_INFINITY);
        for (k, support) in (0..self.classes).zip(&self.support) {
            if k != self.healthy && *support > best.1 {
                best = (Cause::Class(k), *support);
            }
        }
        best.0
    }

    /// The alarm that stands.
    #[must_use]
    pub const fn alarm(&self) -> Option<Alarm> {
        self.alarm
    }

    /// The largest of the scores (3), nats; the alarm is raised where it reaches the limit.
    #[must_use]
    pub fn score(&self) -> f32 {
        self.defects.iter().copied().fold(self.novelty, f32::max)
    }

    /// Segments observed, and how many of them were undetermined.
    #[must_use]
    pub const fn segments(&self) -> (u32, u32) {
        (self.segments, self.undetermined)
    }

    /// Course of the distance from the healthy class over the decided segments; nothing before there are four.
    #[must_use]
    pub fn trend(&self) -> Option<Trend> {
        self.drift.trend()
    }

    /// Starts afresh, as after a repair: alarm, scores, counts and trend.
    pub const fn reset(&mut self) {
        *self = Self::of(self.plan, self.healthy, self.classes);
    }
}

/// A score never falls below zero.
fn raised(score: f32, log_e: f32) -> f32 {
    (score + log_e).max(0.0)
}

/// ln μ of (6).
fn ln_capped_mean(bet: f32, cap: f32) -> f32 {
    let ln_p = (libm::logf(bet) - cap) / (1.0 - bet);
    libm::logf(1.0 - libm::expf(bet * ln_p) + libm::expf(cap + ln_p))
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLAN: EvidencePlan = EvidencePlan { bet: 0.2, limit: 10.0, cap: 5.0 };

    fn decision(surprise: f32, log_likelihoods: [f32; 3]) -> Decision<3> {
        Decision {
            class: 0,
            log_likelihoods,
            posteriors: [0.0; 3],
            expected_costs: [0.0; 3],
            distance: surprise,
            surprise,
        }
    }

    #[test]
    fn scores_by_hand() {
        let mut evidence = Evidence::<3>::of(PLAN, 0, 3);
        // ln 0.2 = −1.609438 and, with ln p* = −8.261798, ln μ = −0.166382: 4 nats bring 1.756944, then 1 nat takes
        // 0.643056, and 0 nats all the rest.
        assert_eq!(evidence.observe(Some(&decision(4.0, [0.0, -9.0, -9.0]))), None);
        assert!((evidence.score() - 1.756_944).abs() < 1e-5);
        evidence.observe(Some(&decision(1.0, [0.0, -9.0, -9.0])));
        assert!((evidence.score() - 1.113_888).abs() < 1e-5);
        evidence.observe(Some(&decision(0.0, [0.0, -9.0, -9.0])));
        assert_eq!(evidence.score(), 0.0);
    }

    #[test]
    fn the_alarm_names_the_likelier_defect_and_stays() {
        let mut evidence = Evidence::<3>::of(PLAN, 0, 3);
        let spalled = decision(1.0, [0.0, 30.0, 20.0]);
        assert_eq!(evidence.observe(Some(&spalled)), None, "capped");
        let alarm = Some(Alarm { segment: 2, cause: Cause::Class(1) });
        assert_eq!(evidence.observe(Some(&spalled)), alarm);
        for _ in 0..50 {
            assert_eq!(evidence.observe(Some(&decision(0.1, [0.0, -30.0, -20.0]))), alarm);
        }
        assert_eq!(evidence.score(), 0.0);
        evidence.reset();
        assert_eq!(evidence, Evidence::of(PLAN, 0, 3));
    }

    #[test]
    fn like_no_defect_is_unknown() {
        let mut evidence = Evidence::<3>::of(PLAN, 0, 3);
        let strange = decision(30.0, [0.0, -2.0, -1.0]);
        evidence.observe(Some(&strange));
        assert_eq!(evidence.observe(Some(&strange)), Some(Alarm { segment: 2, cause: Cause::Unknown }));
    }

    #[test]
    fn what_is_not_a_number_brings_nothing_and_is_forgotten() {
        let mut evidence = Evidence::<3>::of(PLAN, 0, 3);
        let (nan, infinite) = (f32::NAN, f32::INFINITY);
        evidence.observe(None);
        evidence.observe(Some(&decision(nan, [0.0, 5.0, 5.0])));
        evidence.observe(Some(&decision(infinite, [0.0, 5.0, 5.0])));
        assert_eq!((evidence.segments(), evidence.score()), ((3, 3), 0.0));
        for odd in [[nan, 5.0, 5.0], [0.0, nan, nan], [-infinite, -infinite, -infinite]] {
            evidence.observe(Some(&decision(0.0, odd)));
            assert_eq!(evidence.score(), 0.0, "{odd:?}");
        }
        evidence.observe(Some(&decision(0.0, [-infinite, 0.0, -infinite])));
        assert_eq!(evidence.score(), PLAN.cap);
        let alarm = evidence.observe(Some(&decision(0.0, [0.0, 5.0, 0.0])));
        assert_eq!(alarm.map(|alarm| alarm.cause), Some(Cause::Class(1)));
    }

    #[test]
    fn without_a_healthy_class_there_is_no_alarm() {
        let mut evidence = Evidence::<3>::of(PLAN, NO_CLASS, 3);
        for _ in 0..9 {
            assert_eq!(evidence.observe(Some(&decision(30.0, [0.0, 30.0, 0.0]))), None);
        }
    }
}
