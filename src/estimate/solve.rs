//! The factor of a segment → its [`Estimate`], at once or a bounded piece at a time.
//!
//! With T the rows of R that belong to the instruments (by least squares, to the regressor) and the columns of the
//! regressor, D their diagonal:
//!
//! ```text
//! T θ = r(:, target),   T = [ R_uu  R_uy ; 0  G ],   G = r[x̂ᵢ, yⱼ]                               (1)
//! σ² = Σ dᵢ eᵢ² / (N − n),   e the row's own residual, over all rows of R                        (2)
//! cov θ = σ² T⁻¹ D⁻¹ T⁻ᵀ = Σ_k v_k v_kᵀ σ²/d_k,   T v_k = e(k)                                    (3)
//! ```
//!
//! (1) equals (ZᵀX)⁻¹Zᵀy without forming ZᵀX; (3) is σ² (ZᵀX)⁻¹ ZᵀZ (XᵀZ)⁻¹. By least squares T is R, and G has no
//! rows. G is at most 4 × 4 and inverted with pivoting. Its determinant beside the product of its row norms tells
//! how well the instruments follow the output.
//!
//! A piece is the check of excitation, then (1) and (2), then one k of (3), then the checks of the result; pieces give
//! the same bits as all at once, since that is how all at once is done.

use super::accumulator::Mass;
use super::regression::MAX_OUTPUT_TERMS;
use super::stability::is_stable;
use super::triangle::add_outer;
use super::{Counts, Estimate, Method, Reason, Regression, Triangle};

/// Determinant of G beside its row norms, below which the instruments are weak.
const WEAK: f32 = 1e-5;

/// What a solve needs besides the factor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Head<const M: usize> {
    pub(super) mass: Mass,
    pub(super) origin: [f32; 3],
    /// What the target was predicted with; zeros where it was not.
    pub(super) base: [f32; M],
    /// |A(1)| of the prefilter.
    pub(super) gain: f32,
    pub(super) counts: Counts,
}

/// A solve under way.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Solution<const M: usize, const P: usize> {
    estimate: Estimate<M, P>,
    /// σ² of (2), scaled.
    variance: f32,
    /// G⁻¹.
    inverse: [[f32; MAX_OUTPUT_TERMS]; MAX_OUTPUT_TERMS],
    /// Pieces done.
    done: u16,
}

impl<const M: usize, const P: usize> Solution<M, P> {
    pub(super) fn new(regression: &Regression<M>, head: &Head<M>) -> Self {
        let rows = head.mass.rows as u32;
        let estimate = Estimate::empty(regression.order, regression.offset, rows, head.counts);
        Self { estimate, variance: 0.0, inverse: [[0.0; MAX_OUTPUT_TERMS]; MAX_OUTPUT_TERMS], done: 0 }
    }

    /// All pieces.
    pub(super) fn finish(
        mut self,
        regression: &Regression<M>,
        head: &Head<M>,
        triangle: &Triangle<M, P>,
    ) -> Result<Estimate<M, P>, Reason> {
        // As many pieces as there are parameters, and three.
        for _ in 0..M + 3 {
            match self.advance(regression, head, triangle) {
                Ok(false) => {}
                Ok(true) => return Ok(self.estimate),
                Err(reason) => return Err(reason),
            }
        }
        Err(Reason::NotFinite)
    }

    /// The next piece; `true` where it was the last.
    pub(super) fn advance(
        &mut self,
        regression: &Regression<M>,
        head: &Head<M>,
        triangle: &Triangle<M, P>,
    ) -> Result<bool, Reason> {
        let n = regression.parameters();
        let sizes = Sizes { n, inputs: n - outputs(regression) };
        let piece = self.done as usize;
        self.done = self.done.saturating_add(1);
        match piece {
            0 => check(sizes, head, triangle)?,
            1 => self.parameters(sizes, regression, head, triangle)?,
            k if k < n + 2 => self.covariance(sizes, k - 2, regression, triangle),
            _ => return self.accept(regression, head).map(|()| true),
        }
        Ok(false)
    }

    /// The estimate, once the last piece is done.
    pub(super) const fn estimate(&self) -> &Estimate<M, P> {
        &self.estimate
    }

    /// (1) and (2).
    fn parameters(
        &mut self,
        Sizes { n, inputs }: Sizes,
        regression: &Regression<M>,
        head: &Head<M>,
        triangle: &Triangle<M, P>,
    ) -> Result<(), Reason> {
        let outputs = n - inputs;
        let target = |i: usize| triangle.row(i).last().copied().unwrap_or(0.0);
        let mut theta = [0.0_f32; M];
        if outputs > 0 {
            let mut g = [[0.0; MAX_OUTPUT_TERMS]; MAX_OUTPUT_TERMS];
            for (i, row) in g.iter_mut().enumerate().take(outputs) {
                let from = triangle.row(inputs + i).iter().skip(outputs - 1 - i);
                row.iter_mut().zip(from).take(outputs).for_each(|(cell, r)| *cell = *r);
            }
            self.inverse = invert(g, outputs).ok_or(Reason::WeakInstruments)?;
            for (i, row) in self.inverse.iter().enumerate().take(outputs) {
                let value = row.iter().enumerate().take(outputs).fold(0.0, |sum, (j, x)| sum + x * target(inputs + j));
                if let Some(cell) = theta.get_mut(inputs + i) {
                    *cell = value;
                }
            }
        }
        for i in 0..inputs {
            let value = target(i) - output_part(triangle, i, inputs, theta.get(inputs..n).unwrap_or(&[]));
            if let Some(cell) = theta.get_mut(i) {
                *cell = value;
            }
        }
        triangle.back_substitute(theta.get_mut(..inputs).unwrap_or_default());

        let solved = theta.get(inputs..n).unwrap_or(&[]);
        let mut squares = triangle.residual_sum();
        for (i, d) in triangle.diagonal().iter().enumerate().skip(n).take(outputs) {
            // Column y_i is the row's own diagonal.
            let later = solved.get(i - n..).unwrap_or(&[]);
            let row = core::iter::once(&1.0).chain(triangle.row(i));
            let e = later.iter().zip(row).fold(target(i), |sum, (theta, r)| sum - r * theta);
            squares += d * e * e;
        }
        self.variance = squares / (head.mass.rows - head.mass.spread * n as f32); // (2)

        // Scaled problem: (y s_y) = (φ s) θ', so θ = θ' s/s_y, and the variance carries s_y².
        let scale = regression.target_scale();
        // One division after the other: the square of a scale could leave the range of f32.
        self.estimate.variance = self.variance / scale / scale / head.gain / head.gain;
        let ordered = theta.iter().take(n).skip(inputs).chain(theta.iter().take(inputs));
        let cells = self.estimate.delta.iter_mut().zip(ordered).zip(&regression.scale).zip(&head.base);
        for (((cell, theta), factor), base) in cells {
            *cell = base + theta * factor / scale;
        }
        self.variance *= head.mass.spread;
        Ok(())
    }

    /// One k of (3).
    fn covariance(
        &mut self,
        Sizes { n, inputs }: Sizes,
        k: usize,
        regression: &Regression<M>,
        triangle: &Triangle<M, P>,
    ) {
        let outputs = n - inputs;
        // In the order of the estimate: outputs first.
        let mut v = [0.0_f32; M];
        let Some((head, tail)) = v.split_at_mut_checked(outputs) else { return };
        let used = if k < inputs {
            tail.iter_mut().skip(k).take(1).for_each(|own| *own = 1.0);
            triangle.back_substitute(tail.get_mut(..=k).unwrap_or_default());
            k + 1
        } else {
            for (cell, row) in head.iter_mut().zip(&self.inverse) {
                *cell = row.get(k - inputs).copied().unwrap_or(0.0);
            }
            for (i, cell) in tail.iter_mut().enumerate().take(inputs) {
                *cell = -output_part(triangle, i, inputs, head);
            }
            triangle.back_substitute(tail.get_mut(..inputs).unwrap_or_default());
            inputs
        };
        let target = regression.target_scale();
        let v = v.get_mut(..outputs + used).unwrap_or_default();
        v.iter_mut().zip(&regression.scale).for_each(|(v, scale)| *v = *v * scale / target);
        let d = triangle.diagonal().get(k).copied().unwrap_or(1.0);
        add_outer(&mut self.estimate.covariance, v, self.variance / d);
    }

    /// The checks of the result.
    fn accept(&mut self, regression: &Regression<M>, head: &Head<M>) -> Result<(), Reason> {
        self.estimate.uncentre(head.origin);
        let mut numbers = self.estimate.delta.iter().chain(&self.estimate.covariance);
        if !self.estimate.variance.is_finite() || numbers.any(|x| !x.is_finite()) {
            return Err(Reason::NotFinite);
        }
        let t = self.estimate.delta.get(..outputs(regression)).unwrap_or(&[]);
        if is_stable(t) { Ok(()) } else { Err(Reason::Unstable) }
    }
}

/// Parameters, and how many of them belong to columns that are their own instruments.
#[derive(Clone, Copy)]
struct Sizes {
    n: usize,
    inputs: usize,
}

/// Parameters with an instrument of their own; none by least squares.
fn outputs<const M: usize>(regression: &Regression<M>) -> usize {
    match regression.method {
        Method::LeastSquares => 0,
        Method::Instruments => regression.order.na as usize,
    }
}

fn check<const M: usize, const P: usize>(
    Sizes { n, inputs }: Sizes,
    head: &Head<M>,
    triangle: &Triangle<M, P>,
) -> Result<(), Reason> {
    if let Some(signal) = head.counts.stuck.iter().position(|stuck| *stuck) {
        return Err(Reason::Stuck(u8::try_from(signal).unwrap_or(u8::MAX)));
    }
    // Written so that NaN is too few.
    let enough = head.mass.rows > n as f32;
    if !enough {
        return Err(Reason::TooFewRows);
    }
    match triangle.dependent_among(n) {
        None => Ok(()),
        Some(column) => {
            let place = if column < inputs { n - inputs + column } else { column - inputs };
            Err(Reason::NotExcited(u8::try_from(place).unwrap_or(u8::MAX)))
        }
    }
}

/// Σ_j R(i, yⱼ) x_j for an input's row i.
fn output_part<const M: usize, const P: usize>(triangle: &Triangle<M, P>, i: usize, inputs: usize, x: &[f32]) -> f32 {
    // Row i starts at column i + 1; the regressor's outputs at column inputs + outputs.
    let from = triangle.row(i).iter().skip(inputs + x.len() - i - 1);
    from.zip(x).fold(0.0, |sum, (r, x)| sum + r * x)
}

type Block = [[f32; MAX_OUTPUT_TERMS]; MAX_OUTPUT_TERMS];

/// Inverse of the leading `size` rows and columns by Gauss–Jordan with row pivoting; nothing where the determinant is
/// small beside the row norms, or no number.
fn invert(mut g: Block, size: usize) -> Option<Block> {
    let mut inverse = [[0.0; MAX_OUTPUT_TERMS]; MAX_OUTPUT_TERMS];
    inverse.iter_mut().enumerate().for_each(|(i, row)| row.iter_mut().skip(i).take(1).for_each(|own| *own = 1.0));
    let mut weakness = 1.0_f32;
    for row in g.iter().take(size) {
        weakness *= libm::sqrtf(row.iter().map(|x| x * x).sum());
    }
    let mut determinant = 1.0_f32;
    for k in 0..size {
        let size_at = |row: &[f32; MAX_OUTPUT_TERMS]| row.get(k).map_or(0.0, |x| x.abs());
        let best = (k..size).reduce(|a, b| {
            let larger = g.get(b).map(size_at) > g.get(a).map(size_at);
            if larger { b } else { a }
        })?;
        g.swap(k, best);
        inverse.swap(k, best);
        let (pivot_row, own) = (*g.get(k)?, *inverse.get(k)?);
        let pivot = *pivot_row.get(k)?;
        determinant *= pivot;
        for (i, (row, to)) in g.iter_mut().zip(&mut inverse).enumerate().take(size) {
            let factor = if i == k { 1.0 - 1.0 / pivot } else { *row.get(k)? / pivot };
            row.iter_mut().zip(pivot_row).for_each(|(cell, x)| *cell -= factor * x);
            to.iter_mut().zip(own).for_each(|(cell, x)| *cell -= factor * x);
        }
    }
    // Written so that NaN is weak.
    (determinant.abs() > WEAK * weakness).then_some(inverse)
}
