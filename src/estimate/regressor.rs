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
//! With a constant term the levels y₁, u₁, w₁ are taken from an origin, the first sample of the segment, and the
//! constant is brought back when the segment is solved: a level far from zero is nearly the constant column, and would
//! cost the estimate its digits.
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
    /// Power-of-two factor of each column of (1), the target's last; the differences of one signal share theirs.
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

    /// Whether all difference columns of each signal have one scale.
    #[must_use]
    pub fn differences_share_scales(&self) -> bool {
        let Order { na, nb, nc, .. } = self.order;
        let mut scales = self.scale.iter();
        [na, nb, nc].into_iter().all(|terms| {
            let mut differences = scales.by_ref().take(terms as usize).skip(1);
            let first = differences.next().map(|x| x.to_bits());
            // Not short of the end, so that the next signal starts at its own first column.
            differences.fold(true, |alike, x| alike & (Some(x.to_bits()) == first))
        })
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

/// The running state behind (1). `L` is the capacity in delays, at least the larger of nkb and nkc.
///
/// A column of differences moves on by one place a sample, so only two cells a signal are computed anew.
#[derive(Clone, Debug, PartialEq)]
pub struct Regressor<const M: usize, const L: usize> {
    row: [f32; M],
    /// What the levels of y, u1, u2 are taken from.
    origin: [f32; 3],
    /// Accepted samples that a row needs before its own.
    depth: usize,
    /// y(t−1), the value before it in the row, and the same for u1 and u2.
    newest_y: f32,
    level: [f32; 3],
    u1: Delay<L>,
    u2: Delay<L>,
    /// Accepted samples in an unbroken run, saturating.
    clean: u32,
}

impl<const M: usize, const L: usize> Regressor<M, L> {
    /// No samples yet. A regression that does not fit the capacities never gives a row.
    #[must_use]
    pub const fn new(regression: &Regression<M>) -> Self {
        let fits = regression.columns() <= M && regression.order.largest_delay() <= L;
        Self {
            row: [0.0; M],
            origin: [0.0; 3],
            depth: if fits { regression.order.depth() } else { usize::MAX },
            newest_y: 0.0,
            level: [0.0; 3],
            u1: Delay::new(),
            u2: Delay::new(),
            clean: 0,
        }
    }

    /// Takes the levels of the following rows from this sample.
    pub const fn recentre(&mut self, sample: &Sample) {
        self.origin = [sample.y, sample.u1, sample.u2];
    }

    /// What the levels of y, u1, u2 are taken from; zero unless [`Regressor::recentre`] was called.
    #[must_use]
    pub const fn origin(&self) -> [f32; 3] {
        self.origin
    }

    /// Forgets every lag: the next row needs a clean run of `depth + 1` samples.
    pub const fn flush(&mut self) {
        self.clean = 0;
    }

    /// Takes an accepted sample; gives the row (1) of that sample, or nothing while a lag is missing.
    #[inline]
    pub fn push(&mut self, regression: &Regression<M>, sample: &Sample) -> Option<&[f32; M]> {
        let Order { na, nb, nc, nkb, nkc } = regression.order;
        let [level_y, level_u1, level_u2] = &mut self.level;
        let [y0, u1_0, u2_0] = self.origin;
        let (u1, u2) = (self.u1.push(sample.u1, nkb), self.u2.push(sample.u2, nkc));
        let (cells, scale) = (&mut self.row[..], &regression.scale[..]);
        let (cells, scale) = shift_in(cells, scale, na, level_y, (self.newest_y, y0));
        let (cells, scale) = shift_in(cells, scale, nb, level_u1, (u1, u1_0));
        let (cells, scale) = shift_in(cells, scale, nc, level_u2, (u2, u2_0));
        let mut rest = cells.iter_mut().zip(scale);
        if regression.offset
            && let Some((cell, scale)) = rest.next()
        {
            *cell = *scale;
        }
        if let Some((target, scale)) = rest.next() {
            *target = (sample.y - if na == 0 { y0 } else { self.newest_y }) * scale;
        }
        self.newest_y = sample.y;
        self.clean = self.clean.saturating_add(1);
        (self.clean as usize > self.depth).then_some(&self.row)
    }
}

/// Puts a new level, less its origin, in front of `x₁, x₁−x₂, x₂−x₃, …` (`terms` columns); gives the columns behind them.
#[inline]
fn shift_in<'c, 's>(
    cells: &'c mut [f32],
    scale: &'s [f32],
    terms: u8,
    level: &mut f32,
    (newest, origin): (f32, f32),
) -> (&'c mut [f32], &'s [f32]) {
    let terms = terms as usize;
    let (Some((own, cells)), Some((own_scale, scale))) =
        (cells.split_at_mut_checked(terms), scale.split_at_checked(terms))
    else {
        return (&mut [], &[]);
    };
    if let ([first, differences @ ..], [first_scale, scales @ ..]) = (own, own_scale) {
        *first = (newest - origin) * first_scale;
        if let Some(scale) = scales.first() {
            // Differences share one scale (`Model::validate`), so they move on as they are.
            let mut carried = (newest - *level) * scale;
            for cell in differences {
                carried = core::mem::replace(cell, carried);
            }
        }
        *level = newest;
    }
    (cells, scale)
}

/// A signal as it was `delay` samples ago.
#[derive(Clone, Debug, PartialEq)]
struct Delay<const L: usize> {
    ring: [f32; L],
    place: usize,
}

impl<const L: usize> Delay<L> {
    const fn new() -> Self {
        Self { ring: [0.0; L], place: 0 }
    }

    #[inline]
    fn push(&mut self, newest: f32, delay: u8) -> f32 {
        let delay = delay as usize;
        let Some(cell) = self.ring.get_mut(self.place) else { return newest };
        if delay == 0 {
            return newest;
        }
        self.place += 1;
        if self.place >= delay {
            self.place = 0;
        }
        core::mem::replace(cell, newest)
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
        let mut lags = Regressor::<7, 1>::new(&regression);
        assert_eq!(lags.push(&regression, &sample(1.0, 10.0, -1.0)), None);
        assert_eq!(lags.push(&regression, &sample(2.0, 20.0, -2.0)), None, "t₀ = 2");
        // y₁ = 2, y₁−y₂ = 1 (×2), u₁ = 20, u₁−u₂ = 10, w₁ = −3 (×4), 1, target 4 − 2 (×8)
        let row = lags.push(&regression, &sample(4.0, 40.0, -3.0));
        assert_eq!(row, Some(&[2.0, 2.0, 20.0, 10.0, -12.0, 1.0, 16.0]));
    }

    #[test]
    fn moving_average_model_has_the_output_itself_as_target() {
        let regression = regression::<2>(Order::new(0, 1, 0, 1, 0), false);
        let mut lags = Regressor::<2, 1>::new(&regression);
        assert_eq!(lags.push(&regression, &sample(1.0, 10.0, 0.0)), None);
        assert_eq!(lags.push(&regression, &sample(2.0, 20.0, 0.0)), Some(&[10.0, 2.0]));
    }

    #[test]
    fn every_cell_is_the_lag_it_should_be() {
        // Signals whose sample t tells t: y = t, u1 = 1000 + t², u2 = 0.5 t, with long delays and many terms.
        let regression = regression::<9>(Order::new(3, 3, 2, 4, 2), false);
        let signal = |t: i16| {
            let t = f32::from(t);
            sample(t * t * t, 1000.0 + t * t, 0.5 * t)
        };
        let mut lags = Regressor::<9, 4>::new(&regression);
        for t in 0..30_i16 {
            let row = lags.push(&regression, &signal(t)).copied();
            assert_eq!(row.is_some(), t >= 6, "t₀ = 4 + 3 − 1");
            let Some(row) = row else { continue };
            let (y, u1, u2) = (|k| signal(t - k).y, |k| signal(t - k).u1, |k| signal(t - k).u2);
            let expected = [
                y(1),
                y(1) - y(2),
                y(2) - y(3),
                u1(4),
                u1(4) - u1(5),
                u1(5) - u1(6),
                u2(2),
                u2(2) - u2(3),
                y(0) - y(1),
            ];
            assert_eq!(row, expected, "t = {t}");
        }
    }

    #[test]
    fn flush_withholds_rows_until_every_lag_is_clean() {
        let regression = regression::<5>(Order::new(1, 2, 1, 1, 1), false);
        let mut lags = Regressor::<5, 1>::new(&regression);
        let push = |lags: &mut Regressor<5, 1>, x: f32| lags.push(&regression, &sample(x, 10.0 * x, x)).copied();
        assert_eq!((push(&mut lags, 1.0), push(&mut lags, 2.0)), (None, None));
        assert_eq!(push(&mut lags, 3.0), Some([2.0, 20.0, 10.0, 2.0, 1.0]));
        lags.flush();
        assert_eq!((push(&mut lags, 7.0), push(&mut lags, 9.0)), (None, None));
        assert_eq!(push(&mut lags, 12.0), Some([9.0, 90.0, 20.0, 9.0, 3.0]), "nothing from before the gap");
    }

    #[test]
    fn a_regression_too_large_gives_no_rows() {
        let mut narrow = Regressor::<3, 9>::new(&regression::<3>(Order::new(1, 1, 1, 1, 1), false));
        let mut short = Regressor::<4, 1>::new(&regression::<4>(Order::new(1, 1, 1, 2, 1), false));
        for _ in 0..20 {
            assert_eq!(narrow.push(&regression(Order::new(1, 1, 1, 1, 1), false), &sample(1.0, 2.0, 3.0)), None);
            assert_eq!(short.push(&regression(Order::new(1, 1, 1, 2, 1), false), &sample(1.0, 2.0, 3.0)), None);
        }
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
