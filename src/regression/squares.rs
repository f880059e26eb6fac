//! Least squares: the last samples → one row of the regression, in δ-form.
//!
//! Enters: y, u1, u2, a sample at a time. Leaves: a row of M columns, regressor then target, as equation (1) of
//! [`super::constants`].
//!
//! With a constant term the levels y₁, u₁, w₁ are taken from an origin, the first sample of the segment; the solve
//! restores the constant. Without this a level far from zero would nearly be the constant column, and the estimate
//! would lose digits.
//!
//! After a refused sample, rows are withheld until every lag is valid again.

use super::constants::Regression;
use super::delays::Delays;
use super::inputs::{Inputs, carry_on};
use crate::plan::{Array, Cells, Memory, RegressionLayout, RegressionLengths, Structure};
use crate::regression::factor::Row;

/// Rows of least squares.
///
/// A column of differences moves on by one place a sample, so only two cells of each signal are computed.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Squares<P: RegressionLengths> {
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
}

impl<P: RegressionLengths> Squares<P> {
    pub(super) fn new(plan: P) -> Self {
        Self {
            row: Cells::filled(plan.layout().columns(), 0.0),
            origin: [0.0; 3],
            newest_y: 0.0,
            level: [0.0; 3],
            delays: Delays::new(plan),
            clean: 0,
            first: true,
            placed: false,
        }
    }

    #[inline(always)]
    pub(super) fn push(&mut self, plan: P, constants: &Regression<P>, inputs: Inputs) -> Option<Row<'_>> {
        let RegressionLayout { structure, memory, .. } = plan.layout().regression?;
        let Structure { na, nb, nc, nkb, nkc, offset } = structure;
        // Levels are taken from the first sample of the sums; a fading memory keeps its sums.
        if offset && self.first && (!self.placed || memory != Memory::Fading) {
            (self.origin, self.placed) = ([inputs.y, inputs.u1, inputs.u2], true);
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
        Some(Row { cells: self.row.cells(), motion })
    }

    pub(super) fn flush(&mut self) {
        self.clean = 0;
    }

    pub(super) fn next_segment(&mut self) {
        self.first = true;
    }
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
    use crate::plan::{Method, Plan as _, RunTime, testing};
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
            Self { plan, rows: Squares::new(plan), constants }
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
    fn the_origin_of_a_fading_memory_stays_and_that_of_segments_moves() {
        for (memory, later) in [(Memory::Segment, 50.0), (Memory::Fading, 5.0)] {
            let structure = Structure::new(0, 1, 0, 0, 0).with_offset();
            let layout = testing::regression(structure, Method::LeastSquares, memory);
            let plan = RunTime::of(layout).unwrap();
            let mut constants = Regression::new(plan);
            constants.scale = vec![1.0, 1.0, 8.0];
            let mut rows = Squares::new(plan);
            rows.push(plan, &constants, Inputs { y: 5.0, u1: 1.0, u2: 0.0 });
            // The target is y itself, less its level.
            assert_eq!(rows.origin, [5.0, 1.0, 0.0], "{memory:?}");
            rows.next_segment();
            rows.push(plan, &constants, Inputs { y: 50.0, u1: 1.0, u2: 0.0 });
            assert_eq!(rows.origin, [later, 1.0, 0.0], "{memory:?}");
        }
    }
}
