//! What becomes of the rows: one bounded segment, a long one in two levels, or fading memory.
//!
//! | | weight of rows | longest segment | state |
//! |---|---|---|---|
//! | [`Triangle`] | alike | [`MAX_SEGMENT_SAMPLES`] = 1e5 | one factor |
//! | [`TwoLevel`] | alike | [`MAX_LONG_SEGMENT_SAMPLES`] = 1e6 | two factors |
//! | [`Fading`] | λ ≤ 0.9999 a row | endless | one factor, three numbers |
//!
//! Sums that neither fade nor end are not offered: single precision would lose them.

use super::{Forgetting, Memory, Regression, Row, Triangle};

/// Longest segment of a single factor (see [`super::triangle`]).
pub const MAX_SEGMENT_SAMPLES: u32 = 100_000;
/// Longest segment in two levels.
pub const MAX_LONG_SEGMENT_SAMPLES: u32 = 1_000_000;
/// Largest λ: a memory of 1e4 rows.
pub const MAX_LAMBDA: f32 = 0.9999;

/// Rows summed on the lower of two levels before they are handed up.
const BLOCK: u16 = 512;

/// How much the rows in a factor weigh.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Mass {
    /// Σw: the equivalent number of rows of weight one.
    pub rows: f32,
    /// Σw²/Σw: by what unequal weights change a covariance.
    pub spread: f32,
}

/// Rows → the factor of their sums.
pub trait Accumulator<const M: usize, const P: usize>: Clone + core::fmt::Debug + PartialEq {
    /// Rows a segment may have.
    const LONGEST: u32;

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
    /// Σw.
    rows: f32,
}

impl<const M: usize, const P: usize> Accumulator<M, P> for Fading<M, P> {
    const LONGEST: u32 = u32::MAX;

    fn new(columns: usize) -> Self {
        Self { triangle: Triangle::new(columns), motion: 0.0, rows: 0.0 }
    }

    fn fits(regression: &Regression<M>) -> bool {
        regression.memory != Memory::Segment
    }

    #[inline]
    fn add(&mut self, regression: &Regression<M>, row: &Row<M>) -> bool {
        let Memory::Fading { forgetting, still } = regression.memory else { return false };
        let Forgetting { lambda, .. } = forgetting;
        self.motion += 8.0 * (1.0 - lambda) * (row.motion - self.motion); // (1)
        // Written so that NaN freezes.
        let moving = self.motion >= still;
        if moving {
            self.triangle.update_forgetting(&row.cells, row.weight, forgetting);
            self.rows = self.rows * lambda + 1.0;
        }
        moving
    }

    fn total<T>(&self, read: impl FnOnce(&Triangle<M, P>) -> T) -> T {
        read(&self.triangle)
    }

    fn mass(&self, regression: &Regression<M>, _rows: u32) -> Mass {
        let lambda = match regression.memory {
            Memory::Fading { forgetting, .. } => forgetting.lambda,
            Memory::Segment => 1.0,
        };
        // Σλᵏ = (1 − λⁿ)/(1 − λ) and Σλ²ᵏ = (1 − λ²ⁿ)/(1 − λ²), so their ratio is (1 + λⁿ)/(1 + λ).
        let left = 1.0 - self.rows * (1.0 - lambda);
        Mass { rows: self.rows, spread: (1.0 + left) / (1.0 + lambda) }
    }

    fn next_segment(&mut self) {}

    fn restart(&mut self) {
        *self = Self::new(self.triangle.columns());
    }
}
