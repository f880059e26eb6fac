//! The three phase currents against each other: open phases, gain errors, sensors that read nothing.
//!
//! ```text
//! s = i_a + i_b + i_c                                                    (1) zero but for noise and sensor errors
//! unbalanced if  ⟨s²⟩ > 4 σ² + g² (⟨i_a²⟩ + ⟨i_b²⟩ + ⟨i_c²⟩)             (2) σ: rms of s, g: tolerance of the gains
//! or if any    |⟨s i_x⟩| > 2 g ⟨i_x²⟩ + σ²/3 + 6 σ √(⟨i_x²⟩/n)           (3) n: samples in the window
//! phase x explains  q_x = ⟨s i_x⟩² / ⟨i_x²⟩  of ⟨s²⟩                     (4)
//! relative error of its gain  ε = r/(1 − r),  r = ⟨s i_x⟩ / ⟨i_x²⟩       (5)
//! phase x carries no current if  ⟨i_x²⟩ < m/50,  m/50 > σ²               (6) m: largest mean square of the phases
//! ```
//!
//! A sample is taken when the electrical angle has moved by 1/16 turn since the last one, so that the means ⟨·⟩ are
//! about uniform over the angle and nothing is concluded from a current that stands still: at some angles a phase
//! carries none. (3) finds a gain error that noise hides from (2): in the mean product of sum and current, the noise of
//! the own sensor is σ²/3 at most, and all other noise has the standard deviation of the last term, without its 6. The
//! gain of a phase is reported as wrong if the phase explains at least 80 % of ⟨s²⟩, or all but 4 σ², and no other
//! phase explains more than three quarters of that (over a turn: a quarter); a phase without current (6) has no gain.
//! (6) is only concluded if the window contains all octants.
//!
//! A common error of all three gains leaves the sum at zero and is not seen. Cost: nine numbers of state; a sum of six
//! products at most 16 times an electrical turn.

use super::Phase;
use crate::signal::{Abc, Angle};

/// What (2), (3) and (6) expect.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BalanceLimits {
    /// Expected rms of the sum of the three currents, with noise and errors of the offsets, A.
    pub noise_a: f32,
    /// Tolerated relative error of a gain.
    pub gain_tolerance: f32,
    /// Samples in a window, at least 16: sixteen are an electrical turn.
    pub window: u16,
}

impl BalanceLimits {
    pub(super) fn is_valid(&self) -> bool {
        let noise = self.noise_a > 0.0 && self.noise_a <= 1e6;
        noise && self.gain_tolerance >= 0.0 && self.gain_tolerance < 1.0 && self.window >= 16
    }
}

/// Why the three currents do not fit each other.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Imbalance {
    /// No current in a phase, and the other two sum to zero: the winding or its lead is open.
    Open(Phase),
    /// A sensor reads no current, but the other two do not sum to zero: the sensor or its wire is broken.
    Silent(Phase),
    /// The gain of a sensor is wrong.
    Gain {
        /// The phase of the sensor.
        phase: Phase,
        /// Relative error (5) of its gain.
        error: f32,
    },
    /// The currents do not sum to zero, and no single gain explains it: offsets, several sensors, current to earth.
    Unnamed,
}

/// Sums of products over a window.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Sums {
    ss: f32,
    sa: f32,
    sb: f32,
    aa: f32,
    bb: f32,
    ab: f32,
}

/// Compares the three phase currents over windows.
///
/// ```
/// use bearing_watch::drive::{Abc, BalanceLimits, CurrentBalance, Imbalance, Phase};
/// use bearing_watch::Angle;
/// let limits = BalanceLimits { noise_a: 0.05, gain_tolerance: 0.02, window: 64 };
/// let mut balance = CurrentBalance::new(limits);
/// for k in 0..200 {
///     let angle = Angle::from_counts(k * 2, 5);
///     let phase = |third: u32| 10.0 * angle.plus(Angle::from_bits(third * 0x5555_5555)).sin_cos().cos;
///     let _ = balance.push(Abc { a: phase(0), b: 1.1 * phase(2), c: phase(1) }, angle);
/// }
/// let Some(Imbalance::Gain { phase: Phase::B, error }) = balance.imbalance() else { panic!("no gain error") };
/// assert!((error - 0.1).abs() < 1e-3);
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CurrentBalance {
    limits: BalanceLimits,
    sums: Sums,
    count: u16,
    /// Octants of the electrical angle in this window, a bit each.
    octants: u8,
    /// The electrical angle of the last sample taken.
    taken: Angle,
    imbalance: Option<Imbalance>,
    unbalanced_windows: u32,
}

/// 1/16 turn.
const STEP: u32 = 1 << 28;

impl CurrentBalance {
    /// No samples yet; until the first window is closed the currents count as balanced.
    #[must_use]
    pub fn new(limits: BalanceLimits) -> Self {
        Self {
            limits,
            sums: Sums::default(),
            count: 0,
            octants: 0,
            taken: Angle::ZERO,
            imbalance: None,
            unbalanced_windows: 0,
        }
    }

    /// Takes the phase currents, A, at an electrical angle; a sample that is not finite is left out. Returns whether
    /// this sample closed a window.
    #[inline(always)]
    pub fn push(&mut self, currents: Abc, electrical: Angle) -> bool {
        if electrical.since(self.taken).unsigned_abs() < STEP {
            return false;
        }
        self.take(currents, electrical)
    }

    #[inline(never)]
    fn take(&mut self, Abc { a, b, c }: Abc, electrical: Angle) -> bool {
        let s = a + b + c; // (1)
        if !s.is_finite() {
            return false;
        }
        self.taken = electrical;
        let sums = &mut self.sums;
        sums.ss += s * s;
        sums.sa += s * a;
        sums.sb += s * b;
        sums.aa += a * a;
        sums.bb += b * b;
        sums.ab += a * b;
        self.octants |= 1_u8.wrapping_shl(electrical.bits() >> 29);
        self.count = self.count.saturating_add(1);
        if self.count < self.limits.window {
            return false;
        }
        self.close();
        true
    }

    #[cold]
    #[inline(never)]
    fn close(&mut self) {
        self.imbalance = self.judge();
        if self.imbalance.is_some() {
            self.unbalanced_windows = self.unbalanced_windows.saturating_add(1);
        }
        (self.sums, self.count, self.octants) = (Sums::default(), 0, 0);
    }

    fn judge(&self) -> Option<Imbalance> {
        let n = f32::from(self.count.max(1));
        let Sums { ss, sa, sb, aa, bb, ab } = self.sums;
        // c = s − a − b
        let (sc, cc) = (ss - sa - sb, ss + aa + bb + 2.0 * (ab - sa - sb));
        let [ss, sa, sb, sc] = [ss, sa, sb, sc].map(|sum| sum / n);
        let squares = [aa, bb, cc].map(|sum| sum / n);
        let noise = self.limits.noise_a * self.limits.noise_a;
        let tolerance = self.limits.gain_tolerance * self.limits.gain_tolerance;
        let loud = ss > 4.0 * noise + tolerance * squares.iter().sum::<f32>(); // (2)
        let products = [sa, sb, sc];
        let unbalanced =
            loud || products.into_iter().zip(squares).any(|(product, square)| self.follows(product, square, n));
        let floor = squares.iter().fold(0.0, |most: f32, square| if *square > most { *square } else { most }) / 50.0;
        if self.octants == u8::MAX && floor > noise {
            for (square, phase) in squares.iter().zip(Phase::ALL) {
                if *square < floor {
                    return Some(if unbalanced { Imbalance::Silent(phase) } else { Imbalance::Open(phase) }); // (6)
                }
            }
        }
        unbalanced.then(|| named([ss, 4.0 * noise], products, squares, floor))
    }

    /// (3)
    fn follows(&self, product: f32, square: f32, n: f32) -> bool {
        let BalanceLimits { noise_a, gain_tolerance, .. } = self.limits;
        let noise = noise_a * (noise_a / 3.0 + 6.0 * libm::sqrtf(square / n));
        product.abs() > 2.0 * gain_tolerance * square + noise
    }

    /// What the last closed window found; `None` if the currents were balanced.
    #[inline]
    #[must_use]
    pub const fn imbalance(&self) -> Option<Imbalance> {
        self.imbalance
    }

    /// Number of windows that were not balanced.
    #[must_use]
    pub const fn unbalanced_windows(&self) -> u32 {
        self.unbalanced_windows
    }

    /// Counts from zero; the finding of the last window stays.
    pub fn clear_faults(&mut self) {
        self.unbalanced_windows = 0;
    }
}

/// The phase whose gain explains the mean square of the sum, or all of it but the noise, among those with a mean square
/// of at least `floor`.
fn named([ss, noise]: [f32; 2], products: [f32; 3], squares: [f32; 3], floor: f32) -> Imbalance {
    let (mut best, mut second) = ((0.0, Phase::A, 0.0), 0.0);
    let carry_current = products.into_iter().zip(squares).zip(Phase::ALL).filter(|((_, square), _)| *square >= floor);
    for ((product, square), phase) in carry_current {
        let explained = product * product / square; // (4)
        if explained > best.0 {
            second = best.0;
            best = (explained, phase, product / square);
        } else if explained > second {
            second = explained;
        }
    }
    let (explained, phase, r) = best;
    let left = ss - explained;
    if (left <= 0.2 * ss || left <= noise) && second <= 0.75 * explained && r < 1.0 {
        Imbalance::Gain { phase, error: r / (1.0 - r) } // (5)
    } else {
        Imbalance::Unnamed
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::cast_sign_loss, reason = "a positive fraction of a turn")]

    use super::*;

    const LIMITS: BalanceLimits = BalanceLimits { noise_a: 0.1, gain_tolerance: 0.02, window: 320 };

    /// One finding after `turns` electrical turns of currents of `amplitude_a`, with normal noise of 0.05 A a sensor.
    fn finding(
        amplitude_a: f64,
        turns: f64,
        gains: [f64; 3],
        currents: impl Fn(f64, f64) -> [f64; 3],
    ) -> Option<Imbalance> {
        let mut balance = CurrentBalance::new(LIMITS);
        let mut state = 3_u32;
        let mut noise = || {
            let mut uniform = || {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                f64::from(state >> 8) / 16_777_216.0
            };
            0.05 * ((0..12).map(|_| uniform()).sum::<f64>() - 6.0)
        };
        for k in 0..20_000 {
            let turn = turns * f64::from(k) / 20_000.0;
            let mut i = currents(amplitude_a, core::f64::consts::TAU * turn);
            i.iter_mut().zip(gains).for_each(|(i, gain)| *i = gain * *i + noise());
            let [a, b, c] = i.map(|i| i as f32);
            let electrical = Angle::from_bits((turn.fract() * 4_294_967_296.0) as u32);
            let _ = balance.push(Abc { a, b, c }, electrical);
        }
        assert_eq!(balance.unbalanced_windows() > 0, balance.imbalance().is_some());
        balance.imbalance()
    }

    fn three(amplitude: f64, angle: f64) -> [f64; 3] {
        [0.0, 1.0, 2.0].map(|k| amplitude * (angle - k * core::f64::consts::TAU / 3.0).sin())
    }

    #[test]
    fn balanced_currents_are_balanced_with_any_amplitude_and_tolerated_gains() {
        for amplitude in [0.0, 0.3, 10.0, 50.0] {
            assert_eq!(finding(amplitude, 100.0, [1.0; 3], three), None, "{amplitude} A");
        }
        assert_eq!(finding(50.0, 100.0, [1.015, 0.99, 1.01], three), None);
    }

    #[test]
    fn gain_errors_are_named_and_measured() {
        for (place, phase) in Phase::ALL.into_iter().enumerate() {
            for error in [0.1_f64, -0.2] {
                let mut gains = [1.0; 3];
                gains[place] += error;
                let Some(Imbalance::Gain { phase: named, error: measured }) = finding(10.0, 100.0, gains, three) else {
                    panic!("{phase:?} {error}");
                };
                // Noise of 0.09 A in 320 samples of a current of 7 A rms: 0.0007.
                assert!(named == phase && (f64::from(measured) - error).abs() < 0.004, "{phase:?} {error} {measured}");
            }
        }
    }

    #[test]
    fn a_gain_error_below_the_noise_of_the_sum_is_named() {
        // ⟨s²⟩ is 0.0075 A² of noise and 0.02 A² of the gain, half of the limit of (2).
        let Some(Imbalance::Gain { phase: Phase::B, error }) = finding(1.0, 100.0, [1.0, 1.2, 1.0], three) else {
            panic!("not named");
        };
        // Noise of 0.09 A in 320 samples of a current of 0.7 A rms: 0.007, and each sensor's own noise 0.005.
        assert!((error - 0.2).abs() < 0.03, "{error}");
        assert_eq!(finding(1.0, 100.0, [1.015, 0.99, 1.01], three), None);
    }

    #[test]
    fn an_open_winding_differs_from_a_silent_sensor() {
        for (place, phase) in Phase::ALL.into_iter().enumerate() {
            let mut gains = [1.0; 3];
            gains[place] = 0.0;
            assert_eq!(finding(10.0, 100.0, gains, three), Some(Imbalance::Silent(phase)));
            let open = |amplitude: f64, angle: f64| {
                let mut i = [0.0; 3];
                i[(place + 1) % 3] = amplitude * angle.sin();
                i[(place + 2) % 3] = -amplitude * angle.sin();
                i
            };
            assert_eq!(finding(10.0, 100.0, [1.0; 3], open), Some(Imbalance::Open(phase)));
        }
    }

    #[test]
    fn a_silent_sensor_has_no_gain_error_at_a_current_too_small_to_name_it() {
        let limits = BalanceLimits { noise_a: 1.0, ..LIMITS };
        let mut balance = CurrentBalance::new(limits);
        for k in 0..20_000 {
            let angle = core::f64::consts::TAU * f64::from(k) / 200.0;
            let [a, b, _] = three(5.0, angle).map(|i| i as f32);
            let electrical = Angle::from_bits((f64::from(k % 200) / 200.0 * 4_294_967_296.0) as u32);
            let _ = balance.push(Abc { a, b, c: 0.0 }, electrical);
        }
        // 12.5 A² are less than 50 times the square of the noise.
        assert_eq!(balance.imbalance(), Some(Imbalance::Unnamed));
    }

    #[test]
    fn an_offset_is_an_imbalance_without_a_name() {
        let shifted = |amplitude: f64, angle: f64| three(amplitude, angle).map(|i| i + 0.2);
        assert_eq!(finding(10.0, 100.0, [1.0; 3], shifted), Some(Imbalance::Unnamed));
    }

    #[test]
    fn nothing_is_concluded_at_standstill_or_from_missing_samples() {
        assert_eq!(finding(10.0, 0.05, [1.0, 0.0, 1.0], three), None);
        assert_eq!(finding(f64::NAN, 100.0, [1.0; 3], three), None);
    }

    #[test]
    fn a_shaft_that_swings_where_a_phase_has_no_current_has_no_open_phase() {
        let mut balance = CurrentBalance::new(LIMITS);
        let mut push = |turn: f64, amplitude: f64| {
            let [a, b, c] = three(amplitude, core::f64::consts::TAU * turn).map(|i| i as f32);
            balance.push(Abc { a, b, c }, Angle::from_bits((turn.rem_euclid(1.0) * 4_294_967_296.0) as u32))
        };
        // Twenty turns, a window, and then a spring: its current at angle zero, where phase a carries none, and hardly
        // any at the other end of the swing.
        let turns = (0..=320_u16).filter(|k| push(f64::from(*k) / 16.0, 10.0)).count();
        let swings = (0..=960_u16).filter(|k| if k % 2 == 0 { push(0.0, 10.0) } else { push(0.0725, 0.5) }).count();
        assert_eq!((turns, swings), (1, 3), "windows");
        assert_eq!((balance.imbalance(), balance.unbalanced_windows()), (None, 0));
    }

    #[test]
    fn without_current_only_the_noise_limits_a_product() {
        // 0.1²/3 A² without a current; with one, twice the tolerance of its square and six deviations more.
        let balance = CurrentBalance::new(LIMITS);
        assert!(balance.follows(0.0034, 0.0, 10.0) && !balance.follows(0.0033, 0.0, 10.0));
        let limit = 0.04 * 10.0 + 0.1 * (0.1 / 3.0 + 6.0);
        assert!(balance.follows(-1.01 * limit, 10.0, 10.0) && !balance.follows(0.99 * limit, 10.0, 10.0));
    }

    #[test]
    fn two_phases_that_explain_the_sum_alike_are_not_named() {
        let named = |first: f32, later: f32| {
            let products = [first, later, 0.0].map(libm::sqrtf);
            matches!(super::named([1.0, 0.0], products, [1.0; 3], 0.5), Imbalance::Gain { phase: Phase::A, .. })
        };
        assert!(named(0.9, 0.6) && !named(0.9, 0.8));
    }
}
