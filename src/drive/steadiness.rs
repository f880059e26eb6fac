//! Readings of the position that a locked loop would follow although they are wrong: stale, slipped, at unequal times,
//! with a bit that is stuck.
//!
//! ```text
//! stale:     reading(n) = reading(n − 1)  after a motion of 8 Δ or more in a sample        (1)
//! slipped:   |e(n) − e(n − 1)| > limit/4                                                    (2)
//! unsteady:  Σ (e(n) − e(n−1))² > max(0.02 Σ ω̂², n (limit/50)²)                             (3)
//! stuck:     a bit of the reading that does not change, between two that do, of at least six (4)
//! ```
//!
//! ω̂ is the motion of the loop in a sample, e its error, *limit* its largest one. Δ is the step of a converter, which
//! is the lowest bit that was ever set, at least 2⁻¹⁴ turn; of a resolver 2⁻¹³ turn. No shaft stops from 8 Δ within a
//! sample, but at a stop of the mechanics: the lock is then lost, and found again. An error τ of the instant moves the
//! reading by ω τ: with independent errors of σ intervals the sum of (3) is 2 σ² Σ ω̂², and (3) is σ > 0.1. The second
//! limit is for sensors whose noise does not depend on the speed. The error of the loop changes by the noise of the
//! sensor and by what the loop corrects, which is far below (2).
//!
//! A shaft that changes a bit of the counts changes all bits below it (4), down to the resolution. Bits are compared
//! over four windows, of 2⁻¹⁴ turn or more; with a bit that is stuck, samples are missing until a later comparison is
//! better. A number of counts a turn that is no power of two hides the bits of its counter.
//!
//! Cost: about forty-five instructions a sample.

use super::position::{Position, Tracked};
use crate::signal::{Angle, RAD};

/// Steps of the sensor in a sample after which the reading must change.
const TURNING: u32 = 8;
/// 2⁻¹⁴ and 2⁻¹³ turn, counts of 2⁻³² turn.
const LEAST_STEP: u32 = 1 << 18;
const RESOLVER_STEP: u32 = 1 << 19;
/// Part of the limit that is a slip.
const SLIP: f32 = 0.25;
/// Samples of a window of (3).
const WINDOW: u16 = 1024;
/// Twice the square of 0.1 intervals.
const UNSTEADY: f32 = 0.02;
/// Windows, or slips for each of them, of a comparison of (4), and fewest bits that change.
const WINDOWS: u8 = 4;
const SLIPS: u8 = 8;
const FEWEST_BITS: u32 = 6;
/// Square of the part of the limit that noise may be.
const NOISE: f32 = 1.0 / 2500.0;

/// Watches the readings of a locked loop.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Steadiness {
    limit_rad: f32,
    /// The last reading, bit for bit.
    reading: [u32; 2],
    /// Bits of the readings of a converter that the loop followed: those set before the present comparison, those set
    /// and clear in it, how far it is, and the stuck ones of the last.
    bits: u32,
    set: u32,
    clear: u32,
    compared: u8,
    stuck: u32,
    /// The last measured angle that was followed, and its motion, counts of 2⁻³² turn.
    measured: Angle,
    moved: u32,
    /// e(n − 1); NaN after a sample that the loop did not follow.
    error_rad: f32,
    steps: f32,
    motion: f32,
    left: u16,
    unsteady_windows: u32,
}

impl Steadiness {
    pub(super) const fn new(limit_rad: f32) -> Self {
        Self {
            limit_rad,
            reading: [0; 2],
            bits: 0,
            set: 0,
            clear: 0,
            compared: 0,
            stuck: 0,
            measured: Angle::ZERO,
            moved: 0,
            error_rad: f32::NAN,
            steps: 0.0,
            motion: 0.0,
            left: WINDOW,
            unsteady_windows: 0,
        }
    }

    /// Takes a reading; whether it is that of the sample before.
    #[inline(always)]
    pub(super) fn repeats(&mut self, position: &Position) -> bool {
        let reading = match *position {
            Position::Absolute(angle) => [angle.bits(), 0],
            Position::Resolver { sin, cos } => [sin.to_bits(), cos.to_bits()],
            Position::Missing => [0; 2],
        };
        core::mem::replace(&mut self.reading, reading) == reading
    }

    /// Whether the shaft turns so fast that a reading must differ from the last one (1).
    #[cold]
    #[inline(never)]
    pub(super) fn turns(&self, position: &Position) -> bool {
        let step = match *position {
            Position::Absolute(_) => {
                let bits = self.bits | self.set;
                (bits & bits.wrapping_neg()).max(LEAST_STEP)
            }
            Position::Resolver { sin, cos } if (sin + cos).is_finite() => RESOLVER_STEP,
            Position::Resolver { .. } | Position::Missing => return false,
        };
        self.moved >= step.saturating_mul(TURNING)
    }

    /// Takes a reading that the loop followed as this, and its velocity; whether the sensor has slipped (2).
    #[inline(always)]
    pub(super) fn slips(&mut self, position: &Position, tracked: &Tracked, velocity: i32) -> bool {
        let (measured, error_rad) = (tracked.measured(), tracked.error_rad);
        let moved = measured.since(core::mem::replace(&mut self.measured, measured)).unsigned_abs();
        if let Position::Absolute(angle) = position {
            self.set |= angle.bits();
            self.clear |= !angle.bits();
        }
        let step = error_rad - core::mem::replace(&mut self.error_rad, error_rad);
        if step.abs() > SLIP * self.limit_rad {
            self.begin();
            self.compare(1);
            return true;
        }
        // The first error behind a sample that was not followed has none before it.
        if step.is_nan() {
            return false;
        }
        let velocity_rad = velocity as f32 * RAD;
        self.moved = moved;
        self.steps += step * step;
        self.motion += velocity_rad * velocity_rad;
        self.left = self.left.wrapping_sub(1);
        if self.left == 0 {
            self.close();
        }
        false
    }

    /// (3)
    #[cold]
    #[inline(never)]
    fn close(&mut self) {
        let noise = NOISE * self.limit_rad * self.limit_rad * f32::from(WINDOW);
        if self.steps > UNSTEADY * self.motion && self.steps > noise {
            self.unsteady_windows = self.unsteady_windows.saturating_add(1);
        }
        self.begin();
        self.compare(SLIPS);
    }

    /// Counts a window or a slip; with the last one, looks for stuck bits (4).
    #[cold]
    #[inline(never)]
    fn compare(&mut self, slips: u8) {
        self.compared = self.compared.saturating_add(slips);
        if self.compared < WINDOWS.saturating_mul(SLIPS) {
            return;
        }
        // A wrong reading that is followed may have any lower bits.
        let changed = self.set & self.clear & !(LEAST_STEP.wrapping_sub(1));
        let above = changed & changed.wrapping_neg();
        // All bits from the lowest to the highest one that changed.
        let within = (u32::MAX.checked_shr(changed.leading_zeros()).unwrap_or(0)) & !above.wrapping_sub(1);
        let counts = changed.count_ones() >= FEWEST_BITS;
        self.stuck = if counts { within & !changed } else { self.stuck };
        (self.bits, self.set, self.clear, self.compared) = (self.bits | self.set, 0, 0, 0);
    }

    /// The bits of the reading, in 2⁻³² turn, that are stuck now.
    pub(super) const fn stuck_bits(&self) -> u32 {
        self.stuck
    }

    fn begin(&mut self) {
        (self.steps, self.motion, self.left) = (0.0, 0.0, WINDOW);
    }

    /// A sample is not followed.
    pub(super) fn restart(&mut self) {
        self.error_rad = f32::NAN;
    }

    /// The angle is lost: nothing is known of the motion.
    pub(super) fn lose(&mut self) {
        self.restart();
        self.moved = 0;
    }

    pub(super) const fn unsteady_windows(&self) -> u32 {
        self.unsteady_windows
    }

    pub(super) fn clear_faults(&mut self) {
        self.unsteady_windows = 0;
    }
}
