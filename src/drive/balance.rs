//! The phase currents against each other and the rotor: open phases, gain errors, sensors that read nothing, offsets,
//! levels, half waves, and a vector that does not turn with the rotor.
//!
//! ```text
//! s = i_a + i_b + i_c                                                    (1) zero but for noise and sensor errors
//! unbalanced if  ⟨s²⟩ > 4 σ² + g² (⟨i_a²⟩ + ⟨i_b²⟩ + ⟨i_c²⟩)             (2) σ: noise of s, g: tolerance of the gains
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
//! A phase that stays below what the others say ([`levels`]) is named first.
//! (6) is only concluded if the window contains all octants.
//!
//! The mean of s over the window is removed before (2) and (3) if the window contains all octants: it is that of the
//! offsets, which [`vector`] measures phase by phase, as it says whether the currents turn with the rotor. This is
//! concluded from currents that balance, that they do not only with ⟨|i|²⟩ > σ². If eight windows do not tell, the drive
//! has too little current or motion for this check ([`Alignment::Unknown`]). [`FrontEnd`](super::FrontEnd) removes a
//! measured offset in steps of a quarter of it; one that exceeds its limit, alone or as the sum of the phases, is
//! reported. Where the angles do not tell the mean of s, (2) and (3) have room for an offset of this limit.
//!
//! Of two sensors s is zero: open phases, offsets and the direction of the vector are found, gains are not. A common
//! error of all gains leaves the sum at zero and is not seen. Cost: a sum of twenty products at most 16 times an
//! electrical turn.

mod levels;
mod vector;

use super::Phase;
use super::imbalance::{Alignment, Imbalance};
use crate::signal::{Abc, Angle, SinCos};
use levels::Levels;
use vector::Vector;

/// What (2), (3) and (6) expect.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BalanceLimits {
    /// Noise of the sum of the three currents, its standard deviation, A.
    pub noise_a: f32,
    /// Largest offset of a sensor, and of the sum of the three, that is removed, A.
    pub offset_a: f32,
    /// Tolerated relative error of a gain.
    pub gain_tolerance: f32,
    /// Samples in a window, at least 16: sixteen are an electrical turn.
    pub window: u16,
}

impl BalanceLimits {
    pub(super) fn is_valid(&self) -> bool {
        let noise = self.noise_a > 0.0 && self.noise_a <= 1e6;
        let offset = self.offset_a >= 0.0 && self.offset_a <= 1e6;
        noise && offset && self.gain_tolerance >= 0.0 && self.gain_tolerance < 1.0 && self.window >= 16
    }
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
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CurrentBalance {
    limits: BalanceLimits,
    sums: Sums,
    vector: Vector,
    levels: Levels,
    /// Offsets that were removed from the currents, and what is left of them by the last window, A.
    removed_a: [f32; 3],
    left_a: [f32; 3],
    /// Standard deviation of what is left, A.
    error_a: f32,
    count: u16,
    /// Octants of the electrical angle in this window, a bit each.
    octants: u8,
    /// The electrical angle of the last sample taken.
    taken: Angle,
    imbalance: Option<Imbalance>,
    last_imbalance: Option<Imbalance>,
    unbalanced_windows: u32,
    alignment: Alignment,
    /// Windows that must show that the currents turn with the rotor after one that has shown the opposite.
    doubts: u8,
    /// Windows that did not tell.
    mute: u8,
}

/// 1/16 turn.
const STEP: u32 = 1 << 28;
/// Part of a measured offset that a window removes: a single window is disturbed by a change of the load.
const PART: f32 = 0.25;
/// Least offset that is removed, in σ, besides three of its own deviations: smaller ones are in the noise that a model
/// knows.
const LEAST: f32 = 0.2;
/// Windows in a row that end a misalignment.
const DOUBTS: u8 = 4;
/// Windows without an answer after which there is none to be expected.
const MUTE: u8 = 8;

impl CurrentBalance {
    /// No samples yet; until the first window is closed the currents count as balanced.
    #[must_use]
    pub fn new(limits: BalanceLimits) -> Self {
        Self {
            limits,
            sums: Sums::default(),
            vector: Vector::default(),
            levels: Levels::default(),
            removed_a: [0.0; 3],
            left_a: [0.0; 3],
            error_a: 0.0,
            count: 0,
            octants: 0,
            taken: Angle::ZERO,
            imbalance: None,
            last_imbalance: None,
            unbalanced_windows: 0,
            alignment: Alignment::Undecided,
            doubts: 0,
            mute: 0,
        }
    }

    /// Takes a sample as [`Self::push`], but leaves a full window to [`Self::close`].
    #[inline(always)]
    pub(super) fn gather(&mut self, currents: Abc, electrical: Angle, turn: SinCos) {
        let turned = electrical.since(self.taken);
        if turned.unsigned_abs() >= STEP {
            self.take(currents, electrical, turn, turned < 0);
        }
    }

    /// Whether the window is to be closed.
    #[inline(always)]
    pub(super) const fn is_full(&self) -> bool {
        self.count >= self.limits.window
    }

    #[inline(never)]
    fn take(&mut self, currents: Abc, electrical: Angle, turn: SinCos, backward: bool) {
        let Abc { a, b, c } = currents;
        let s = a + b + c; // (1)
        if !s.is_finite() {
            return;
        }
        self.taken = electrical;
        let sums = &mut self.sums;
        sums.ss += s * s;
        sums.sa += s * a;
        sums.sb += s * b;
        sums.aa += a * a;
        sums.bb += b * b;
        sums.ab += a * b;
        self.vector.take(currents, turn, backward);
        self.levels.take(currents, s);
        self.octants |= 1_u8.wrapping_shl(electrical.bits() >> 29);
        self.count = self.count.saturating_add(1);
    }

    /// Concludes from a window and starts the next one.
    #[cold]
    #[inline(never)]
    pub(super) fn close(&mut self) {
        let n = f32::from(self.count.max(1));
        let measured = if self.octants == u8::MAX { self.vector.offsets(n) } else { None };
        let power = self.center(n, measured.is_some());
        (self.left_a, self.error_a) = (measured.unwrap_or_default(), self.vector.deviation(power, n));
        self.imbalance =
            self.judge(n, measured.is_some()).or_else(|| self.shifted()).or_else(|| self.misaligned(power, n));
        if self.imbalance.is_some() {
            // A window with less current may name a level or a half wave with less detail.
            let is_named = matches!(self.last_imbalance, Some(Imbalance::Clipped(_) | Imbalance::HalfWave(_)));
            if !is_named || !matches!(self.imbalance, Some(Imbalance::Gain { .. } | Imbalance::Unnamed)) {
                self.last_imbalance = self.imbalance;
            }
            self.unbalanced_windows = self.unbalanced_windows.saturating_add(1);
        }
        (self.sums, self.count, self.octants) = (Sums::default(), 0, 0);
        self.vector.restart();
        self.levels.restart();
    }

    /// Removes the mean of s from the sums, if it is known; returns P.
    fn center(&mut self, n: f32, known: bool) -> f32 {
        let [a, b, c] = self.vector.phase_means(n);
        let mean = a + b + c;
        let sums = &mut self.sums;
        let Sums { ss, sa, sb, aa, bb, ab } = *sums;
        let cc = ss + aa + bb + 2.0 * (ab - sa - sb);
        if known {
            sums.ss -= n * mean * mean;
            sums.sa -= n * mean * a;
            sums.sb -= n * mean * b;
        }
        (aa + bb + cc - ss / 3.0) * (2.0 / 3.0)
    }

    /// An offset beyond those that are removed.
    fn shifted(&self) -> Option<Imbalance> {
        let mut largest = (0.0, Phase::A);
        let mut sum = 0.0;
        for ((removed, left), phase) in self.removed_a.iter().zip(self.left_a).zip(Phase::ALL) {
            let offset: f32 = removed + left;
            sum += offset;
            if offset.abs() > f32::abs(largest.0) {
                largest = (offset, phase);
            }
        }
        let (offset_a, phase) = largest;
        let most = self.limits.offset_a;
        let far = offset_a.abs() > most + 6.0 * self.error_a || f32::abs(sum) > most;
        far.then_some(Imbalance::Offset { phase, offset_a })
    }

    fn misaligned(&mut self, power: f32, n: f32) -> Option<Imbalance> {
        let noise = self.limits.noise_a * self.limits.noise_a;
        let told = if self.octants == u8::MAX { self.vector.is_aligned(power, n) } else { None };
        let told = told.filter(|aligned| *aligned || power > n * noise);
        match told {
            Some(false) => self.doubts = DOUBTS,
            // Where the shaft turns back, any vector may look as if it turned with the rotor.
            Some(true) => self.doubts = self.doubts.saturating_sub(1),
            None => self.mute = self.mute.saturating_add(1),
        }
        self.alignment = match (self.doubts, told, self.alignment) {
            (1.., ..) => Alignment::Misaligned,
            (0, Some(_), _) => Alignment::Aligned,
            (0, None, Alignment::Undecided) if self.mute >= MUTE => Alignment::Unknown,
            (0, None, before) => before,
        };
        (self.doubts > 0).then_some(Imbalance::Misaligned)
    }

    /// There are no currents of phases.
    pub(super) const fn is_not_checked(&mut self) {
        self.alignment = Alignment::Unknown;
    }

    /// Whether the currents turn with the rotor, by the last window that told. None does before the shaft has turned by
    /// an electrical turn with a current.
    #[must_use]
    pub const fn alignment(&self) -> Alignment {
        self.alignment
    }

    /// Removes a part of the offsets that the last window has measured; returns it, to be subtracted from the currents
    /// that are pushed from now on.
    pub(super) fn remove_offsets(&mut self) -> [f32; 3] {
        let BalanceLimits { noise_a, offset_a: most, .. } = self.limits;
        let sure = matches!(self.imbalance, None | Some(Imbalance::Offset { .. }));
        let large = self.left_a.iter().any(|left| left.abs() > LEAST * noise_a + 3.0 * self.error_a);
        let mut steps = [0.0; 3];
        if sure && large {
            for ((step, removed), left) in steps.iter_mut().zip(&mut self.removed_a).zip(self.left_a) {
                let next = (*removed + PART * left).max(-most).min(most);
                *step = next - *removed;
                *removed = next;
            }
        }
        steps
    }

    /// Offsets that were removed, A.
    pub(super) const fn removed_a(&self) -> [f32; 3] {
        self.removed_a
    }

    fn judge(&self, n: f32, centered: bool) -> Option<Imbalance> {
        let Sums { ss, sa, sb, aa, bb, ab } = self.sums;
        // c = s − a − b
        let (sc, cc) = (ss - sa - sb, ss + aa + bb + 2.0 * (ab - sa - sb));
        let [ss, sa, sb, sc] = [ss, sa, sb, sc].map(|sum| sum / n);
        let squares = [aa, bb, cc].map(|sum| sum / n);
        let BalanceLimits { noise_a, offset_a, .. } = self.limits;
        let noise = noise_a * noise_a;
        // 2 σ have room for an offset of this size.
        let offset = if centered { 0.0 } else { (offset_a - 2.0 * noise_a).max(0.0) };
        let expected = (2.0 * noise_a + offset) * (2.0 * noise_a + offset);
        let tolerance = self.limits.gain_tolerance * self.limits.gain_tolerance;
        let loud = ss > expected + tolerance * squares.iter().sum::<f32>(); // (2)
        let products = [sa, sb, sc];
        let unbalanced = loud
            || products
                .into_iter()
                .zip(squares)
                .any(|(product, square)| self.follows(f32::abs(product) - offset * libm::sqrtf(square), square, n));
        let floor = squares.iter().fold(0.0, |most: f32, square| if *square > most { *square } else { most }) / 50.0;
        if self.octants == u8::MAX && floor > noise {
            for (square, phase) in squares.iter().zip(Phase::ALL) {
                if *square < floor {
                    return Some(if unbalanced { Imbalance::Silent(phase) } else { Imbalance::Open(phase) }); // (6)
                }
            }
        }
        let level = || self.levels.found(self.limits.noise_a);
        unbalanced.then(|| level().unwrap_or_else(|| named([ss, expected], products, squares, floor)))
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

    /// What the last window found that was not balanced, since the start or [`Self::clear_faults`].
    #[must_use]
    pub const fn last_imbalance(&self) -> Option<Imbalance> {
        self.last_imbalance
    }

    /// Number of windows that were not balanced.
    #[must_use]
    pub const fn unbalanced_windows(&self) -> u32 {
        self.unbalanced_windows
    }

    /// Counts from zero; the finding of the last window stays.
    pub fn clear_faults(&mut self) {
        (self.unbalanced_windows, self.last_imbalance) = (0, None);
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
mod tests;
