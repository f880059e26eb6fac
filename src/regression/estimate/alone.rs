//! An estimator with its gate, without a shaft, a classifier and an alarm.

use super::{Estimate, Estimator, RegressionSolve, RegressionSums};
use crate::plan::{Array, Plan, RegressionLayout};
use crate::reason::Reason;
use crate::regression::{Inputs, Regression};
use crate::signal::{Channel, Counts, Gate};

/// A stream of samples through the gate and the estimator; the program closes the segments.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RecursiveEstimator<'m, P: Plan> {
    plan: P,
    channels: &'m Array<P::Channels, Channel>,
    constants: &'m Regression<P>,
    gate: Gate<P>,
    estimator: Estimator<P>,
    sums: RegressionSums<P>,
}

/// A closed segment, and its solve.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ClosedSegment<P: Plan> {
    plan: P,
    sums: RegressionSums<P>,
    solve: RegressionSolve<P>,
    estimate: Estimate<P>,
}

impl<'m, P: Plan> RecursiveEstimator<'m, P> {
    /// Nothing sampled yet; the plan must have a regression.
    #[must_use]
    pub fn new(plan: P, channels: &'m Array<P::Channels, Channel>, constants: &'m Regression<P>) -> Self {
        let (gate, estimator, sums) = (Gate::new(plan), Estimator::new(plan, constants), RegressionSums::new(plan));
        Self { plan, channels, constants, gate, estimator, sums }
    }

    /// Takes one sample.
    #[inline(always)]
    pub fn step(&mut self, sample: &P::Sample) {
        let refused = self.gate.refused(self.channels, sample);
        let Some(layout) = self.plan.layout().regression else { return };
        if refused == 0 {
            let y_limit = crate::signal::limit(self.channels, layout.y);
            let inputs = Inputs::of(&layout, sample);
            self.estimator.take(&mut self.sums, self.plan, self.constants, (inputs, y_limit));
        } else {
            self.estimator.skip(self.plan);
        }
    }

    /// Rows of the open segment.
    #[must_use]
    pub const fn rows(&self) -> u32 {
        self.sums.count
    }

    /// What was refused in the open segment.
    #[must_use]
    pub fn counts(&self) -> Counts {
        let (resting, refused) = self.estimator.counts(&self.sums);
        Counts { resting, refused, ..self.gate.counts }
    }

    /// The open segment as if it were closed; no estimate if a channel is stuck.
    #[inline(always)]
    fn segment(&self) -> ClosedSegment<P> {
        let mut segment = ClosedSegment {
            plan: self.plan,
            sums: self.sums.clone(),
            solve: RegressionSolve::new(self.plan),
            estimate: Estimate::empty(self.plan),
        };
        self.estimator.close(&mut segment.sums, self.plan, self.constants.rest);
        let mask = self.plan.layout().regression.map_or(0, |layout: RegressionLayout| layout.mask());
        if let Some(channel) = self.gate.counts.stuck.first_of(mask) {
            segment.estimate.reason = Some(Reason::Stuck { channel });
        }
        segment
    }

    /// The estimate of the open segment, which stays open.
    #[must_use]
    pub fn estimate(&self) -> Estimate<P> {
        let mut segment = self.segment();
        segment.run(self.constants);
        segment.estimate
    }

    /// Closes the segment and solves it; its estimate becomes the next auxiliary model.
    pub fn close(&mut self) -> Estimate<P> {
        let estimate = self.estimate();
        self.estimator.offer(self.plan, &estimate);
        self.next_segment();
        estimate
    }

    /// Closes the segment and hands it out.
    pub fn detach(&mut self) -> ClosedSegment<P> {
        let segment = self.segment();
        self.next_segment();
        segment
    }

    /// Starts a segment.
    pub fn next_segment(&mut self) {
        self.gate.next_segment();
        self.estimator.next_segment(self.plan, self.constants);
        self.sums.next_segment(self.plan);
    }

    /// Offers an estimate as the next auxiliary model.
    pub fn adopt(&mut self, estimate: &Estimate<P>) -> bool {
        self.estimator.adopt(self.plan, estimate)
    }

    /// Starts afresh.
    pub fn restart(&mut self) {
        *self = Self::new(self.plan, self.channels, self.constants);
    }
}

impl<P: Plan> ClosedSegment<P> {
    /// Does the next step of the solve; the estimate once it is complete.
    pub fn advance(&mut self, constants: &Regression<P>) -> Option<&Estimate<P>> {
        let stuck = matches!(self.estimate.reason, Some(Reason::Stuck { .. }));
        let done = stuck || self.solve.advance(self.plan, constants, &mut self.sums, &mut self.estimate);
        done.then_some(&self.estimate)
    }

    /// Solves it at once.
    #[must_use]
    pub fn finish(mut self, constants: &Regression<P>) -> Estimate<P> {
        self.run(constants);
        self.estimate
    }

    fn run(&mut self, constants: &Regression<P>) {
        while self.advance(constants).is_none() {}
    }
}

#[cfg(test)]
mod tests;
