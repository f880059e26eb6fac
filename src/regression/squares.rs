//! Least squares: the last samples → one row of the regression, in δ-form.
//!
//! Enters: y, u1, u2, a sample at a time. Leaves: a row of M columns, regressor then target, as equation (1) of
//! [`super::constants`].
//!
//! With a constant term the levels y₁, u₁, w₁ are taken from an origin, the first sample of the segment; the solve
//! restores the constant. Without this a level far from zero would nearly be the constant column, and the estimate
//! would lose digits.
//!
//! After a refused sample, rows are withheld until every lag is valid again. A row whose residual e under the last
//! accepted model exceeds the threshold κσ has the weight κσ/|e|.

use super::auxiliary::{self, Auxiliary, Candidate};
use super::constants::Regression;
use super::delays::Delays;
use super::inputs::{Inputs, carry_on, dot};
use crate::plan::{Array, Cells, Memory, Plan, RegressionLayout, Structure};
use crate::regression::factor::Row;

/// Rows of least squares.
///
/// A column of differences moves on by one place a sample, so only two cells of each signal are computed.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Squares<P: Plan> {
    row: Array<P::Columns, f32>,
    /// Values that are subtracted from the levels of y, u1, u2.
    pub(super) origin: [f32; 3],
    /// y(t−1).
    newest_y: f32,
    /// The levels of the row before.
    level: [f32; 3],
    delays: Delays<P>,
    /// Accepted samples in an unbroken run, saturating.
    clean: u16,
    /// Whether the next row starts a segment.
    first: bool,
    /// Whether the origin has been taken: it moves only while the sums are empty.
    placed: bool,
    /// Scaled parameters, for the residual.
    pub(super) auxiliary: Auxiliary<P>,
    /// Part of the scaled prediction that the origin removes from the levels.
    shift: f32,
}

impl<P: Plan> Squares<P> {
    pub(super) fn new(plan: P, constants: &Regression<P>) -> Self {
        Self {
            row: Cells::filled(plan.layout().columns(), 0.0),
            origin: [0.0; 3],
            newest_y: 0.0,
            level: [0.0; 3],
            delays: Delays::new(plan),
            clean: 0,
            first: true,
            placed: false,
            auxiliary: Auxiliary::new(nominal(plan, constants)),
            shift: 0.0,
        }
    }

    #[inline(always)]
    pub(super) fn push(&mut self, plan: P, constants: &Regression<P>, inputs: Inputs) -> Option<Row<'_>> {
        let RegressionLayout { structure, memory, .. } = plan.layout().regression?;
        let Structure { na, nb, nc, nkb, nkc, offset } = structure;
        let swapped = self.auxiliary.tick(|| nominal(plan, constants));
        if offset && (self.first || swapped) {
            self.recentre(structure, memory, constants, inputs);
        }
        let [level_y, level_u1, level_u2] = &mut self.level;
        let [y0, u1_0, u2_0] = self.origin;
        let [u1, u2] = self.delays.push([inputs.u1, inputs.u2], [nkb, nkc]);
        let (cells, scale) = (self.row.cells_mut(), constants.scale.cells());
        let (cells, scale, _) = shift_in(cells, scale, na, level_y, (self.newest_y, y0));
        let (cells, scale, du1) = shift_in(cells, scale, nb, level_u1, (u1, u1_0));
        let (cells, scale, du2) = shift_in(cells, scale, nc, level_u2, (u2, u2_0));
        let (cells, scale) = match (offset, cells, scale) {
            (true, [cell, cells @ ..], [constant, scale @ ..]) => {
                *cell = *constant;
                (cells, scale)
            }
            (_, cells, scale) => (cells, scale),
        };
        if let ([target, ..], [scale, ..]) = (cells, scale) {
            *target = (inputs.y - if na == 0 { y0 } else { self.newest_y }) * scale;
        }
        self.newest_y = inputs.y;
        self.clean = self.clean.saturating_add(1);
        let depth = structure.depth();
        if (self.clean as usize) <= depth {
            return None;
        }
        // The level before the first row may be from before a gap.
        let motion = if (self.clean as usize) > depth.saturating_add(1) { du1 * du1 + du2 * du2 } else { 0.0 };
        self.first = false;
        let mut weight = 1.0;
        let row = self.row.cells();
        if constants.huber > 0.0 {
            let model = &self.auxiliary.now;
            let prediction = dot(self.shift, row, model.theta.cells());
            let target = row.get(structure.parameters()).copied().unwrap_or(0.0);
            weight = auxiliary::weight(target - prediction, model.threshold);
        }
        Some(Row { cells: row, weight, motion })
    }

    pub(super) fn flush(&mut self) {
        self.clean = 0;
    }

    pub(super) fn next_segment(&mut self, plan: P, constants: &Regression<P>) {
        self.first = true;
        self.auxiliary.next_segment(constants.handover, || nominal(plan, constants));
    }

    /// Takes the levels of the following rows from this sample, if it starts the sums.
    #[inline(never)]
    fn recentre(&mut self, structure: Structure, memory: Memory, constants: &Regression<P>, inputs: Inputs) {
        if self.first && (!self.placed || memory != Memory::Fading) {
            self.placed = true;
            self.origin = [inputs.y, inputs.u1, inputs.u2];
        }
        let Structure { na, nb, nc, .. } = structure;
        let (na, nb) = (na as usize, nb as usize);
        let places = [(na > 0, 0), (nb > 0, na), (nc > 0, na.saturating_add(nb))];
        let mut shift = if na == 0 { -self.origin[0] * constants.target_scale(structure.parameters()) } else { 0.0 };
        let (theta, scale) = (self.auxiliary.now.theta.cells(), constants.scale.cells());
        for ((used, place), origin) in places.into_iter().zip(self.origin) {
            if let (true, Some(theta), Some(scale)) = (used, theta.get(place), scale.get(place)) {
                shift += theta * scale * origin;
            }
        }
        self.shift = shift;
    }
}

fn nominal<P: Plan>(plan: P, constants: &Regression<P>) -> Candidate<P> {
    candidate(plan, constants, constants.nominal.cells(), constants.deviation)
}

/// Scaled problem: `(y s_y) = (φ s) θ'`, so `θ' = θ s_y/s`.
pub(super) fn candidate<P: Plan>(plan: P, constants: &Regression<P>, delta: &[f32], deviation: f32) -> Candidate<P> {
    let parameters = plan.layout().parameters();
    let target = constants.target_scale(parameters);
    let mut theta: Array<P::Parameters, f32> = Cells::filled(parameters, 0.0);
    let pairs = delta.iter().zip(constants.scale.cells());
    theta.cells_mut().iter_mut().zip(pairs).for_each(|(to, (theta, scale))| *to = theta * (target / scale));
    Candidate { theta, threshold: auxiliary::threshold(constants.huber, deviation * target) }
}

/// Puts a new level, less its origin, in front of `x₁, x₁−x₂, x₂−x₃, …` (`terms` columns); returns the columns after
/// them, and the change of the level.
#[inline(always)]
fn shift_in<'c, 's>(
    cells: &'c mut [f32],
    scale: &'s [f32],
    terms: u8,
    level: &mut f32,
    (newest, origin): (f32, f32),
) -> (&'c mut [f32], &'s [f32], f32) {
    let terms = terms as usize;
    let (Some((section, cells)), Some((section_scale, scale))) =
        (cells.split_at_mut_checked(terms), scale.split_at_checked(terms))
    else {
        return (&mut [], &[], 0.0);
    };
    let mut change = 0.0;
    if let ([first, differences @ ..], [first_scale, scales @ ..]) = (section, section_scale) {
        *first = (newest - origin) * first_scale;
        change = (newest - *level) * first_scale;
        if let Some(scale) = scales.first() {
            // Differences share one scale (a validated model), so they move on unchanged.
            carry_on(differences, (newest - *level) * scale);
        }
        *level = newest;
    }
    (cells, scale, change)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{Method, RunTime, testing};
    use std::vec;
    use std::vec::Vec;

    struct Stream {
        plan: RunTime,
        constants: Regression<RunTime>,
        rows: Squares<RunTime>,
    }

    impl Stream {
        fn new(structure: Structure) -> Self {
            let layout = testing::regression(structure, Method::LeastSquares, Memory::Segment);
            let plan = RunTime::of(layout).unwrap();
            let constants = Regression::new(plan);
            Self { plan, rows: Squares::new(plan, &constants), constants }
        }

        fn push(&mut self, y: f32, u1: f32, u2: f32) -> Option<Vec<f32>> {
            let row = self.rows.push(self.plan, &self.constants, Inputs { y, u1, u2 });
            row.map(|row| row.cells.to_vec())
        }
    }

    #[test]
    fn row_by_hand() {
        let mut lags = Stream::new(Structure::new(2, 2, 1, 1, 0).with_offset());
        lags.constants.scale = vec![1.0, 2.0, 0.5, 1.0, 4.0, 1.0, 8.0];
        assert_eq!(lags.push(1.0, 10.0, -1.0), None);
        assert_eq!(lags.push(2.0, 20.0, -2.0), None, "t₀ = 2");
        // Levels from the sample (4, 40, −3): y₁ = 2 − 4, y₁−y₂ = 1 (×2), u₁ = 20 − 40 (×½), u₁−u₂ = 10, w₁ = 0 (×4),
        // 1, target 4 − 2 (×8)
        assert_eq!(lags.push(4.0, 40.0, -3.0), Some(vec![-2.0, 2.0, -10.0, 10.0, 0.0, 1.0, 16.0]));
    }

    #[test]
    fn the_limit_of_outliers_is_in_units_of_the_target() {
        let Stream { plan, mut constants, .. } = Stream::new(Structure::new(1, 1, 0, 1, 0));
        (constants.scale, constants.huber, constants.deviation) = (vec![1.0, 1.0, 8.0], 3.0, 0.25);
        assert_eq!(nominal(plan, &constants).threshold, 6.0);
    }

    #[test]
    fn moving_average_model_has_the_output_itself_as_target() {
        let mut lags = Stream::new(Structure::new(0, 1, 0, 1, 0));
        assert_eq!(lags.push(1.0, 10.0, 0.0), None);
        assert_eq!(lags.push(2.0, 20.0, 0.0), Some(vec![10.0, 2.0]));
    }

    #[test]
    fn every_cell_is_the_lag_it_should_be() {
        // Each sample has values of its own, y = t³, u1 = 1000 + t², u2 = 0.5 t; long delays and many terms.
        let signal = |t: i16| {
            let t = f32::from(t);
            (t * t * t, 1000.0 + t * t, 0.5 * t)
        };
        let mut lags = Stream::new(Structure::new(3, 3, 2, 4, 2));
        for t in 0..30_i16 {
            let (y, u1, u2) = signal(t);
            let row = lags.push(y, u1, u2);
            assert_eq!(row.is_some(), t >= 6, "t₀ = 4 + 3 − 1");
            let Some(row) = row else { continue };
            let (y, u1, u2) = (|k| signal(t - k).0, |k| signal(t - k).1, |k| signal(t - k).2);
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
    fn flush_withholds_rows_until_every_lag_is_valid() {
        let mut lags = Stream::new(Structure::new(1, 2, 1, 1, 1));
        assert_eq!((lags.push(1.0, 10.0, 1.0), lags.push(2.0, 20.0, 2.0)), (None, None));
        assert_eq!(lags.push(3.0, 30.0, 3.0), Some(vec![2.0, 20.0, 10.0, 2.0, 1.0]));
        lags.rows.flush();
        assert_eq!((lags.push(7.0, 70.0, 7.0), lags.push(9.0, 90.0, 9.0)), (None, None));
        assert_eq!(lags.push(12.0, 120.0, 12.0), Some(vec![9.0, 90.0, 20.0, 9.0, 3.0]), "no value from before the gap");
    }

    #[test]
    fn the_first_row_after_a_gap_tells_no_motion() {
        let mut lags = Stream::new(Structure::new(1, 1, 1, 1, 1));
        let motion = |rows: &mut Squares<RunTime>, u: f32| {
            let row = rows.push(lags.plan, &lags.constants, Inputs { y: 0.0, u1: u, u2: 2.0 * u });
            row.map(|row| row.motion)
        };
        let rows = &mut lags.rows;
        assert_eq!([1.0, 3.0, 3.0].map(|u| motion(rows, u)), [None, Some(0.0), Some(4.0 + 16.0)]);
        rows.flush();
        assert_eq!([50.0, 50.0, 51.0, 0.0].map(|u| motion(rows, u)), [None, Some(0.0), Some(0.0), Some(5.0)]);
    }

    #[test]
    fn an_outlier_weighs_less() {
        let mut lags = Stream::new(Structure::new(1, 1, 0, 1, 0));
        (lags.constants.huber, lags.constants.deviation) = (2.0, 0.5);
        lags.rows = Squares::new(lags.plan, &lags.constants);
        lags.push(0.0, 0.0, 0.0);
        // The nominal model is zero, so the residual is Δy; the threshold is 1.
        let mut weight = |y: f32| {
            let row = lags.rows.push(lags.plan, &lags.constants, Inputs { y, u1: 0.0, u2: 0.0 });
            row.map(|row| row.weight)
        };
        assert_eq!([weight(0.5), weight(1.5), weight(5.5)], [Some(1.0), Some(1.0), Some(0.25)]);
    }

    /// Signals far from zero, of the nominal model itself: what the origin removes from the levels is in the
    /// prediction.
    #[test]
    fn rows_of_the_nominal_model_weigh_fully_far_from_zero() {
        let mut lags = Stream::new(Structure::new(1, 1, 1, 1, 1).with_offset());
        lags.constants.scale = vec![2.0, 4.0, 8.0, 1.0, 16.0];
        lags.constants.nominal = vec![-0.5, 0.25, 0.125, 3.0];
        // The threshold is 0.03 of the scaled target, a hundred times what numbers of a hundred round to.
        (lags.constants.huber, lags.constants.deviation) = (2.0, 1e-3);
        lags.rows = Squares::new(lags.plan, &lags.constants);
        let (mut y, mut given) = (20.0, 0);
        for t in 0..50_u8 {
            let (u1, u2) = (40.0 + f32::from(t % 3), -30.0 + f32::from(t % 5));
            let row = lags.rows.push(lags.plan, &lags.constants, Inputs { y, u1, u2 });
            given += usize::from(row.is_some());
            assert!(row.is_none_or(|row| row.weight >= 1.0), "{t}");
            y += -0.5 * y + 0.25 * u1 + 0.125 * u2 + 3.0;
        }
        assert_eq!(given, 49);
    }

    #[test]
    fn the_origin_of_a_fading_memory_stays_and_that_of_segments_moves() {
        for (memory, later) in [(Memory::Segment, 50.0), (Memory::Fading, 5.0)] {
            let structure = Structure::new(0, 1, 0, 0, 0).with_offset();
            let layout = testing::regression(structure, Method::LeastSquares, memory);
            let plan = RunTime::of(layout).unwrap();
            let mut constants = Regression::new(plan);
            constants.scale = vec![1.0, 1.0, 8.0];
            let mut rows = Squares::new(plan, &constants);
            rows.push(plan, &constants, Inputs { y: 5.0, u1: 1.0, u2: 0.0 });
            // The target is y itself, less its level.
            assert_eq!((rows.origin, rows.shift), ([5.0, 1.0, 0.0], -5.0 * 8.0), "{memory:?}");
            rows.next_segment(plan, &constants);
            rows.push(plan, &constants, Inputs { y: 50.0, u1: 1.0, u2: 0.0 });
            assert_eq!((rows.origin, rows.shift), ([later, 1.0, 0.0], -later * 8.0), "{memory:?}");
        }
    }
}
