//! Angle-synchronous amplitude of the torque residual at the bearing's orders, beside the noise around them.
//!
//! Enters: the way the shaft turned since the last sample, and the residual r. Leaves: for each order its *prominence* and
//! its amplitude.
//!
//! ```text
//! φ ← φ + O_q (θ − θ₋),   O_q = 2¹⁶ O, wrapping 64 bits: 2⁻⁴⁸ turns                                  (1)
//! b(h) = Σ_block r sgn(Δθ) e^{−j h φ},   h = 1 … 3                                                     (2)
//! R(h) = |Σ b(h)|² / Σ |b(h)|²,   prominence = Σ w(h) R(h) / Σ w(h)                                     (3)
//! amplitude = 2 √((|Σ b(1)|² − Σ |b(1)|²) n/(n − 1)) / N,   n blocks, N samples                         (4)
//! ```
//!
//! A defect that drags once a ball keeps its phase from block to block, noise does not: without a defect each R is the
//! power of the order beside the mean power of a band of ± one block rate around it. Its mean is one and P(R > x) =
//! (1 − x/n)ⁿ⁻¹, nearly e⁻ˣ, whatever the noise's size, colour or dependence on speed. The blocks are the neighbouring
//! orders: no further phasors are tracked for the noise. (4) takes the noise's power off, and is that of a steady defect
//! however many blocks there are. sgn(Δθ) makes a drag the same in both directions. Phases follow the angle, so that speed
//! may vary and reverse; samples slower than `still` turn the phase but do not count.
//!
//! Cost a sample: one 64-bit multiply-add, one sine and cosine by table, and 2 to 6 multiply-adds a harmonic for each order.
//! `cargo xtask measure` prints instructions. Error of (1): 2⁻¹⁷ turns a turn from rounding O, nothing from adding.

use core::f32::consts::PI;

use super::Reason;

/// Harmonics of an order that may count.
pub const MAX_HARMONICS: usize = 3;
/// Fewer blocks tell no noise.
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
    /// No order: the place is not in use.
    pub const NONE: Self = Self { order_q16: 0, weights: [0.0; MAX_HARMONICS] };

    /// From events a turn, at most 1e4, and the weights of the harmonics.
    #[must_use]
    #[expect(
        clippy::cast_possible_truncation,
        reason = "`as` takes NaN to zero and what is beyond the range to its ends"
    )]
    pub const fn new(order: f32, weights: [f32; MAX_HARMONICS]) -> Self {
        Self { order_q16: (order * 65_536.0 + 0.5) as i32, weights }
    }

    /// Events a turn.
    #[must_use]
    pub const fn order(&self) -> f32 {
        self.order_q16 as f32 / 65_536.0
    }
}

/// What is tracked, at most `K` orders.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Tracking<const K: usize> {
    /// The orders.
    pub orders: [TrackedOrder; K],
    /// Orders in use.
    pub count: u8,
    /// Harmonics that are computed, 1 … 3.
    pub harmonics: u8,
    /// Turn a sample, in counts of 2⁻³² turn, up to which the shaft counts as still.
    pub still: u32,
    /// Samples a block, still ones not counted: long beside the period of the order, and at least [`MIN_BLOCKS`] of them a segment.
    pub block_samples: u16,
}

/// How much an order stands out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct OrderStrength {
    /// (3): about one without a defect, at most the number of blocks.
    pub prominence: f32,
    /// (4), in units of the residual; zero where it does not exceed the noise.
    pub amplitude: f32,
}

/// One order's phase and sums.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Line {
    /// φ of (1).
    phase: i64,
    /// b of (2).
    block: [[f32; 2]; MAX_HARMONICS],
    /// Σ b.
    sum: [[f32; 2]; MAX_HARMONICS],
    /// Σ |b|².
    power: [f32; MAX_HARMONICS],
}

const EMPTY: Line =
    Line { phase: 0, block: [[0.0; 2]; MAX_HARMONICS], sum: [[0.0; 2]; MAX_HARMONICS], power: [0.0; MAX_HARMONICS] };

/// Running state.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct OrderTracking<const K: usize> {
    lines: [Line; K],
    /// Samples in the open block.
    pending: u16,
    /// Closed blocks.
    blocks: u16,
    /// Samples in closed blocks.
    samples: u32,
}

impl<const K: usize> Default for OrderTracking<K> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const K: usize> OrderTracking<K> {
    /// Nothing seen yet.
    #[must_use]
    pub const fn new() -> Self {
        Self { lines: [EMPTY; K], pending: 0, blocks: 0, samples: 0 }
    }

    /// Takes a sample: the way turned since the last one in counts of 2⁻³² turn ([`Angle::since`](crate::Angle::since)), and the residual, if there is
    /// one. A residual that is not finite must not be given.
    #[inline]
    pub fn step(&mut self, tracking: &Tracking<K>, turned: i32, residual: Option<f32>) {
        let residual = match residual {
            Some(residual) if turned.unsigned_abs() > tracking.still => {
                self.pending += 1;
                if turned < 0 { -residual } else { residual }
            }
            _ => {
                for (line, order) in self.lines.iter_mut().zip(&tracking.orders).take(tracking.count as usize) {
                    line.turn(order, turned);
                }
                return;
            }
        };
        for (line, order) in self.lines.iter_mut().zip(&tracking.orders).take(tracking.count as usize) {
            line.turn(order, turned);
            line.add(tracking.harmonics, residual);
        }
        if self.pending >= tracking.block_samples {
            self.close_block(tracking);
        }
    }

    #[inline(never)]
    fn close_block(&mut self, tracking: &Tracking<K>) {
        for line in self.lines.iter_mut().take(tracking.count as usize) {
            line.close_block(tracking.harmonics);
        }
        self.samples = self.samples.saturating_add(u32::from(self.pending));
        self.blocks = self.blocks.saturating_add(1);
        self.pending = 0;
    }

    /// Samples that count so far, those of the open block aside.
    #[must_use]
    pub const fn samples(&self) -> u32 {
        self.samples
    }

    /// Strengths from the closed blocks, leaving the segment open. Places not in use are zero.
    ///
    /// # Errors
    /// [`Reason::TooFewRows`] with fewer than [`MIN_BLOCKS`] blocks, [`Reason::NotFinite`] where the residual left the range of `f32`.
    pub fn strengths(&self, tracking: &Tracking<K>) -> Result<[OrderStrength; K], Reason> {
        if self.blocks < MIN_BLOCKS && tracking.count > 0 {
            return Err(Reason::TooFewRows);
        }
        let mut strengths = [OrderStrength::default(); K];
        let used = tracking.orders.iter().zip(&self.lines).take(tracking.count as usize);
        for (strength, (order, line)) in strengths.iter_mut().zip(used) {
            *strength = line.strength(order, (self.blocks, self.samples));
            if !(strength.prominence + strength.amplitude).is_finite() {
                return Err(Reason::NotFinite);
            }
        }
        Ok(strengths)
    }

    /// Starts a segment; phases go on.
    pub const fn next_segment(&mut self) {
        let mut k = 0;
        while let Some((_, rest)) = self.lines.split_at_mut_checked(k) {
            let Some(line) = rest.first_mut() else { break };
            *line = Line { phase: line.phase, ..EMPTY };
            k += 1;
        }
        (self.pending, self.blocks, self.samples) = (0, 0, 0);
    }
}

impl Line {
    #[inline(always)]
    fn turn(&mut self, order: &TrackedOrder, turned: i32) {
        self.phase = self.phase.wrapping_add(i64::from(order.order_q16) * i64::from(turned)); // (1)
    }

    #[inline(always)]
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the fraction of a turn, on purpose")]
    fn add(&mut self, harmonics: u8, residual: f32) {
        let (cos, sin) = phasor((self.phase >> 16) as u32);
        let (mut re, mut im) = (cos, sin);
        for (h, block) in self.block.iter_mut().enumerate().take(harmonics as usize) {
            if h > 0 {
                (re, im) = (re * cos - im * sin, re * sin + im * cos);
            }
            let [x, y] = block;
            *x += residual * re; // (2)
            *y -= residual * im;
        }
    }

    fn close_block(&mut self, harmonics: u8) {
        let sums = self.sum.iter_mut().zip(&mut self.power);
        for (block, (sum, power)) in self.block.iter_mut().zip(sums).take(harmonics as usize) {
            let [x, y] = core::mem::take(block);
            let [sx, sy] = sum;
            *sx += x;
            *sy += y;
            *power += x * x + y * y;
        }
    }

    fn strength(&self, order: &TrackedOrder, (blocks, samples): (u16, u32)) -> OrderStrength {
        let (mut prominence, mut weights) = (0.0, 0.0);
        let mut first = 0.0;
        let harmonics = self.sum.iter().zip(&self.power).zip(&order.weights).enumerate();
        for (h, (([x, y], power), weight)) in harmonics {
            let square = x * x + y * y;
            if *power > 0.0 {
                prominence += weight * square / power; // (3)
            }
            weights += weight;
            if h == 0 {
                first = square - power;
            }
        }
        let blocks = f32::from(blocks.max(2));
        let steady = first.max(0.0) * (blocks / (blocks - 1.0));
        let amplitude = 2.0 * libm::sqrtf(steady) / (samples.max(1) as f32); // (4)
        OrderStrength { prominence: prominence / weights, amplitude }
    }
}

/// Points of the sine's table a turn.
const POINTS: usize = 64;

/// Sine of k/64 turns, and a quarter of a turn more for the cosine.
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

/// Cosine and sine of a fraction of a turn, within 2.1e-5: plenty for a phasor, and half the work of
/// [`Angle::sin_cos`](crate::Angle::sin_cos). From the nearest point a of the table, t away:
///
/// ```text
/// sin(a + t) ≈ (1 − t²/2) sin a + t cos a,   cos(a + t) ≈ (1 − t²/2) cos a − t sin a,   |t³/6| ≤ 2.0e-5
/// ```
#[inline(always)]
fn phasor(bits: u32) -> (f32, f32) {
    let place = (bits.wrapping_add(0x0200_0000) >> 26) as usize;
    let entry = |place: usize| SINE.get(place).copied().unwrap_or(0.0);
    let (sin, cos) = (entry(place), entry(place + POINTS / 4));
    let t = (bits << 6).cast_signed() as f32 * (PI / 2_147_483_648.0 / 64.0);
    let less = 1.0 - 0.5 * t * t;
    (less * cos - t * sin, less * sin + t * cos)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TURN: f64 = 4_294_967_296.0;

    const fn tracking(order: f32) -> Tracking<1> {
        Tracking {
            orders: [TrackedOrder::new(order, [1.0, 0.0, 0.0])],
            count: 1,
            harmonics: 1,
            still: 1000,
            block_samples: 100,
        }
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
        let mut track = OrderTracking::<1>::new();
        let (mut last, mut way, mut turned) = (angle(0), 0.0_f64, 0.0_f64);
        for k in 1..2_000_000 {
            let now = angle(k);
            let step = now.wrapping_sub(last).cast_signed();
            last = now;
            way += f64::from(step);
            turned += f64::from(step).abs() / TURN;
            track.step(&tracking, step, None);
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
            let mut track = OrderTracking::<1>::new();
            let mut last = angle(0);
            let mut way = 0.0_f64;
            for k in 1..60_000 {
                let now = angle(k);
                let step = now.wrapping_sub(last).cast_signed();
                last = now;
                way += f64::from(step) / TURN;
                // A drag of 0.5 at the order, against the motion.
                let drag = 0.5 * (core::f64::consts::TAU * order * way + 1.0).cos() * f64::from(step.signum());
                track.step(&tracking, step, Some(drag as f32));
            }
            let [strength] = track.strengths(&tracking).unwrap();
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
        let mut track = OrderTracking::<1>::new();
        let mut way = 0.0_f64;
        // Eight blocks, a fraction of a turn each sample that closes no block at a whole period.
        for _ in 0..800 {
            let step = 43_000_000;
            way += f64::from(step) / TURN;
            let drag = 0.5 * (core::f64::consts::TAU * 3.717_94 * way).cos();
            track.step(&tracking, step, Some(drag as f32));
        }
        let [strength] = track.strengths(&tracking).unwrap();
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
        let mut track = OrderTracking::<1>::new();
        assert_eq!(track.strengths(&tracking), Err(Reason::TooFewRows));
        for _ in 0..2000 {
            track.step(&tracking, 1 << 20, Some(1e30));
        }
        assert_eq!(track.strengths(&tracking), Err(Reason::NotFinite));
        track.next_segment();
        for _ in 0..2000 {
            track.step(&tracking, 1 << 20, Some(0.0));
        }
        assert_eq!(track.strengths(&tracking).unwrap()[0].prominence, 0.0);
    }
}
