//! Least squares: the last samples → one row of the regression, in δ-form.
//!
//! Enters: (y, u1, u2), a sample at a time. Leaves: a row of `m` columns, regressor then target, as
//! [`regression`](super::regression) (1) has it.
//!
//! With a constant term the levels y₁, u₁, w₁ are taken from an origin, the first sample of the segment, and the
//! constant is brought back when the segment is solved: a level far from zero is nearly the constant column, and would
//! cost the estimate its digits.
//!
//! After a rejected sample rows are withheld until every lag is clean again. A row whose residual e under the last
//! accepted model exceeds the threshold κσ weighs κσ/|e|.

use super::reference::{self, Candidate, Reference};
use super::rows::{AnyShape, Delays, Form, Row, Rows, Shape};
use super::{Estimate, Memory, Method, Order, Regression};
use crate::detector::Sample;

/// Rows of least squares. `L` is the capacity in delays, at least the larger of nkb and nkc; `S` the structure.
///
/// A column of differences moves on by one place a sample, so only two cells a signal are computed anew.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Regressor<const M: usize, const L: usize, S = AnyShape> {
    row: [f32; M],
    /// What the levels of y, u1, u2 are taken from.
    origin: [f32; 3],
    /// y(t−1), the value before it in the row, and the same for u1 and u2.
    newest_y: f32,
    level: [f32; 3],
    delays: Delays<L>,
    /// Accepted samples in an unbroken run, saturating; `None` where the regression does not fit.
    clean: Option<u16>,
    /// Whether the next row starts a segment.
    first: bool,
    /// Whether the origin has been taken: it moves where the sums are empty only.
    placed: bool,
    /// Scaled parameters, for the residual.
    reference: Reference<M>,
    /// Part of the scaled prediction that the origin has taken out of the levels.
    shift: f32,
    shape: core::marker::PhantomData<S>,
}

impl<const M: usize, const L: usize, S: Shape> Rows<M> for Regressor<M, L, S> {
    type Shape = S;

    fn new(regression: &Regression<M>) -> Self {
        Self {
            row: [0.0; M],
            origin: [0.0; 3],
            newest_y: 0.0,
            level: [0.0; 3],
            delays: Delays::new(),
            clean: Self::fits(regression).then_some(0),
            first: true,
            placed: false,
            reference: Reference::new(nominal(regression)),
            shift: 0.0,
            shape: core::marker::PhantomData,
        }
    }

    fn fits(regression: &Regression<M>) -> bool {
        regression.method == Method::LeastSquares
            && regression.columns() <= M
            && regression.order.largest_delay() <= L
            && S::fits(regression)
    }

    #[inline]
    fn push(&mut self, regression: &Regression<M>, sample: &Sample) -> Option<Row<M>> {
        let Form { order, offset, .. } = S::of(regression);
        let Order { na, nb, nc, nkb, nkc } = order;
        let swapped = self.reference.tick(|| nominal(regression));
        if offset && (self.first || swapped) {
            self.recentre(regression, sample);
        }
        let [level_y, level_u1, level_u2] = &mut self.level;
        let [y0, u1_0, u2_0] = self.origin;
        let [u1, u2] = self.delays.push([sample.u1, sample.u2], [nkb, nkc]);
        let (cells, scale) = (&mut self.row[..], &regression.scale[..]);
        let (cells, scale, _) = shift_in(cells, scale, na, level_y, (self.newest_y, y0));
        let (cells, scale, du1) = shift_in(cells, scale, nb, level_u1, (u1, u1_0));
        let (cells, scale, du2) = shift_in(cells, scale, nc, level_u2, (u2, u2_0));
        let mut rest = cells.iter_mut().zip(scale);
        if offset && let Some((cell, scale)) = rest.next() {
            *cell = *scale;
        }
        if let Some((target, scale)) = rest.next() {
            *target = (sample.y - if na == 0 { y0 } else { self.newest_y }) * scale;
        }
        self.newest_y = sample.y;
        let clean = self.clean.as_mut()?;
        *clean = clean.saturating_add(1);
        if (*clean as usize) <= order.depth() {
            return None;
        }
        // The level before the first row may be from before a gap.
        let motion = if *clean as usize > order.depth() + 1 { du1 * du1 + du2 * du2 } else { 0.0 };
        self.first = false;
        let mut weight = 1.0;
        if regression.guard.huber > 0.0 {
            let n = order.columns(offset) - 1;
            let known = self.row.iter().zip(&self.reference.now).take(n);
            let prediction = known.fold(self.shift, |sum, (x, theta)| sum + x * theta);
            let target = self.row.get(n).copied().unwrap_or(0.0);
            weight = reference::weight(target - prediction, self.reference.threshold);
        }
        Some(Row { cells: self.row, weight, motion })
    }

    fn flush(&mut self, _regression: &Regression<M>) {
        self.clean = self.clean.map(|_| 0);
    }

    fn next_segment(&mut self, regression: &Regression<M>) {
        self.first = true;
        self.reference.next_segment(regression.handover, || nominal(regression));
    }

    fn adopt<const P: usize>(&mut self, regression: &Regression<M>, estimate: &Estimate<M, P>) {
        self.reference.offer(candidate(regression, &estimate.delta, libm::sqrtf(estimate.variance)));
    }

    fn awaits(&self) -> bool {
        self.reference.awaits()
    }

    fn origin(&self) -> [f32; 3] {
        self.origin
    }

    fn gain(&self) -> f32 {
        1.0
    }

    fn base(&self, _regression: &Regression<M>) -> [f32; M] {
        [0.0; M]
    }

    fn refused(&self) -> u8 {
        self.reference.refused
    }
}

impl<const M: usize, const L: usize, S: Shape> Regressor<M, L, S> {
    /// Takes the levels of the following rows from this sample, if it starts the sums.
    fn recentre(&mut self, regression: &Regression<M>, sample: &Sample) {
        if self.first && (!self.placed || regression.memory == Memory::Segment) {
            self.placed = true;
            self.origin = [sample.y, sample.u1, sample.u2];
        }
        let Order { na, nb, nc, .. } = regression.order;
        let (na, nb) = (na as usize, nb as usize);
        let places = [(na > 0, 0), (nb > 0, na), (nc > 0, na + nb)];
        let mut shift = if na == 0 { -self.origin[0] * regression.target_scale() } else { 0.0 };
        for ((used, place), origin) in places.into_iter().zip(self.origin) {
            if let (true, Some(theta), Some(scale)) = (used, self.reference.now.get(place), regression.scale.get(place))
            {
                shift += theta * scale * origin;
            }
        }
        self.shift = shift;
    }
}

fn nominal<const M: usize>(regression: &Regression<M>) -> Candidate<M> {
    candidate(regression, &regression.nominal.delta, regression.nominal.deviation)
}

/// Scaled problem: `(y s_y) = (φ s) θ'`, so `θ' = θ s_y/s`.
fn candidate<const M: usize>(regression: &Regression<M>, delta: &[f32; M], deviation: f32) -> Candidate<M> {
    let target = regression.target_scale();
    let mut theta = *delta;
    theta.iter_mut().zip(&regression.scale).for_each(|(theta, scale)| *theta *= target / scale);
    (theta, reference::threshold(regression, deviation * target))
}

/// Puts a new level, less its origin, in front of `x₁, x₁−x₂, x₂−x₃, …` (`terms` columns); gives the columns behind
/// them, and the change of the level.
#[inline]
fn shift_in<'c, 's>(
    cells: &'c mut [f32],
    scale: &'s [f32],
    terms: u8,
    level: &mut f32,
    (newest, origin): (f32, f32),
) -> (&'c mut [f32], &'s [f32], f32) {
    let terms = terms as usize;
    let (Some((own, cells)), Some((own_scale, scale))) =
        (cells.split_at_mut_checked(terms), scale.split_at_checked(terms))
    else {
        return (&mut [], &[], 0.0);
    };
    let mut change = 0.0;
    if let ([first, differences @ ..], [first_scale, scales @ ..]) = (own, own_scale) {
        *first = (newest - origin) * first_scale;
        change = (newest - *level) * first_scale;
        if let Some(scale) = scales.first() {
            // Differences share one scale (`Model::validate`), so they move on as they are.
            let mut carried = (newest - *level) * scale;
            for cell in differences {
                carried = core::mem::replace(cell, carried);
            }
        }
        *level = newest;
    }
    (cells, scale, change)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(y: f32, u1: f32, u2: f32) -> Sample {
        Sample { y, u1, u2 }
    }

    fn regression<const M: usize>(order: Order, offset: bool) -> Regression<M> {
        Regression::new(order, offset)
    }

    #[test]
    fn row_by_hand() {
        let mut regression = regression::<7>(Order::new(2, 2, 1, 1, 0), true);
        regression.scale = [1.0, 2.0, 1.0, 1.0, 4.0, 1.0, 8.0];
        let mut lags = Regressor::<7, 1>::new(&regression);
        assert_eq!(lags.push(&regression, &sample(1.0, 10.0, -1.0)), None);
        assert_eq!(lags.push(&regression, &sample(2.0, 20.0, -2.0)), None, "t₀ = 2");
        // Levels from the sample (4, 40, −3): y₁ = 2 − 4, y₁−y₂ = 1 (×2), u₁ = 20 − 40, u₁−u₂ = 10, w₁ = 0 (×4), 1,
        // target 4 − 2 (×8)
        let row = lags.push(&regression, &sample(4.0, 40.0, -3.0)).map(|row| row.cells);
        assert_eq!(row, Some([-2.0, 2.0, -20.0, 10.0, 0.0, 1.0, 16.0]));
    }

    #[test]
    fn moving_average_model_has_the_output_itself_as_target() {
        let regression = regression::<2>(Order::new(0, 1, 0, 1, 0), false);
        let mut lags = Regressor::<2, 1>::new(&regression);
        assert_eq!(lags.push(&regression, &sample(1.0, 10.0, 0.0)), None);
        assert_eq!(lags.push(&regression, &sample(2.0, 20.0, 0.0)).map(|r| r.cells), Some([10.0, 2.0]));
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
            let row = lags.push(&regression, &signal(t)).map(|row| row.cells);
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
        let push =
            |lags: &mut Regressor<5, 1>, x: f32| lags.push(&regression, &sample(x, 10.0 * x, x)).map(|row| row.cells);
        assert_eq!((push(&mut lags, 1.0), push(&mut lags, 2.0)), (None, None));
        assert_eq!(push(&mut lags, 3.0), Some([2.0, 20.0, 10.0, 2.0, 1.0]));
        lags.flush(&regression);
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
}
