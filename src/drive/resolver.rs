//! Sine and cosine of a resolver: error of a predicted angle, and what is wrong with the signals.
//!
//! ```text
//! e = tan(θ − θ̂) = (s cos θ̂ − c sin θ̂) / (c cos θ̂ + s sin θ̂)            (1) for less than 45°, else ±1
//! A² = s² + c²                                                           (2)
//! θ₀ ≈ atan2(s, c),   |θ₀ − θ| ≤ 0.17°                                    (3)
//! ```
//!
//! s = A sin θ, c = A cos θ. The quotient (1) does not depend on the amplitude A, costs one division and no root, and
//! exceeds the angle by e³/3. Beyond 45° the error is ±1 with the sign of the sine, so the loop turns to the only
//! stable angle from everywhere.
//!
//! **Start.** A loop that searches has no θ̂. The coarse angle (3), an approximation by `micromath`, takes its place,
//! and (1) gives the rest: θ₀ + e is the angle to e³/3 < 1e-8 rad, which is less than single precision resolves. The
//! error of (3) therefore reaches no result, and a program needs no full arctangent for the start. `cargo xtask
//! measure` prints the flash of both.
//!
//! The signals are *lost* if A is below its lowest value and *too high* above its highest one, where converters clip;
//! such a sample is missing. A relative difference δ of the two gains moves the angle by up to δ/2 rad, at twice the
//! speed. A then varies over half a turn: the gains are *mismatched* if the largest A of a half turn exceeds the least
//! by more than the limit, and samples are missing until a later half turn is better.

use micromath::F32;

use crate::signal::{Angle, SinCos};

/// What the amplitude of resolver signals must be.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ResolverLimits {
    /// Lowest amplitude, in the unit of the signals.
    pub low: f32,
    /// Highest amplitude.
    pub high: f32,
    /// Largest relative difference of the amplitudes of sine and cosine, noise included.
    pub mismatch: f32,
}

impl ResolverLimits {
    pub(super) fn is_valid(&self) -> bool {
        let band = self.low > 0.0 && self.low < self.high && self.high <= 1e9;
        band && self.mismatch > 0.0 && self.mismatch <= 1.0
    }
}

/// Refused samples of resolver signals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ResolverFaults {
    /// Samples with too low an amplitude, or not a number.
    pub lost: u32,
    /// Samples with too high an amplitude.
    pub too_high: u32,
    /// Samples while the gains of sine and cosine differed too much.
    pub mismatched: u32,
}

/// The signals of a resolver.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct ResolverSignal {
    /// Squares of the lowest and highest amplitude.
    low: f32,
    high: f32,
    /// Largest ratio of squared amplitudes.
    ratio: f32,
    /// Extremes of A² since the last half turn was complete.
    least: f32,
    most: f32,
    /// The angle of the last amplitude taken.
    taken: Angle,
    /// Octants of the half turn that have been visited, a bit each.
    octants: u8,
    mismatched: bool,
    faults: ResolverFaults,
}

/// 1/32 turn: amplitudes are taken at angles at least that far apart, and not at rest.
const STEP: u32 = 1 << 27;
/// The four octants of a half turn.
const HALF_TURN: u8 = 0b1111;

/// The coarse angle (3). Of wrong signals it is any angle: [`ResolverSignal::error`] refuses them.
pub(super) fn coarse(s: f32, c: f32) -> Angle {
    Angle::from_radians(F32(s).atan2(F32(c)).0)
}

impl ResolverSignal {
    pub(super) fn new(limits: &ResolverLimits) -> Self {
        let ResolverLimits { low, high, mismatch } = *limits;
        Self {
            low: low * low,
            high: high * high,
            ratio: (1.0 + mismatch) * (1.0 + mismatch),
            least: f32::INFINITY,
            most: 0.0,
            taken: Angle::ZERO,
            octants: 0,
            mismatched: false,
            faults: ResolverFaults::default(),
        }
    }

    /// The error (1) of a predicted angle; `None` if the signals are wrong.
    #[inline(always)]
    pub(super) fn error(&mut self, s: f32, c: f32, predicted: Angle) -> Option<f32> {
        self.check(s, c, predicted)?;
        let SinCos { sin, cos } = predicted.sin_cos();
        let (across, along) = (s * cos - c * sin, c * cos + s * sin);
        Some(if across.abs() < along { across / along } else { 1.0_f32.copysign(across) }) // (1)
    }

    #[inline(always)]
    fn check(&mut self, s: f32, c: f32, angle: Angle) -> Option<()> {
        let square = s * s + c * c; // (2)
        if !(square >= self.low && square <= self.high) {
            self.refuse(square);
            return None;
        }
        if angle.since(self.taken).unsigned_abs() >= STEP {
            self.take(square, angle);
        }
        if self.mismatched {
            self.faults.mismatched = self.faults.mismatched.saturating_add(1);
            return None;
        }
        Some(())
    }

    #[cold]
    #[inline(never)]
    fn refuse(&mut self, square: f32) {
        let count = if square > self.high { &mut self.faults.too_high } else { &mut self.faults.lost };
        *count = count.saturating_add(1);
    }

    /// Takes an amplitude for the comparison over half a turn.
    #[inline(never)]
    fn take(&mut self, square: f32, angle: Angle) {
        self.taken = angle;
        self.least = if square < self.least { square } else { self.least };
        self.most = if square > self.most { square } else { self.most };
        self.octants |= 1_u8.wrapping_shl((angle.bits() >> 29) & 3);
        if self.octants != HALF_TURN {
            return;
        }
        self.mismatched = self.most > self.ratio * self.least;
        (self.least, self.most, self.octants) = (f32::INFINITY, 0.0, 0);
    }

    pub(super) const fn mismatched(&self) -> bool {
        self.mismatched
    }

    pub(super) const fn faults(&self) -> ResolverFaults {
        self.faults
    }

    pub(super) fn clear_faults(&mut self) {
        self.faults = ResolverFaults::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: ResolverLimits = ResolverLimits { low: 0.5, high: 2.0, mismatch: 0.05 };

    fn signals(angle: f64, gain: f64) -> (f32, f32) {
        ((gain * angle.sin()) as f32, angle.cos() as f32)
    }

    #[test]
    fn the_error_is_the_tangent_of_the_difference_from_everywhere() {
        let mut signal = ResolverSignal::new(&LIMITS);
        for k in 0..4000_u32 {
            let (angle, predicted) = (0.01 * f64::from(k), Angle::from_bits(k.wrapping_mul(0x9E37_79B9)));
            let (s, c) = signals(angle, 1.0);
            let difference = angle - core::f64::consts::TAU * f64::from(predicted.bits()) / 4_294_967_296.0;
            let exact =
                if difference.cos() > difference.sin().abs() { difference.tan() } else { difference.sin().signum() };
            let error = f64::from(signal.error(s, c, predicted).unwrap());
            // Products and a quotient of numbers up to 1, and a sine within 2e-7.
            assert!(
                (error - exact).abs() < 1e-6 || (error.abs() > 0.999 && exact.abs() > 0.999),
                "{k}: {error} {exact}"
            );
        }
    }

    /// Error of the coarse angle, rad.
    fn error_of_coarse(s: f32, c: f32) -> f64 {
        let turns = f64::from(s).atan2(f64::from(c)) / core::f64::consts::TAU
            - f64::from(coarse(s, c).bits()) / 4_294_967_296.0;
        core::f64::consts::TAU * (turns - turns.round()).abs()
    }

    #[test]
    fn the_coarse_angle_is_within_a_sixth_of_a_degree_in_all_quadrants() {
        let mut worst = 0.0_f64;
        for gain in [1e-15, 1e-3, 1.0, 1e9] {
            for k in 0..1 << 16 {
                let (sin, cos) = (core::f64::consts::TAU * f64::from(k) / 65_536.0).sin_cos();
                worst = worst.max(error_of_coarse((gain * sin) as f32, (gain * cos) as f32));
            }
        }
        std::println!("largest error of the coarse angle: {:.5}°", worst.to_degrees());
        // (b x + x²)/(1 + 2 b x + x²) with b = 0.596227 is at most this far from atan(x) 2/π: its two extremes.
        assert!((0.160..=0.163).contains(&worst.to_degrees()), "{worst}");
        for [s, c] in [[0.0, 1.0], [-0.0, 1.0], [1.0, 0.0], [1.0, -0.0], [0.0, -1.0], [-0.0, -1.0], [-1.0, 0.0]] {
            // On the axes it is exact, but for the rounding of π/2.
            assert!(error_of_coarse(s, c) < 2e-7, "{s} {c}");
        }
    }

    #[test]
    fn wrong_signals_have_no_error_from_their_coarse_angle_and_others_a_small_one() {
        let wrong = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN_POSITIVE, 1e-45, 0.0, -0.0];
        for s in wrong {
            for c in wrong {
                assert_eq!(ResolverSignal::new(&LIMITS).error(s, c, coarse(s, c)), None, "{s} {c}");
            }
        }
        // Any bits; half of the pairs have nearly equal magnitudes.
        let (mut bits, mut taken) = (1_u32, 0);
        for _ in 0..100_000 {
            bits = bits.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let other = if bits & 1 == 0 { bits ^ 0x8000_FFFF } else { bits.reverse_bits() };
            let (s, c) = (f32::from_bits(bits), f32::from_bits(other));
            let error = ResolverSignal::new(&LIMITS).error(s, c, coarse(s, c));
            assert!(error.is_none_or(|error| error.abs() < 0.003), "{s} {c}: {error:?}");
            taken += u32::from(error.is_some());
        }
        assert!(taken > 100, "{taken}");
    }

    #[test]
    fn amplitudes_out_of_the_band_are_counted_by_kind() {
        let mut signal = ResolverSignal::new(&LIMITS);
        let mut taken = |s, c| signal.error(s, c, Angle::ZERO).is_some();
        assert_eq!([taken(0.0, 0.49), taken(0.3, -0.3), taken(f32::NAN, 1.0)], [false; 3]);
        assert_eq!([taken(2.1, 0.0), taken(1.5, 1.5), taken(1.9, 0.0), taken(0.0, -0.51)], [false, false, true, true]);
        assert_eq!(signal.faults(), ResolverFaults { lost: 3, too_high: 2, mismatched: 0 });
        signal.clear_faults();
        assert_eq!(signal.faults(), ResolverFaults::default());
    }

    #[test]
    fn mismatched_gains_are_found_within_a_half_turn_and_forgotten_after_a_better_one() {
        let mut signal = ResolverSignal::new(&LIMITS);
        let mut taken = |k: u32, gain: f64| {
            let angle = core::f64::consts::TAU * f64::from(k) / 1000.0;
            let (s, c) = signals(angle, gain);
            signal.error(s, c, Angle::from_radians(angle as f32)).is_some()
        };
        assert!((0..2000).all(|k| taken(k, 1.04)), "within the limit");
        let lost: std::vec::Vec<bool> = (0..2000).map(|k| taken(k, 1.08)).collect();
        // The half turn that is open when the gains change may be the first to show it; then the next one does.
        assert!(lost[1000..].iter().all(|taken| !taken), "mismatch of 8 %");
        let better: std::vec::Vec<bool> = (0..2000).map(|k| taken(k, 1.0)).collect();
        assert!(better[1000..].iter().all(|taken| *taken));
        assert!(signal.faults().mismatched >= 1000);
    }

    #[test]
    fn limits_that_are_none_are_refused() {
        let refused = |limits: ResolverLimits| !limits.is_valid();
        assert!(LIMITS.is_valid() && ResolverLimits { mismatch: 1.0, high: 1e9, ..LIMITS }.is_valid());
        assert!(refused(ResolverLimits { low: 0.0, ..LIMITS }) && refused(ResolverLimits { low: 2.0, ..LIMITS }));
        assert!(
            refused(ResolverLimits { high: 2e9, ..LIMITS }) && refused(ResolverLimits { high: f32::NAN, ..LIMITS })
        );
        assert!(
            refused(ResolverLimits { mismatch: 0.0, ..LIMITS }) && refused(ResolverLimits { mismatch: 1.1, ..LIMITS })
        );
    }
}
