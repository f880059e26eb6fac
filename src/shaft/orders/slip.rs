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
use super::sight::{self, ProminenceLaw};
use crate::logarithm::ln;
use crate::plan::MAX_HARMONICS;
use crate::regression::factor::pairs;

/// Slips that are tried on each side of zero.
const SIDE: i8 = 8;

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
    /// Amplitude of the smallest defect that this segment shows, of the noise of the score, in units of the residual;
    /// infinite if it shows none.
    pub smallest: f32,
    /// The same over the deviation of the noise between the orders: how much the shaft has turned. A strong defect does
    /// not raise it.
    pub smallest_relative: f32,
    /// Whether the shaft has turned too little for a result ([`TrackedOrder::most_relative`]), and the order does not
    /// stand out: a strong defect also disturbs what is known of the noise.
    pub unseen: bool,
}

/// Products d h in (1): phases of its terms, in ψ.
const COMBINED: usize = LAGS * MAX_HARMONICS;
// `parts` takes terms in pairs, those of a harmonic too.
const _: () = assert!(LAGS.is_multiple_of(2));

/// The slips among which the largest P is looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::shaft) struct SlipRange {
    /// L, turns of a cell.
    pub cell_turns: f32,
    /// Largest slip.
    pub slip: f32,
}

impl SlipRange {
    /// ψ of (2) in turns at the largest slip.
    fn turns(&self, order: &TrackedOrder) -> f32 {
        order.order() * order.slip_ratio * self.slip * self.cell_turns
    }
}

/// An order whose largest P is known.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(in crate::shaft) struct Search {
    pairs: Pairs,
    /// `σ_c²` at the order, and b of (5).
    variance: f32,
    uncertain: f32,
    /// The first sum of (7).
    slopes: f32,
    /// g of [`super::sight`]: the prominence that a first harmonic of the size of the noise adds.
    gain: f32,
    /// The same with the noise of the control orders, which does not contain what is at the order itself.
    of_motion: f32,
    /// The largest P, its slip, and −P″ (6) a squared step.
    best: f32,
    slip: f32,
    curvature: f32,
}

impl Search {
    /// Looks for the largest P.
    #[inline(never)]
    pub(in crate::shaft) fn new(sums: &LineSums, noise: &NoiseLine, order: &TrackedOrder, range: &SlipRange) -> Self {
        let (variance, uncertain) = noise.at(order.order());
        let of_pairs = Pairs::of(sums.pairs);
        let power = Power::of(sums, &of_pairs, order, noise, variance);
        let peak = power.peak(range.turns(order));
        let (shift, curvature, best) = peak.vertex();
        let slip = (f32::from(peak.at) + shift) * range.slip / f32::from(SIDE);
        let [w1, w2, w3] = order.weights;
        let of_one = sight::IN_PHASE * of_pairs.coherent * variance / (w1 + w2 + w3);
        let [gain, of_motion] = power.harmonics.map(|sum| of_one * sum);
        Self { pairs: of_pairs, variance, uncertain, slopes: power.slopes, gain, of_motion, best, slip, curvature }
    }

    /// What the largest P says.
    #[inline(never)]
    pub(in crate::shaft) fn strength(&self, sums: &LineSums, order: &TrackedOrder, range: &SlipRange) -> OrderStrength {
        let [w1, w2, w3] = order.weights;
        let prominence = (self.best / (w1 + w2 + w3)).max(0.0); // (3)
        let power = self.amplitude_power(sums, order, range);
        let ([total, ..], square) = (sums.weight, self.pairs.square);
        let turning = 2.0 * PI * order.order() * order.slip_ratio.abs() * range.cell_turns;
        let crossed = 1.0 + power * square / (self.variance * total);
        let slope_deviation = turning * libm::sqrtf(self.slopes * self.pairs.spread * crossed) / total; // (7)
        let step = range.slip / f32::from(SIDE);
        let slip_deviation = slope_deviation * step * step / self.curvature; // (6)
        let law = self.law(sums, order, range);
        let smallest_relative = law.smallest(order.needed_score, self.of_motion);
        let score = law.score(prominence);
        // Written so that a value that is not a number shows nothing.
        let shows = smallest_relative <= order.most_relative;
        OrderStrength {
            prominence,
            score,
            smallest: smallest_relative * libm::sqrtf(self.variance * self.of_motion / self.gain),
            smallest_relative,
            unseen: !shows && score < order.needed_score,
            amplitude: 2.0 * libm::sqrtf(power), // (8)
            deviation: 2.0 * libm::sqrtf(self.variance / total),
            slip: self.slip,
            slip_deviation: if self.curvature > 0.0 { slip_deviation.min(range.slip) } else { range.slip },
        }
    }

    /// The law of the prominence, as (5) has it.
    #[inline(never)]
    fn law(&self, sums: &LineSums, order: &TrackedOrder, range: &SlipRange) -> ProminenceLaw {
        let Pairs { square, noise, spread, .. } = self.pairs;
        let ([w1, w2, w3], [total, ..]) = (order.weights, sums.weight);
        let (weights, squares) = (w1 + w2 + w3, w1 * w1 + w2 * w2 + w3 * w3);
        let freedom = 2.0 * weights * weights * total * total / (squares * noise); // (4)
        let relative = 2.0 / (9.0 * freedom);
        let steady = square / noise;
        let varying = spread / (noise * (1.0 - steady)).max(f32::MIN_POSITIVE);
        let log_slips = ln(1.0 + 4.0 * PI * range.turns(order).abs() * libm::sqrtf(varying));
        let of_slips = libm::sqrtf((relative * (1.0 - steady)).max(0.0));
        let of_largest = of_slips / (1.0 + 0.2 * log_slips);
        ProminenceLaw {
            relative,
            usual: 1.0 - relative + 0.7 * of_slips * log_slips,
            variance: of_largest * of_largest + relative * steady,
            uncertain: self.uncertain,
        }
    }

    /// |A|² of (8).
    #[inline(never)]
    fn amplitude_power(&self, sums: &LineSums, order: &TrackedOrder, range: &SlipRange) -> f32 {
        let mut lags = sums.lags.first().copied().unwrap_or_default();
        for (d, [x, y]) in (1_u8..).zip(&mut lags) {
            let t = taper(f32::from(d));
            (*x, *y) = (*x * t, *y * t);
        }
        let (even, odd) = parts(&lags, range.turns(order) * (self.slip / range.slip.max(f32::MIN_POSITIVE)));
        ((even + odd) / self.pairs.steady).max(0.0)
    }
}

/// Sums over the pairs of blocks, that is over the V(d) of the first harmonic.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Pairs {
    /// V(0).
    square: f32,
    /// Σ V(d)²/V(0)².
    squares: f32,
    /// V(0) + 2 Σ (1 − d/7)² V(d).
    noise: f32,
    /// 2 Σ (1 − d/7)² d² V(d).
    spread: f32,
    /// Σ (1 − d/7) V(d).
    steady: f32,
    /// V(0) + 2 Σ (1 − d/7) V(d).
    coherent: f32,
}

impl Pairs {
    /// The sums of (4), (7), (8) and (9).
    #[inline(never)]
    fn of([square, lags @ ..]: [f32; LAGS + 1]) -> Self {
        let mut sums = Self { square, squares: 0.0, noise: square, spread: 0.0, steady: 0.0, coherent: 0.0 };
        for (d, pair) in (1_u8..).zip(lags) {
            let far = f32::from(d);
            let t = taper(far);
            let (once, twice) = (t * pair, 2.0 * t * t * pair);
            sums.steady += once;
            sums.squares += pair * pair;
            sums.noise += twice;
            sums.spread += twice * far * far;
        }
        sums.squares /= square * square;
        sums.coherent = square + 2.0 * sums.steady;
        sums
    }
}

/// P(δ) of (1) by its terms.
#[derive(Clone, Copy, Debug)]
struct Power {
    /// The terms of (1) by their phases d h ψ, and the one without a phase.
    terms: [[f32; 2]; COMBINED],
    constant: f32,
    /// The first sum of (7).
    slopes: f32,
    /// `Σ w q W(h)/(σ_h² W(1)²)`, of the powers of a defect's harmonics; the same with `σ_c²`.
    harmonics: [f32; 2],
}

impl Power {
    /// Of all harmonics, with noise of this variance at the order.
    #[inline(never)]
    fn of(sums: &LineSums, of_pairs: &Pairs, order: &TrackedOrder, noise: &NoiseLine, variance: f32) -> Self {
        let mut power = Self { terms: [[0.0; 2]; COMBINED], constant: 0.0, slopes: 0.0, harmonics: [0.0; 2] };
        for (h, weight) in pairs(0..usize::MAX, &order.weights) {
            power.add(sums, of_pairs, h, *weight, variance * noise.ratio(h));
        }
        power
    }

    /// Adds the terms of a harmonic to those of equal phase, with `control` as its noise between the orders.
    #[inline(never)]
    fn add(&mut self, sums: &LineSums, pairs: &Pairs, h: usize, weight: f32, control: f32) {
        let of_harmonic = (sums.power.get(h), sums.weight.get(h), sums.lags.get(h));
        let (Some(power), Some(total), Some(lags)) = of_harmonic else { return };
        if weight <= 0.0 || *total <= 0.0 {
            return;
        }
        let squares: f32 = lags.as_flattened().iter().map(|x| x * x).sum();
        let unit = control * total;
        let in_phase = libm::sqrtf(squares / pairs.squares);
        // Without neighbouring blocks not a number.
        let excess = (power - 2.0 * in_phase) / unit - 2.0;
        let least = (power - 3.0 * in_phase) / unit;
        // `clamp` may panic.
        let limited = if excess > 1.5 {
            4.0
        } else if excess > 0.0 {
            1.0 + 2.0 * excess
        } else {
            1.0
        };
        let noise = if least > limited { least } else { limited }; // (9)
        let relative = weight / noise;
        let slope = h.wrapping_add(1) as f32 * relative;
        self.slopes += slope * slope;
        let scale = relative / unit;
        self.constant += scale * power;
        // V of a harmonic is that of the first one by the ratio of their weights.
        let [first, ..] = sums.weight;
        let part = total / first;
        let power = part * part * sight::POWERS.get(h).copied().unwrap_or(0.0);
        let [all, of_motion] = &mut self.harmonics;
        *all += scale * power;
        *of_motion += weight / unit * power;
        let mut terms = self.terms.get_mut(h..).unwrap_or_default();
        for (d, [x, y]) in (1_u8..).zip(lags) {
            let twice = 2.0 * scale * taper(f32::from(d));
            // Phases (h + 1) d: every (h + 1)-th term.
            let [[sum_x, sum_y], later @ ..] = terms else { return };
            *sum_x += twice * x;
            *sum_y += twice * y;
            terms = later.get_mut(h..).unwrap_or_default();
        }
    }

    /// The largest of P at [`SIDE`] slips on each side of zero, of a range of so many turns ψ. Of equal values, as
    /// those of an order that does not slip, that nearest to slip zero is the largest.
    #[inline(never)]
    fn peak(&self, turns: f32) -> Peak {
        let mut peak = Peak { value: f32::NEG_INFINITY, at: 0, around: [f32::NEG_INFINITY; 2] };
        let mut last = [f32::NEG_INFINITY; 2];
        for k in 0..=SIDE {
            let (even, odd) = parts(&self.terms, turns * (f32::from(k) / f32::from(SIDE)));
            let [low, high] = [self.constant + even - odd, self.constant + even + odd];
            let [last_low, last_high] = last;
            peak.compare(k.wrapping_neg(), low, [f32::NEG_INFINITY, last_low]);
            peak.compare(k, high, [last_high, f32::NEG_INFINITY]);
            last = [low, high];
        }
        peak
    }
}

/// The largest P, its slip, and P at the slips below and above it.
#[derive(Clone, Copy, Debug)]
struct Peak {
    value: f32,
    at: i8,
    around: [f32; 2],
}

impl Peak {
    /// Takes P at a slip, of whose neighbours those next to zero are known.
    #[inline(always)]
    fn compare(&mut self, at: i8, value: f32, around: [f32; 2]) {
        let [below, above] = &mut self.around;
        if value > self.value {
            *self = Self { value, at, around };
        } else if at == self.at.wrapping_sub(1) {
            *below = value;
        } else if at == self.at.wrapping_add(1) {
            *above = value;
        }
    }

    /// Vertex of the parabola through the best slip and its neighbours: shift in steps, −P″ a step², P.
    fn vertex(&self) -> (f32, f32, f32) {
        let [before, after] = self.around;
        if before.is_finite() && after.is_finite() {
            let curvature = 2.0 * self.value - before - after;
            if curvature > 0.0 {
                let slope = 0.5 * (after - before);
                return (slope / curvature, curvature, self.value + 0.5 * slope * slope / curvature);
            }
        }
        (0.0, 0.0, self.value)
    }
}

/// 1 − d/7.
fn taper(d: f32) -> f32 {
    1.0 - d / (f32::from(PLACES) + 1.0)
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
