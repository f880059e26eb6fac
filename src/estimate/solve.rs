//! The factor of a segment → its [`Estimate`], at once or a bounded piece at a time.
//!
//! ```text
//! R θ = r,   σ² = Σ dᵢ eᵢ² / (N − n),   cov θ = σ² R⁻¹ D⁻¹ R⁻ᵀ                                    (1)
//! ```
//!
//! with the [`Factor`] of the regression; e is a row's own residual, over all rows of the segment's factor.
//!
//! A piece is the check of excitation, then θ and σ², then one column of R⁻¹, then the scaling and the checks of the
//! result. Pieces give the same bits as all at once, since that is how all at once is done.

use super::accumulator::Mass;
use super::factor::{Factor, Of, Outputs, lower, unrolled};
use super::rows::Shape;
use super::stability::is_stable;
use super::{Counts, Estimate, Reason, Regression, Triangle};

/// What a solve needs besides the factor.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Head<const M: usize> {
    pub(super) mass: Mass,
    pub(super) origin: [f32; 3],
    /// What the target was predicted with; zeros where it was not.
    pub(super) base: [f32; M],
    /// |A(1)| of the prefilter.
    pub(super) gain: f32,
    pub(super) counts: Counts,
    pub(super) at_rest: bool,
    pub(super) segment: u8,
}

/// A solve under way, beside the estimate that it fills: that is large, and made where it stays.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Solution {
    rotated: Outputs,
    /// σ² of the scaled rows.
    variance: f32,
    /// Pieces done.
    done: u16,
    failed: Option<Reason>,
}

impl Solution {
    pub(super) const fn new() -> Self {
        Self { rotated: Outputs::NONE, variance: 0.0, done: 0, failed: None }
    }

    /// All pieces, into an [`empty`] estimate; where there is a reason, what is left in it says nothing. `S` is the
    /// structure of the regression, if it is known when compiling.
    pub(super) fn finish<S: Shape, const M: usize, const P: usize>(
        &mut self,
        (regression, head): (&Regression<M>, &Head<M>),
        sums: &Triangle<M, P>,
        estimate: &mut Estimate<M, P>,
    ) -> Result<(), Reason> {
        // As many pieces as there are parameters, and three.
        for _ in 0..M + 3 {
            if self.advance::<S, M, P>((regression, head), sums, estimate)? {
                return Ok(());
            }
        }
        Err(Reason::NotFinite)
    }

    /// The next piece; `true` where it was the last. An error is given again by
    /// every further call.
    #[inline]
    pub(super) fn advance<S: Shape, const M: usize, const P: usize>(
        &mut self,
        (regression, head): (&Regression<M>, &Head<M>),
        sums: &Triangle<M, P>,
        estimate: &mut Estimate<M, P>,
    ) -> Result<bool, Reason> {
        let result = match self.failed {
            Some(reason) => Err(reason),
            None => self.piece::<S, M, P>((regression, head), sums, estimate),
        };
        self.failed = result.err();
        result
    }

    #[inline]
    fn piece<S: Shape, const M: usize, const P: usize>(
        &mut self,
        (regression, head): (&Regression<M>, &Head<M>),
        sums: &Triangle<M, P>,
        estimate: &mut Estimate<M, P>,
    ) -> Result<bool, Reason> {
        let (inputs, outputs) = S::of(regression).split();
        let n = inputs + outputs;
        let piece = self.done as usize;
        self.done = self.done.saturating_add(1);
        match piece {
            0 => self.check::<S, M, P>(regression, head, sums)?,
            1 => self.parameters::<S, M, P>((regression, head), sums, estimate),
            k if k >= n + 2 => return self.accept::<S, M, P>(regression, head, estimate).map(|()| true),
            k => {
                let factor = factor::<S, M, P>(regression, sums, &self.rotated);
                let covariance = &mut estimate.covariance;
                if !unrolled::add_covariance::<Of<S>>(&factor, k - 2, self.variance, covariance) {
                    factor.add_covariance(k - 2, self.variance, &mut [0.0; M], covariance);
                }
            }
        }
        Ok(false)
    }

    /// Whether there is anything to solve.
    fn check<S: Shape, const M: usize, const P: usize>(
        &mut self,
        regression: &Regression<M>,
        head: &Head<M>,
        sums: &Triangle<M, P>,
    ) -> Result<(), Reason> {
        let factor = factor::<S, M, P>(regression, sums, &Outputs::NONE);
        let n = factor.inputs + factor.outputs;
        if let Some(signal) = head.counts.stuck.iter().position(|stuck| *stuck) {
            return Err(Reason::Stuck(u8::try_from(signal).unwrap_or(u8::MAX)));
        }
        if head.at_rest {
            return Err(Reason::AtRest);
        }
        // Written so that NaN is too few.
        let enough = head.mass.rows > n as f32;
        if !enough {
            return Err(Reason::TooFewRows);
        }
        // The columns that must be independent are those of the instruments, the first n.
        let own = Factor { inputs: n, outputs: 0, ..factor };
        let known = unrolled::dependent::<Of<S>>(&own);
        if let Some(column) = known.unwrap_or_else(|| own.dependent()) {
            return Err(Reason::NotExcited(u8::try_from(factor.place(column)).unwrap_or(u8::MAX)));
        }
        if factor.outputs == 0 {
            return Ok(());
        }
        let (rotated, strong) = factor.rotate_outputs(head.mass.rows);
        self.rotated = rotated;
        if strong { Ok(()) } else { Err(Reason::WeakInstruments) }
    }

    /// θ and σ² of (1).
    fn parameters<S: Shape, const M: usize, const P: usize>(
        &mut self,
        (regression, head): (&Regression<M>, &Head<M>),
        sums: &Triangle<M, P>,
        estimate: &mut Estimate<M, P>,
    ) {
        let factor = factor::<S, M, P>(regression, sums, &self.rotated);
        let n = factor.inputs + factor.outputs;
        let mut theta = [0.0_f32; M];
        if !unrolled::solve::<Of<S>>(&factor, &mut theta) {
            factor.solve(&mut theta);
        }
        let squares = factor.residual_sum(&theta);
        let variance = squares / (head.mass.rows - head.mass.spread * n as f32);
        // Scaled problem: (y s_y) = (φ s) θ', so θ = θ' s/s_y, and the variance carries s_y². Scales are powers of two.
        let target = 1.0 / regression.target_scale();
        // One factor after the other: the square of a scale could leave the range of f32.
        estimate.variance = variance * target * target / head.gain / head.gain;
        let cell = |i: usize| {
            let place = factor.place(i);
            let to = estimate.delta.get_mut(place);
            let scales = (regression.scale.get(place), head.base.get(place));
            if let (Some(to), Some(theta), (Some(scale), Some(base))) = (to, theta.get(i), scales) {
                *to = base + theta * scale * target;
            }
        };
        each::<S>(n, cell);
        self.variance = variance * head.mass.spread;
    }

    /// The constant from its origin, and whether the result serves.
    fn accept<S: Shape, const M: usize, const P: usize>(
        &mut self,
        regression: &Regression<M>,
        head: &Head<M>,
        estimate: &mut Estimate<M, P>,
    ) -> Result<(), Reason> {
        let (inputs, outputs) = S::of(regression).split();
        if S::of(regression).offset {
            estimate.uncentre(head.origin);
        }
        // What is no number in a covariance is none on its diagonal.
        let mut sum = estimate.variance;
        let Estimate { delta, covariance, .. } = estimate;
        each::<S>(inputs + outputs, |i| {
            sum += delta.get(i).copied().unwrap_or(0.0) + covariance.get(lower(i, i)).copied().unwrap_or(0.0);
        });
        // Infinity and NaN are not lost in a sum.
        if !sum.is_finite() {
            return Err(Reason::NotFinite);
        }
        estimate.stable = is_stable(estimate.delta.get(..outputs).unwrap_or(&[]));
        Ok(())
    }
}

/// What a solve starts with.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a number of rows, and `as` takes NaN and what is beyond the range to its ends"
)]
pub(super) const fn empty<const M: usize, const P: usize>(
    regression: &Regression<M>,
    head: &Head<M>,
) -> Estimate<M, P> {
    let empty = Estimate::empty(regression.order, regression.offset, head.mass.rows as u32, head.counts);
    Estimate { segment: head.segment, ..empty }
}

/// Hands every place to `run`.
#[inline(always)]
fn each<S: Shape>(n: usize, mut run: impl FnMut(usize)) {
    if !unrolled::every::<Of<S>>(&mut run) {
        (0..n).for_each(run);
    }
}

/// The factor of the regression. Its sizes are constants where the form is.
#[inline(always)]
fn factor<'a, S: Shape, const M: usize, const P: usize>(
    regression: &'a Regression<M>,
    sums: &'a Triangle<M, P>,
    rotated: &'a Outputs,
) -> Factor<'a> {
    let (inputs, outputs) = S::of(regression).split();
    let (d, r) = sums.parts();
    let (scale, common) = (&regression.scale, 1.0 / regression.target_scale());
    Factor { d, r, columns: inputs + 2 * outputs + 1, inputs, outputs, rotated, scale, common }
}
