//! What one segment says about the plant, and why one may say nothing.

use nalgebra::SMatrix;

use super::{Counts, Order};

/// Why a segment has no verdict.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Reason {
    /// No more rows than parameters, or most of a segment's samples were rejected.
    TooFewRows,
    /// The inputs hardly moved, see [`Regression::still`](super::Regression::still).
    AtRest,
    /// The data do not excite this parameter: place in [`Estimate::delta`]. A signal that is constant over the whole
    /// segment (a load at rest, a held reference) ends here, so a drive at standstill gets no verdict. With fading memory
    /// the floor hides this once the memory is full; there [`Reason::AtRest`] tells.
    NotExcited(u8),
    /// The instruments explain hardly more of the output than chance (F ≤ 10), or cannot be told apart: the auxiliary model
    /// does not fit, or noise hides the output.
    WeakInstruments,
    /// Signal 0, 1 or 2 (y, u1, u2) repeated one value for too long.
    Stuck(u8),
    /// An estimate is not a finite number, or no class has a likelihood above zero.
    NotFinite,
}

impl core::fmt::Display for Reason {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::TooFewRows => f.write_str("too few usable samples"),
            Self::AtRest => f.write_str("the inputs are at rest"),
            Self::NotExcited(k) => {
                write!(f, "the signals do not excite parameter {} of t, β, γ, constant", u16::from(*k) + 1)
            }
            Self::WeakInstruments => f.write_str("the auxiliary model hardly follows the output"),
            Self::Stuck(0) => f.write_str("the output's sensor is stuck"),
            Self::Stuck(1) => f.write_str("the first input's sensor is stuck"),
            Self::Stuck(_) => f.write_str("the second input's sensor is stuck"),
            Self::NotFinite => f.write_str("an estimate or every likelihood is out of range"),
        }
    }
}

/// What one segment says about the plant. `M` is the capacity in columns, `P` = M(M−1)/2.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
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
    /// Residual variance σ², in units of y²: of the equation error by least squares, of the output error by
    /// instrumental variables. Rows that weighed less count with their weight. With fading memory and instruments it is
    /// right once the rows of earlier auxiliary models have faded.
    pub variance: f32,
    /// Rows the estimate rests on; with fading memory the equivalent number of rows of full weight.
    pub rows: u32,
    /// What was refused or weighed less.
    pub counts: Counts,
    /// Whether the model is stable, and so can serve as the next auxiliary model; always by least squares. A pole next to
    /// one may be found on either side of it by chance: such an estimate stands, but does not take over.
    pub stable: bool,
    /// Number of its segment in the stream, wrapping.
    pub segment: u8,
}

impl<const M: usize, const P: usize> Estimate<M, P> {
    /// An estimate that says nothing.
    #[must_use]
    pub const fn empty(order: Order, offset: bool, rows: u32, counts: Counts) -> Self {
        Self {
            order,
            offset,
            delta: [0.0; M],
            covariance: [0.0; P],
            variance: 0.0,
            rows,
            counts,
            stable: true,
            segment: 0,
        }
    }

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
    pub(super) fn uncentre(&mut self, [y, u1, u2]: [f32; 3]) {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn raw_form_of_three_terms() {
        let mut estimate = Estimate::<6, 15>::empty(Order::new(3, 3, 0, 1, 1), false, 0, Counts::default());
        // a = [−1.5, 0.7, −0.1], b = [0.5, 0.25, −0.125]: t = [−0.1, 0.6, −0.1], β = [0.625, −0.125, 0.125]
        estimate.delta = [-0.1, 0.6, -0.1, 0.625, -0.125, 0.125];
        let expected = [-1.5, 0.7, -0.1, 0.5, 0.25, -0.125];
        for (got, want) in estimate.raw().into_iter().zip(expected) {
            assert!((got - want).abs() < 1e-6, "{got} {want}"); // rounding of numbers near one
        }
    }
}
