//! Angle-synchronous amplitude of the torque residual at the orders of a bearing, relative to the noise around them.
//!
//! Enters: the angle turned since the last sample, and the residual r. Leaves: the *prominence* and the amplitude of
//! each order.
//!
//! ```text
//! φ ← φ + O_q (θ − θ₋),   O_q = 2¹⁶ O, wrapping 64 bits: 2⁻⁴⁸ turns                                  (1)
//! b(h) = Σ_block r sgn(Δθ) e^{−j h φ},   h = 1 … 3                                                     (2)
//! R(h) = |Σ b(h)|² / Σ |b(h)|²,   prominence = Σ w(h) R(h) / Σ w(h)                                     (3)
//! amplitude = 2 √((|Σ b(1)|² − Σ |b(1)|²) n/(n − 1)) / N,   n blocks, N samples                         (4)
//! e^{−2jφ}: c₂ = 1 − 2 s²,  s₂ = 2 s c;      e^{−3jφ}: c₃ = (2 c₂ − 1) c,  s₃ = (2 c₂ + 1) s            (5)
//! ```
//!
//! A defect that causes a friction torque at each ball pass keeps its phase from block to block; noise does not.
//! Without a defect each R is the power of the order divided by the mean power of a band of ± one block rate around it.
//! Its mean is one and P(R > x) = (1 − x/n)ⁿ⁻¹, nearly e⁻ˣ, for any size, colour and speed dependence of the noise. The
//! blocks serve as the neighbouring orders, so no further phasors are tracked for the noise. (4) subtracts the power of
//! the noise, and does not depend on the number of blocks for a steady defect. sgn(Δθ) gives a friction torque the same
//! sign in both directions. Phases follow the angle, so the speed may vary and reverse; samples slower than
//! `slowest_turn` advance the phase but do not count.
//!
//! The blocks of order k end k samples after those of order 0, so that no sample pays for all of them.
//!
//! Cost a sample for each order: one 64-bit multiply-add, one sine and cosine by table, and 2 to 7 operations a
//! harmonic. `cargo xtask measure` prints instructions. Error of (1): 2⁻¹⁷ turns a turn from rounding O, none from
//! adding.

use super::phasor::phasor;
use crate::plan::{Array, Cells, MAX_HARMONICS, Plan, Size};
use crate::reason::{Part, Reason};

/// Fewer blocks than this do not determine the noise.
pub const MIN_BLOCKS: u16 = 8;

/// An order to track.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TrackedOrder {
    /// `O_q` of (1).
    pub order_q16: i32,
    /// w(h) of (3); none negative, not all zero.
    pub weights: [f32; MAX_HARMONICS],
}

impl TrackedOrder {
    /// From the order in events a turn, at most 1e4, and the weights of the harmonics.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, reason = "`as` maps NaN to zero and what is out of range to the ends")]
    pub const fn new(order: f32, weights: [f32; MAX_HARMONICS]) -> Self {
        Self { order_q16: (order * 65_536.0 + 0.5) as i32, weights }
    }

    /// The order in events a turn.
    #[must_use]
    pub const fn order(&self) -> f32 {
        self.order_q16 as f32 / 65_536.0
    }
}

/// The orders and the blocks.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Tracking<P: Plan> {
    /// The orders.
    pub orders: Array<P::Orders, TrackedOrder>,
    /// Angle a sample, in counts of 2⁻³² turn, up to which a sample does not count.
    pub slowest_turn: u32,
    /// Samples in a block: long compared with the period of the order, and at least 8 blocks in a segment.
    pub block_samples: u16,
}

/// How much an order exceeds the noise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct OrderStrength {
    /// (3): about one without a defect, at most the number of blocks.
    pub prominence: f32,
    /// (4), in units of the residual; zero if it does not exceed the noise.
    pub amplitude: f32,
}

/// Sums of one order over the blocks of a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct LineSums {
    /// Σ b.
    sum: [[f32; 2]; MAX_HARMONICS],
    /// Σ |b|².
    power: [f32; MAX_HARMONICS],
}

impl LineSums {
    const EMPTY: Self = Self { sum: [[0.0; 2]; MAX_HARMONICS], power: [0.0; MAX_HARMONICS] };
}

/// Phase and sums of one order.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Line {
    /// φ of (1).
    phase: i64,
    /// b of (2).
    block: [[f32; 2]; MAX_HARMONICS],
    sums: LineSums,
}

/// Running state.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct OrderTracking<P: Plan> {
    lines: Array<P::Orders, Line>,
    /// Samples in the open block of order 0.
    pending: u16,
    /// Closed blocks of order 0.
    blocks: u16,
}

/// The sums of a segment, separate from the running state.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct OrderSums<P: Plan> {
    lines: Array<P::Orders, LineSums>,
    pending: u16,
    blocks: u16,
}

impl<P: Plan> OrderTracking<P> {
    pub(super) fn new(plan: P) -> Self {
        let line = Line { phase: 0, block: [[0.0; 2]; MAX_HARMONICS], sums: LineSums::EMPTY };
        Self { lines: Cells::filled(plan.layout().orders(), line), pending: 0, blocks: 0 }
    }

    /// Takes a sample: the angle turned since the last one in counts of 2⁻³² turn
    /// ([`Angle::since`](crate::Angle::since)), and the residual, if there is one; it must be finite.
    #[inline(always)]
    pub(super) fn step(&mut self, harmonics: u8, tracking: &Tracking<P>, turned: i32, residual: Option<f32>) {
        let (mut lines, mut orders) = (self.lines.cells_mut(), tracking.orders.cells());
        let residual = match residual {
            Some(residual) if turned.unsigned_abs() > tracking.slowest_turn => {
                if turned < 0 {
                    -residual
                } else {
                    residual
                }
            }
            _ => {
                while let ([line, rest @ ..], [order, later @ ..]) = (lines, orders) {
                    line.turn(order, turned);
                    (lines, orders) = (rest, later);
                }
                return;
            }
        };
        while let ([line, rest @ ..], [order, later @ ..]) = (lines, orders) {
            line.turn(order, turned);
            line.add(harmonics, residual);
            (lines, orders) = (rest, later);
        }
        self.pending = self.pending.wrapping_add(1);
        if self.pending >= tracking.block_samples {
            self.pending = 0;
            self.blocks = self.blocks.saturating_add(1);
        }
        // The first block of order k is k samples longer.
        if self.blocks > 0
            && let Some(line) = self.lines.cells_mut().get_mut(self.pending as usize)
        {
            line.close_block(harmonics);
        }
    }

    /// A copy of the sums.
    #[inline(always)]
    pub(super) fn sums(&self) -> OrderSums<P> {
        OrderSums { lines: P::Orders::map(&self.lines, |line| line.sums), pending: self.pending, blocks: self.blocks }
    }

    /// Starts a segment; phases continue.
    #[inline(always)]
    pub(super) fn next_segment(&mut self) {
        for line in self.lines.cells_mut() {
            (line.block, line.sums) = ([[0.0; 2]; MAX_HARMONICS], LineSums::EMPTY);
        }
        (self.pending, self.blocks) = (0, 0);
    }
}

impl<P: Plan> OrderSums<P> {
    /// Closed blocks of order k, and their samples.
    fn closed(&self, block_samples: u16, k: usize) -> (u16, u32) {
        let blocks = if self.pending as usize >= k { self.blocks } else { self.blocks.saturating_sub(1) };
        let samples = u32::from(blocks).wrapping_mul(u32::from(block_samples));
        (blocks, samples.saturating_add(u32::try_from(k).unwrap_or(0)))
    }

    /// The strength of order k.
    ///
    /// # Errors
    /// [`Reason::TooFewRows`] with fewer than 8 blocks, [`Reason::NotFinite`] if the residual left the range
    /// of `f32`.
    #[inline(never)]
    pub(super) fn strength(&self, tracking: &Tracking<P>, k: usize) -> Result<OrderStrength, Reason> {
        let (blocks, samples) = self.closed(tracking.block_samples, k);
        if blocks < MIN_BLOCKS {
            return Err(Reason::TooFewRows { part: Part::Orders, rows: u32::from(blocks) });
        }
        let none = OrderStrength::default();
        let (Some(line), Some(order)) = (self.lines.cells().get(k), tracking.orders.cells().get(k)) else {
            return Ok(none);
        };
        let strength = line.strength(order, f32::from(blocks), samples as f32);
        let finite = (strength.prominence + strength.amplitude).is_finite();
        if finite { Ok(strength) } else { Err(Reason::NotFinite(Part::Orders)) }
    }
}

impl LineSums {
    fn strength(&self, order: &TrackedOrder, blocks: f32, samples: f32) -> OrderStrength {
        let (mut prominence, mut weights, mut first) = (0.0, 0.0, None);
        let harmonics = self.sum.iter().zip(&self.power).zip(&order.weights);
        for (([x, y], power), weight) in harmonics {
            let square = x * x + y * y;
            if *power > 0.0 {
                prominence += weight * square / power; // (3)
            }
            weights += weight;
            first = first.or(Some(square - power));
        }
        let steady = first.unwrap_or(0.0).max(0.0) * (blocks / (blocks - 1.0));
        OrderStrength { prominence: prominence / weights, amplitude: 2.0 * libm::sqrtf(steady) / samples } // (4)
    }
}

impl Line {
    #[inline(always)]
    fn turn(&mut self, order: &TrackedOrder, turned: i32) {
        let way = i64::from(order.order_q16).wrapping_mul(i64::from(turned));
        self.phase = self.phase.wrapping_add(way); // (1)
    }

    #[inline(always)]
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "takes the fraction of a turn")]
    fn add(&mut self, harmonics: u8, residual: f32) {
        let (cos, sin) = phasor((self.phase >> 16) as u32);
        let add = |[x, y]: &mut [f32; 2], cos: f32, sin: f32| {
            *x += residual * cos; // (2)
            *y -= residual * sin;
        };
        let [first, second, third] = &mut self.block;
        add(first, cos, sin);
        if harmonics < 2 {
            return;
        }
        let twice = sin + sin; // (5)
        let (cos_2, sin_2) = (1.0 - twice * sin, twice * cos);
        add(second, cos_2, sin_2);
        if harmonics < 3 {
            return;
        }
        let double = cos_2 + cos_2;
        add(third, (double - 1.0) * cos, (double + 1.0) * sin);
    }

    #[inline(always)]
    fn close_block(&mut self, harmonics: u8) {
        let LineSums { sum, power } = &mut self.sums;
        let sums = sum.iter_mut().zip(power);
        for (block, (sum, power)) in self.block.iter_mut().zip(sums).take(harmonics as usize) {
            let [x, y] = core::mem::take(block);
            let [sx, sy] = sum;
            *sx += x;
            *sy += y;
            *power += x * x + y * y;
        }
    }
}

#[cfg(test)]
mod tests;
