//! The residual of the torque balance, whitened.
//!
//! Enters: the signals of a sample and the present parameters of [`balance`](crate::shaft::balance). Leaves: the
//! whitened residual y, and the excitation g of the bearing orders at this sample.
//!
//! ```text
//! e = i − p₁ ω − p₂ s − p₃ T − p₄ − p₅ |T| s − p₆ s/(1 + (ω/ω_s)²)                                    (1)
//! ρ(k) = g ((e(k) + e(k−1))/2 − p₀ (ω(k) − ω(k−1))/Ts)                                                (2)
//! x(k) = ρ(k) + α x(k−1),   α = (p₀/Ts − a/2)/(p₀/Ts + a/2)                                           (3)
//! y(k) = x(k) − v(k−1),   v(k) = v(k−1) + γ y(k)                                                      (4)
//! g = 3 q² − 2 q³,   q = clamp(|ω(k) + ω(k−1)|/(2 ω_g) − 1, 0, 1)                                     (5)
//! ```
//!
//! (2) holds over one interval. Its noise is mainly the differentiated noise of the velocity: it grows with frequency
//! and hides the small torques of a spall. (3) is the shaft itself with a damping a, the ratio of the noise of the
//! current to that of the velocity: behind it the noise is white, and the sum of products with an equally filtered
//! signal is the best linear detector of that signal (matched filter; Kay, *Detection Theory*, §4.4). Torques
//! that the balance does not contain, such as the change of friction with temperature, vary slowly; the high-pass (4)
//! removes them. Near standstill the residual is mostly error of the friction model; g removes it, without a step,
//! which would pass the differentiated noise. The mean velocity of the interval is uncorrelated with the differentiated
//! noise; with ω(k) alone (2) would have a mean.

use super::blocks::Blocks;
use crate::shaft::balance::{Regressors, TERMS, TorqueBalance, Torques};

/// The filter (3) and (4).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Filter {
    /// x of (3).
    low: f32,
    /// v of (4).
    slow: f32,
}

impl Filter {
    const EMPTY: Self = Self { low: 0.0, slow: 0.0 };

    /// Takes the next sample; returns y of (4).
    #[inline(always)]
    fn step(&mut self, blocks: &Blocks, sample: f32) -> f32 {
        self.low = sample + blocks.pole * self.low; // (3)
        let filtered = self.low - self.slow;
        self.slow += blocks.high_pass * filtered; // (4)
        filtered
    }
}

/// Running state.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(in crate::shaft) struct ResidualState {
    /// e and ω of the last sample.
    last: (f32, f32),
    filter: Filter,
}

/// The residual of one interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::shaft) struct Residual {
    /// y of (4), A.
    pub white: f32,
    /// g of (5) with the sign of ω: a friction torque has that sign.
    pub excitation: f32,
}

impl ResidualState {
    pub(in crate::shaft) const fn new() -> Self {
        Self { last: (0.0, 0.0), filter: Filter::EMPTY }
    }

    /// Takes a sample; without `good` samples at both ends, an interval has no residual.
    #[inline(always)]
    pub(in crate::shaft) fn step(
        &mut self,
        balance: &TorqueBalance,
        blocks: &Blocks,
        p: &[f32; TERMS],
        now: &Torques,
        regressors: &Regressors,
        good: bool,
    ) -> Residual {
        let [p0, p1, p2, p3, p4, p5, p6] = *p;
        let Torques { current_a, velocity_rad_s: w, .. } = *now;
        let Regressors { sign, stribeck, load: [t, q] } = *regressors;
        let friction = p1 * w + p2 * sign + p5 * q + p6 * stribeck;
        let e = current_a - friction - p3 * t - p4; // (1)
        let (e_1, w_1) = core::mem::replace(&mut self.last, (e, w));
        let mean = 0.5 * (w + w_1);
        let q = (mean.abs() / blocks.slowest_rad_s - 1.0).clamp(0.0, 1.0);
        let g = if good { q * q * (3.0 - 2.0 * q) } else { 0.0 }; // (5)
        let rho = if g > 0.0 { g * (0.5 * (e + e_1) - p0 * (w - w_1) / balance.interval_s) } else { 0.0 }; // (2)
        let white = self.filter.step(blocks, rho);
        Residual { white, excitation: if mean < 0.0 { -g } else { g } }
    }
}
