//! The factor of a segment → its [`Estimate`], at once or a bounded piece at a time.
//!
//! ```text
//! R θ = r,   σ² = Σ dᵢ eᵢ² / (N − n),   cov θ = σ² R⁻¹ D⁻¹ R⁻ᵀ                                    (1)
//! ```
//!
//! with the factor of the regression by least squares, and by instrumental variables with the one that
//! [`Triangle::without_instruments`] makes of it; e is a row's own residual, over all rows of the segment's factor.
//!
//! A piece is the check of excitation, then θ and σ², then one column of R⁻¹, then the scaling and the checks of the
//! result. Pieces give the same bits as all at once, since that is how all at once is done.

use super::accumulator::Mass;
use super::rows::Shape;
use super::stability::is_stable;
use super::{Counts, Estimate, Method, Reason, Regression, Triangle};

/// det² G beside its row norms, below which instruments are weak: a determinant of 1e-5.
const WEAK: f32 = 1e-10;

/// What a solve needs besides the factor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Head {
    pub(super) mass: Mass,
    pub(super) origin: [f32; 3],
    /// |A(1)| of the prefilter.
    pub(super) gain: f32,
    pub(super) counts: Counts,
}

/// A solve under way.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Solution<const M: usize, const P: usize> {
    /// The covariance holds R⁻¹ D⁻¹ R⁻ᵀ, in the order of the factor, until the last piece.
    estimate: Estimate<M, P>,
    factor: Triangle<M, P>,
    /// σ² of the scaled rows.
    variance: f32,
    /// Pieces done.
    done: u16,
}

impl<const M: usize, const P: usize> Solution<M, P> {
    pub(super) fn new(regression: &Regression<M>, head: &Head) -> Self {
        let rows = head.mass.rows as u32;
        let estimate = Estimate::empty(regression.order, regression.offset, rows, head.counts);
        Self { estimate, factor: Triangle::new(1), variance: 0.0, done: 0 }
    }

    /// All pieces. `S` is the structure of the regression, if it is known when compiling.
    pub(super) fn finish<S: Shape>(
        mut self,
        regression: &Regression<M>,
        head: &Head,
        sums: &Triangle<M, P>,
    ) -> Result<Estimate<M, P>, Reason> {
        // As many pieces as there are parameters, and three.
        for _ in 0..M + 3 {
            match self.advance::<S>(regression, head, sums) {
                Ok(false) => {}
                Ok(true) => return Ok(self.estimate),
                Err(reason) => return Err(reason),
            }
        }
        Err(Reason::NotFinite)
    }

    /// The next piece; `true` where it was the last.
    #[inline]
    pub(super) fn advance<S: Shape>(
        &mut self,
        regression: &Regression<M>,
        head: &Head,
        sums: &Triangle<M, P>,
    ) -> Result<bool, Reason> {
        let (order, offset) = S::of(regression);
        let n = order.columns(offset) - 1;
        let outputs = if regression.method == Method::Instruments { order.na as usize } else { 0 };
        let sizes = Sizes { n, inputs: n - outputs };
        let piece = self.done as usize;
        self.done = self.done.saturating_add(1);
        match piece {
            0 => self.check(sizes, head, sums)?,
            1 => self.parameters(sizes, regression, head, sums)?,
            k if k >= n + 2 => return self.scale(sizes, regression, head).map(|()| true),
            k if S::FIXED.is_some() => self.factor.add_inverse_column_of(n, k - 2, &mut self.estimate.covariance),
            k => self.factor.add_inverse_column(k - 2, &mut self.estimate.covariance),
        }
        Ok(false)
    }

    /// The estimate, once the last piece is done.
    pub(super) const fn estimate(&self) -> &Estimate<M, P> {
        &self.estimate
    }

    /// Whether there is anything to solve.
    fn check(&mut self, sizes: Sizes, head: &Head, sums: &Triangle<M, P>) -> Result<(), Reason> {
        let Sizes { n, inputs } = sizes;
        if let Some(signal) = head.counts.stuck.iter().position(|stuck| *stuck) {
            return Err(Reason::Stuck(u8::try_from(signal).unwrap_or(u8::MAX)));
        }
        // Written so that NaN is too few.
        let enough = head.mass.rows > n as f32;
        if !enough {
            return Err(Reason::TooFewRows);
        }
        if let Some(column) = sums.dependent_among(n) {
            return Err(Reason::NotExcited(u8::try_from(sizes.place(column)).unwrap_or(u8::MAX)));
        }
        if inputs == n {
            self.factor = sums.clone();
            return Ok(());
        }
        let (factor, strength) = sums.without_instruments(inputs, n - inputs);
        self.factor = factor;
        // Written so that NaN is weak.
        if strength > WEAK { Ok(()) } else { Err(Reason::WeakInstruments) }
    }

    /// θ and σ² of (1).
    fn parameters(
        &mut self,
        sizes: Sizes,
        regression: &Regression<M>,
        head: &Head,
        sums: &Triangle<M, P>,
    ) -> Result<(), Reason> {
        let Sizes { n, inputs } = sizes;
        let theta = self.factor.solve();
        let solved = theta.get(inputs..n).unwrap_or(&[]);
        let mut squares = sums.residual_sum();
        for (i, d) in sums.diagonal().iter().enumerate().skip(n).take(n - inputs) {
            let Some((target, later)) = sums.row(i).split_last() else { continue };
            // The column of output i − n is the row's own diagonal.
            let row = core::iter::once(&1.0).chain(later);
            let known = row.zip(solved.get(i - n..).unwrap_or(&[]));
            let e = known.fold(*target, |sum, (r, theta)| sum - r * theta);
            squares += d * e * e;
        }
        let variance = squares / (head.mass.rows - head.mass.spread * n as f32);
        // Scaled problem: (y s_y) = (φ s) θ', so θ = θ' s/s_y, and the variance carries s_y².
        let target = regression.target_scale();
        // One division after the other: the square of a scale could leave the range of f32.
        self.estimate.variance = variance / target / target / head.gain / head.gain;
        for (column, theta) in theta.iter().enumerate().take(n) {
            let place = sizes.place(column);
            if let (Some(cell), Some(scale)) = (self.estimate.delta.get_mut(place), regression.scale.get(place)) {
                *cell = theta * scale / target;
            }
        }
        self.variance = variance * head.mass.spread;
        Ok(())
    }

    /// The covariance in its units and order, and whether the result serves.
    fn scale(&mut self, sizes: Sizes, regression: &Regression<M>, head: &Head) -> Result<(), Reason> {
        let Sizes { n, inputs } = sizes;
        let outputs = n - inputs;
        let target = regression.target_scale();
        let scale = regression.scale.map(|scale| scale / target);
        let inverse = self.estimate.covariance;
        let mut cells = self.estimate.covariance.iter_mut();
        let mut sum = self.estimate.variance;
        for (i, row_scale) in scale.iter().enumerate().take(n) {
            let factor = self.variance * row_scale;
            let i = sizes.column(i);
            for (j, (column_scale, cell)) in scale.iter().zip(cells.by_ref().take(sizes.place(i) + 1)).enumerate() {
                let j = sizes.column(j);
                let packed = if i >= j { i * (i + 1) / 2 + j } else { j * (j + 1) / 2 + i };
                *cell = inverse.get(packed).copied().unwrap_or(0.0) * factor * column_scale;
                sum += *cell;
            }
        }
        self.estimate.uncentre(head.origin);
        let delta = self.estimate.delta.get(..n).unwrap_or(&[]);
        sum = delta.iter().fold(sum, |sum, x| sum + x);
        // Infinity and NaN are not lost in a sum.
        if !sum.is_finite() {
            return Err(Reason::NotFinite);
        }
        if is_stable(delta.get(..outputs).unwrap_or(&[])) { Ok(()) } else { Err(Reason::Unstable) }
    }
}

/// Parameters, and how many of them belong to inputs (by least squares: all, in the order of the estimate).
#[derive(Clone, Copy)]
struct Sizes {
    n: usize,
    inputs: usize,
}

impl Sizes {
    /// Place in the estimate of the parameter of a column of the factor: outputs first.
    const fn place(self, column: usize) -> usize {
        if column < self.inputs { self.n - self.inputs + column } else { column - self.inputs }
    }

    /// The column of the factor for a place in the estimate.
    const fn column(self, place: usize) -> usize {
        let outputs = self.n - self.inputs;
        if place < outputs { self.inputs + place } else { place - outputs }
    }
}
