//! What becomes of the rows: one bounded segment, a long one in two levels, or fading memory.
//!
//! | | weight of rows | longest segment | state |
//! |---|---|---|---|
//! | [`Triangle`] | alike | [`MAX_SEGMENT_SAMPLES`] = 1e5 | one factor |
//! | [`TwoLevel`] | alike | [`MAX_LONG_SEGMENT_SAMPLES`] = 1e6 | two factors |
//! | [`Fading`] | λ ≤ 0.9999 a row | endless | one factor, three numbers |
//!
//! Sums that neither fade nor end are not offered: single precision would lose them.

use super::triangle::PRIOR;
use super::{Forgetting, Memory, Regression, Row, Triangle};

/// Longest segment of a single factor (see [`super::triangle`]).
pub const MAX_SEGMENT_SAMPLES: u32 = 100_000;
/// Longest segment in two levels.
pub const MAX_LONG_SEGMENT_SAMPLES: u32 = 1_000_000;
/// Largest λ: a memory of 1e4 rows.
pub const MAX_LAMBDA: f32 = 0.9999;

/// Part of its final mass from which a fading memory counts as filled.
const FILLED: f32 = 0.9;

/// Rows summed on the lower of two levels before they are handed up.
const BLOCK: u16 = 512;

/// How much the rows in a factor weigh.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Mass {
    /// Σλᵏ: the equivalent number of rows that have not faded. Weights of outliers are not in it.
    pub rows: f32,
    /// Σλ²ᵏ/Σλᵏ: by what fading changes a covariance.
    pub spread: f32,
}

/// Rows → the factor of their sums.
pub trait Accumulator<const M: usize, const P: usize>: Clone + core::fmt::Debug + PartialEq {
    /// Rows a segment may have.
    const LONGEST: u32;
    /// Whether rows fade, and none is added at rest.
    const FADES: bool;

    /// No rows yet, of so many columns.
    fn new(columns: usize) -> Self;

    /// Whether this is the memory the regression asks for.
    fn fits(regression: &Regression<M>) -> bool;

    /// Adds a row; `false` where nothing moved and it was left out.
    fn add(&mut self, regression: &Regression<M>, row: &Row<M>) -> bool;

    /// Hands the factor of all rows to `read`.
    fn total<T>(&self, read: impl FnOnce(&Triangle<M, P>) -> T) -> T;

    /// How much they weigh; `rows` is the number of the open segment.
    fn mass(&self, regression: &Regression<M>, rows: u32) -> Mass;

    /// A segment is closed.
    fn next_segment(&mut self);

    /// Forgets everything.
    fn restart(&mut self);
}

impl<const M: usize, const P: usize> Accumulator<M, P> for Triangle<M, P> {
    const LONGEST: u32 = MAX_SEGMENT_SAMPLES;
    const FADES: bool = false;

    fn new(columns: usize) -> Self {
        Self::new(columns)
    }

    fn fits(regression: &Regression<M>) -> bool {
        regression.memory == Memory::Segment
    }

    #[inline]
    fn add(&mut self, _regression: &Regression<M>, row: &Row<M>) -> bool {
        self.update_weighted(&row.cells, row.weight);
        true
    }

    fn total<T>(&self, read: impl FnOnce(&Self) -> T) -> T {
        read(self)
    }

    fn mass(&self, _regression: &Regression<M>, rows: u32) -> Mass {
        Mass { rows: rows as f32, spread: 1.0 }
    }

    fn next_segment(&mut self) {
        self.reset();
    }

    fn restart(&mut self) {
        self.reset();
    }
}

/// Blocks of rows are summed apart and handed up one row of their factor a sample, so that a long sum is one of
/// sums of like size. A sample that hands up costs one rotation more, at most twice the usual.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TwoLevel<const M: usize, const P: usize> {
    block: Triangle<M, P>,
    sum: Triangle<M, P>,
    place: u16,
}

impl<const M: usize, const P: usize> Accumulator<M, P> for TwoLevel<M, P> {
    const LONGEST: u32 = MAX_LONG_SEGMENT_SAMPLES;
    const FADES: bool = false;

    fn new(columns: usize) -> Self {
        Self { block: Triangle::new(columns), sum: Triangle::new(columns), place: 0 }
    }

    fn fits(regression: &Regression<M>) -> bool {
        regression.memory == Memory::Segment
    }

    #[inline]
    fn add(&mut self, _regression: &Regression<M>, row: &Row<M>) -> bool {
        self.block.update_weighted(&row.cells, row.weight);
        self.place = if self.place + 1 == BLOCK { 0 } else { self.place + 1 };
        if (self.place as usize) < self.block.columns() {
            self.sum.take_row(&mut self.block, self.place as usize);
        }
        true
    }

    fn total<T>(&self, read: impl FnOnce(&Triangle<M, P>) -> T) -> T {
        let (mut block, mut sum) = (self.block.clone(), self.sum.clone());
        for i in 0..block.columns() {
            sum.take_row(&mut block, i);
        }
        read(&sum)
    }

    fn mass(&self, _regression: &Regression<M>, rows: u32) -> Mass {
        Mass { rows: rows as f32, spread: 1.0 }
    }

    fn next_segment(&mut self) {
        *self = Self::new(self.block.columns());
    }

    fn restart(&mut self) {
        self.next_segment();
    }
}

/// Rows fade by λ a row. While the inputs rest nothing is learnt and nothing forgotten: forgetting without excitation
/// would let noise take the place of knowledge.
///
/// ```text
/// m ← m + 8(1 − λ)(motion − m);   frozen while m < still                                    (1)
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Fading<const M: usize, const P: usize> {
    triangle: Triangle<M, P>,
    /// Mean motion of the inputs (1).
    motion: f32,
    /// Σλᵏ.
    rows: f32,
}

impl<const M: usize, const P: usize> Accumulator<M, P> for Fading<M, P> {
    const LONGEST: u32 = u32::MAX;
    const FADES: bool = true;

    fn new(columns: usize) -> Self {
        Self { triangle: Triangle::new(columns), motion: 0.0, rows: 0.0 }
    }

    fn fits(regression: &Regression<M>) -> bool {
        regression.memory != Memory::Segment
    }

    #[inline]
    fn add(&mut self, regression: &Regression<M>, row: &Row<M>) -> bool {
        let Memory::Fading(forgetting) = regression.memory else { return false };
        let Forgetting { lambda, .. } = forgetting;
        self.motion += f32::min(8.0 * (1.0 - lambda), 1.0) * (row.motion - self.motion); // (1)
        // Written so that NaN freezes.
        let moving = self.motion >= regression.still;
        if moving {
            // While the memory fills, the floor would be a prior that outweighs the rows.
            let floor = if self.rows * (1.0 - lambda) < FILLED { PRIOR } else { forgetting.floor };
            self.triangle.update_forgetting(&row.cells, row.weight, Forgetting { floor, ..forgetting });
            self.rows = self.rows * lambda + 1.0;
        }
        moving
    }

    fn total<T>(&self, read: impl FnOnce(&Triangle<M, P>) -> T) -> T {
        read(&self.triangle)
    }

    fn mass(&self, regression: &Regression<M>, _rows: u32) -> Mass {
        let lambda = match regression.memory {
            Memory::Fading(forgetting) => forgetting.lambda,
            Memory::Segment => 1.0,
        };
        // Σλᵏ = (1 − λⁿ)/(1 − λ) and Σλ²ᵏ = (1 − λ²ⁿ)/(1 − λ²), so their ratio is (1 + λⁿ)/(1 + λ).
        let left = 1.0 - self.rows * (1.0 - lambda);
        Mass { rows: self.rows, spread: (1.0 + left) / (1.0 + lambda) }
    }

    fn next_segment(&mut self) {
        // Cannot come from samples that passed a validated guard; but what fades must not keep it for ever.
        if !self.triangle.parts().0.iter().all(|d| d.is_finite()) {
            self.restart();
        }
    }

    fn restart(&mut self) {
        *self = Self::new(self.triangle.columns());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::Order;

    /// Rows of y = 3 x₀ − 2 x₁ with some noise, by a small congruential generator.
    fn rows(count: usize) -> impl Iterator<Item = Row<3>> {
        let mut state = 5_u32;
        let mut uniform = move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f32::from((state >> 16) as i16) / 32_768.0
        };
        (0..count).map(move |_| {
            let (a, b, e) = (uniform(), uniform(), uniform());
            Row { cells: [a, b, 3.0 * a - 2.0 * b + 0.1 * e], weight: 1.0, motion: a * a }
        })
    }

    const SEGMENT: Regression<3> = Regression::new(Order::new(0, 1, 1, 0, 0), false);
    const FADING: Regression<3> =
        Regression { memory: Memory::Fading(Forgetting { lambda: 0.999, floor: 10.0 }), still: 0.01, ..SEGMENT };

    #[test]
    fn two_levels_hold_what_one_holds() {
        let (mut one, mut two) = (<Triangle<3, 3> as Accumulator<3, 3>>::new(3), TwoLevel::<3, 3>::new(3));
        // Within the first block, at its end, in a later one, and while rows are handed up.
        let mut added = 0;
        for count in [7, 505, 512, 513, 514, 5000, 5121] {
            for row in rows(count).skip(added) {
                assert!(one.add(&SEGMENT, &row) && two.add(&SEGMENT, &row));
            }
            added = count;
            two.total(|sum| {
                let pairs = [(one.solve(), sum.solve()), (one.inverse(), sum.inverse())];
                for (x, y) in pairs.iter().flat_map(|(x, y)| x.iter().zip(y)) {
                    // Roundings of five thousand rows.
                    assert!((x - y).abs() <= 1e-5 * x.abs(), "{count}: {x} {y}");
                }
                let (x, y) = (one.residual_sum(), sum.residual_sum());
                assert!((x / y - 1.0).abs() < 1e-5, "{count}: {x} {y}");
            });
        }
        two.next_segment();
        assert_eq!(two, TwoLevel::new(3));
    }

    #[test]
    fn nothing_moving_changes_nothing() {
        let mut fading = Fading::<3, 3>::new(3);
        let learnt = rows(5000).filter(|row| fading.add(&FADING, row)).count();
        assert!(learnt > 4900, "{learnt}: all but the start");
        let mass = fading.mass(&FADING, 0);
        // Σλᵏ → 1/(1 − λ), Σλ²ᵏ/Σλᵏ → 1/(1 + λ), up to e⁻⁵.
        assert!((mass.rows / 1000.0 - 1.0).abs() < 0.01 && (mass.spread / 0.5003 - 1.0).abs() < 0.02, "{mass:?}");
        // The mean of the motion first runs out.
        let mut at_rest = rows(100_000).map(|row| Row { motion: 0.0, ..row });
        while fading.add(&FADING, &at_rest.next().unwrap()) {}
        let frozen = fading.triangle.clone();
        assert!(at_rest.all(|row| !fading.add(&FADING, &row)));
        assert_eq!(fading.triangle, frozen);
        let woken = rows(1000).filter(|row| fading.add(&FADING, row)).count();
        assert!(woken > 900, "{woken}");
    }

    #[test]
    fn each_memory_takes_its_own_regressions() {
        assert!(<Triangle<3, 3> as Accumulator<3, 3>>::fits(&SEGMENT) && TwoLevel::<3, 3>::fits(&SEGMENT));
        assert!(!Fading::<3, 3>::fits(&SEGMENT) && Fading::<3, 3>::fits(&FADING));
        assert!(!<Triangle<3, 3> as Accumulator<3, 3>>::fits(&FADING) && !TwoLevel::<3, 3>::fits(&FADING));
    }
}
