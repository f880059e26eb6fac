//! Products of block phasors → strength, amplitude and slip of a bearing order.
//!
//! Enters: [`LineSums`] of [`super::orders`]. Leaves: an [`OrderStrength`].
//!
//! ```text
//! P(δ) = Σ_h w_h [R(h, 0) + 2 Σ_d (1 − d/7) Re(R(h, d) e^{−j d h ψ})] / (σ² W(h))                     (1)
//! ψ = 2π O c δ L,   c: ratio of the order's slip to the cage's,   L: turns of a cell                  (2)
//! prominence = max P(δ) / Σ w_h   over |δ| ≤ slip                                                     (3)
//! ν = 2 (Σ w_h)² W² / (Σ w_h² [V(0) + 2 Σ_d (1 − d/7)² V(d)])                                         (4)
//! score = (prominence^⅓ − 1 + 2/(9ν)) / √(2/(9ν)) − 0.7 ln M                                          (5)
//! slip deviation = √(Var P′)/(−P″)   at the largest P                                                  (6)
//! Var P′ = (dψ/dδ)² Σ_h (h w_h)² · 2 Σ_d (1 − d/7)² d² V(d)/W² · (1 + |A|² V(0)/(σ² W))                (7)
//! |A|² = Σ_d (1 − d/7) Re(R(1, d) e^{−jdψ}) / Σ_d (1 − d/7) V(d),   amplitude = 2 |A|                 (8)
//! ```
//!
//! (1) is a spectral estimate by few lags (Blackman and Tukey) near the kinematic order, one slip for all harmonics.
//! Without a defect P at one δ is a χ² of ν degrees of freedom, whatever the number of turns; its cube root is nearly
//! normal (Wilson and Hilferty 1931), and M independent slips raise the largest of them: (5) is about standard normal
//! for any number of turns.
//!
//! (7): the imaginary part of a product of two blocks of noise has the variance `σ⁴ W_n W_m/2`, and P′ is a sum of
//! 2 (1 − d/7) d h of them. A product of noise and defect adds at most 2 |A|² W/σ² times as much; pairs before and after
//! a block have opposite signs, so at constant speed most of it cancels, and next to a reversal none. (7) counts half.
//! A motion that reverses adds a systematic error of about 0.001 to the slip of a defect: the middle of a passage that
//! reverses is not that of its cell.

use super::orders::{LineSums, Noise, PLACES, TrackedOrder};
use super::phasor::phasor;

/// Slips that are tried on each side of zero.
const SIDE: i8 = 8;
/// Γ(5/4), the mean of the fourth root of an exponential variable.
const ROOT_MEAN: f32 = 0.906_402_5;

/// How much an order exceeds the noise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct OrderStrength {
    /// (3): about one without a defect.
    pub prominence: f32,
    /// (5): about standard normal without a defect, whatever the number of turns.
    pub score: f32,
    /// Amplitude (8) of the first harmonic, in units of the residual; zero if it does not exceed the noise.
    pub amplitude: f32,
    /// Standard deviation of the amplitude.
    pub deviation: f32,
    /// Relative slip of the cage at which the order is strongest.
    pub slip: f32,
    /// Standard deviation (6) of the slip, if there is a defect.
    pub slip_deviation: f32,
}

/// The search under way, one slip a step.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct SlipSearch {
    next: i8,
    best: f32,
    best_at: i8,
    /// P before and after the best one.
    around: [f32; 2],
    last: f32,
}

/// What a search needs besides the sums.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SlipRange {
    /// L, turns of a cell.
    pub cell_turns: f32,
    /// Largest slip.
    pub slip: f32,
}

impl SlipSearch {
    pub(super) const fn new() -> Self {
        Self { next: -SIDE, best: f32::NEG_INFINITY, best_at: 0, around: [f32::NEG_INFINITY; 2], last: 0.0 }
    }

    /// Tries the next slip; the strength after the last one.
    #[inline(never)]
    pub(super) fn step(
        &mut self,
        sums: &LineSums,
        noise: &Noise,
        order: &TrackedOrder,
        range: &SlipRange,
    ) -> Option<OrderStrength> {
        let k = self.next;
        if k > SIDE {
            return Some(self.strength(sums, noise, order, range));
        }
        let value = spectrum(sums, order, turns(order, range, f32::from(k) / f32::from(SIDE)));
        if k == self.best_at.wrapping_add(1) && self.best_at != k {
            let [_, after] = &mut self.around;
            *after = value;
        }
        if value > self.best {
            (self.best, self.best_at) = (value, k);
            self.around = [if k > -SIDE { self.last } else { f32::NEG_INFINITY }, f32::NEG_INFINITY];
        }
        self.last = value;
        self.next = k.wrapping_add(1);
        None
    }

    #[inline(never)]
    fn strength(&self, sums: &LineSums, noise: &Noise, order: &TrackedOrder, range: &SlipRange) -> OrderStrength {
        let [w1, w2, w3] = order.weights;
        let [total, ..] = sums.weight;
        let weights = w1 + w2 + w3;
        let root = noise.roots / (f32::from(noise.count) * ROOT_MEAN);
        let variance = root * root * root * root; // (6) of the orders
        let (shift, curvature, best) = self.vertex();
        let step = range.slip / f32::from(SIDE);
        let slip = (f32::from(self.best_at) + shift) * step;
        let prominence = (best / variance / weights).max(0.0); // (3)
        let [square, pairs @ ..] = sums.pairs;
        let (mut noise_power, mut spread) = (square, 0.0);
        let mut steady = 0.0;
        for (d, pair) in (1_u8..).zip(pairs) {
            let far = f32::from(d);
            let t = taper(far);
            noise_power += 2.0 * t * t * pair;
            spread += 2.0 * t * t * pair * far * far;
            steady += t * pair;
        }
        let squares = w1 * w1 + w2 * w2 + w3 * w3;
        let freedom = 2.0 * weights * weights * total * total / (squares * noise_power); // (4)
        let relative = 2.0 / (9.0 * freedom);
        let cube_root = libm::cbrtf(prominence);
        let reach = 2.0 * turns(order, range, 1.0).abs() * libm::sqrtf(spread / noise_power);
        let independent = 1.0 + 2.0 * core::f32::consts::PI * reach;
        let score = (cube_root - 1.0 + relative) / libm::sqrtf(relative) - 0.7 * libm::logf(independent); // (5)
        let own = lag_sum(sums, 0, turns(order, range, (f32::from(self.best_at) + shift) / f32::from(SIDE)));
        let deviation = 2.0 * libm::sqrtf(variance / total);
        let turning = core::f32::consts::TAU * turns(order, range, 1.0).abs() / range.slip;
        let slopes = w1 * w1 + 4.0 * w2 * w2 + 9.0 * w3 * w3;
        let power = (own / steady).max(0.0);
        let crossed = 1.0 + power * square / (variance * total);
        let slope_deviation = variance * turning * libm::sqrtf(slopes * spread * crossed) / total; // (7)
        let slip_deviation = slope_deviation * step * step / curvature; // (6)
        OrderStrength {
            prominence,
            score,
            amplitude: 2.0 * libm::sqrtf(power), // (8)
            deviation,
            slip,
            slip_deviation: if curvature > 0.0 { slip_deviation.min(range.slip) } else { range.slip },
        }
    }

    /// Vertex of the parabola through the best slip and its neighbours: shift in steps, −P″ a step², P.
    fn vertex(&self) -> (f32, f32, f32) {
        let [before, after] = self.around;
        if before.is_finite() && after.is_finite() {
            let curvature = 2.0 * self.best - before - after;
            if curvature > 0.0 {
                let slope = 0.5 * (after - before);
                return (slope / curvature, curvature, self.best + 0.5 * slope * slope / curvature);
            }
        }
        (0.0, 0.0, self.best)
    }
}

/// 1 − d/7.
fn taper(d: f32) -> f32 {
    1.0 - d / (f32::from(PLACES) + 1.0)
}

/// ψ of (2) in turns at a part of the range.
fn turns(order: &TrackedOrder, range: &SlipRange, part: f32) -> f32 {
    order.order() * order.slip_ratio * range.slip * range.cell_turns * part
}

/// `Σ_d (1 − d/7) Re(R(h, d) e^{−2πj d turns})` by Horner's rule from the longest lag.
#[inline(always)]
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "takes the fraction of a turn")]
fn lag_sum(sums: &LineSums, h: usize, turns: f32) -> f32 {
    let fraction = turns - turns as i32 as f32;
    let bits = (fraction * 4_294_967_296.0) as i64 as u32;
    let (cos, sin) = phasor(bits);
    let (mut x, mut y) = (0.0, 0.0);
    let lags = sums.lags.get(h).map_or(&[][..], |lags| lags.as_slice());
    let mut longest = lags;
    while let [shorter @ .., [rx, ry]] = longest {
        let t = taper(longest.len() as f32);
        let (ax, ay) = (x + t * rx, y + t * ry);
        (x, y) = (ax * cos + ay * sin, ay * cos - ax * sin);
        longest = shorter;
    }
    x
}

/// (1) times σ², the harmonics weighted.
#[inline(never)]
fn spectrum(sums: &LineSums, order: &TrackedOrder, turns_first: f32) -> f32 {
    let mut value = 0.0;
    for (h, weight) in order.weights.iter().enumerate() {
        let (Some(power), Some(total)) = (sums.power.get(h), sums.weight.get(h)) else { break };
        if *weight > 0.0 && *total > 0.0 {
            let sum = lag_sum(sums, h, turns_first * (h as f32 + 1.0));
            value += weight * (power + 2.0 * sum) / total;
        }
    }
    value
}
