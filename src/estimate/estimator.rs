//! Samples → one [`Estimate`] a segment.
//!
//! Enters: (y, u1, u2) a sample at a time. Leaves: δ-parameters θ, their covariance, the residual variance.
//!
//! ```text
//! sample ─► gate ─► rows: Regressor or Instruments ─► accumulator: Triangle, TwoLevel or Fading
//!                      ▲ auxiliary model, reference              │ segment closed
//!                      └───────────── Estimate ◄───── solve ◄────┘ at once, or from a copy elsewhere
//!
//! least squares   θ = (XᵀX)⁻¹ Xᵀ Y,   cov θ = σ² (XᵀX)⁻¹                         (1)  thesis Eq. 2.17–2.19
//! instruments     θ = (ZᵀX)⁻¹ Zᵀ Y,   cov θ = σ² (ZᵀX)⁻¹ ZᵀZ (XᵀZ)⁻¹             (2)
//! ```
//!
//! The parameters are those of the δ-form: the raw a₁ ≈ −1.9 of a slow pole would hide what tells a fault in its last
//! digits. [`Estimate::raw`] gives a, b, c.
//!
//! Cost: one row and one triangle update a sample; the solve once a segment. [`Estimator::close`] solves on the spot.
//! [`Estimator::detach`] instead hands out a copy of the sums, for a [`Solver`] in another thread or spread over
//! samples; [`Estimator::adopt`] brings its estimate back. Both give the same bits if the estimate is back before
//! [`Regression::handover`].

use super::accumulator::Accumulator;
use super::gate::Gate;
use super::rows::{AnyShape, Rows, Shape};
use super::solve::{Head, Solution, empty};
use super::{Counts, Estimate, Reason, Regression, Regressor, Triangle};
use crate::detector::Sample;

/// Running state of an estimate. Capacities: `M` columns, `P` = M(M−1)/2, `L` delays. `R` makes the rows, `A` sums them.
///
/// Not `Copy`, so that no step goes to a copy by accident.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Estimator<'m, const M: usize, const P: usize, const L: usize, R = Regressor<M, L>, A = Triangle<M, P>> {
    regression: &'m Regression<M>,
    gate: Gate,
    source: R,
    sums: A,
    rows: u32,
    /// Sum of the rows' motion.
    motion: f32,
}

impl<'m, const M: usize, const P: usize, const L: usize, R: Rows<M>, A: Accumulator<M, P>>
    Estimator<'m, M, P, L, R, A>
{
    /// An empty segment of the given regression. One that does not fit ([`Estimator::fits`]) never gives a row.
    #[must_use]
    pub fn new(regression: &'m Regression<M>) -> Self {
        Self {
            regression,
            gate: Gate::new(Self::fits(regression)),
            source: R::new(regression),
            sums: A::new(regression.columns()),
            rows: 0,
            motion: 0.0,
        }
    }

    /// Whether rows and sums of this type are what the regression asks for, within their capacities.
    #[must_use]
    pub fn fits(regression: &Regression<M>) -> bool {
        R::fits(regression) && A::fits(regression)
    }

    /// Takes one sample at the identification rate. One that the gate refuses is counted and flushes the lags. After
    /// [`Accumulator::LONGEST`] rows nothing is added until the next segment, since sums that do not fade need a bound.
    #[inline]
    pub fn step(&mut self, sample: &Sample) {
        if self.admit(sample) {
            self.take(sample);
        } else {
            self.skip();
        }
    }

    /// The gate alone: whether the sample may be used, counted where not. For means, every sample of the block passes
    /// here before the mean goes to [`Estimator::take`].
    #[inline]
    pub fn admit(&mut self, sample: &Sample) -> bool {
        self.gate.admits(&self.regression.guard, sample)
    }

    /// Takes a sample that has passed the gate.
    #[inline]
    pub fn take(&mut self, sample: &Sample) {
        let Some(row) = self.source.push(self.regression, sample) else { return };
        if !self.gate.open || (self.rows >= A::LONGEST && !A::FADES) {
            return;
        }
        if row.weight < 1.0 {
            self.gate.counts.downweighted = self.gate.counts.downweighted.saturating_add(1);
        }
        if self.sums.add(self.regression, &row) {
            self.rows = self.rows.saturating_add(1);
            self.motion += row.motion;
        } else {
            self.gate.counts.still = self.gate.counts.still.saturating_add(1);
        }
    }

    /// Stands in for a sample that is missing or was refused: the lags start anew.
    pub fn skip(&mut self) {
        self.source.flush(self.regression);
    }

    /// Rows of the open segment.
    #[must_use]
    pub const fn rows(&self) -> u32 {
        self.rows
    }

    /// What the open segment was denied.
    #[must_use]
    pub fn counts(&self) -> Counts {
        Counts { refused: self.source.refused(), ..self.gate.counts }
    }

    /// The estimate from the rows so far, leaving the segment open.
    ///
    /// # Errors
    /// A [`Reason`] where the rows are too few or do not excite a parameter, a sensor was stuck, or the result does
    /// not serve.
    pub fn estimate(&self) -> Result<Estimate<M, P>, Reason> {
        let mut estimate = self.empty_estimate();
        self.estimate_into(&mut estimate).map(|()| estimate)
    }

    /// [`Estimator::estimate`] where it is to stay, so that it takes no stack on its way.
    pub(crate) fn estimate_into(&self, estimate: &mut Estimate<M, P>) -> Result<(), Reason> {
        let (regression, head) = (self.regression, self.head());
        *estimate = empty(regression, &head);
        let solve = |sums: &_| Solution::new().finish::<R::Shape, M, P>((regression, &head), sums, estimate);
        let result = self.sums.total(solve);
        if result.is_err() {
            *estimate = self.empty_estimate();
        }
        result
    }

    /// An estimate that says nothing but how many rows and rejections there were.
    #[must_use]
    pub fn empty_estimate(&self) -> Estimate<M, P> {
        let form = (self.regression.order, self.regression.offset);
        Estimate { segment: self.gate.segment, ..Estimate::empty(form.0, form.1, self.rows, self.counts()) }
    }

    /// Where the rows come from.
    #[cfg(test)]
    pub(super) const fn source(&self) -> &R {
        &self.source
    }

    fn head(&self) -> Head<M> {
        let still = self.gate.counts.still;
        let at_rest = if A::FADES { still > self.rows } else { self.motion < self.regression.still * self.rows as f32 };
        Head {
            mass: self.sums.mass(self.regression, self.rows),
            origin: self.source.origin(),
            base: self.source.base(self.regression),
            gain: self.source.gain(),
            counts: self.counts(),
            at_rest,
            segment: self.gate.segment,
        }
    }

    /// Closes the segment: its estimate, which takes over as auxiliary model and reference at the handover. The lags
    /// stay.
    ///
    /// # Errors
    /// As [`Estimator::estimate`]; the auxiliary model then stays, and after three such segments the nominal one
    /// returns.
    pub fn close(&mut self) -> Result<Estimate<M, P>, Reason> {
        let mut estimate = self.empty_estimate();
        self.close_into(&mut estimate).map(|()| estimate)
    }

    /// [`Estimator::close`], as [`Estimator::estimate_into`].
    pub(crate) fn close_into(&mut self, estimate: &mut Estimate<M, P>) -> Result<(), Reason> {
        let result = self.estimate_into(estimate);
        if result.is_ok() && estimate.stable {
            self.source.adopt(self.regression, estimate);
        }
        self.next_segment();
        result
    }

    /// Closes the segment without solving it, in time that does not depend on the data: hands out what a [`Solver`]
    /// needs. Bring its estimate back by [`Estimator::adopt`].
    // Out of line, so that the usual sample has no room for it on the stack.
    #[inline(never)]
    pub fn detach(&mut self) -> Segment<M, P, R::Shape> {
        let (head, sums) = (self.head(), self.sums.total(Triangle::clone));
        let segment = Segment { head, sums, rows: self.rows, shape: core::marker::PhantomData };
        self.next_segment();
        segment
    }

    /// Lets the estimate of the segment that was detached last take over at the handover; `false`, and nothing done, if
    /// that is past, if it is the estimate of another segment, or if its model is not stable.
    pub fn adopt(&mut self, estimate: &Estimate<M, P>) -> bool {
        let own = estimate.stable && estimate.segment.wrapping_add(1) == self.gate.segment;
        let in_time = own && self.source.awaits();
        if in_time {
            self.source.adopt(self.regression, estimate);
        }
        in_time
    }

    fn next_segment(&mut self) {
        self.sums.next_segment();
        self.source.next_segment(self.regression);
        self.gate.next_segment();
        (self.rows, self.motion) = (0, 0.0);
    }

    /// Starts afresh, for a stream that does not go on from the last sample: lags, sums and auxiliary model.
    pub fn restart(&mut self) {
        *self = Self::new(self.regression);
    }
}

/// A closed segment's sums, apart from the estimator that goes on.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Segment<const M: usize, const P: usize, S = AnyShape> {
    head: Head<M>,
    sums: Triangle<M, P>,
    rows: u32,
    shape: core::marker::PhantomData<S>,
}

impl<const M: usize, const P: usize, S: Shape> Segment<M, P, S> {
    /// Rows of the segment.
    #[must_use]
    pub const fn rows(&self) -> u32 {
        self.rows
    }

    /// What the segment was denied.
    #[must_use]
    pub const fn counts(&self) -> Counts {
        self.head.counts
    }

    /// All of the solve, where the estimate is to stay.
    pub(crate) fn solve_into(&self, regression: &Regression<M>, estimate: &mut Estimate<M, P>) -> Result<(), Reason> {
        *estimate = empty(regression, &self.head);
        let result = Solution::new().finish::<S, M, P>((regression, &self.head), &self.sums, estimate);
        if result.is_err() {
            *estimate = Estimate::empty(regression.order, regression.offset, self.rows, self.counts());
        }
        result
    }
}

/// The solve of a detached segment, a bounded piece a call.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Solver<'m, const M: usize, const P: usize, S = AnyShape> {
    regression: &'m Regression<M>,
    segment: Segment<M, P, S>,
    solution: Solution,
    estimate: Estimate<M, P>,
}

impl<'m, const M: usize, const P: usize, S: Shape> Solver<'m, M, P, S> {
    /// Nothing solved yet.
    #[must_use]
    pub fn new(regression: &'m Regression<M>, segment: Segment<M, P, S>) -> Self {
        let estimate = empty(regression, &segment.head);
        Self { regression, segment, solution: Solution::new(), estimate }
    }

    /// The segment under way.
    #[must_use]
    pub const fn segment(&self) -> &Segment<M, P, S> {
        &self.segment
    }

    /// The next piece, of which there are as many as parameters, and three; the last brings the result. Not to be
    /// called after that.
    pub fn advance(&mut self) -> Option<Result<Estimate<M, P>, Reason>> {
        let Self { regression, segment, solution, estimate } = self;
        match solution.advance::<S, M, P>((regression, &segment.head), &segment.sums, estimate) {
            Ok(false) => None,
            Ok(true) => Some(Ok(*estimate)),
            Err(reason) => Some(Err(reason)),
        }
    }

    /// All that is left, at once.
    ///
    /// # Errors
    /// As [`Estimator::estimate`].
    pub fn finish(self) -> Result<Estimate<M, P>, Reason> {
        let Self { regression, segment, mut solution, mut estimate } = self;
        solution.finish::<S, M, P>((regression, &segment.head), &segment.sums, &mut estimate).map(|()| estimate)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::{Guard, Order};

    const REGRESSION: Regression<6> = Regression {
        scale: [1.0, 4.0, 1.0, 0.5, 1.0, 2.0],
        guard: Guard::within([1e3; 3]),
        ..Regression::new(Order::new(2, 1, 1, 1, 1), true)
    };

    type Small<'m> = Estimator<'m, 6, 15, 1>;

    /// y = 1.2 y₁ − 0.4 y₂ + 0.5 u1₁ − 0.25 u2₁ + 0.1 with two square waves.
    fn feed(estimator: &mut Small<'_>, count: u32) {
        let [mut y1, mut y2, mut u1, mut u2] = [0.0_f32; 4];
        for t in 0..count {
            let y = 1.2 * y1 - 0.4 * y2 + 0.5 * u1 - 0.25 * u2 + 0.1;
            u1 = if t % 7 < 3 { 1.0 } else { -1.0 };
            u2 = if t % 11 < 5 { 2.0 } else { 0.0 };
            estimator.step(&Sample { y, u1, u2 });
            (y2, y1) = (y1, y);
        }
    }

    #[test]
    fn exact_data_give_the_exact_model() {
        let mut estimator = Small::new(&REGRESSION);
        feed(&mut estimator, 300);
        let estimate = estimator.estimate().unwrap();
        let expected = [-1.2, 0.4, 0.5, -0.25, 0.1];
        for (got, want) in estimate.raw().into_iter().zip(expected) {
            // A few hundred roundings of f32.
            assert!((got - want).abs() < 2e-5, "{got} {want}");
        }
        assert_eq!((estimate.rows, estimate.parameters()), (298, 5));
        assert!(estimate.variance < 1e-9);
        let v = estimate.covariance_matrix();
        assert!(v == v.transpose() && (0..5).all(|i| v[(i, i)] > 0.0));
    }

    #[test]
    fn few_rows_constant_signals_and_nan_are_reasons() {
        let mut estimator = Small::new(&REGRESSION);
        assert_eq!(estimator.estimate(), Err(Reason::TooFewRows));
        feed(&mut estimator, 7); // 5 rows for 5 parameters
        assert_eq!(estimator.estimate(), Err(Reason::TooFewRows));
        estimator.restart();
        for _ in 0..100 {
            estimator.step(&Sample { y: 1.0, u1: 2.0, u2: 3.0 });
        }
        assert_eq!(estimator.estimate(), Err(Reason::NotExcited(0)));
        estimator.restart();
        for _ in 0..10 {
            estimator.step(&Sample { y: f32::NAN, u1: 0.0, u2: 0.0 });
        }
        assert_eq!(estimator.counts().rejected, 10);
        feed(&mut estimator, 300);
        assert_eq!(estimator.estimate().unwrap().rows, 298, "back to work after the burst");
    }

    #[test]
    fn next_segment_keeps_the_lags() {
        let mut estimator = Small::new(&REGRESSION);
        feed(&mut estimator, 50);
        estimator.next_segment();
        feed(&mut estimator, 50);
        assert_eq!(estimator.empty_estimate().rows, 50);
        estimator.restart();
        feed(&mut estimator, 50);
        assert_eq!(estimator.empty_estimate().rows, 48);
    }

    #[test]
    fn a_level_far_from_zero_costs_no_digits() {
        // The model of `feed`, seen from an operating point of y + 900, u1 + 500, u2 − 300.
        let run = |shift: [f32; 3]| {
            let mut estimator = Small::new(&REGRESSION);
            let [mut y1, mut y2, mut u1, mut u2] = [0.0_f32; 4];
            for t in 0..2000_u32 {
                let noise = if t % 5 < 2 { 0.015_625 } else { -0.015_625 };
                let y = 1.25 * y1 - 0.5 * y2 + 0.5 * u1 - 0.25 * u2 + noise;
                (u1, u2) = (if t % 7 < 3 { 1.0 } else { -1.0 }, if t % 11 < 5 { 2.0 } else { 0.0 });
                estimator.step(&Sample { y: y + shift[0], u1: u1 + shift[1], u2: u2 + shift[2] });
                (y2, y1) = (y1, y);
            }
            estimator.estimate().unwrap()
        };
        let (near, far) = (run([0.0; 3]), run([900.0, 500.0, -300.0]));
        for k in 0..4 {
            let sd = near.covariance_matrix()[(k, k)].sqrt();
            // Samples near 900 carry 6e-5 each, a two-hundredth of the noise.
            assert!((near.delta[k] - far.delta[k]).abs() < 0.1 * sd, "{k}: {} {}", near.delta[k], far.delta[k]);
            assert!((far.covariance_matrix()[(k, k)].sqrt() / sd - 1.0).abs() < 0.01);
        }
        // k = k₀ − t₀ y₀ − β₀ u1₀ − γ₀ u2₀ of the shifted signals.
        let expected = near.delta[4] - near.delta[0] * 900.0 - near.delta[2] * 500.0 + near.delta[3] * 300.0;
        let sd = far.covariance_matrix()[(4, 4)].sqrt();
        assert!((far.delta[4] - expected).abs() < 0.1 * sd, "{} {expected} {sd}", far.delta[4]);
        let g = nalgebra::SVector::from([-900.0, 0.0, -500.0, 300.0, 1.0, 0.0]);
        let transformed = (g.transpose() * near.covariance_matrix() * g)[0].sqrt();
        assert!((sd / transformed - 1.0).abs() < 0.01, "{sd} {transformed}");
    }
}
