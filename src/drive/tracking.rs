//! A type-2 tracking loop for the shaft angle, and its lock.
//!
//! ```text
//! e(n) = θ(n) − θ̂(n)                                                     (1)
//! θ̂(n+1) = θ̂(n) + ω̂(n) + K₁ e(n),   ω̂(n+1) = ω̂(n) + K₂ e(n)             (2)
//! poles  z = exp(ωₙ T (−ζ ± j √(1 − ζ²))):  r = exp(−ζ ωₙ T),  φ = ωₙ T √(1 − ζ²)
//! K₂ = (1 − r)² + 4 r sin²(φ/2),   K₁ = K₂ + 1 − r²                      (3)
//! ωₙ = 2π f₃ / √(1 + 2ζ² + √((1 + 2ζ²)² + 1))                          (4) f₃: −3 dB
//! e → α/Ka,   Ka = K₂/T² ≈ ωₙ²                                          (5) constant acceleration α
//! ```
//!
//! θ̂ is an [`Angle`] and ω̂ an integer, in counts of 2⁻³² turn a sample: neither drifts. θ̂(n) is a prediction from
//! the samples before n. At constant velocity its error is zero; by (5) it is 0.073° at 1000 rad/s² with f₃ = 300 Hz,
//! ζ = 0.707 and T = 100 µs. The gains (3) place the poles exactly, also where f₃ is not small against the sampling
//! rate. A type-2 loop overshoots: with ζ = 0.707 its gain is 1.22 at ωₙ. The front end therefore adds the error
//! (1) to θ̂, which gives the measured angle.
//!
//! **Lock.** The first two readings set angle and velocity; [`resolver`](super::resolver) says how a resolver's angle
//! is found without a prediction. If one of the two was wrong, the velocity is wrong too, and the loop might follow an
//! error (1) that passes through whole turns without end: a settling loop searches again if the error exceeds 0.75 rad.
//! The loop is *locked* after `settle_samples` errors in a row below half of the limit. A locked loop does not follow a
//! sample that is missing or whose error exceeds the limit: it continues at its velocity, and after such a sample the
//! limit is halved until an error is below (hysteresis). After `lost_samples` in a row it searches again. Samples
//! without lock are missing.
//!
//! **Steadiness.** [`steadiness`](super::steadiness) says which readings of a locked loop are stale, have slipped or
//! come at unequal times.

use core::f32::consts::TAU;

use super::position::{Position, Tracked};
use super::resolver::{ResolverFaults, ResolverLimits, ResolverSignal};
use super::steadiness::Steadiness;
use crate::signal::{Angle, RAD};

/// Error of a settling loop beyond which its velocity is taken for that of a wrong reading: 43°, or 37° by a resolver,
/// whose error is the tangent of the angle's.
const SLIPPED_RAD: f32 = 0.75;

/// Constants of the tracking of the angle.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TrackingConstants {
    /// Bandwidth f₃ of the closed loop, Hz: 1/2000 … 1/10 of the sampling rate.
    pub bandwidth_hz: f32,
    /// Damping ζ, 0.5 … 1.
    pub damping: f32,
    /// Largest error of a locked loop, rad, 0.001 … 0.5; several times that of the largest acceleration (5), and at
    /// least eight steps of the sensor. A step of the error by more than a quarter of it is a slip.
    pub error_limit_rad: f32,
    /// Missing samples, or samples beyond the limit, in a row after which the loop searches again; at least 1.
    pub lost_samples: u16,
    /// Samples in a row below half of the limit that make the lock; at least 1.
    pub settle_samples: u16,
    /// What the amplitude of resolver signals must be; not used for absolute angles.
    pub resolver: ResolverLimits,
}

/// How far the loop has found the angle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Lock {
    /// No reading yet, or lost.
    Searching,
    /// One reading: the next one gives the velocity.
    Found(Angle),
    /// The loop follows, but its errors have not been small for long enough: so many samples are left.
    Settling(u16),
    /// The loop follows.
    Locked,
}

/// Why angles were missing, in samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PositionFaults {
    /// [`Position::Missing`].
    pub missing: u32,
    /// Samples of a locked loop with an error beyond the limit.
    pub strayed: u32,
    /// Number of times that the lock was lost.
    pub losses: u32,
    /// Readings that repeat the one before although the shaft turns; they are missing.
    pub stale: u32,
    /// Steps of the angle that are no motion: the sensor has slipped on the shaft, or lost or gained counts. Angles
    /// behind it differ from those before.
    pub slipped: u32,
    /// Windows in which angle and sample were not of one instant, by more than a tenth of an interval.
    pub unsteady_windows: u32,
    /// Bits of the converter's reading, of 2⁻³² turn, that do not change while those beside them do; samples are missing.
    pub stuck_bits: u32,
    /// Of the signals of a resolver.
    pub resolver: ResolverFaults,
}

/// Follows the shaft angle by (2).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PositionTracker {
    angle: Angle,
    /// ω̂, counts of 2⁻³² turn a sample.
    velocity: i32,
    /// K₁ and K₂, counts a radian.
    gains: [f32; 2],
    lock: Lock,
    /// Samples in a row that the loop did not follow.
    lost: u16,
    /// Largest error that a locked loop follows.
    limit_rad: f32,
    constants: TrackingConstants,
    rate_hz: f32,
    signal: ResolverSignal,
    steadiness: Steadiness,
    faults: PositionFaults,
}

impl TrackingConstants {
    pub(super) fn is_valid(&self, rate_hz: f32) -> bool {
        let bandwidth = self.bandwidth_hz >= rate_hz / 2000.0 && self.bandwidth_hz <= rate_hz / 10.0;
        let limit = (0.001..=0.5).contains(&self.error_limit_rad);
        bandwidth && (0.5..=1.0).contains(&self.damping) && limit && self.lost_samples > 0 && self.settle_samples > 0
    }

    /// K₁ and K₂ (3).
    fn gains(&self, rate_hz: f32) -> [f32; 2] {
        let z = self.damping;
        let twice = 1.0 + 2.0 * z * z;
        let ratio = libm::sqrtf(twice + libm::sqrtf(twice * twice + 1.0));
        let turn = TAU * self.bandwidth_hz / (rate_hz * ratio); // (4), ωₙ T
        let decay = -libm::expm1f(-z * turn); // 1 − r
        let half = Angle::from_radians(0.5 * turn * libm::sqrtf((1.0 - z * z).abs())).sin_cos().sin;
        let k2 = decay * decay + 4.0 * (1.0 - decay) * half * half;
        [k2 + decay * (2.0 - decay), k2] // (3), 1 − r² = (1 − r)(1 + r)
    }
}

impl PositionTracker {
    /// A loop that searches, for samples at `rate_hz`. [`FrontEnd::new`](super::FrontEnd::new) checks the constants;
    /// constants out of range give a loop that does not lock.
    #[must_use]
    pub fn new(constants: &TrackingConstants, rate_hz: f32) -> Self {
        Self {
            angle: Angle::ZERO,
            velocity: 0,
            gains: constants.gains(rate_hz).map(|gain| gain / RAD),
            lock: Lock::Searching,
            lost: 0,
            limit_rad: constants.error_limit_rad,
            constants: *constants,
            rate_hz,
            signal: ResolverSignal::new(&constants.resolver),
            steadiness: Steadiness::new(constants.error_limit_rad),
            faults: PositionFaults::default(),
        }
    }

    /// Takes one reading; `None` if it is missing or wrong, or the loop not locked.
    #[inline(always)]
    pub fn push(&mut self, position: &Position) -> Option<Tracked> {
        let repeated = self.steadiness.repeats(position);
        if self.lock != Lock::Locked {
            self.approach(position);
            return None;
        }
        if repeated && self.steadiness.turns(position) {
            self.stay();
            return None;
        }
        let angle = self.angle;
        let Some(error_rad) = self.error(position, angle) else {
            self.coast();
            return None;
        };
        if error_rad.abs() > self.limit_rad {
            self.stray();
            return None;
        }
        if self.lost > 0 {
            self.recover();
        }
        self.follow(error_rad);
        let tracked = Tracked { angle, error_rad };
        if self.steadiness.slips(position, &tracked, self.velocity) {
            self.faults.slipped = self.faults.slipped.saturating_add(1);
            return None;
        }
        if self.has_stuck_bit() {
            self.faults.stuck_bits |= self.steadiness.stuck_bits();
            return None;
        }
        Some(tracked)
    }

    /// The error (1) of a predicted angle; `None` if the reading is missing or wrong.
    #[inline(always)]
    fn error(&mut self, position: &Position, predicted: Angle) -> Option<f32> {
        match *position {
            Position::Absolute(measured) => Some(measured.since(predicted) as f32 * RAD),
            Position::Resolver { sin, cos } => self.signal.error(sin, cos, predicted),
            Position::Missing => {
                self.faults.missing = self.faults.missing.saturating_add(1);
                None
            }
        }
    }

    /// (2)
    #[inline(always)]
    #[expect(clippy::cast_possible_truncation, reason = "`as` saturates; gains and error are below 2 and π")]
    fn follow(&mut self, error_rad: f32) {
        let [k1, k2] = self.gains;
        self.angle = self.angle.turned(self.velocity).turned((k1 * error_rad) as i32);
        self.velocity = self.velocity.saturating_add((k2 * error_rad) as i32);
    }

    /// Continues at the velocity of the loop; after too many samples the lock is lost.
    #[cold]
    #[inline(never)]
    fn coast(&mut self) {
        self.angle = self.angle.turned(self.velocity);
        self.limit_rad = 0.5 * self.constants.error_limit_rad;
        self.steadiness.restart();
        self.lost = self.lost.saturating_add(1);
        if self.lost >= self.constants.lost_samples {
            self.lose();
        }
    }

    #[cold]
    #[inline(never)]
    fn stay(&mut self) {
        self.faults.stale = self.faults.stale.saturating_add(1);
        self.coast();
    }

    #[cold]
    #[inline(never)]
    fn stray(&mut self) {
        self.faults.strayed = self.faults.strayed.saturating_add(1);
        self.coast();
    }

    /// The first small error after samples that were not followed.
    #[cold]
    #[inline(never)]
    fn recover(&mut self) {
        (self.lost, self.limit_rad) = (0, self.constants.error_limit_rad);
    }

    fn lose(&mut self) {
        if self.lock == Lock::Locked {
            self.faults.losses = self.faults.losses.saturating_add(1);
        }
        self.steadiness.lose();
        self.lock = Lock::Searching;
    }

    /// Without lock.
    #[cold]
    #[inline(never)]
    fn approach(&mut self, position: &Position) {
        let settling = matches!(self.lock, Lock::Settling(_));
        let angle = if settling { self.angle } else { position.coarse() };
        match self.error(position, angle) {
            Some(error_rad) if settling => self.settle(error_rad),
            None if settling => self.coast(),
            error => self.search(error.map(|error_rad| Tracked { angle, error_rad }.measured())),
        }
    }

    /// Angle and velocity from two readings in a row.
    fn search(&mut self, reading: Option<Angle>) {
        self.lock = match (reading, self.lock) {
            (Some(angle), Lock::Found(before)) => {
                self.velocity = angle.since(before);
                self.angle = angle.turned(self.velocity);
                Lock::Settling(self.constants.settle_samples)
            }
            (Some(angle), _) => Lock::Found(angle),
            (None, _) => Lock::Searching,
        };
    }

    /// Follows every error until enough of them in a row are small.
    fn settle(&mut self, error_rad: f32) {
        if error_rad.abs() > SLIPPED_RAD {
            return self.lose();
        }
        self.recover();
        self.follow(error_rad);
        self.lock = match self.lock {
            _ if error_rad.abs() > 0.5 * self.constants.error_limit_rad => {
                Lock::Settling(self.constants.settle_samples)
            }
            Lock::Settling(left) if left > 1 => Lock::Settling(left.wrapping_sub(1)),
            _ => Lock::Locked,
        };
    }

    /// Continues over samples that were never taken; more than `lost_samples` of them lose the lock.
    #[cold]
    pub fn skip(&mut self, samples: u32) {
        if samples >= u32::from(self.constants.lost_samples) || matches!(self.lock, Lock::Found(_)) {
            self.lose();
        }
        self.steadiness.restart();
        self.angle = self.angle.plus(Angle::from_bits(self.velocity.cast_unsigned().wrapping_mul(samples)));
    }

    /// Whether the loop is locked.
    #[must_use]
    pub const fn lock(&self) -> Lock {
        self.lock
    }

    /// Whether the gains of the resolver's sine and cosine differ too much now. Samples of the half turn before were
    /// used.
    #[must_use]
    pub const fn mismatched(&self) -> bool {
        self.signal.mismatched()
    }

    /// Whether a bit of the readings is stuck. Samples of the windows before were used.
    #[must_use]
    pub const fn has_stuck_bit(&self) -> bool {
        self.steadiness.stuck_bits() != 0
    }

    /// What was refused since the start or [`Self::clear_faults`].
    #[must_use]
    pub const fn faults(&self) -> PositionFaults {
        let unsteady_windows = self.steadiness.unsteady_windows();
        PositionFaults { resolver: self.signal.faults(), unsteady_windows, ..self.faults }
    }

    /// Counts from zero.
    pub fn clear_faults(&mut self) {
        self.faults = PositionFaults::default();
        self.signal.clear_faults();
        self.steadiness.clear_faults();
    }
}

#[cfg(test)]
mod tests;
