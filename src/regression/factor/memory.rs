//! How long rows count: one bounded segment, or fading memory.
//!
//! | [`Memory`] | weight of rows | longest segment | state |
//! |---|---|---|---|
//! | `Segment` | equal | [`MAX_SEGMENT_ROWS`] = 1e5 | one factor |
//! | `Fading` | λ ≤ 0.9999 a row | endless | one factor, two numbers |
//!
//! Sums that neither fade nor end are not offered: single precision would lose their digits.
//!
//! Fading memory ignores rows while the inputs rest: forgetting without excitation would
//! replace what is known by noise.
//!
//! ```text
//! m ← m + 8(1 − λ)(motion − m);   frozen while m < rest                                    (1)
//! ```
//!
//! The floor of a full memory keeps what is known of a column whose excitation ends. A column that depended on the ones
//! before it while the memory filled is not known at all: it has no result until its pivot is above the floor.

use super::problem::is_excited;
use super::triangle::{Row, Triangle};
use super::weight::{EffectiveRows, Forgetting, PRIOR};
use crate::plan::{Array, Memory, Plan};

/// Largest number of rows of a segment summed in one factor: more would cost accuracy in single precision.
pub const MAX_SEGMENT_ROWS: u32 = 100_000;
/// Largest λ: a memory of 1e4 rows.
pub const MAX_LAMBDA: f32 = 0.9999;

/// Part of its final mass from which a fading memory counts as full.
const FULL: f32 = 0.9;

/// The factor of a plan's rows.
pub type PlanTriangle<P> = Triangle<Array<<P as Plan>::Columns, f32>, Array<<P as Plan>::Packed, f32>>;

/// The sums over the rows of a segment, or of a fading memory.
#[derive(Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sums<P: Plan> {
    sum: PlanTriangle<P>,
    /// Mean motion of the inputs (1).
    motion: f32,
    /// Σλᵏ of a fading memory.
    faded_rows: f32,
    /// The first column that was not excited when a fading memory became full; [`EXCITED`] if all were.
    unexcited: u8,
    /// Number of parameters, whose columns must be excited.
    parameters: u8,
}

/// Every column is excited.
const EXCITED: u8 = u8::MAX;
/// A pivot above so many floors is one of rows: at most half of it is the floor's.
const ABOVE_FLOOR: f32 = 2.0;

// Not derived: the clone of an array moves its elements once more.
impl<P: Plan> Clone for Sums<P> {
    #[inline(always)]
    fn clone(&self) -> Self {
        Self { sum: self.sum.clone(), ..*self }
    }
}

/// Longest segment of a memory, rows.
#[must_use]
pub const fn longest(memory: Memory) -> u32 {
    match memory {
        Memory::Segment => MAX_SEGMENT_ROWS,
        Memory::Fading => u32::MAX,
    }
}

impl<P: Plan> Sums<P> {
    /// No rows yet.
    #[must_use]
    pub fn new(plan: P) -> Self {
        let layout = plan.layout();
        Self {
            sum: Triangle::new(layout.columns()),
            motion: 0.0,
            faded_rows: 0.0,
            unexcited: EXCITED,
            parameters: u8::try_from(layout.parameters()).unwrap_or(u8::MAX),
        }
    }

    /// Adds a row; returns `false` if fading memory ignored it because the inputs rest.
    #[inline(always)]
    pub fn add(&mut self, memory: Memory, row: &Row<'_>, forgetting: Forgetting, rest: f32) -> bool {
        match memory {
            Memory::Segment => self.sum.update(row.cells),
            Memory::Fading => return self.add_fading(row, forgetting, rest),
        }
        true
    }

    /// Finds the first column that a memory which becomes full does not know.
    #[cold]
    #[inline(never)]
    fn fill(&mut self) {
        let columns = self.sum.columns();
        let (d, r) = self.sum.parts_mut();
        let unknown = (0..self.parameters as usize).find(|j| !is_excited((&*d, &*r), columns, *j));
        self.unexcited = unknown.and_then(|j| u8::try_from(j).ok()).unwrap_or(EXCITED);
    }

    /// The first column without a result in a full fading memory with this floor.
    #[inline(always)]
    pub fn unknown(&mut self, memory: Memory, floor: f32) -> Option<usize> {
        if memory != Memory::Fading || self.unexcited == EXCITED {
            return None;
        }
        let column = self.unexcited as usize;
        let (d, _) = self.sum.parts_mut();
        let known = d.get(column).is_none_or(|d| *d > ABOVE_FLOOR * floor);
        (!known).then_some(column)
    }

    #[inline(always)]
    fn add_fading(&mut self, row: &Row<'_>, forgetting: Forgetting, rest: f32) -> bool {
        let Forgetting { lambda, .. } = forgetting;
        self.motion += f32::min(8.0 * (1.0 - lambda), 1.0) * (row.motion - self.motion); // (1)
        // Written so that NaN freezes.
        let moving = self.motion >= rest;
        if moving {
            // While the memory fills, the floor would act as a prior that outweighs the rows.
            let filling = self.faded_rows * (1.0 - lambda) < FULL;
            let floor = if filling { PRIOR } else { forgetting.floor };
            self.sum.update_forgetting(row.cells, Forgetting { floor, ..forgetting });
            self.faded_rows = self.faded_rows * lambda + 1.0;
            if filling && self.faded_rows * (1.0 - lambda) >= FULL {
                self.fill();
            }
        }
        moving
    }

    /// The factor.
    #[cfg(test)]
    pub const fn triangle(&self) -> &PlanTriangle<P> {
        &self.sum
    }

    /// The factor, to be overwritten.
    #[inline(always)]
    pub const fn triangle_mut(&mut self) -> &mut PlanTriangle<P> {
        &mut self.sum
    }

    /// The weight of the rows; `rows` is the number of rows of the open segment.
    #[inline(always)]
    pub fn mass(&self, memory: Memory, lambda: f32, rows: u32) -> EffectiveRows {
        if memory != Memory::Fading {
            return EffectiveRows { rows: rows as f32, spread: 1.0 };
        }
        // Σλᵏ = (1 − λⁿ)/(1 − λ) and Σλ²ᵏ = (1 − λ²ⁿ)/(1 − λ²), so their ratio is (1 + λⁿ)/(1 + λ).
        let left = 1.0 - self.faded_rows * (1.0 - lambda);
        EffectiveRows { rows: self.faded_rows, spread: (1.0 + left) / (1.0 + lambda) }
    }

    /// Starts a segment: fading memory continues, other sums start empty.
    #[inline(always)]
    pub fn next_segment(&mut self, memory: Memory) {
        if memory == Memory::Fading {
            // Samples that passed a validated gate cannot cause this, but a memory that fades must not keep it for
            // ever.
            if !self.sum.is_finite() {
                self.empty();
            }
            return;
        }
        self.sum.reset();
    }

    /// Forgets all rows.
    pub fn empty(&mut self) {
        self.sum.reset();
        (self.motion, self.faded_rows, self.unexcited) = (0.0, 0.0, EXCITED);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{Layout, Method, RegressionLayout, Structure};

    crate::plan! {
        struct Endless;
        struct EndlessSample { y: "", u1: "", u2: "" }
        layout: Layout {
            regression: Some(RegressionLayout {
                structure: Structure::new(0, 1, 1, 0, 0),
                method: Method::LeastSquares,
                memory: Memory::Fading,
                y,
                u1,
                u2,
            }),
            features: 1,
            coordinates: 1,
            classes: 1,
            ..Layout::EMPTY
        }
    }

    /// Cells and motion of rows of y = 3 x₀ − 2 x₁ with some noise.
    fn rows(count: usize) -> impl Iterator<Item = ([f32; 3], f32)> {
        let mut state = 5_u32;
        let mut uniform = move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f32::from((state >> 16) as i16) / 32_768.0
        };
        (0..count).map(move |_| {
            let (a, b, e) = (uniform(), uniform(), uniform());
            ([a, b, 3.0 * a - 2.0 * b + 0.1 * e], a * a)
        })
    }

    const FORGETTING: Forgetting = Forgetting { lambda: 0.999, floor: 10.0 };

    fn add<P: Plan>(sums: &mut Sums<P>, memory: Memory, (cells, motion): ([f32; 3], f32)) -> bool {
        sums.add(memory, &Row { cells: &cells, motion }, FORGETTING, 0.01)
    }

    #[test]
    fn resting_inputs_change_nothing() {
        let mut fading = Sums::new(Endless);
        let learnt = rows(5000).filter(|row| add(&mut fading, Memory::Fading, *row)).count();
        assert!(learnt > 4900, "{learnt}: all but the start");
        let mass = fading.mass(Memory::Fading, 0.999, 0);
        // Σλᵏ → 1/(1 − λ), Σλ²ᵏ/Σλᵏ → 1/(1 + λ), up to e⁻⁵.
        assert!((mass.rows / 1000.0 - 1.0).abs() < 0.01 && (mass.spread / 0.5003 - 1.0).abs() < 0.02, "{mass:?}");
        // The mean of the motion decays first.
        let mut resting = rows(100_000).map(|(cells, _)| (cells, 0.0));
        while add(&mut fading, Memory::Fading, resting.next().unwrap()) {}
        let frozen = fading.triangle().clone();
        assert!(resting.all(|row| !add(&mut fading, Memory::Fading, row)));
        assert_eq!(fading.triangle(), &frozen);
        let woken = rows(1000).filter(|row| add(&mut fading, Memory::Fading, *row)).count();
        assert!(woken > 900, "{woken}");
    }

    /// No validated model passes such a row: the square of 1e30 is beyond the range of single precision.
    #[test]
    fn poisoned_sums_are_dropped_with_the_segment() {
        let mut fading = Sums::new(Endless);
        rows(100).for_each(|(cells, _)| assert!(add(&mut fading, Memory::Fading, (cells, 10.0))));
        add(&mut fading, Memory::Fading, ([1e30, 0.0, 0.0], 10.0));
        assert!(!fading.triangle().is_finite());
        fading.next_segment(Memory::Fading);
        assert_eq!(fading, Sums::new(Endless));
    }

    #[test]
    fn the_mass_of_a_memory_that_fills_is_that_of_its_weights() {
        let mut fading = Sums::new(Endless);
        // The mean of the motion is above rest from the first row on.
        for (n, (cells, _)) in rows(1500).enumerate() {
            assert!(add(&mut fading, Memory::Fading, (cells, 10.0)), "{n}");
            let weights = |power: i32| (0..=n as i32).map(|k| 0.999_f64.powi(power * k)).sum::<f64>();
            let (sum, squares) = (weights(1), weights(2));
            let mass = fading.mass(Memory::Fading, 0.999, 0);
            // Roundings of 1500 sums.
            assert!((f64::from(mass.rows) / sum - 1.0).abs() < 1e-4, "{n}: {mass:?}");
            assert!((f64::from(mass.spread) / (squares / sum) - 1.0).abs() < 1e-4, "{n}: {mass:?}");
        }
    }

    #[test]
    fn the_mean_motion_bridges_rows_at_rest() {
        let mut fading = Sums::new(Endless);
        // Every second row moves, by two and a half times the limit.
        let moving = (0..).map(|n: u32| if n.is_multiple_of(2) { 0.025 } else { 0.0 });
        let learnt: std::vec::Vec<bool> = rows(4000)
            .zip(moving)
            .map(|((cells, _), motion)| add(&mut fading, Memory::Fading, (cells, motion)))
            .collect();
        assert!(learnt[1000..].iter().all(|learnt| *learnt));
    }
}
