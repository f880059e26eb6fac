//! The trained constants of the regression.
//!
//! ```text
//! φ = [ y₁, y₁−y₂, y₂−y₃, …,  u₁, u₁−u₂, …,  w₁, w₁−w₂, …,  (1) ],   target y − y₁            (1)
//! t₀ = −(1 + Σa),   t_k = Σ_{i>k} aᵢ          (k = 1 … na−1)                                  (2)
//! β₀ = Σb,          β_k = −Σ_{j>k} b_j        (k = 1 … nb−1),  γ from c likewise              (3)
//! ```
//!
//! y₁ is y(t−1), u₁ is u1(t−nkb), w₁ is u2(t−nkc). With na = 0 the target is y itself. This is the δ-form of the model:
//! first differences of neighbouring lags, scaled by powers of two to rms ≈ 1, cut the condition number of slow models
//! from 1e3–1e6 to 5–2e3. That reduces the error in `f32` by two to five decades, for a few subtractions. Scaling by
//! powers of two is exact.

use crate::plan::{Array, Cells, RegressionLengths};
use crate::regression::factor::Forgetting;

/// Scales, nominal model and limits of a regression.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Regression<P: RegressionLengths> {
    /// Power-of-two factor of each column of (1), then that of the target; the differences of one signal share one
    /// factor. By instrumental variables the places after the target are 1.
    pub scale: Array<P::Columns, f32>,
    /// The nominal model (data sheet, or mean of healthy traces): δ-parameters t, β, γ, then the constant. By
    /// instrumental variables it is the auxiliary model of the first segment.
    pub nominal: Array<P::Parameters, f32>,
    /// Forgetting of a fading memory; not used by other memories.
    pub forgetting: Forgetting,
    /// Mean of (Δu1)² + (Δu2)² of the rows, scaled as their levels are, below which the inputs count as at rest: a
    /// segment gets no verdict, fading memory neither learns nor forgets. 0 for never. By instrumental variables the
    /// inputs are the prefiltered ones.
    pub rest: f32,
    /// Samples withheld after a change of the auxiliary model, until its filters have settled: three of its slowest
    /// time constants, or six if rejected samples are frequent.
    pub settle: u16,
    /// Accepted samples into the next segment after which the model of a segment takes over; a deferred solve may take
    /// as long.
    pub handover: u16,
}

impl<P: RegressionLengths> Regression<P> {
    /// Unscaled constants: the base of struct literals.
    #[must_use]
    pub fn new(plan: P) -> Self {
        let layout = plan.layout();
        Self {
            scale: Cells::filled(layout.columns(), 1.0),
            nominal: Cells::filled(layout.parameters(), 0.0),
            forgetting: Forgetting { lambda: 0.9999, floor: 100.0 },
            rest: 0.0,
            settle: 100,
            handover: 0,
        }
    }
}
