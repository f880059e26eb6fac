//! What the regression of one segment estimated.

use crate::plan::{Array, Cells, Plan, Structure};
use crate::reason::{Part, Reason};
use crate::regression::factor::{lower, pairs};

/// The estimate of one segment: δ-parameters with covariance, and residual variance.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Estimate<P: Plan> {
    /// Why there is no estimate; the parameters are then zero.
    pub reason: Option<Reason>,
    /// Structure of the parameters.
    pub(crate) structure: Structure,
    pub(crate) delta: Array<P::Parameters, f32>,
    /// Lower triangle packed by rows.
    pub(crate) covariance: Array<P::Covariance, f32>,
    /// Residual variance σ², in the unit of y squared: of the equation error by least squares, of the output error by
    /// instrumental variables. With fading memory and instruments it is correct once the rows of earlier auxiliary
    /// models have faded.
    pub variance: f32,
    /// Number of rows of the estimate; with fading memory the equivalent number of rows of full weight.
    pub rows: u32,
    /// Whether the model is stable, so that it can be the next auxiliary model; always by least squares. Chance can
    /// place a pole near the unit circle on either side of it: such an estimate is valid, but does not take over.
    pub stable: bool,
    pub(crate) segment: SegmentNumber,
}

/// Number of a segment in the stream, wrapping after 2³² segments. It is no result: estimates and detectors that differ
/// in nothing else are equal.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SegmentNumber(u32);

impl SegmentNumber {
    pub(crate) const FIRST: Self = Self(0);

    /// The number of the next segment.
    #[inline(always)]
    pub(crate) const fn next(self) -> Self {
        Self(self.0.wrapping_add(1))
    }

    /// Whether this is the segment after the other one.
    pub(crate) const fn follows(self, other: Self) -> bool {
        self.0 == other.0.wrapping_add(1)
    }
}

impl PartialEq for SegmentNumber {
    fn eq(&self, _other: &Self) -> bool {
        true
    }
}

impl<P: Plan> Estimate<P> {
    /// No estimate.
    pub(crate) fn empty(plan: P) -> Self {
        let layout = plan.layout();
        Self {
            reason: Some(Reason::TooFewRows { part: Part::Regression, rows: 0 }),
            structure: layout.regression.map_or(Structure::new(0, 0, 0, 0, 0), |regression| regression.structure),
            delta: Cells::filled(layout.parameters(), 0.0),
            covariance: Cells::filled(layout.covariance(), 0.0),
            variance: 0.0,
            rows: 0,
            stable: true,
            segment: SegmentNumber::FIRST,
        }
    }

    /// The δ-parameters t, β, γ, then the constant; in units of y over units of the signal.
    #[must_use]
    pub fn delta(&self) -> &[f32] {
        self.delta.cells()
    }

    /// Covariance of two δ-parameters; 0 beyond the last.
    #[must_use]
    pub fn covariance(&self, i: usize, j: usize) -> f32 {
        let (i, j) = if i >= j { (i, j) } else { (j, i) };
        self.covariance.cells().get(lower(i, j)).copied().unwrap_or(0.0)
    }

    /// The covariance of the δ-parameters, lower triangle packed by rows: element (i, j ≤ i) at i(i+1)/2 + j.
    #[must_use]
    pub fn packed_covariance(&self) -> &[f32] {
        self.covariance.cells()
    }

    /// Standard deviation of a δ-parameter.
    #[must_use]
    pub fn deviation(&self, k: usize) -> f32 {
        libm::sqrtf(self.covariance(k, k))
    }

    /// The parameters a₁…, b₁…, c₁…, then the constant, from the δ-form:
    ///
    /// ```text
    /// a₁ = −1 − t₀ − t₁,   a_k = t_{k−1} − t_k,   b₁ = β₀ + β₁,   b_k = β_k − β_{k−1}
    /// ```
    #[must_use]
    pub fn raw(&self) -> Array<P::Parameters, f32> {
        let Structure { na, nb, nc, .. } = self.structure;
        let mut raw = self.delta.clone();
        let sections = raw
            .cells_mut()
            .split_at_mut_checked(na as usize)
            .and_then(|(a, rest)| rest.split_at_mut_checked(nb as usize).map(|(b, rest)| (a, b, rest)))
            .and_then(|(a, b, rest)| rest.split_at_mut_checked(nc as usize).map(|(c, _)| (a, b, c)));
        if let Some((a, b, c)) = sections {
            output_terms(a);
            input_terms(b);
            input_terms(c);
        }
        raw
    }

    /// Whether every parameter, variance and covariance is finite.
    #[inline(never)]
    pub(crate) fn is_finite(&self) -> bool {
        // A value that is not a number in a covariance appears on its diagonal too. Infinity and NaN survive a sum.
        let (mut sum, mut diagonal) = (self.variance, 0_usize);
        for (i, delta) in pairs(2.., self.delta.cells()) {
            sum += delta + self.covariance.cells().get(diagonal).copied().unwrap_or(0.0);
            diagonal = diagonal.wrapping_add(i);
        }
        sum.is_finite()
    }

    /// Restores the constant from levels that were taken from an origin:
    ///
    /// ```text
    /// k = k' + gᵀ θ (+ y₀ where na = 0),   g = −y₀ at t₀, −u1₀ at β₀, −u2₀ at γ₀, 1 at k'
    /// row k of the covariance = gᵀ V,   its corner gᵀ V g
    /// ```
    #[inline(never)]
    pub(crate) fn restore_constant(&mut self, [y, u1, u2]: [f32; 3]) {
        let Structure { na, nb, nc, .. } = self.structure;
        let constant = self.structure.terms();
        let (na, second) = (na as usize, na as usize + nb as usize);
        let terms = [(na > 0, 0, -y), (nb > 0, na, -u1), (nc > 0, second, -u2)];
        let mut k = if na == 0 { y } else { 0.0 };
        let mut row = self.delta.clone();
        for (j, covariance) in row.cells_mut().iter_mut().enumerate() {
            *covariance = self.covariance(constant, j);
        }
        for (_, index, g) in terms.into_iter().filter(|term| term.0) {
            k += g * self.delta().get(index).copied().unwrap_or(0.0);
            for (j, covariance) in row.cells_mut().iter_mut().enumerate() {
                *covariance += g * self.covariance(index, j);
            }
        }
        // The corner: the variance of the restored constant.
        let mut corner = row.cells().get(constant).copied().unwrap_or(0.0);
        for (_, index, g) in terms.into_iter().filter(|term| term.0) {
            corner += g * row.cells().get(index).copied().unwrap_or(0.0);
        }
        if let Some(cell) = row.cells_mut().get_mut(constant) {
            *cell = corner;
        }
        if let Some(delta) = self.delta.cells_mut().get_mut(constant) {
            *delta += k;
        }
        let cells = self.covariance.cells_mut().iter_mut().skip(lower(constant, 0));
        cells.zip(row.cells()).for_each(|(cell, covariance)| *cell = *covariance);
    }
}

fn output_terms(t: &mut [f32]) {
    for k in 0..t.len() {
        let next = t.get(k.saturating_add(1)).copied().unwrap_or(0.0);
        let Some(cell) = t.get_mut(k) else { return };
        // In place: a_{k+1} = t_k − t_{k+1} needs only what has not been overwritten yet.
        *cell = if k == 0 { -1.0 - *cell - next } else { *cell - next };
    }
}

fn input_terms(beta: &mut [f32]) {
    for k in 0..beta.len() {
        let next = beta.get(k.saturating_add(1)).copied().unwrap_or(0.0);
        let Some(cell) = beta.get_mut(k) else { return };
        *cell = if k == 0 { *cell + next } else { next - *cell };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{Memory, Method, RunTime, testing};
    use std::vec;

    #[test]
    fn raw_form_of_three_terms() {
        let layout = testing::regression(Structure::new(3, 3, 0, 1, 1), Method::LeastSquares, Memory::Segment);
        let mut estimate = Estimate::empty(RunTime::of(layout).unwrap());
        // a = [−1.5, 0.7, −0.1], b = [0.5, 0.25, −0.125]: t = [−0.1, 0.6, −0.1], β = [0.625, −0.125, 0.125]
        estimate.delta = vec![-0.1, 0.6, -0.1, 0.625, -0.125, 0.125];
        let expected = [-1.5, 0.7, -0.1, 0.5, 0.25, -0.125];
        for (got, want) in estimate.raw().into_iter().zip(expected) {
            assert!((got - want).abs() < 1e-6, "{got} {want}"); // rounding of numbers near one
        }
    }

    #[test]
    fn the_constant_of_a_model_without_output_terms_is_that_of_the_signals_themselves() {
        let structure = Structure { offset: true, ..Structure::new(0, 1, 0, 1, 0) };
        let layout = testing::regression(structure, Method::LeastSquares, Memory::Segment);
        let mut estimate = Estimate::empty(RunTime::of(layout).unwrap());
        // y − 5 = 2 (u − 3) + ½ is y = 2 u − ½.
        estimate.delta = vec![2.0, 0.5];
        estimate.restore_constant([5.0, 3.0, 0.0]);
        assert_eq!(estimate.delta, [2.0, -0.5]);
    }
}
