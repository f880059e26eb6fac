//! Decisions of many segments → one alarm, with a set mean time between false alarms.
//!
//! Enters: a [`Decision`] a segment, and where a run ends. Leaves: an [`Alarm`], once, latched until
//! [`Evidence::reset`].
//!
//! ```text
//! segment    ln e₀ = min(ln κ + (1 − κ) s, cap)                          (1)  s: surprise of the distance; 0 < κ < 1
//!            ln e_k = min(ln p(z|k) − ln p(z|healthy), cap)              (2)  of each defect k
//! run        ln ē_i = ln((e_i of segment 1 + … + e_i of segment n)/n) − ln μ_i   (3)
//! scores     S_i ← max(0, max(S_i, ln n) + ln ē_i)   at the end of a run (4)
//! alarm      where any S_i ≥ limit                                       (5)
//! limit      = ln(K T),   T the mean segments between false alarms       (6)  K: number of scores
//! ```
//!
//! An e-value is a number ≥ 0 whose mean is at most 1 while the drive is healthy. (1) is one since the surprise's
//! probability e^−s is uniform, and ∫ κ p^(κ−1) dp = 1. With the cap this integral is
//!
//! ```text
//! μ₀ = 1 − p*^κ + p* e^cap,   ln p* = (ln κ − cap)/(1 − κ)               (7)  p*: the probability at the cap
//! ```
//!
//! and (3) divides by it; (2) is one as a ratio of densities. The healthy class is known from a finite number of
//! segments only: for the drive at hand the mean of (1) or (2) differs from (7) or 1, as long as this model is in use.
//! The trained ln μ is therefore the mean that 95 % of baselines of this size do not exceed.
//!
//! Segments of one run (from one power-up to the next, say) have an offset in common. The mean of e-values is an
//! e-value whatever the dependence between them (Vovk and Wang 2021), their product is not: (3) averages within a run,
//! and (4) multiplies over runs. A run ends by [`Evidence::end_run`], or after `segments_a_run` segments: 1 for
//! independent segments.
//!
//! Let run t have an e-value E and n segments, where E is independent of the runs before given the baseline, and n does
//! not depend on E. Then the recursion
//!
//! ```text
//! R_t = (R_{t−1} + n_t) E_t,   E R_t ≤ E(n_1 + … + n_t)                  (8)
//! ```
//!
//! bounds (4) without its floor, which changes nothing as ln n ≥ 0: e^S ≤ R. So the mean number of *segments* until a
//! score first reaches a limit h is at least e^h, however many segments a run has and however small the defect (Lorden
//! 1971; Shin, Ramdas and Rinaldo, e-detectors, 2023). The false-alarm rates of the K scores at most add up: (6).
//!
//! This sets the mean *time* between false alarms. κ near 0 reacts to few large surprises, κ near 1 sums many small
//! ones; a mean surprise of 1/κ is found soonest. If cap − ln μ is half of limit − ln `segments_a_run`, at least two
//! runs are required, so that one disturbed record causes no alarm. The alarm names the defect that is most likely over
//! the segments since the first suspicion, and [`Cause::Unknown`] if only the novelty reached the limit.
//!
//! A segment beyond the gate of a defect ([`super::novelty`]) has an e-value of at most 1 for it, and adds nothing to
//! its support: a sensor fault far from every class is no trained defect.
//!
//! A model with directions has [`Runs`] in the place of (1) … (4): the means of runs in each direction, relative to
//! this drive, and an alarm that names the direction. Its score of the novelty is that of falls: s of (1) is then the
//! surprise of the rarest fall ([`crate::model::Fall`]), which contains the part of falls in the false alarms, and a
//! segment without a fall has the e-value 0.
//!
//! Cost: a few operations a class, and an exponential and a logarithm a class for runs of several segments.
//! Undetermined segments add nothing and do not count; a value that is not a number makes its segment undetermined.
//! Too many of them in a row are a [`Silence`].

mod words;

use super::growth::{Contribution, Growth};
use super::runs::Runs;
use super::silence::{Silence, SilenceLimits, Silent};
use crate::decide::{Decision, Directions, Fall, NO_MODEL};
use crate::logarithm::ln;
use crate::plan::{Array, Cells, Plan};
use crate::reason::{Part, Reason};

/// Constants of the evidence.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct EvidenceConstants {
    /// κ of (1), between 0 and 1.
    pub bet: f32,
    /// (6), nats; infinite for no alarm.
    pub limit: f32,
    /// The most that ln e of one segment can be, or with directions that of a run, nats.
    pub cap: f32,
    /// Number of decided segments after which a run ends by itself; 1 if segments are independent.
    pub segments_a_run: u32,
    /// ln μ of the novelty (3), nats.
    pub log_mean: f32,
    /// ln μ of every defect (3), nats.
    pub defect_log_mean: f32,
}

impl EvidenceConstants {
    /// Never an alarm.
    pub const NONE: Self =
        Self { bet: 0.5, limit: f32::INFINITY, cap: 1.0, segments_a_run: 1, log_mean: 0.0, defect_log_mean: 0.0 };
}

/// The cause of an alarm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Cause {
    /// The trained defect with the largest likelihood.
    Class(u8),
    /// Not healthy, and similar to no trained defect.
    Unknown,
    /// The coordinate, by its index, whose runs have risen most above those of this drive. Coordinates are not in the
    /// order of the features: the exported model and the hello of [`telemetry`](crate::telemetry) say what each is.
    Coordinate(u8),
    /// The coordinate, by its index, that has been below its usual value over several runs: the load or a sensor, and
    /// no bearing defect.
    Fallen(u8),
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

/// Running state of the alarm; it takes the decision of each report.
///
/// Without a healthy class in the model there is never an alarm.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Evidence<P: Plan> {
    constants: EvidenceConstants,
    healthy: Option<u8>,
    novelty: Score,
    /// Of each defect; zero for the healthy class and those not in use.
    defects: Array<P::Classes, Score>,
    /// Log-likelihood of each defect beside the likeliest of them, summed since all scores were last zero.
    support: Array<P::Classes, f32>,
    /// Number of decided segments of the run.
    run: u32,
    alarm: Option<Alarm>,
    segments: u32,
    undetermined: u32,
    silent: Silent,
    /// Runs in the directions of the model; not used without directions.
    runs: Runs<P>,
    /// What raised the alarm.
    main: Option<Contribution>,
    /// The coordinate that fell last, in a model with directions.
    fallen: Option<u8>,
    /// The id of the model.
    model: u32,
}

/// S of (4), and ln Σe of the run.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Score {
    sum: f32,
    run: f32,
}

impl<P: Plan> Evidence<P> {
    pub(crate) fn empty(
        plan: P,
        constants: EvidenceConstants,
        directions: &Directions<P>,
        healthy: Option<u8>,
    ) -> Self {
        let classes = plan.layout().classes as usize;
        Self {
            constants,
            healthy,
            novelty: Score::ZERO,
            defects: Cells::filled(classes, Score::ZERO),
            support: Cells::filled(classes, 0.0),
            run: 0,
            alarm: None,
            segments: 0,
            undetermined: 0,
            silent: Silent::NONE,
            runs: Runs::new(directions),
            main: None,
            fallen: None,
            model: NO_MODEL,
        }
    }

    /// Of the model with this id, whose segments take so long.
    pub(crate) const fn of_model(mut self, model: u32, segment_s: f32) -> Self {
        (self.model, self.silent) = (model, self.silent.of_segments(segment_s));
        self
    }

    /// With the limits for a silence that another evidence has.
    pub(crate) const fn limited_as(mut self, other: &Self) -> Self {
        self.silent.limit(other.silent.limits());
        self
    }

    /// Sets other limits for [`Evidence::silence`] than [`SilenceLimits::USUAL`].
    pub const fn limit_silence(&mut self, limits: SilenceLimits) {
        self.silent.limit(limits);
    }

    /// Takes the decision of the next segment, nothing where it had none; gives the alarm that stands.
    /// [`Evidence::observe_outcome`] also takes the reason.
    pub fn observe(&mut self, decision: Option<&Decision<P>>) -> Option<Alarm> {
        self.take(decision.ok_or(None))
    }

    /// Takes the outcome of the next segment, [`Report::outcome`](crate::Report::outcome): its decision, or why it has
    /// none; gives the alarm that stands. A decision of another model counts as none.
    pub fn observe_outcome(&mut self, outcome: Result<&Decision<P>, Reason>) -> Option<Alarm> {
        self.take(outcome.map_err(Some))
    }

    fn take(&mut self, outcome: Result<&Decision<P>, Option<Reason>>) -> Option<Alarm> {
        self.segments = self.segments.saturating_add(1);
        let decision = match outcome.and_then(|decision| self.of_this_model(decision)) {
            Ok(decision) => decision,
            Err(reason) => {
                self.undetermined = self.undetermined.saturating_add(1);
                self.silent.add(reason);
                return self.alarm;
            }
        };
        self.silent.end();
        let healthy = self.healthy?;
        let EvidenceConstants { bet, cap, segments_a_run, .. } = self.constants;
        self.run = self.run.saturating_add(1);
        if self.runs.are_used() {
            self.runs.add(decision.directed());
            let Fall { surprise, coordinate } = decision.fall;
            // Without a fall the e-value is zero.
            if surprise > 0.0 {
                self.novelty.add((ln(bet) + (1.0 - bet) * surprise).min(cap)); // (1)
                self.fallen = Some(coordinate);
            }
        } else {
            self.novelty.add((ln(bet) + (1.0 - bet) * decision.distance_surprise).min(cap)); // (1)
            self.weigh_defects(healthy, decision);
        }
        if self.run >= segments_a_run {
            return self.end_run();
        }
        if self.runs.are_used() && self.runs.is_long(self.run) {
            self.look();
        }
        self.alarm
    }

    /// The decision, if it is one of this model, or made without one, and has numbers.
    fn of_this_model<'a>(&self, decision: &'a Decision<P>) -> Result<&'a Decision<P>, Option<Reason>> {
        let Decision { model, distance_surprise, .. } = *decision;
        if model != self.model && model != NO_MODEL && self.model != NO_MODEL {
            return Err(Some(Reason::OtherModel));
        }
        if distance_surprise.is_finite() { Ok(decision) } else { Err(Some(Reason::NotFinite(Part::Classifier))) }
    }

    /// (2) and the support. A segment beyond the gate of a defect raises neither.
    fn weigh_defects(&mut self, healthy_class: u8, decision: &Decision<P>) {
        let (log_likelihoods, healthy_class) = (decision.log_likelihoods(), healthy_class as usize);
        let healthy = log_likelihoods.get(healthy_class).copied().unwrap_or(f32::NAN);
        let cap = self.constants.cap;
        let mut largest = f32::NEG_INFINITY;
        for ((k, likelihood), beyond) in log_likelihoods.iter().enumerate().zip(decision.beyond()) {
            largest = if k == healthy_class || *beyond { largest } else { largest.max(*likelihood) };
        }
        let states = self.defects.cells_mut().iter_mut().zip(self.support.cells_mut());
        let classes = log_likelihoods.iter().enumerate().zip(decision.beyond());
        for (((k, likelihood), beyond), (score, support)) in classes.zip(states) {
            if k != healthy_class {
                let ratio = likelihood - healthy; // (2)
                score.add(if ratio.is_nan() { 0.0 } else { ratio.min(if *beyond { 0.0 } else { cap }) });
                let behind = if *beyond { f32::NEG_INFINITY } else { likelihood - largest };
                // Capped too, so that one disturbed segment does not outweigh the others.
                *support += if behind.is_nan() { 0.0 } else { behind.max(-cap) };
            }
        }
    }

    /// Ends the run, as at power-up or where a new session starts; gives the alarm that stands. Nothing changes if the
    /// run has no decided segment.
    // Out of line like `look`: each has two callers.
    #[inline(never)]
    pub fn end_run(&mut self) -> Option<Alarm> {
        let (Some(healthy), 1..) = (self.healthy, self.run) else { return self.alarm };
        if self.runs.are_used() {
            let EvidenceConstants { limit, cap, .. } = self.constants;
            let risen = self.look();
            self.novelty.end_run(ln(self.run as f32), 0.0);
            let most = if risen > self.novelty.sum { risen } else { self.novelty.sum };
            let quiet = most < 0.5 * limit && self.alarm.is_none();
            self.runs.end(self.run, cap, quiet, self.segments);
            self.run = 0;
            if let (None, Some(index), true) = (self.alarm, self.fallen, self.novelty.sum >= limit) {
                self.alarm = Some(Alarm { segment: self.segments, cause: Cause::Fallen(index) });
            }
            return self.alarm;
        }
        let EvidenceConstants { limit, log_mean, defect_log_mean, .. } = self.constants;
        // Short: a run of one segment needs no logarithm.
        let length = if self.run == 1 { 0.0 } else { ln(self.run as f32) };
        self.run = 0;
        self.novelty.end_run(length, log_mean);
        for (k, defect) in (0_u8..).zip(self.defects.cells_mut()) {
            if k != healthy {
                defect.end_run(length, defect_log_mean);
            }
        }
        if self.score() <= 0.0 {
            self.support.cells_mut().fill(0.0);
        }
        if self.alarm.is_none() && self.score() >= limit {
            let conclusive = self.defects.cells().iter().any(|score| score.sum >= limit); // (5)
            let cause = if conclusive { self.likeliest(healthy) } else { Cause::Unknown };
            self.alarm = Some(Alarm { segment: self.segments, cause });
        }
        self.alarm
    }

    /// Raises the alarm if a direction reaches the limit in the run as it stands; the largest score.
    #[inline(never)]
    fn look(&mut self) -> f32 {
        let EvidenceConstants { cap, limit, .. } = self.constants;
        let (largest, (direction, score)) = self.runs.largest(self.run, cap, limit);
        if self.alarm.is_none() && largest >= limit {
            let cause = Cause::Coordinate(self.runs.coordinate(direction).unwrap_or(u8::MAX));
            self.alarm = Some(Alarm { segment: self.segments, cause });
            self.main = self.runs.standing(direction, score);
        }
        largest
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

    /// The largest of the scores (4) of the runs that have ended, nats; the alarm is raised where it reaches the limit.
    #[must_use]
    pub fn score(&self) -> f32 {
        if self.runs.are_used() {
            return self.runs.score().max(self.novelty.sum);
        }
        self.defects.cells().iter().map(|score| score.sum).fold(self.novelty.sum, f32::max)
    }

    /// What raised the alarm: the direction, by how many deviations, and since when; `None` without directions.
    #[must_use]
    pub const fn main_contribution(&self) -> Option<Contribution> {
        self.main
    }

    /// What a direction contributes at the end of the last run; `None` if the model does not have it.
    #[must_use]
    pub fn contribution(&self, direction: u8) -> Option<Contribution> {
        self.runs.contribution(direction)
    }

    /// The size of a defect in a direction, its slope, and the time until a single segment would show it: four
    /// deviations of segments of healthy drives. `None` if the model does not have the direction.
    #[must_use]
    pub fn growth(&self, direction: u8) -> Option<Growth> {
        self.growth_of(direction, None)
    }

    /// As [`Evidence::growth`], until a size in standard deviations of usual runs, as that of a known full defect.
    #[must_use]
    pub fn growth_to(&self, direction: u8, size: f32) -> Option<Growth> {
        self.growth_of(direction, Some(size))
    }

    fn growth_of(&self, direction: u8, size: Option<f32>) -> Option<Growth> {
        let run_hours = self.runs.usual_segments() * self.silent.segment_s() / 3600.0;
        self.runs.growth(direction, size).map(|growth| Growth { run_hours, ..growth })
    }

    /// Number of runs from which the usual mean of this drive is learned so far; 0 without directions.
    #[must_use]
    pub const fn learned_runs(&self) -> u16 {
        self.runs.learned
    }

    /// The direction in which this drive, after three runs, lies more than three deviations from the drives of
    /// training: it is another drive or has another sensor, and its alarms are in doubt.
    #[must_use]
    pub fn unlike_the_fleet(&self) -> Option<u8> {
        self.runs.unlike_the_fleet()
    }

    /// Segments observed, and how many of them were undetermined.
    #[must_use]
    pub const fn segments(&self) -> (u32, u32) {
        (self.segments, self.undetermined)
    }

    /// Whether no segment has had a verdict for too long, and why; `None` again with the next verdict. It is no alarm
    /// of the bearing and is not latched: a fault that denies verdicts adds nothing to the scores, and would otherwise
    /// be silent for ever.
    #[must_use]
    pub fn silence(&self) -> Option<Silence> {
        self.silent.silence()
    }

    /// Denies the alarm that stands, because the bearing was inspected and is sound; without one nothing changes, and
    /// the result is false. Scores start afresh, and the standard deviation of runs of the direction that raised the
    /// alarm becomes 1.5 times as large, for at most three such alarms. The drive's usual mean goes back to what it was
    /// before the runs that supported the alarm, and later runs change it only if they would have been usual then. A
    /// defect that is denied again and again therefore raises the alarm again and again.
    pub fn deny(&mut self) -> bool {
        if self.alarm.is_none() {
            return false;
        }
        self.runs.deny(self.main.map(|main| main.direction), self.segments);
        self.start_scores();
        true
    }

    /// Scores, run and alarm start afresh.
    fn start_scores(&mut self) {
        self.defects.cells_mut().fill(Score::ZERO);
        self.support.cells_mut().fill(0.0);
        (self.novelty, self.run, self.main, self.alarm) = (Score::ZERO, 0, None, None);
        self.fallen = None;
    }

    /// Starts afresh, as after a repair: alarm, scores, counts, silence, and what was learned of the drive.
    pub fn reset(&mut self) {
        self.start_scores();
        self.runs.reset();
        (self.segments, self.undetermined) = (0, 0);
        self.silent.end();
    }
}

impl Score {
    const ZERO: Self = Self { sum: 0.0, run: f32::NEG_INFINITY };

    /// Adds e to the sum of the run: ln(eᵃ + eᵇ) = max + ln(1 + e^−|a − b|).
    fn add(&mut self, log_e: f32) {
        let (more, less) = (self.run.max(log_e), self.run.min(log_e));
        self.run = if less > f32::NEG_INFINITY { more + ln(1.0 + libm::expf(less - more)) } else { more };
    }

    /// (3) and (4) for a run of which this is ln n.
    fn end_run(&mut self, length: f32, log_mean: f32) {
        let log_e = self.run - length - log_mean;
        *self = Self { sum: (self.sum.max(length) + log_e).max(0.0), ..Self::ZERO };
    }
}

#[cfg(test)]
mod tests;
