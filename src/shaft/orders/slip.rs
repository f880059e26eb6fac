//! Products of block phasors → strength, amplitude and slip of a bearing order.
//!
//! Enters: [`LineSums`] of [`super::line`]. Leaves: an [`OrderStrength`].
//!
//! ```text
//! P(δ) = Σ_h w_h [R(h, 0) + 2 Σ_d (1 − d/7) Re(R(h, d) e^{−j d h ψ})] / (σ_h² W(h))                   (1)
//! ψ = 2π O c δ L,   c: ratio of the order's slip to the cage's,   L: turns of a cell                  (2)
//! prominence = max P(δ) / Σ w_h   over |δ| ≤ slip                                                     (3)
//! ν = 2 (Σ w_h)² W² / (Σ w_h² [V(0) + 2 Σ_d (1 − d/7)² V(d)])                                         (4)
//! score = ((1 − b) prominence^⅓ − 1 + a − 0.7 √a₁ ln M) / √(a₁/(1 + 0.2 ln M)² + a₀ + b prominence^⅔) (5)
//! a = 2/(9ν) = a₀ + a₁,   a₀/a: part of V(0) in the bracket of (4),   b: a ninth of Var ln σ²
//! slip deviation = √(Var P′)/(−P″)   at the largest P                                                  (6)
//! Var P′ = (dψ/dδ)² Σ_h (h w_h σ_c²/σ_h²)² · 2 Σ_d (1 − d/7)² d² V(d)/W² · (1 + |A|² V(0)/(σ_c² W)) (7)
//! |A|² = Σ_d (1 − d/7) Re(R(1, d) e^{−jdψ}) / Σ_d (1 − d/7) V(d),   amplitude = 2 |A|                 (8)
//! σ_h² = max(clamp(2 m₂ − 3 σ_c², σ_c², 4 σ_c²), m₃)                                                  (9)
//! m_k = [R(h, 0) − k V(0) √(Σ_d |R(h, d)|²/Σ_d V(d)²)]/W(h)
//! ```
//!
//! The noise at the order's harmonic h is `σ_h²`, at least `σ_c²` of the control orders ([`super::noise`]). A resonance
//! of the mechanics or a line of the rotor may leave more noise at an order than between the control orders, above all
//! at constant speed. It adds to the power R(h, 0) of each block, but unlike a defect it does not stay in phase from
//! one block to the next. By (9) the power counts as noise if less than half of it stays in phase: the pulses of a
//! defect vary, so a part of their power does not stay in phase either. V(d) of the first harmonic is used for all
//! harmonics, since its ratios are the same. Power of less than twice `σ_c²` is within the scatter of few blocks and
//! does not count; above three times all of it does. The limit of four prevents that strong defects count as noise; it
//! does not apply if less than a third of the power stays in phase.
//!
//! (1) is a spectral estimate by few lags (Blackman and Tukey) near the kinematic order, one slip for all harmonics.
//! Without a defect P at one δ is a χ² of ν degrees of freedom, whatever the number of turns; its cube root is nearly
//! normal (Wilson and Hilferty 1931). The noise is estimated too; their ratio then follows an F distribution, of which
//! (5) is the normal score (Paulson 1942), at most 1/√b. Where P varies with the slip, it takes M independent values;
//! the largest of M normal numbers has about the mean 0.7 ln M and the deviation 1/(1 + 0.2 ln M), both within 0.1 for
//! M to 10. So (5) is about standard normal for any number of turns and any range of slips.
//!
//! (7): the imaginary part of a product of two blocks of noise has the variance `σ⁴ W_n W_m/2`, and P′ is a sum of
//! 2 (1 − d/7) d h of them. A product of noise and defect adds at most 2 |A|² W/`σ_c²` times as much; pairs before and
//! after a block have opposite signs, so at constant speed most of it cancels, and next to a reversal none. (7) counts
//! half. A motion that reverses adds a systematic error of about 0.001 to the slip of a defect: the middle of a passage
//! that reverses is not that of its cell.

use core::f32::consts::PI;

use super::blocks::{LAGS, PLACES, TrackedOrder};
use super::line::LineSums;
use super::noise::NoiseLine;
use super::phasor::phasor;
use crate::logarithm::ln;
use crate::plan::MAX_HARMONICS;

/// Slips that are tried on each side of zero.
const SIDE: i8 = 8;

/// How much an order exceeds the noise.
#[derive(Clone, Copy, Debug, PartialEq)]
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

impl OrderStrength {
    const NONE: Self =
        Self { prominence: 0.0, score: 0.0, amplitude: 0.0, deviation: 0.0, slip: 0.0, slip_deviation: 0.0 };
}

impl Default for OrderStrength {
    fn default() -> Self {
        Self::NONE
    }
}

/// Products d h in (1): phases of its terms, in ψ.
const COMBINED: usize = LAGS * MAX_HARMONICS;
// `parts` takes terms in pairs, those of a harmonic too.
const _: () = assert!(LAGS.is_multiple_of(2));

/// The search under way, one slip a step.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(in crate::shaft) struct SlipSearch {
    /// What the next step does: before the first slip, it takes the noise and combines the harmonics; after the last,
    /// it forms the results.
    next: i8,
    /// The terms of (1) by their phases d h ψ, and the one without a phase.
    terms: [[f32; 2]; COMBINED],
    constant: f32,
    /// The first sum of (7).
    slopes: f32,
    /// P at the last slip on each side of zero.
    last: [f32; 2],
    /// The largest P, its slip, and P at the slips below and above it.
    best: f32,
    best_at: i8,
    around: [f32; 2],
    found: OrderStrength,
    /// Of the prominence.
    cube_root: f32,
    /// `σ_c²` at the order, and of −P″ (6) a squared step.
    variance: f32,
    curvature: f32,
    /// b of (5), a, a₀/a, and ln M.
    uncertain: f32,
    relative: f32,
    constant_part: f32,
    log_slips: f32,
    /// Σ V(d)²/V(0)², V(0) + 2 Σ (1 − d/7)² V(d), 2 Σ (1 − d/7)² d² V(d), and Σ (1 − d/7) V(d).
    squared_pairs: f32,
    noise_power: f32,
    spread: f32,
    steady: f32,
    /// |A|² of (8).
    power: f32,
}

/// What a search needs besides the sums.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::shaft) struct SlipRange {
    /// L, turns of a cell.
    pub cell_turns: f32,
    /// Largest slip.
    pub slip: f32,
}

impl SlipSearch {
    pub(in crate::shaft) const fn new() -> Self {
        Self {
            next: LEVEL,
            terms: [[0.0; 2]; COMBINED],
            constant: 0.0,
            slopes: 0.0,
            last: [f32::NEG_INFINITY; 2],
            best: f32::NEG_INFINITY,
            best_at: 0,
            around: [f32::NEG_INFINITY; 2],
            found: OrderStrength::NONE,
            cube_root: 0.0,
            variance: 0.0,
            curvature: 0.0,
            uncertain: 0.0,
            relative: 1.0,
            constant_part: 0.0,
            log_slips: 0.0,
            squared_pairs: 0.0,
            noise_power: 0.0,
            spread: 0.0,
            steady: 0.0,
            power: 0.0,
        }
    }

    /// Does the next step; the strength after the last one.
    #[inline(never)]
    pub(in crate::shaft) fn step(
        &mut self,
        sums: &LineSums,
        noise: &NoiseLine,
        order: &TrackedOrder,
        range: &SlipRange,
    ) -> Option<OrderStrength> {
        let next = self.next;
        self.next = next.wrapping_add(1);
        match next {
            0..=SIDE => self.compare(next, turns(order, range, f32::from(next) / f32::from(SIDE))),
            PROMINENCE => self.prominence(order, range),
            NOISE => self.noise(sums),
            LAW => self.law(sums, order, range),
            SCORE => self.score(),
            AMPLITUDE => self.amplitude(sums, order, range),
            DEVIATIONS => {
                self.deviations(sums, order, range);
                return Some(self.found);
            }
            LEVEL => (self.variance, self.uncertain) = noise.at(order.order()),
            before => self.combine(sums, noise, order, usize::from(before.wrapping_sub(COMBINE).unsigned_abs())),
        }
        None
    }

    /// Adds the terms of a harmonic to those of equal phase.
    fn combine(&mut self, sums: &LineSums, noise: &NoiseLine, order: &TrackedOrder, h: usize) {
        let own = (order.weights.get(h), sums.power.get(h), sums.weight.get(h), sums.lags.get(h));
        let (Some(weight), Some(power), Some(total), Some(lags)) = own else { return };
        if *weight <= 0.0 || *total <= 0.0 {
            return;
        }
        let control = self.variance * noise.ratio(h);
        let squares: f32 = lags.as_flattened().iter().map(|x| x * x).sum();
        let unit = control * total;
        let in_phase = libm::sqrtf(squares / self.squared_pairs);
        // Without neighbouring blocks not a number.
        let excess = (power - 2.0 * in_phase) / unit - 2.0;
        let rest = (power - 3.0 * in_phase) / unit;
        // `clamp` may panic.
        let limited = if excess > 1.5 {
            4.0
        } else if excess > 0.0 {
            1.0 + 2.0 * excess
        } else {
            1.0
        };
        let noise = if rest > limited { rest } else { limited }; // (9)
        let relative = weight / noise;
        let slope = h.wrapping_add(1) as f32 * relative;
        self.slopes += slope * slope;
        let scale = relative / unit;
        self.constant += scale * power;
        let mut terms = self.terms.get_mut(h..).unwrap_or_default();
        for (d, [x, y]) in (1_u8..).zip(lags) {
            let twice = 2.0 * scale * taper(f32::from(d));
            // Phases (h + 1) d: every (h + 1)-th term.
            let [[sum_x, sum_y], rest @ ..] = terms else { return };
            *sum_x += twice * x;
            *sum_y += twice * y;
            terms = rest.get_mut(h..).unwrap_or_default();
        }
    }

    /// (1) at two opposite slips, `k` steps from zero, where ψ is so many turns at the upper one. Of equal values, as
    /// those of an order that does not slip, that nearest to slip zero is the largest.
    fn compare(&mut self, k: i8, turns: f32) {
        let (even, odd) = parts(&self.terms, turns);
        let [low, high] = [self.constant + even - odd, self.constant + even + odd];
        let [last_low, last_high] = self.last;
        self.add(k.wrapping_neg(), low, [f32::NEG_INFINITY, last_low]);
        self.add(k, high, [last_high, f32::NEG_INFINITY]);
        self.last = [low, high];
    }

    /// Takes P at a slip, of whose neighbours those next to zero are known.
    fn add(&mut self, at: i8, value: f32, around: [f32; 2]) {
        let [below, above] = &mut self.around;
        if value > self.best {
            (self.best, self.best_at, self.around) = (value, at, around);
        } else if at == self.best_at.wrapping_sub(1) {
            *below = value;
        } else if at == self.best_at.wrapping_add(1) {
            *above = value;
        }
    }

    /// Slip and (3).
    #[inline(never)]
    fn prominence(&mut self, order: &TrackedOrder, range: &SlipRange) {
        let (shift, curvature, best) = self.vertex();
        self.curvature = curvature;
        self.found.slip = (f32::from(self.best_at) + shift) * range.slip / f32::from(SIDE);
        let [w1, w2, w3] = order.weights;
        let prominence = (best / (w1 + w2 + w3)).max(0.0); // (3)
        // The cube root of libm works in double precision, which the chip does in software.
        self.cube_root = if prominence > f32::MIN_POSITIVE { libm::expf(ln(prominence) / 3.0) } else { 0.0 };
        self.found.prominence = prominence;
    }

    /// The sums over V of (4), (7), (8) and (9).
    fn noise(&mut self, sums: &LineSums) {
        let [square, lags @ ..] = sums.pairs;
        self.noise_power = square;
        for (d, pair) in (1_u8..).zip(lags) {
            let far = f32::from(d);
            let t = taper(far);
            let (once, twice) = (t * pair, 2.0 * t * t * pair);
            self.steady += once;
            self.squared_pairs += pair * pair;
            self.noise_power += twice;
            self.spread += twice * far * far;
        }
        self.squared_pairs /= square * square;
    }

    /// The numbers of (5) that depend on the sums: a, a₀/a, and ln M.
    fn law(&mut self, sums: &LineSums, order: &TrackedOrder, range: &SlipRange) {
        let ([w1, w2, w3], [total, ..]) = (order.weights, sums.weight);
        let (weights, squares) = (w1 + w2 + w3, w1 * w1 + w2 * w2 + w3 * w3);
        let freedom = 2.0 * weights * weights * total * total / (squares * self.noise_power); // (4)
        self.relative = 2.0 / (9.0 * freedom);
        let steady = sums.pairs.first().map_or(0.0, |square| square / self.noise_power);
        let varying = self.spread / (self.noise_power * (1.0 - steady)).max(f32::MIN_POSITIVE);
        self.constant_part = steady;
        self.log_slips = ln(1.0 + 4.0 * PI * turns(order, range, 1.0).abs() * libm::sqrtf(varying));
    }

    /// (5).
    #[inline(never)]
    fn score(&mut self) {
        let (root, own) = (self.cube_root, self.uncertain);
        let (relative, steady, log) = (self.relative, self.constant_part, self.log_slips);
        let of_slips = libm::sqrtf((relative * (1.0 - steady)).max(0.0));
        let excess = (1.0 - own) * root - 1.0 + relative - 0.7 * of_slips * log;
        let of_largest = of_slips / (1.0 + 0.2 * log);
        let variance = of_largest * of_largest + relative * steady + own * root * root;
        self.found.score = excess / libm::sqrtf(variance);
    }

    /// (8).
    fn amplitude(&mut self, sums: &LineSums, order: &TrackedOrder, range: &SlipRange) {
        let mut lags = sums.lags.first().copied().unwrap_or_default();
        for (d, [x, y]) in (1_u8..).zip(&mut lags) {
            let t = taper(f32::from(d));
            (*x, *y) = (*x * t, *y * t);
        }
        let (even, odd) = parts(&lags, turns(order, range, self.found.slip / range.slip.max(f32::MIN_POSITIVE)));
        self.power = ((even + odd) / self.steady).max(0.0);
        self.found.amplitude = 2.0 * libm::sqrtf(self.power);
    }

    /// (6) and (7), and the deviation of the amplitude.
    fn deviations(&mut self, sums: &LineSums, order: &TrackedOrder, range: &SlipRange) {
        let ([total, ..], [square, ..]) = (sums.weight, sums.pairs);
        let turning = 2.0 * PI * order.order() * order.slip_ratio.abs() * range.cell_turns;
        let crossed = 1.0 + self.power * square / (self.variance * total);
        let slope_deviation = turning * libm::sqrtf(self.slopes * self.spread * crossed) / total; // (7)
        let step = range.slip / f32::from(SIDE);
        let slip_deviation = slope_deviation * step * step / self.curvature; // (6)
        self.found.deviation = 2.0 * libm::sqrtf(self.variance / total);
        self.found.slip_deviation = if self.curvature > 0.0 { slip_deviation.min(range.slip) } else { range.slip };
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

/// Before the first slip the noise and a step for each harmonic, after the last one the results.
const COMBINE: i8 = -3;
const NOISE: i8 = COMBINE - 1;
const LEVEL: i8 = NOISE - 1;
const PROMINENCE: i8 = SIDE + 1;
const LAW: i8 = SIDE + 2;
const SCORE: i8 = SIDE + 3;
const AMPLITUDE: i8 = SIDE + 4;
const DEVIATIONS: i8 = SIDE + 5;

/// 1 − d/7.
fn taper(d: f32) -> f32 {
    1.0 - d / (f32::from(PLACES) + 1.0)
}

/// ψ of (2) in turns at a part of the range.
fn turns(order: &TrackedOrder, range: &SlipRange, part: f32) -> f32 {
    order.order() * order.slip_ratio * range.slip * range.cell_turns * part
}

/// `Σ_m Re r_m cos(m θ)` and `Σ_m Im r_m sin(m θ)`, m from one on, θ so many turns, by Clenshaw's recurrence: their sum
/// is `Re Σ_m r_m e^{−jmθ}`, their difference the same at −θ.
#[inline(never)]
#[expect(clippy::cast_possible_truncation, reason = "takes the fraction of a turn")]
fn parts(terms: &[[f32; 2]], turns: f32) -> (f32, f32) {
    let fraction = turns - turns as i32 as f32;
    let (cos, sin) = phasor(((fraction * 2_147_483_648.0) as i32).cast_unsigned() << 1);
    let twice = 2.0 * cos;
    let ([mut x, mut y], [mut next_x, mut next_y]) = ([0.0; 2], [0.0; 2]);
    // In pairs, no values have to be moved.
    for pair in terms.as_chunks::<2>().0.iter().rev() {
        let [[ax, ay], [bx, by]] = pair;
        (next_x, next_y) = (bx + twice * x - next_x, by + twice * y - next_y);
        (x, y) = (ax + twice * next_x - x, ay + twice * next_y - y);
    }
    (x * cos - next_x, y * sin)
}
