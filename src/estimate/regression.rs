//! What is estimated and how: the constants of an estimator, trained once, in flash.
//!
//! ```text
//! φ = [ y₁, y₁−y₂, y₂−y₃, …,  u₁, u₁−u₂, …,  w₁, w₁−w₂, …,  (1) ],   target y − y₁            (1)
//! t₀ = −(1 + Σa),   t_k = Σ_{i>k} aᵢ          (k = 1 … na−1)                                  (2)
//! β₀ = Σb,          β_k = −Σ_{j>k} b_j        (k = 1 … nb−1),  γ from c likewise              (3)
//! ```
//!
//! y₁ is y(t−1), u₁ is u1(t−nkb), w₁ is u2(t−nkc). With na = 0 the target is y itself. First differences of
//! neighbouring lags, scaled by powers of two to rms ≈ 1, cut the condition number of slow models from 1e3–1e6 to
//! 5–2e3: two to five decades of error in `f32`, for a few subtractions. Scaling by powers of two is exact.

use super::{Forgetting, Form, Order};
use crate::detector::Sample;

/// Most output terms of a model with instrumental variables.
pub const MAX_OUTPUT_TERMS: usize = 4;

/// How the parameters of a segment are estimated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Method {
    /// Least squares: cheapest; biased where the output is noisy, which a classifier trained on it does not mind.
    LeastSquares,
    /// Streaming simplified refined instrumental variables: consistent under output noise, closed loop included.
    Instruments,
}

/// What becomes of rows as time goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Memory {
    /// Every segment starts empty and weighs its rows alike.
    Segment,
    /// Rows fade; the estimate goes on over segments and may be read at any sample.
    Fading(Forgetting),
}

/// The model before anything has been estimated: from the data sheet, or the mean of healthy traces.
///
/// It is the auxiliary model of the first segment, and the reference that outliers are told by.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Nominal<const M: usize> {
    /// δ-parameters t, β, γ, then the constant.
    pub delta: [f32; M],
    /// Standard deviation of its residual (of the output error, with instruments); 0 where unknown.
    pub deviation: f32,
}

/// What counts as a believable sample. Arrays are in the order y, u1, u2.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Guard {
    /// Largest believable magnitude, in the signal's units: beyond it a sample is rejected.
    pub limit: [f32; 3],
    /// Magnitude from which a sensor is saturated, at most the limit: such a sample is not used, and counted apart.
    pub saturation: [f32; 3],
    /// So many equal samples in a row mean a stuck sensor and deny the segment its verdict; 0 where a signal may rest.
    pub stuck_samples: [u16; 3],
    /// Rows whose residual exceeds so many standard deviations weigh less, as Huber's estimator has it; 0 for none.
    pub huber: f32,
}

/// The regression a model was trained for. `M` is the capacity in columns.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Regression<const M: usize> {
    /// Terms and delays.
    pub order: Order,
    /// Whether a constant term is estimated (recorded signals have operating points).
    pub offset: bool,
    /// Least squares or instrumental variables.
    pub method: Method,
    /// Segments or fading.
    pub memory: Memory,
    /// Power-of-two factor of each column of (1), the target's last; the differences of one signal share theirs.
    pub scale: [f32; M],
    /// The model to start from.
    pub nominal: Nominal<M>,
    /// Believable samples.
    pub guard: Guard,
    /// Mean of (Δu1)² + (Δu2)² of the rows ([`Row::motion`](super::Row::motion)), scaled as their levels are, with
    /// instruments of the prefiltered inputs, below which the drive counts
    /// as at rest: a segment gets no verdict, fading memory learns and forgets nothing. 0 for never.
    pub still: f32,
    /// Samples withheld after a change of the auxiliary model, until its filters have settled: three of its slowest time
    /// constants, six where rejected samples are usual.
    pub settle: u16,
    /// Accepted samples into the next segment at which a segment's model takes over; until then a deferred solve may take.
    pub handover: u16,
}

impl Guard {
    /// Accepts every finite number within `f32`'s better half, tells no outliers and no stuck sensor. Too wide for a
    /// [`Model`](crate::Model), whose limits are beside its scales.
    pub const OPEN: Self = Self { limit: [1e18; 3], saturation: [1e18; 3], stuck_samples: [0; 3], huber: 0.0 };

    /// [`Guard::OPEN`] within limits.
    #[must_use]
    pub const fn within(limit: [f32; 3]) -> Self {
        Self { limit, saturation: limit, ..Self::OPEN }
    }
}

impl<const M: usize> Regression<M> {
    /// Least squares over segments, unscaled and unguarded: the base of struct literals.
    #[must_use]
    pub const fn new(order: Order, offset: bool) -> Self {
        Self {
            order,
            offset,
            method: Method::LeastSquares,
            memory: Memory::Segment,
            scale: [1.0; M],
            nominal: Nominal { delta: [0.0; M], deviation: 0.0 },
            guard: Guard::OPEN,
            still: 0.0,
            settle: 100,
            handover: 0,
        }
    }

    /// What its rows look like.
    #[must_use]
    pub const fn form(&self) -> Form {
        Form { order: self.order, offset: self.offset, method: self.method }
    }

    /// Parameters a, b, c and the constant.
    #[must_use]
    pub const fn parameters(&self) -> usize {
        self.order.columns(self.offset) - 1
    }

    /// Columns of a row: parameters and target, and with instruments one more for each output term. At most `M` in a
    /// validated model.
    #[must_use]
    pub const fn columns(&self) -> usize {
        self.order.columns(self.offset)
            + match self.method {
                Method::LeastSquares => 0,
                Method::Instruments => self.order.na as usize,
            }
    }

    /// Least capacity `M` in columns: that of the rows, and of the filters of the instruments, which need more where
    /// an input has fewer terms than the output.
    #[must_use]
    pub fn capacity(&self) -> usize {
        match self.method {
            Method::LeastSquares => self.columns(),
            Method::Instruments => self.columns().max(super::instruments::cells(&self.order)),
        }
    }

    /// The scale of the target column.
    #[must_use]
    pub fn target_scale(&self) -> f32 {
        self.scale.get(self.parameters()).copied().unwrap_or(1.0)
    }

    /// Whether all difference columns of each signal have one scale.
    #[must_use]
    pub fn differences_share_scales(&self) -> bool {
        let Order { na, nb, nc, .. } = self.order;
        let (na, nb, nc) = (na as usize, nb as usize, nc as usize);
        let alike = |from: usize, terms: usize| {
            let differences = self.scale.get(from + 1..from + terms).unwrap_or(&[]);
            differences.windows(2).all(|pair| matches!(pair, [one, other] if one.to_bits() == other.to_bits()))
        };
        alike(0, na) && alike(na, nb) && alike(na + nb, nc)
    }

    /// Whether every signal of the sample is finite and within its limit.
    #[inline]
    #[must_use]
    pub fn accepts(&self, sample: &Sample) -> bool {
        within(sample, &self.guard.limit)
    }
}

/// Written so that NaN fails.
#[inline]
pub(super) fn within(sample: &Sample, [y, u1, u2]: &[f32; 3]) -> bool {
    (sample.y.abs() <= *y) & (sample.u1.abs() <= *u1) & (sample.u2.abs() <= *u2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn guard_refuses_whatever_is_not_a_believable_number() {
        let regression =
            Regression::<4> { guard: Guard::within([100.0; 3]), ..Regression::new(Order::new(1, 1, 1, 1, 1), false) };
        let sample = |y, u1, u2| Sample { y, u1, u2 };
        assert!(regression.accepts(&sample(100.0, -100.0, 0.0)));
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30, 100.1] {
            assert!(!regression.accepts(&sample(bad, 0.0, 0.0)), "{bad}");
            assert!(!regression.accepts(&sample(0.0, bad, 0.0)), "{bad}");
            assert!(!regression.accepts(&sample(0.0, 0.0, bad)), "{bad}");
        }
    }

    #[test]
    fn instruments_need_a_column_for_each_output_term() {
        let least = Regression::<20>::new(Order::new(3, 2, 1, 1, 1), true);
        let instruments = Regression { method: Method::Instruments, ..least };
        assert_eq!((least.parameters(), least.columns(), instruments.columns()), (7, 8, 11));
    }
}
