//! Decisions of many segments → one alarm, with a set mean time between false alarms.
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
//! and (3) divides by it; (2) holds as a ratio of densities. Then the mean number of segments until `S_i` first reaches
//! a limit h is at least e^h, for any h and however small the defect (Lorden 1971; Shin, Ramdas and Rinaldo,
//! e-detectors, 2023). There are K scores, of the novelty and of each trained defect; their false-alarm rates at most
//! add up, so each gets a K-th part of the rate:
//!
//! ```text
//! limit = ln(K T),   T the mean segments between false alarms            (5)
//! ```
//!
//! This sets the mean *time* between false alarms. κ near 0 reacts to few large surprises, κ near 1 sums many small
//! ones; a mean surprise of 1/κ is found soonest. A cap of half the limit requires at least two segments, so that one
//! disturbed record causes no alarm. The bound holds if (2) of [`Novelty`](super::Novelty) is exact and segments are
//! independent. With few training segments the whole series of one drive has a common error, which averages out over
//! drives, not over segments. The alarm names the defect that is most likely over the segments since the first
//! suspicion, and [`Cause::Unknown`] if only the novelty reached the limit.
//!
//! Cost: a few operations a class. Undetermined segments add nothing; a value that is not a number makes its segment
//! undetermined.

use super::discriminant::Decision;
use super::trend::{Drift, Trend};
use crate::plan::{Array, Cells, Plan};

/// Constants of the evidence.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct EvidenceConstants {
    /// κ of (1), between 0 and 1.
    pub bet: f32,
    /// (5), nats; infinite for no alarm.
    pub limit: f32,
    /// The most that one segment adds, nats.
    pub cap: f32,
}

impl EvidenceConstants {
    /// Never an alarm.
    pub const NONE: Self = Self { bet: 0.5, limit: f32::INFINITY, cap: 1.0 };
}

/// The cause of an alarm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Cause {
    /// The trained defect with the largest likelihood.
    Class(u8),
    /// Not healthy, and similar to no trained defect.
    Unknown,
}

/// An alarm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Alarm {
    /// Number of the segment that raised it; the first is 1.
    pub segment: u32,
    /// Its cause.
    pub cause: Cause,
}

/// Running state of the alarm. [`Model::evidence`](crate::Model::evidence) makes it; it takes the decision of each
/// report.
///
/// Without a healthy class in the model there is never an alarm.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Evidence<P: Plan> {
    constants: EvidenceConstants,
    healthy: Option<u8>,
    novelty: f32,
    /// S of each defect; zero for the healthy class and those not in use.
    defects: Array<P::Classes, f32>,
    /// Log-likelihood of each defect beside the likeliest of them, summed since all scores were last zero.
    support: Array<P::Classes, f32>,
    alarm: Option<Alarm>,
    segments: u32,
    undetermined: u32,
    drift: Drift,
}

impl<P: Plan> Evidence<P> {
    pub(crate) fn new(plan: P, constants: EvidenceConstants, healthy: Option<u8>) -> Self {
        let zeros: Array<P::Classes, f32> = Cells::filled(plan.layout().classes as usize, 0.0);
        Self {
            constants,
            healthy,
            novelty: 0.0,
            defects: zeros.clone(),
            support: zeros,
            alarm: None,
            segments: 0,
            undetermined: 0,
            drift: Drift::NONE,
        }
    }

    /// Takes the decision of the next segment, nothing where it had none; gives the alarm that stands.
    pub fn observe(&mut self, decision: Option<&Decision<P>>) -> Option<Alarm> {
        self.segments = self.segments.saturating_add(1);
        let Some(decision) = decision.filter(|decision| decision.surprise.is_finite()) else {
            self.undetermined = self.undetermined.saturating_add(1);
            return self.alarm;
        };
        let healthy = self.healthy?;
        self.drift.add(decision.distance);
        let EvidenceConstants { bet, limit, cap } = self.constants;
        let novelty = super::ln(bet) + (1.0 - bet) * decision.surprise; // (1)
        self.novelty = raised(self.novelty, novelty.min(cap) - ln_capped_mean(bet, cap)); // (3)
        self.weigh_defects(healthy, decision.log_likelihoods());
        if self.alarm.is_none() && self.score() >= limit {
            let conclusive = self.defects.cells().iter().any(|score| *score >= limit); // (4)
            let cause = if conclusive { self.likeliest(healthy) } else { Cause::Unknown };
            self.alarm = Some(Alarm { segment: self.segments, cause });
        }
        self.alarm
    }

    /// (2), (3) and the support.
    fn weigh_defects(&mut self, healthy_class: u8, log_likelihoods: &[f32]) {
        let healthy_class = healthy_class as usize;
        let healthy = log_likelihoods.get(healthy_class).copied().unwrap_or(f32::NAN);
        let cap = self.constants.cap;
        let mut largest = f32::NEG_INFINITY;
        for (k, own) in log_likelihoods.iter().enumerate() {
            largest = if k == healthy_class { largest } else { largest.max(*own) };
        }
        let states = self.defects.cells_mut().iter_mut().zip(self.support.cells_mut());
        for ((k, own), (score, support)) in log_likelihoods.iter().enumerate().zip(states) {
            if k != healthy_class {
                let ratio = own - healthy; // (2)
                *score = raised(*score, if ratio.is_nan() { 0.0 } else { ratio.min(cap) });
                let behind = own - largest;
                // Capped too, so that one disturbed segment does not outweigh the others.
                *support += if behind.is_nan() { 0.0 } else { behind.max(-cap) };
            }
        }
        if self.score() <= 0.0 {
            self.support.cells_mut().fill(0.0);
        }
    }

    fn likeliest(&self, healthy: u8) -> Cause {
        let mut best = (Cause::Unknown, f32::NEG_INFINITY);
        for (k, support) in (0_u8..).zip(self.support.cells()) {
            if k != healthy && *support > best.1 {
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
        self.defects.cells().iter().copied().fold(self.novelty, f32::max)
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
    pub fn reset(&mut self) {
        self.defects.cells_mut().fill(0.0);
        self.support.cells_mut().fill(0.0);
        (self.novelty, self.alarm, self.segments, self.undetermined) = (0.0, None, 0, 0);
        self.drift = Drift::NONE;
    }
}

/// A score never falls below zero.
fn raised(score: f32, log_e: f32) -> f32 {
    (score + log_e).max(0.0)
}

/// ln μ of (6).
fn ln_capped_mean(bet: f32, cap: f32) -> f32 {
    let ln_p = (super::ln(bet) - cap) / (1.0 - bet);
    super::ln(1.0 - libm::expf(bet * ln_p) + libm::expf(cap + ln_p))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{Layout, Memory, Method, RunTime, Structure, testing};

    const CONSTANTS: EvidenceConstants = EvidenceConstants { bet: 0.2, limit: 10.0, cap: 5.0 };

    fn plan() -> RunTime {
        let plain = testing::regression(Structure::new(1, 1, 0, 1, 0), Method::LeastSquares, Memory::Segment);
        RunTime::of(Layout { classes: 3, ..plain }).unwrap()
    }

    fn evidence(healthy: Option<u8>) -> Evidence<RunTime> {
        Evidence::new(plan(), CONSTANTS, healthy)
    }

    fn decision(surprise: f32, log_likelihoods: [f32; 3]) -> Decision<RunTime> {
        let log_likelihoods = log_likelihoods.to_vec();
        Decision { log_likelihoods, distance: surprise, surprise, ..Decision::empty(plan()) }
    }

    #[test]
    fn scores_by_hand() {
        let mut evidence = evidence(Some(0));
        // ln 0.2 = −1.609438 and, with ln p* = −8.261798, ln μ = −0.166382: 4 nats add 1.756944, then 1 nat subtracts
        // 0.643056, and 0 nats all the rest.
        assert_eq!(evidence.observe(Some(&decision(4.0, [0.0, -9.0, -9.0]))), None);
        assert!((evidence.score() - 1.756_944).abs() < 1e-5);
        evidence.observe(Some(&decision(1.0, [0.0, -9.0, -9.0])));
        assert!((evidence.score() - 1.113_888).abs() < 1e-5);
        evidence.observe(Some(&decision(0.0, [0.0, -9.0, -9.0])));
        assert_eq!(evidence.score(), 0.0);
    }

    #[test]
    fn the_alarm_names_the_likelier_defect_and_is_latched() {
        let mut evidence = evidence(Some(0));
        let spalled = decision(1.0, [0.0, 30.0, 20.0]);
        assert_eq!(evidence.observe(Some(&spalled)), None, "capped");
        let alarm = Some(Alarm { segment: 2, cause: Cause::Class(1) });
        assert_eq!(evidence.observe(Some(&spalled)), alarm);
        for _ in 0..50 {
            assert_eq!(evidence.observe(Some(&decision(0.1, [0.0, -30.0, -20.0]))), alarm);
        }
        assert_eq!(evidence.score(), 0.0);
        evidence.reset();
        assert_eq!(evidence, self::evidence(Some(0)));
    }

    #[test]
    fn what_resembles_no_defect_is_unknown() {
        let mut evidence = evidence(Some(0));
        let strange = decision(30.0, [0.0, -2.0, -1.0]);
        evidence.observe(Some(&strange));
        assert_eq!(evidence.observe(Some(&strange)), Some(Alarm { segment: 2, cause: Cause::Unknown }));
    }

    #[test]
    fn nan_adds_nothing_and_is_forgotten() {
        let mut evidence = evidence(Some(0));
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
        assert_eq!(evidence.score(), CONSTANTS.cap);
        let alarm = evidence.observe(Some(&decision(0.0, [0.0, 5.0, 0.0])));
        assert_eq!(alarm.map(|alarm| alarm.cause), Some(Cause::Class(1)));
    }

    #[test]
    fn without_a_healthy_class_there_is_no_alarm() {
        let mut evidence = evidence(None);
        for _ in 0..9 {
            assert_eq!(evidence.observe(Some(&decision(30.0, [0.0, 30.0, 0.0]))), None);
        }
    }
}
