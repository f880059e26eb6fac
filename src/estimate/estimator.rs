//! Samples → one [`Estimate`] a segment, by least squares.
//!
//! Enters: (y, u1, u2) a sample at a time. Leaves: δ-parameters θ, their covariance, the residual variance.
//!
//! ```text
//! θ = (XᵀX)⁻¹ Xᵀ Y                                       (1)  thesis Eq. 2.17, by the triangle
//! σ² = RSS/(N − n),   cov θ = σ² (XᵀX)⁻¹                 (2)  thesis Eq. 2.18, 2.19
//! ```
//!
//! N counts rows (start-up lags and rejected samples are none), n parameters with the constant. The parameters are
//! those of the δ-form: the raw a₁ ≈ −1.9 of a slow pole would hide what tells a fault in its last digits.
//! [`Estimate::raw`] gives a, b, c.
//!
//! Cost: one regressor row and one triangle update a sample; one back-substitution and one triangular inverse a
//! segment. λ is 1, so a segment must be bounded: [`Sampling::segment_samples`](crate::Sampling) ≤ 1e5.

use nalgebra::SMatrix;

use super::{Order, Regression, Regressor, Triangle};
use crate::detector::Sample;
use crate::model::MAX_SEGMENT_SAMPLES;

/// Why a segment has no verdict.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Reason {
    /// No more rows than parameters, or most of a segment's samples were rejected.
    TooFewRows,
    /// The data do not excite this parameter: place in [`Estimate::delta`]. A signal that is constant over the whole
    /// segment (a load at rest, a held reference) ends here, so a drive at standstill gets no verdict.
    NotExcited(u8),
    /// An estimate is not a finite number, or no class has a likelihood above zero.
    NotFinite,
}

impl core::fmt::Display for Reason {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::TooFewRows => f.write_str("too few usable samples"),
            Self::NotExcited(k) => {
                write!(f, "the signals do not excite parameter {} of t, β, γ, constant", u16::from(*k) + 1)
            }
            Self::NotFinite => f.write_str("an estimate or every likelihood is out of range"),
        }
    }
}

/// What one segment says about the plant. `M` is the capacity in columns, `P` = M(M−1)/2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate<const M: usize, const P: usize> {
    /// Structure of the parameters.
    pub order: Order,
    /// Whether the last parameter is a constant term.
    pub offset: bool,
    /// δ-parameters t, β, γ, then the constant; in units of y over units of the signal. The first
    /// [`Estimate::parameters`] places are used.
    pub delta: [f32; M],
    /// Covariance of `delta`, lower triangle packed by rows: element (i, j ≤ i) at i(i+1)/2 + j.
    pub covariance: [f32; P],
    /// Residual variance σ², in units of y².
    pub variance: f32,
    /// Rows the estimate rests on.
    pub rows: u32,
    /// Samples (means, where the detector averages) refused by the range guard.
    pub rejected: u32,
}

impl<const M: usize, const P: usize> Estimate<M, P> {
    /// Number of parameters, the constant included.
    #[must_use]
    pub const fn parameters(&self) -> usize {
        self.order.columns(self.offset) - 1
    }

    /// The parameters a₁…, b₁…, c₁…, then the constant, from the δ-form:
    ///
    /// ```text
    /// a₁ = −1 − t₀ − t₁,   a_k = t_{k−1} − t_k,   b₁ = β₀ + β₁,   b_k = β_k − β_{k−1}
    /// ```
    #[must_use]
    pub fn raw(&self) -> [f32; M] {
        let (na, nb, nc) = (self.order.na as usize, self.order.nb as usize, self.order.nc as usize);
        let mut raw = self.delta;
        let sections = raw
            .split_at_mut_checked(na)
            .and_then(|(a, rest)| rest.split_at_mut_checked(nb).map(|(b, rest)| (a, b, rest)))
            .and_then(|(a, b, rest)| rest.split_at_mut_checked(nc).map(|(c, _)| (a, b, c)));
        if let Some((a, b, c)) = sections {
            output_terms(a);
            input_terms(b);
            input_terms(c);
        }
        raw
    }

    /// Brings the constant back from levels that were taken from an origin:
    ///
    /// ```text
    /// k = k' + gᵀ θ (+ y₀ where na = 0),   g = −y₀ at t₀, −u1₀ at β₀, −u2₀ at γ₀, 1 at k'
    /// row k of the covariance = gᵀ V,   its corner gᵀ V g
    /// ```
    fn uncentre(&mut self, [y, u1, u2]: [f32; 3]) {
        if !self.offset {
            return;
        }
        let Order { na, nb, nc, .. } = self.order;
        let (na, nb) = (na as usize, nb as usize);
        let constant = self.parameters() - 1;
        let terms = [(na > 0, 0, -y), (nb > 0, na, -u1), (nc > 0, na + nb, -u2)];
        let mut k = if na == 0 { y } else { 0.0 };
        let mut covariances = [0.0_f32; M];
        for (j, covariance) in covariances.iter_mut().enumerate().take(constant + 1) {
            *covariance = self.covariance_of(constant, j);
        }
        for (_, place, g) in terms.into_iter().filter(|term| term.0) {
            k += g * self.delta.get(place).copied().unwrap_or(0.0);
            for (j, covariance) in covariances.iter_mut().enumerate().take(constant + 1) {
                *covariance += g * self.covariance_of(place, j);
            }
        }
        // The corner: covariance of the new constant with itself.
        let mut corner = covariances.get(constant).copied().unwrap_or(0.0);
        for (_, place, g) in terms.into_iter().filter(|term| term.0) {
            corner += g * covariances.get(place).copied().unwrap_or(0.0);
        }
        if let Some(cell) = covariances.get_mut(constant) {
            *cell = corner;
        }
        if let Some(delta) = self.delta.get_mut(constant) {
            *delta += k;
        }
        let start = constant * (constant + 1) / 2;
        let cells = self.covariance.iter_mut().skip(start).take(constant + 1);
        cells.zip(covariances).for_each(|(cell, covariance)| *cell = covariance);
    }

    /// Element (i, j) of the symmetric covariance.
    fn covariance_of(&self, i: usize, j: usize) -> f32 {
        let (row, column) = if i >= j { (i, j) } else { (j, i) };
        self.covariance.get(row * (row + 1) / 2 + column).copied().unwrap_or(0.0)
    }

    /// Covariance of the δ-parameters as a matrix; places beyond [`Estimate::parameters`] are zero.
    #[must_use]
    pub fn covariance_matrix(&self) -> SMatrix<f32, M, M> {
        let n = self.parameters();
        SMatrix::from_fn(|i, j| if i.max(j) >= n { 0.0 } else { self.covariance_of(i, j) })
    }
}

fn output_terms(t: &mut [f32]) {
    for k in 0..t.len() {
        let next = t.get(k + 1).copied().unwrap_or(0.0);
        let Some(cell) = t.get_mut(k) else { return };
        // In place: a_{k+1} = t_k − t_{k+1} needs only what has not been overwritten yet.
        *cell = if k == 0 { -1.0 - *cell - next } else { *cell - next };
    }
}

fn input_terms(beta: &mut [f32]) {
    for k in 0..beta.len() {
        let next = beta.get(k + 1).copied().unwrap_or(0.0);
        let Some(cell) = beta.get_mut(k) else { return };
        *cell = if k == 0 { *cell + next } else { next - *cell };
    }
}

/// Least squares over one segment: running state. `L` is the capacity in delays, at least the larger of nkb and nkc.
///
/// Not `Copy`, so that no step goes to a copy by accident.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimator<'m, const M: usize, const P: usize, const L: usize> {
    regression: &'m Regression<M>,
    regressor: Regressor<M, L>,
    triangle: Triangle<M, P>,
    rows: u32,
    rejected: u32,
}

impl<'m, const M: usize, const P: usize, const L: usize> Estimator<'m, M, P, L> {
    /// An empty segment of the given regression.
    #[must_use]
    pub const fn new(regression: &'m Regression<M>) -> Self {
        Self {
            regression,
            regressor: Regressor::new(regression),
            triangle: Triangle::new(regression.columns()),
            rows: 0,
            rejected: 0,
        }
    }

    /// Takes one sample at the identification rate. A sample outside the limits is counted and flushes the lags;
    /// after [`MAX_SEGMENT_SAMPLES`] rows nothing is added until the next segment, since λ = 1 needs a bound.
    #[inline]
    pub fn step(&mut self, sample: &Sample) {
        if !self.regression.accepts(sample) {
            self.rejected = self.rejected.saturating_add(1);
            self.regressor.flush();
            return;
        }
        if self.rows == 0 && self.regression.offset {
            self.regressor.recentre(sample);
        }
        if let Some(row) = self.regressor.push(self.regression, sample)
            && self.rows < MAX_SEGMENT_SAMPLES
        {
            self.triangle.update(row);
            self.rows = self.rows.saturating_add(1);
        }
    }

    /// The estimate from the rows so far, leaving the segment open.
    ///
    /// # Errors
    /// A [`Reason`] where the rows are too few, do not excite a parameter, or the result is not finite.
    pub fn estimate(&self) -> Result<Estimate<M, P>, Reason> {
        let n = self.regression.columns() - 1;
        let mut estimate = self.empty_estimate();
        let degrees = (self.rows as usize).checked_sub(n).filter(|&free| free > 0).ok_or(Reason::TooFewRows)?;
        if let Some(column) = self.triangle.dependent_column() {
            return Err(Reason::NotExcited(u8::try_from(column).unwrap_or(u8::MAX)));
        }
        // Scaled problem: (y s_y) = (φ s) θ', so θ = θ' s/s_y, and RSS carries s_y².
        let target = self.regression.target_scale();
        let scale = self.regression.scale.map(|scale| scale / target);
        let theta = self.triangle.solve();
        let scaled_variance = self.triangle.residual_sum() / degrees as f32; // (2)
        // One division after the other: the square of a scale could leave the range of f32.
        estimate.variance = scaled_variance / target / target;
        for ((delta, theta), scale) in estimate.delta.iter_mut().zip(theta).zip(scale).take(n) {
            *delta = theta * scale;
        }
        let inverse = self.triangle.inverse();
        let mut cells = estimate.covariance.iter_mut().zip(inverse);
        for (i, row) in scale.iter().enumerate().take(n) {
            for column in scale.iter().take(i + 1) {
                if let Some((cell, inverse)) = cells.next() {
                    *cell = scaled_variance * inverse * row * column;
                }
            }
        }
        estimate.uncentre(self.regressor.origin());
        let mut numbers = estimate.delta.iter().chain(&estimate.covariance);
        let finite = estimate.variance.is_finite() && numbers.all(|x| x.is_finite());
        if finite { Ok(estimate) } else { Err(Reason::NotFinite) }
    }

    /// An estimate that says nothing but how many rows and rejections there were.
    #[must_use]
    pub fn empty_estimate(&self) -> Estimate<M, P> {
        Estimate {
            order: self.regression.order,
            offset: self.regression.offset,
            delta: [0.0; M],
            covariance: [0.0; P],
            variance: 0.0,
            rows: self.rows,
            rejected: self.rejected,
        }
    }

    /// Starts the next segment of the same stream: the lags stay.
    pub fn next_segment(&mut self) {
        self.triangle.reset();
        self.rows = 0;
        self.rejected = 0;
    }

    /// Starts afresh, for a stream that does not go on from the last sample.
    pub fn restart(&mut self) {
        self.next_segment();
        self.regressor.flush();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const REGRESSION: Regression<6> = Regression {
        order: Order::new(2, 1, 1, 1, 1),
        offset: true,
        scale: [1.0, 4.0, 1.0, 0.5, 1.0, 2.0],
        limit: [1e3; 3],
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
        assert_eq!(estimator.empty_estimate().rejected, 10);
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

    #[test]
    fn raw_form_of_three_terms() {
        let mut estimate = Small::new(&REGRESSION).empty_estimate();
        // a = [−1.5, 0.7, −0.1], b = [0.5, 0.25, −0.125]: t = [−0.1, 0.6, −0.1], β = [0.625, −0.125, 0.125]
        (estimate.order, estimate.offset) = (Order::new(3, 3, 0, 1, 1), false);
        estimate.delta = [-0.1, 0.6, -0.1, 0.625, -0.125, 0.125];
        let expected = [-1.5, 0.7, -0.1, 0.5, 0.25, -0.125];
        for (got, want) in estimate.raw().into_iter().zip(expected) {
            assert!((got - want).abs() < 1e-6, "{got} {want}"); // rounding of numbers near one
        }
    }
}
