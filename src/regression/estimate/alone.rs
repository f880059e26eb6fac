//! An estimator with its gate and without a shaft or a classifier, for tests and measurements.

use super::{Estimate, Estimator, RegressionSolve, RegressionSums};
use crate::plan::{Array, Plan, RegressionLayout};
use crate::reason::Reason;
use crate::regression::{Inputs, Regression};
use crate::signal::{Channel, Counts, Gate};

/// A stream of samples through the gate and the estimator.
#[derive(Clone, Debug, PartialEq)]
pub struct Alone<'m, P: Plan> {
    plan: P,
    channels: &'m Array<P::Channels, Channel>,
    constants: &'m Regression<P>,
    gate: Gate<P>,
    estimator: Estimator<P>,
}

/// A closed segment.
#[derive(Clone, Debug, PartialEq)]
pub struct Detached<P: Plan> {
    /// The sums.
    pub sums: RegressionSums<P>,
    /// Samples, rows and channels of the segment that were refused or weighted less.
    pub counts: Counts,
}

impl<'m, P: Plan> Alone<'m, P> {
    /// Nothing sampled yet; the plan must have a regression.
    #[must_use]
    pub fn new(plan: P, channels: &'m Array<P::Channels, Channel>, constants: &'m Regression<P>) -> Self {
        Self { plan, channels, constants, gate: Gate::new(plan), estimator: Estimator::new(plan, constants) }
    }

    /// Takes one sample.
    #[inline(always)]
    pub fn step(&mut self, sample: &P::Sample) {
        let refused = self.gate.refused(self.channels, sample);
        let Some(layout) = self.plan.layout().regression else { return };
        if refused == 0 {
            let y_limit = crate::signal::limit(self.channels, layout.y);
            self.estimator.take(self.plan, self.constants, Inputs::of(&layout, sample), y_limit);
        } else {
            self.estimator.skip(self.plan);
        }
    }

    /// Rows of the open segment.
    #[must_use]
    pub const fn rows(&self) -> u32 {
        self.estimator.rows()
    }

    /// What was refused in the open segment.
    #[must_use]
    pub fn counts(&self) -> Counts {
        let (downweighted, resting, refused) = self.estimator.counts();
        Counts { downweighted, resting, refused, ..self.gate.counts }
    }

    fn sums(&self) -> Detached<P> {
        Detached { sums: self.estimator.sums(self.plan, self.constants.rest), counts: self.counts() }
    }

    /// The estimate of the open segment, which stays open.
    #[must_use]
    pub fn estimate(&self) -> Estimate<P> {
        self.solve(self.sums())
    }

    /// Closes the segment and solves it; its estimate becomes the next auxiliary model.
    pub fn close(&mut self) -> Estimate<P> {
        let estimate = self.estimate();
        self.estimator.offer(self.plan, self.constants, &estimate);
        self.next_segment();
        estimate
    }

    /// Closes the segment and hands out its sums.
    pub fn detach(&mut self) -> Detached<P> {
        let sums = self.sums();
        self.next_segment();
        sums
    }

    /// Starts a segment.
    pub fn next_segment(&mut self) {
        self.gate.next_segment();
        self.estimator.next_segment(self.plan, self.constants);
    }

    /// Solves a closed segment at once.
    #[must_use]
    pub fn solve(&self, mut detached: Detached<P>) -> Estimate<P> {
        let mut estimate = self.unsolved(&detached);
        let mut solve = RegressionSolve::new(self.plan);
        let stuck = matches!(estimate.reason, Some(Reason::Stuck { .. }));
        while !stuck && !solve.advance(self.plan, self.constants, &mut detached.sums, &mut estimate) {}
        estimate
    }

    /// No estimate, and the reason if a channel is stuck.
    fn unsolved(&self, detached: &Detached<P>) -> Estimate<P> {
        let mut estimate = Estimate::empty(self.plan);
        let mask = self.plan.layout().regression.map_or(0, |layout: RegressionLayout| layout.mask());
        if let Some(channel) = detached.counts.stuck.first_of(mask) {
            estimate.reason = Some(Reason::Stuck { channel });
        }
        estimate
    }

    /// The solve of a closed segment in steps.
    #[must_use]
    pub fn steps(&self, detached: Detached<P>) -> Steps<P> {
        let estimate = self.unsolved(&detached);
        let done = matches!(estimate.reason, Some(Reason::Stuck { .. }));
        Steps { plan: self.plan, sums: detached.sums, solve: RegressionSolve::new(self.plan), estimate, done }
    }

    /// Offers an estimate as the next auxiliary model.
    pub fn adopt(&mut self, estimate: &Estimate<P>) -> bool {
        self.estimator.adopt(self.plan, self.constants, estimate)
    }

    /// Starts afresh.
    pub fn restart(&mut self) {
        *self = Self::new(self.plan, self.channels, self.constants);
    }
}

/// A solve under way.
#[derive(Clone, Debug, PartialEq)]
pub struct Steps<P: Plan> {
    plan: P,
    sums: RegressionSums<P>,
    solve: RegressionSolve<P>,
    estimate: Estimate<P>,
    done: bool,
}

impl<P: Plan> Steps<P> {
    /// Does the next step; the estimate once it is complete.
    pub fn advance(&mut self, constants: &Regression<P>) -> Option<&Estimate<P>> {
        if !self.done {
            self.done = self.solve.advance(self.plan, constants, &mut self.sums, &mut self.estimate);
        }
        self.done.then_some(&self.estimate)
    }
}

#[cfg(test)]
mod tests;
