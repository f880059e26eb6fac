//! The last samples → one row of the regression, in δ-form.
//!
//! Enters: (y, u1, u2), a sample at a time. Leaves: a row of `m` columns, regressor then target.
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
//!
//! Validity: a sample is accepted only if |v| ≤ limit for each signal: one comparison that NaN and infinity fail
//! too. After a rejected sample rows are withheld until every lag is clean again.

use super::Order;
use crate::detector::Sample;

/// The regression a model was trained for: structure, scales, and the range of believable samples.
///
/// `M` is the capacity in columns; [`Order::columns`] of them are used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Regression<const M: usize> {
    /// Terms and delays.
    pub order: Order,
    /// Whether a constant term is estimated (recorded signals have operating points).
    pub offset: bool,
    /// Power-of-two factor of each column of (1), the target's last.
    pub scale: [f32; M],
    /// Largest believable magnitude of y, u1, u2, in their own units.
    pub limit: [f32; 3],
}

impl<const M: usize> Regression<M> {
    /// Columns in use: parameters, constant, target. At most `M` in a validated model.
    #[must_use]
    pub const fn columns(&self) -> usize {
        self.order.columns(self.offset)
    }

    /// The scale of the target column.
    #[must_use]
    pub fn target_scale(&self) -> f32 {
        self.scale.get(self.columns() - 1).copied().unwrap_or(1.0)
    }

    /// Whether every signal of the sample is finite and within its limit.
    #[inline]
    #[must_use]
    pub fn accepts(&self, sample: &Sample) -> bool {
        let [y, u1, u2] = self.limit;
        // Written so that NaN fails.
        (sample.y.abs() <= y) & (sample.u1.abs() <= u1) & (sample.u2.abs() <= u2)
    }
}

/// The lags, newest first: the running state behind (1). `L` is the capacity, at least `order.depth() + 1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Regressor<const L: usize> {
    y: [f32; L],
    u1: [f32; L],
    u2: [f32; L],
    /// Accepted samples in an unbroken run, saturating.
    clean: u32,
}

impl<const L: usize> Regressor<L> {
    /// No samples yet.
    #[must_use]
    pub const fn new() -> Self {
        Self { y: [0.0; L], u1: [0.0; L], u2: [0.0; L], clean: 0 }
    }

    /// Forgets every lag: the next row needs a clean run of `depth + 1` samples.
    pub const fn flush(&mut self) {
        self.clean = 0;
    }

    /// Takes an accepted sample.
    #[inline]
    pub fn push(&mut self, sample: &Sample) {
        shift_in(&mut self.y, sample.y);
        shift_in(&mut self.u1, sample.u1);
        shift_in(&mut self.u2, sample.u2);
        self.clean = self.clean.saturating_add(1);
    }

    /// The row (1) of the newest sample, or nothing while a lag is missing.
    #[inline]
    #[must_use]
    pub fn row<const M: usize>(&self, regression: &Regression<M>) -> Option<[f32; M]> {
        let order = regression.order;
        if (self.clean as usize) <= order.depth() {
            return None;
        }
        let mut row = [0.0; M];
        let mut cells = row.iter_mut().zip(&regression.scale);
        let (newest, past) = self.y.split_first()?;
        differences(past, order.na, &mut cells);
        differences(self.u1.get(order.nkb as usize..).unwrap_or(&[]), order.nb, &mut cells);
        differences(self.u2.get(order.nkc as usize..).unwrap_or(&[]), order.nc, &mut cells);
        if regression.offset
            && let Some((cell, scale)) = cells.next()
        {
            *cell = *scale;
        }
        let (target, scale) = cells.next()?;
        let base = if order.na == 0 { 0.0 } else { past.first().copied().unwrap_or(0.0) };
        *target = (newest - base) * scale;
        Some(row)
    }
}

impl<const L: usize> Default for Regressor<L> {
    fn default() -> Self {
        Self::new()
    }
}

#[inline]
fn shift_in<const L: usize>(lags: &mut [f32; L], newest: f32) {
    let mut carried = newest;
    for lag in lags {
        carried = core::mem::replace(lag, carried);
    }
}

/// Writes `x₁, x₁−x₂, x₂−x₃, …` (`terms` of them), each times the scale of its column.
#[inline]
fn differences<'a>(lags: &[f32], terms: u8, cells: &mut impl Iterator<Item = (&'a mut f32, &'a f32)>) {
    let mut newer = 0.0;
    for (k, &lag) in lags.iter().enumerate().take(terms as usize) {
        if let Some((cell, scale)) = cells.next() {
            *cell = scale * if k == 0 { lag } else { newer - lag };
        }
        newer = lag;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(y: f32, u1: f32, u2: f32) -> Sample {
        Sample { y, u1, u2 }
    }

    fn regression<const M: usize>(order: Order, offset: bool) -> Regression<M> {
        Regression { order, offset, scale: [1.0; M], limit: [100.0; 3] }
    }

    #[test]
    fn row_by_hand() {
        let mut regression = regression::<7>(Order::new(2, 2, 1, 1, 0), true);
        regression.scale = [1.0, 2.0, 1.0, 1.0, 4.0, 1.0, 8.0];
        let mut lags = Regressor::<3>::new();
        lags.push(&sample(1.0, 10.0, -1.0));
        lags.push(&sample(2.0, 20.0, -2.0));
        assert_eq!(lags.row(&regression), None, "t₀ = 2");
        lags.push(&sample(4.0, 40.0, -3.0));
        // y₁ = 2, y₁−y₂ = 1 (×2), u₁ = 20, u₁−u₂ = 10, w₁ = −3 (×4), 1, target 4 − 2 (×8)
        assert_eq!(lags.row(&regression), Some([2.0, 2.0, 20.0, 10.0, -12.0, 1.0, 16.0]));
    }

    #[test]
    fn moving_average_model_has_the_output_itself_as_target() {
        let mut lags = Regressor::<2>::new();
        lags.push(&sample(1.0, 10.0, 0.0));
        lags.push(&sample(2.0, 20.0, 0.0));
        assert_eq!(lags.row(&regression::<2>(Order::new(0, 1, 0, 1, 0), false)), Some([10.0, 2.0]));
    }

    #[test]
    fn flush_withholds_rows_until_every_lag_is_clean() {
        let regression = regression::<4>(Order::new(1, 1, 1, 1, 1), false);
        let mut lags = Regressor::<2>::new();
        lags.push(&sample(1.0, 1.0, 1.0));
        lags.push(&sample(1.0, 1.0, 1.0));
        assert!(lags.row(&regression).is_some());
        lags.flush();
        lags.push(&sample(1.0, 1.0, 1.0));
        assert!(lags.row(&regression).is_none());
        lags.push(&sample(1.0, 1.0, 1.0));
        assert!(lags.row(&regression).is_some());
    }

    #[test]
    fn guard_refuses_whatever_is_not_a_believable_number() {
        let regression = regression::<4>(Order::new(1, 1, 1, 1, 1), false);
        assert!(regression.accepts(&sample(100.0, -100.0, 0.0)));
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30, 100.1] {
            assert!(!regression.accepts(&sample(bad, 0.0, 0.0)), "{bad}");
            assert!(!regression.accepts(&sample(0.0, bad, 0.0)), "{bad}");
            assert!(!regression.accepts(&sample(0.0, 0.0, bad)), "{bad}");
        }
    }
}
