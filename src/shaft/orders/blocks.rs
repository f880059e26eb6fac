//! The orders to track, and how blocks of them are formed and compared.

use crate::plan::{Array, MAX_HARMONICS, ShaftLengths};
use crate::record::{BELOW_ONE, record};

/// Blocks back to which products are formed, and cells apart up to which they are kept.
pub const LAGS: usize = PLACES as usize;
pub(super) const PLACES: u8 = 6;
/// Number of control orders.
pub const CONTROLS: usize = 4;
/// Fewer blocks than this do not determine noise and phase.
pub const MIN_BLOCKS: u32 = 4;
/// Most blocks of a segment: sums of more in single precision would lose digits. [`least_steps`] bounds them.
pub const MAX_BLOCKS: u32 = 1_000_000;

/// Orders beyond this would turn more than half a turn between samples at any speed that can be tracked.
const MAX_ORDER_Q16: i32 = 1000 << 16;

/// Steps that a block takes at least: one finds its end, and then each closes an order and harmonic, a control order,
/// or the block.
pub const fn least_steps(orders: u8, harmonics: u8) -> u64 {
    (orders as u64).saturating_mul(harmonics as u64).saturating_add(CONTROLS as u64 + 2)
}

record! {
    /// An order to track.
    #[derive(Clone, Copy, Debug, PartialEq)]
    #[cfg_attr(feature = "defmt", derive(defmt::Format))]
    pub struct TrackedOrder: BearingOrder {
        /// `O_q` of (1).
        pub order_q16: i32 in [1, MAX_ORDER_Q16],
        /// Weights of the harmonics; none negative, not all zero.
        pub weights: [f32; MAX_HARMONICS],
        /// Relative change of this order for a relative change of one of the cage's order. Ball passes of the outer
        /// ring have 1, those of the inner ring −outer/inner.
        pub slip_ratio: f32 in [-10.0, 10.0],
        /// The expected score of the smallest defect that counts as found.
        pub needed_score: f32 in [-1e6, 1e6],
        /// Largest amplitude of that defect, over the deviation of the noise at the order, with which the order still
        /// has a result: beyond it the shaft has turned too little.
        pub most_relative: f32 in [f32::MIN_POSITIVE, f32::INFINITY],
        /// Largest amplitude of that defect, A, with which a segment may be called healthy: beyond it the noise is too
        /// large.
        pub most_a: f32 in [f32::MIN_POSITIVE, f32::INFINITY],
    }
}

/// [`TrackedOrder::needed_score`] of an order of which no gate is known.
const PLAIN_SCORE: f32 = 4.0;

impl TrackedOrder {
    /// From the order in events a turn, at most 1e4, and the weights of the harmonics; it slips as the cage does. Any
    /// segment has a result.
    #[must_use]
    pub const fn new(order: f32, weights: [f32; MAX_HARMONICS]) -> Self {
        let (needed_score, most_relative, most_a) = (PLAIN_SCORE, f32::INFINITY, f32::INFINITY);
        Self { order_q16: q16(order), weights, slip_ratio: 1.0, needed_score, most_relative, most_a }
    }

    /// The order in events a turn.
    #[must_use]
    pub const fn order(&self) -> f32 {
        self.order_q16 as f32 / 65_536.0
    }
}

/// An order in counts of 2⁻¹⁶.
#[must_use]
#[expect(clippy::cast_possible_truncation, reason = "`as` maps NaN to zero and what is out of range to the ends")]
pub const fn q16(order: f32) -> i32 {
    (order * 65_536.0 + 0.5) as i32
}

/// The orders and the blocks.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Tracking<P: ShaftLengths> {
    /// The orders.
    pub orders: Array<P::Orders, TrackedOrder>,
    /// Blocks, slip and noise.
    pub blocks: Blocks,
}

record! {
    /// How blocks are formed and compared.
    #[derive(Clone, Copy, Debug, PartialEq)]
    #[cfg_attr(feature = "defmt", derive(defmt::Format))]
    pub struct Blocks: OrderBlock {
        /// Orders at which no bearing and no rotor has an effect, in counts of 2⁻¹⁶.
        pub controls: [i32; CONTROLS] in [1, MAX_ORDER_Q16],
        /// Width of a cell is 2ⁿ turns.
        pub cell_turns_log2: i8 in [-6, 10],
        /// Largest relative slip of the cage that is searched.
        pub slip: f32 in [0.0, 0.1],
        /// Velocity `ω_g` up to which a sample does not count; from twice that on it counts fully.
        pub slowest_rad_s: f32 in [1e-6, 1e6],
        /// α of the residual's filter.
        pub pole: f32 in [0.0, BELOW_ONE],
        /// γ of the residual's high-pass; 0 for none.
        pub high_pass: f32 in [0.0, BELOW_ONE],
    }
}

impl Blocks {
    /// Without orders.
    pub const EMPTY: Self = Self {
        controls: [1 << 16; CONTROLS],
        cell_turns_log2: 0,
        slip: 0.0,
        slowest_rad_s: 1.0,
        pole: 0.0,
        high_pass: 0.0,
    };
}
