//! Accepted samples → one [`Estimate`] a segment.
//!
//! Enters: y, u1, u2 a sample at a time. Leaves: δ-parameters θ, their covariance, the residual variance.
//!
//! ```text
//! sample ─► rows: least squares or instruments ─► sums: a segment or fading memory
//!              ▲ auxiliary model                      │ segment closed
//!              └───────────── Estimate ◄──── solve ◄──┘
//!
//! least squares   θ = (XᵀX)⁻¹ Xᵀ Y,   cov θ = σ² (XᵀX)⁻¹                         (1)  thesis Eq. 2.17–2.19
//! instruments     θ = (ZᵀX)⁻¹ Zᵀ Y,   cov θ = σ² (ZᵀX)⁻¹ ZᵀZ (XᵀZ)⁻¹             (2)
//! ```
//!
//! The parameters are those of the δ-form: the raw a₁ ≈ −1.9 of a slow pole would contain the effect of a fault in its
//! last digits only. [`Estimate::raw`] converts to a, b, c.
//!
//! Cost: one row and one update of the factor a sample. [`RegressionSums`] is a copy of a segment's sums that is solved
//! in steps, at once or in another thread. Both ways give the same bits if the estimate is back before
//! [`Regression::handover`].

use super::result::SegmentNumber;
use super::{Estimate, is_stable};
use crate::plan::{Array, Cells, Memory, Plan, RegressionLayout};
use crate::reason::{Part, Reason};
use crate::regression::factor::{Problem, Solution, SolveError, Solved, Sums, longest};
use crate::regression::{Inputs, Reference, Regression, Rows};

/// Running state of the regression.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Estimator<P: Plan> {
    rows: Rows<P>,
    /// Of the open segment.
    segment: SegmentNumber,
}

/// The sums of a segment, separate from the running state.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RegressionSums<P: Plan> {
    sums: Sums<P>,
    frame: Reference<P>,
    /// Rows of the segment.
    pub count: u32,
    /// Sum of the rows' motion.
    motion: f32,
    /// Rows that fading memory ignored.
    resting: u32,
    at_rest: bool,
    segment: SegmentNumber,
}

/// The solve of a closed segment under way.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RegressionSolve<P: Plan> {
    /// What is left of it; `None` before the first step.
    solution: Option<Solution>,
    work: Array<P::Parameters, f32>,
}

impl<P: Plan> Estimator<P> {
    /// Nothing sampled yet.
    #[must_use]
    pub fn new(plan: P, constants: &Regression<P>) -> Self {
        Self { rows: Rows::new(plan, constants), segment: SegmentNumber::FIRST }
    }

    /// Starts afresh, in place; segments are counted on, so that no earlier estimate passes for one of the next
    /// segment.
    #[inline(always)]
    pub fn restart(&mut self, plan: P, constants: &Regression<P>) {
        self.rows = Rows::new(plan, constants);
        self.segment = self.segment.next();
    }

    /// Takes an accepted sample; `y_limit` is the largest plausible output. Once the segment has as many rows as its
    /// memory allows, nothing is added until the next segment.
    #[inline(always)]
    pub fn take(
        &mut self,
        sums: &mut RegressionSums<P>,
        plan: P,
        constants: &Regression<P>,
        (inputs, y_limit): (Inputs, f32),
    ) {
        let Some(RegressionLayout { memory, .. }) = plan.layout().regression else { return };
        let Some(row) = self.rows.push(plan, constants, inputs, y_limit) else { return };
        if sums.count >= longest(memory) && memory != Memory::Fading {
            return;
        }
        if sums.sums.add(memory, &row, constants.forgetting, constants.rest) {
            sums.count = sums.count.saturating_add(1);
            sums.motion += row.motion;
        } else {
            sums.resting = sums.resting.saturating_add(1);
        }
    }

    /// Stands in for a sample that is missing or was refused: the lags start anew.
    #[cold]
    #[inline(never)]
    pub fn skip(&mut self, plan: P) {
        self.rows.flush(plan);
    }

    /// Rows that fading memory ignored, and segments in a row without a new auxiliary model.
    #[must_use]
    pub fn counts(&self, sums: &RegressionSums<P>) -> (u32, u8) {
        (sums.resting, self.rows.refused())
    }

    /// Completes the sums of the segment for a solve; below the motion `rest` the inputs count as at rest.
    #[inline(always)]
    pub fn close(&self, sums: &mut RegressionSums<P>, plan: P, rest: f32) {
        sums.at_rest = match memory(plan) {
            Memory::Fading => sums.resting > sums.count,
            Memory::Segment => sums.motion < rest * sums.count as f32,
        };
        (sums.frame, sums.segment) = (self.rows.frame(plan), self.segment);
    }

    /// Offers an estimate of the segment that was closed last as auxiliary model, to take over at the handover. Returns
    /// `false`, and does nothing, if that is past, if it is the estimate of another segment, or if its model is not
    /// stable.
    pub fn adopt(&mut self, plan: P, estimate: &Estimate<P>) -> bool {
        let in_time = self.segment.follows(estimate.segment) && self.rows.awaits();
        in_time && self.offer(plan, estimate)
    }

    /// Offers the estimate of the open segment, before it is closed.
    pub fn offer(&mut self, plan: P, estimate: &Estimate<P>) -> bool {
        let good = estimate.reason.is_none() && estimate.stable;
        if good {
            self.rows.offer(plan, estimate.delta());
        }
        good
    }

    /// Starts a segment; the lags continue.
    #[inline(always)]
    pub fn next_segment(&mut self, plan: P, constants: &Regression<P>) {
        self.rows.next_segment(plan, constants);
        self.segment = self.segment.next();
    }
}

fn memory<P: Plan>(plan: P) -> Memory {
    plan.layout().regression.map_or(Memory::Segment, |regression| regression.memory)
}

impl<P: Plan> RegressionSums<P> {
    /// No rows.
    #[must_use]
    pub fn new(plan: P) -> Self {
        Self {
            sums: Sums::new(plan),
            frame: Reference::of_zeros(plan),
            count: 0,
            motion: 0.0,
            resting: 0,
            at_rest: false,
            segment: SegmentNumber::FIRST,
        }
    }

    /// No rows again.
    #[inline(never)]
    pub fn clear(&mut self) {
        self.sums.empty();
        self.start();
    }

    /// Starts a segment in the place of the last one: fading memory goes on.
    #[inline(always)]
    pub fn next_segment(&mut self, plan: P) {
        if memory(plan) == Memory::Fading {
            self.sums.next_segment(Memory::Fading);
            self.start();
        } else {
            self.clear();
        }
    }

    /// Starts a segment in a place that is clear: fading memory goes on with the sums of another place.
    #[inline(always)]
    pub fn follow(&mut self, plan: P, last: &Self) {
        if memory(plan) == Memory::Fading {
            self.sums.clone_from(&last.sums);
            self.sums.next_segment(Memory::Fading);
        }
    }

    const fn start(&mut self) {
        (self.count, self.motion, self.resting) = (0, 0.0, 0);
    }

    /// δ-parameters whose prediction was subtracted from the target column.
    #[cfg(test)]
    pub(super) fn base(&self) -> &[f32] {
        self.frame.base.cells()
    }
}

impl<P: Plan> RegressionSolve<P> {
    /// Nothing solved yet.
    #[must_use]
    pub fn new(plan: P) -> Self {
        Self { solution: None, work: Cells::filled(plan.layout().parameters(), 0.0) }
    }

    /// Does the next step of the solve; `true` once the estimate is complete, or has its reason.
    pub fn advance(
        &mut self,
        plan: P,
        constants: &Regression<P>,
        sums: &mut RegressionSums<P>,
        estimate: &mut Estimate<P>,
    ) -> bool {
        let Some(RegressionLayout { memory, .. }) = plan.layout().regression else { return true };
        match self.solve(plan, constants, sums, estimate) {
            Ok(false) => return false,
            Ok(true) => finish(plan, sums, estimate),
            Err(reason) => estimate.reason = Some(reason),
        }
        let mass = sums.sums.mass(memory, constants.forgetting.lambda, sums.count);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a number of rows; `as` maps NaN and what is out of range to the ends"
        )]
        let rows = mass.rows as u32;
        (estimate.rows, estimate.segment) = (rows, sums.segment);
        if estimate.reason.is_some() {
            estimate.delta.cells_mut().fill(0.0);
            estimate.covariance.cells_mut().fill(0.0);
            estimate.variance = 0.0;
        }
        true
    }

    /// Solves for the parameters, or adds a column to the covariance; whether it was the last.
    #[inline(always)]
    fn solve(
        &mut self,
        plan: P,
        constants: &Regression<P>,
        sums: &mut RegressionSums<P>,
        estimate: &mut Estimate<P>,
    ) -> Result<bool, Reason> {
        let Some(layout) = plan.layout().regression else { return Ok(true) };
        if sums.at_rest {
            return Err(Reason::AtRest);
        }
        let mass = sums.sums.mass(layout.memory, constants.forgetting.lambda, sums.count);
        let unknown = sums.sums.unknown(layout.memory, constants.forgetting.floor);
        let (d, r) = sums.sums.triangle_mut().parts_mut();
        let (inputs, outputs) = layout.split();
        let problem = &mut Problem {
            d,
            r,
            inputs,
            outputs,
            scale: constants.scale.cells(),
            base: sums.frame.base.cells(),
            mass,
            gain: sums.frame.gain,
        };
        let solved = &mut Solved {
            delta: estimate.delta.cells_mut(),
            covariance: estimate.covariance.cells_mut(),
            variance: &mut estimate.variance,
            work: self.work.cells_mut(),
        };
        // Known at compile time. By least squares the torque balance uses the same copy of the code.
        let plain = outputs == 0;
        if let Some(solution) = &mut self.solution {
            let add = if plain { Solution::add_column::<false> } else { Solution::add_column::<true> };
            return Ok(add(solution, problem, solved));
        }
        let solution = match unknown {
            Some(column) => Err(SolveError::NotExcited(problem.index(column))),
            None if plain => Solution::new::<false>(problem, solved),
            None => Solution::new::<true>(problem, solved),
        };
        self.solution = Some(solution.map_err(|error| match error {
            SolveError::TooFewRows => Reason::TooFewRows { part: Part::Regression, rows: sums.count },
            SolveError::NotExcited(index) => Reason::ParameterNotExcited(u8::try_from(index).unwrap_or(u8::MAX)),
            SolveError::WeakInstruments => Reason::WeakInstruments(Part::Regression),
        })?);
        Ok(false)
    }
}

/// Restores the constant, and checks that the result can be used.
fn finish<P: Plan>(plan: P, sums: &RegressionSums<P>, estimate: &mut Estimate<P>) {
    // Known at compile time: a plan without a constant carries no code for one.
    if plan.layout().regression.is_some_and(|regression| regression.structure.offset) {
        estimate.restore_constant(sums.frame.origin);
    }
    estimate.reason = if estimate.is_finite() { None } else { Some(Reason::NotFinite(Part::Regression)) };
    let outputs = plan.layout().regression.map_or(0, |regression| regression.split().1);
    estimate.stable = outputs == 0 || is_stable(estimate.delta().get(..outputs).unwrap_or(&[]));
}
