//! Angle-synchronous amplitude of the torque residual at the orders of a bearing, relative to the noise around them.
//!
//! Enters: the angle turned since the last sample, and the residual r. Leaves: the *prominence* and the amplitude of each
//! order.
//!
//! ```text
//! φ ← φ + O_q (θ − θ₋),   O_q = 2¹⁶ O, wrapping 64 bits: 2⁻⁴⁸ turns                                  (1)
//! b(h) = Σ_block r sgn(Δθ) e^{−j h φ},   h = 1 … 3                                                     (2)
//! R(h) = |Σ b(h)|² / Σ |b(h)|²,   prominence = Σ w(h) R(h) / Σ w(h)                                     (3)
//! amplitude = 2 √((|Σ b(1)|² − Σ |b(1)|²) n/(n − 1)) / N,   n blocks, N samples                         (4)
//! e^{−2jφ}: c₂ = 1 − 2 s²,  s₂ = 2 s c;      e^{−3jφ}: c₃ = (2 c₂ − 1) c,  s₃ = (2 c₂ + 1) s            (5)
//! ```
//!
//! A defect that causes a friction torque at each ball pass keeps its phase from block to block; noise does not. Without a
//! defect each R is the power of the order divided by the mean power of a band of ± one block rate around it. Its mean is
//! one and P(R > x) = (1 − x/n)ⁿ⁻¹, nearly e⁻ˣ, for any size, colour and speed dependence of the noise. The blocks serve
//! as the neighbouring orders, so no further phasors are tracked for the noise. (4) subtracts the power of the noise, and
//! does not depend on the number of blocks for a steady defect. sgn(Δθ) gives a friction torque the same sign in both
//! directions. Phases follow the angle, so the speed may vary and reverse; samples slower than `slowest_turn` advance the
//! phase but do not count.
//!
//! The blocks of order k end k samples after those of order 0, so that no sample pays for all of them.
//!
//! Cost a sample for each order: one 64-bit multiply-add, one sine and cosine by table, and 2 to 7 operations a harmonic.
//! `cargo xtask measure` prints instructions. Error of (1): 2⁻¹⁷ turns a turn from rounding O, none from adding.

use core::f32::consts::PI;

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
    /// Samples in a block: long compared with the period of the order, and at least [`MIN_BLOCKS`] blocks in a segment.
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

    /// Takes a sample: the angle turned since the last one in counts of 2⁻³² turn ([`Angle::since`](crate::Angle::since)),
    /// and the residual, if there is one; it must be finite.
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
    /// [`Reason::TooFewRows`] with fewer than [`MIN_BLOCKS`] blocks, [`Reason::NotFinite`] if the residual left the range
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

/// Points of the sine's table a turn.
const POINTS: usize = 64;

/// Sine of k/64 turns for one and a quarter turns, so that it serves for the cosine too.
static SINE: [f32; POINTS + POINTS / 4] = sine();

#[expect(clippy::indexing_slicing, clippy::cast_possible_truncation, reason = "evaluated when compiling")]
const fn sine() -> [f32; POINTS + POINTS / 4] {
    let mut table = [0.0; POINTS + POINTS / 4];
    let mut k = 0;
    while k < table.len() {
        // Within half a turn of zero, where 15 terms of the series leave less than 1e-16.
        let turns = (k as f64 - if k > POINTS / 2 { POINTS as f64 } else { 0.0 }) / POINTS as f64;
        let x = turns * core::f64::consts::TAU;
        let (mut term, mut sum, mut n) = (x, x, 1.0);
        while n < 30.0 {
            term *= -x * x / ((n + 1.0) * (n + 2.0));
            sum += term;
            n += 2.0;
        }
        table[k] = sum as f32;
        k += 1;
    }
    table
}

/// Cosine and sine of a fraction of a turn, within 2.1e-5: enough for a phasor, at half the cost of
/// [`Angle::sin_cos`](crate::Angle::sin_cos). From the nearest point a of the table, at distance t:
///
/// ```text
/// sin(a + t) ≈ (1 − t²/2) sin a + t cos a,   cos(a + t) ≈ (1 − t²/2) cos a − t sin a,   |t³/6| ≤ 2.0e-5
/// ```
#[inline(always)]
fn phasor(bits: u32) -> (f32, f32) {
    let place = (bits.wrapping_add(0x0200_0000) >> 26) as usize;
    let entry = |place: usize| SINE.get(place).copied().unwrap_or(0.0);
    let (sin, cos) = (entry(place), entry(place.wrapping_add(POINTS / 4)));
    let t = (bits << 6).cast_signed() as f32 * (PI / 2_147_483_648.0 / 64.0);
    let less = 1.0 - 0.5 * t * t;
    (less * cos - t * sin, less * sin + t * cos)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{Layout, ShaftLayout};

    const TURN: f64 = 4_294_967_296.0;

    crate::plan! {
        struct One;
        struct Moved with angle { current: "A", velocity: "rad/s" }
        layout: Layout {
            shaft: Some(ShaftLayout {
                current,
                velocity,
                reference: velocity,
                load: None,
                orders: 1,
                harmonics: 1,
            }),
            features: 1,
            coordinates: 1,
            classes: 1,
            ..Layout::EMPTY
        }
    }

    type Track = OrderTracking<One>;

    const fn tracking(order: f32) -> Tracking<One> {
        let orders = [TrackedOrder::new(order, [1.0, 0.0, 0.0])];
        Tracking { orders, slowest_turn: 1000, block_samples: 100 }
    }

    fn strength(track: &Track, tracking: &Tracking<One>) -> Result<OrderStrength, Reason> {
        track.sums().strength(tracking, 0)
    }

    /// Turns of a shaft that speeds up, reverses and comes back, at most 0.03 a sample; 14-bit angles.
    fn angle(k: u32) -> u32 {
        let t = f64::from(k) * 1e-3;
        let turns = 12.0 * (0.7 * t).sin() + 2.0 * t;
        ((turns * 16_384.0).floor() as i32).cast_unsigned() << 18
    }

    #[test]
    fn phase_is_that_of_the_turned_way_over_thousands_of_turns_and_reversals() {
        let tracking = tracking(3.717_94);
        let mut track = Track::new(One);
        let (mut last, mut way, mut turned) = (angle(0), 0.0_f64, 0.0_f64);
        for k in 1..2_000_000 {
            let now = angle(k);
            let step = now.wrapping_sub(last).cast_signed();
            last = now;
            way += f64::from(step);
            turned += f64::from(step).abs() / TURN;
            track.step(1, &tracking, step, None);
        }
        assert!(turned > 10_000.0, "{turned}");
        let order = f64::from(tracking.orders[0].order_q16) / 65_536.0;
        let exact = order * (way / TURN);
        let phase = ((track.lines[0].phase >> 16) & 0xFFFF_FFFF) as f64;
        let error = (exact - exact.floor()) - phase / TURN;
        // The oracle adds in double precision: 2e6 roundings of 1e-16 × 4e13 counts stay below 1e-6 turns.
        assert!((error - error.round()).abs() < 1e-5, "{error}");
    }

    #[test]
    fn drag_at_the_order_stands_out_by_the_number_of_blocks() {
        let tracking = tracking(3.717_94);
        for (order, expected) in [(3.717_94_f64, 400.0), (4.1, 0.1)] {
            let mut track = Track::new(One);
            let mut last = angle(0);
            let mut way = 0.0_f64;
            for k in 1..60_000 {
                let now = angle(k);
                let step = now.wrapping_sub(last).cast_signed();
                last = now;
                way += f64::from(step) / TURN;
                // A drag of 0.5 at the order, against the motion.
                let drag = 0.5 * (core::f64::consts::TAU * order * way + 1.0).cos() * f64::from(step.signum());
                track.step(1, &tracking, step, Some(drag as f32));
            }
            let strength = strength(&track, &tracking).unwrap();
            if expected > 1.0 {
                // Every block alike: R is their number (still samples aside), the amplitude what was put in.
                assert!(strength.prominence > expected && (strength.amplitude - 0.5).abs() < 2e-3, "{strength:?}");
            } else {
                assert!(strength.prominence < 3.0 && strength.amplitude < 0.02, "{strength:?}");
            }
        }
    }

    #[test]
    fn amplitude_is_that_of_the_drag_with_few_blocks_too() {
        let tracking = tracking(3.717_94);
        let mut track = Track::new(One);
        let mut way = 0.0_f64;
        // Eight blocks, a fraction of a turn each sample that closes no block at a whole period.
        for _ in 0..800 {
            let step = 43_000_000;
            way += f64::from(step) / TURN;
            let drag = 0.5 * (core::f64::consts::TAU * 3.717_94 * way).cos();
            track.step(1, &tracking, step, Some(drag as f32));
        }
        let strength = strength(&track, &tracking).unwrap();
        // The mirror image at −O leaves 1/(π periods a block) of a block: 3.7 periods, 9 %, of changing phase.
        assert!((strength.amplitude - 0.5).abs() < 0.01 && strength.prominence > 7.8, "{strength:?}");
    }

    #[test]
    fn phasor_is_that_of_the_angle_everywhere() {
        let strided = (0..1_u32 << 20).map(|k| k.wrapping_mul(4093));
        let edges = (0..128_u32).flat_map(|half| (-64_i32..=64).map(move |k| (half << 25).wrapping_add_signed(k)));
        let error = |bits: u32| {
            let exact = core::f64::consts::TAU * f64::from(bits) / TURN;
            let (cos, sin) = phasor(bits);
            (f64::from(cos) - exact.cos()).abs().max((f64::from(sin) - exact.sin()).abs())
        };
        let worst = strided.chain(edges).map(error).fold(0.0, f64::max);
        assert!(worst < 2.1e-5 && worst > 1.8e-5, "{worst}");
    }

    #[test]
    fn too_short_and_out_of_range_are_reasons() {
        let tracking = tracking(3.7);
        let mut track = Track::new(One);
        assert_eq!(strength(&track, &tracking), Err(Reason::TooFewRows { part: Part::Orders, rows: 0 }));
        for _ in 0..2000 {
            track.step(1, &tracking, 1 << 20, Some(1e30));
        }
        assert_eq!(strength(&track, &tracking), Err(Reason::NotFinite(Part::Orders)));
        track.next_segment();
        for _ in 0..2000 {
            track.step(1, &tracking, 1 << 20, Some(0.0));
        }
        assert_eq!(strength(&track, &tracking).unwrap().prominence, 0.0);
    }

    #[test]
    fn harmonics_are_those_of_the_angle() {
        for k in 0..1000_u32 {
            let mut line = Line { phase: i64::from(k) << 38, block: [[0.0; 2]; MAX_HARMONICS], sums: LineSums::EMPTY };
            line.add(3, 1.0);
            for (h, [x, y]) in (1_u8..).zip(line.block) {
                let angle = core::f64::consts::TAU * f64::from(k) / 1024.0 * f64::from(h);
                let (dx, dy) = (f64::from(x) - angle.cos(), f64::from(y) + angle.sin());
                // Three times the error of the phasor.
                assert!(dx.abs() < 7e-5 && dy.abs() < 7e-5, "{k} {h}: {x} {y}");
            }
        }
    }

    #[test]
    fn blocks_of_later_orders_end_later() {
        crate::plan! {
            struct Two;
            struct Sample with angle { current: "A", velocity: "rad/s" }
            layout: Layout {
                shaft: Some(ShaftLayout { current, velocity, reference: velocity, load: None, orders: 2, harmonics: 2 }),
                features: 1,
                coordinates: 1,
                classes: 1,
                ..Layout::EMPTY
            }
        }
        let orders = [TrackedOrder::new(3.7, [1.0, 0.5, 0.0]); 2];
        let tracking = Tracking::<Two> { orders, slowest_turn: 1000, block_samples: 100 };
        let mut track = OrderTracking::new(Two);
        for k in 0..1000_u16 {
            track.step(2, &tracking, 1 << 24, Some(f32::from(k % 7)));
        }
        let sums = track.sums();
        assert_eq!((sums.closed(100, 0), sums.closed(100, 1)), ((10, 1000), (9, 901)));
        track.step(2, &tracking, 1 << 24, Some(1.0));
        let sums = track.sums();
        assert_eq!((sums.closed(100, 0), sums.closed(100, 1)), ((10, 1000), (10, 1001)));
        assert_ne!(sums.lines[0], sums.lines[1]);
    }
}
