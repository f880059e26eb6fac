//! The largest currents of a window as measured, and by the other two phases: a phase that is clipped, or has no half
//! wave.
//!
//! ```text
//! r = i_x − s        what phase x carries by the other two                                               (1)
//! level:  max(±r) > max(±i_x) + w,   w = max(6 σ, max(±r)/10)                                            (2)
//! ```
//!
//! A gain that is too small looks alike, but is as wrong where the current is small: below half of what it reached in
//! both directions in the window before, the ratio of `Σ s i_x` and `Σ i_x²` is its error. A level says more than that
//! the currents do not sum to zero; it is only looked for where they do not.
//!
//! A sample counts for one phase, in turn: sixteen a turn are no multiple of three, so that each phase gets all angles.

use crate::drive::Phase;
use crate::drive::imbalance::Imbalance;
use crate::signal::Abc;

/// w of (2).
const NOISE: f32 = 6.0;
const PART: f32 = 0.1;
/// Part of the largest current below which a level is that of no current.
const NO_CURRENT: f32 = 0.15;
/// Largest error of the gain below a level.
const GAIN: f32 = 0.05;

/// One phase: largest positive and negative currents, magnitudes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Reach {
    measured: [f32; 2],
    by_others: [f32; 2],
    /// Currents below are small; their number, `Σ i_x²` and `Σ s i_x`.
    small: f32,
    count: f32,
    square: f32,
    product: f32,
}

impl Reach {
    /// Whether the gain is right where the current is small.
    // Out of line: six calls of it are smaller than six copies.
    #[inline(never)]
    fn has_gain(&self, noise_a: f32) -> bool {
        // The noise of the own sensor is σ²/3 of the products.
        let most = GAIN * self.square + self.count * noise_a * noise_a / 3.0;
        self.product.abs() <= most && self.square > 0.0
    }
}

/// The phases in a window, and the one of the last sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Levels {
    reaches: [Reach; 3],
    phase: u8,
}

fn largest(most: &mut [f32; 2], x: f32) {
    let [high, low] = most;
    *high = if x > *high { x } else { *high };
    *low = if -x > *low { -x } else { *low };
}

impl Levels {
    /// Takes three currents with the sum s.
    #[inline(always)]
    pub(super) fn take(&mut self, Abc { a, b, c }: Abc, s: f32) {
        let (phase, x) = match self.phase {
            0 => (1, b),
            1 => (2, c),
            _ => (0, a),
        };
        self.phase = phase;
        let Some(reach) = self.reaches.get_mut(phase as usize) else { return };
        largest(&mut reach.measured, x);
        largest(&mut reach.by_others, x - s); // (1)
        if x.abs() < reach.small {
            reach.count += 1.0;
            reach.square += x * x;
            reach.product += s * x;
        }
    }

    /// The phase that reaches least of what the others say (2); σ is the noise of s.
    #[cold]
    #[inline(never)]
    pub(super) fn found(&self, noise_a: f32) -> Option<Imbalance> {
        let mut found = (0.0, None);
        for (reach, phase) in self.reaches.iter().zip(Phase::ALL) {
            for (measured, others) in reach.measured.into_iter().zip(reach.by_others) {
                let lacks = others - measured - (NOISE * noise_a).max(PART * others);
                let half = measured < NO_CURRENT * others;
                if lacks > found.0 && (half || reach.has_gain(noise_a)) {
                    found = (lacks, Some(if half { Imbalance::HalfWave(phase) } else { Imbalance::Clipped(phase) }));
                }
            }
        }
        found.1
    }

    /// Starts the next window.
    pub(super) fn restart(&mut self) {
        for reach in &mut self.reaches {
            let [high, low] = reach.measured;
            *reach = Reach { small: 0.5 * high.min(low), ..Reach::default() };
        }
    }
}
