//! The law of the distance of a further segment from a mean and covariance of few segments.
//!
//! ```text
//! d² ~ a F(p, ν),  a = p f g/ν,  ν = f − p + 1                           (1)  f: degrees of freedom of the covariance
//! g  = 1 + 1/κ                                                           (2)  κ: number of segments of the mean
//! u_i² ~ as (1) with p = 1, ν = f − i + 1                               (3)  of the i-th coordinate given those before
//! 1/ν' = 1/ν + h,  a chosen so that E d² is as in (1)                    (4)  h: tails heavier than normal
//! P(F ≥ x) = I_y(ν/2, p/2),  y = ν/(ν + p x)                             (5)  regularised incomplete beta function
//! ```
//!
//! (1) is Hotelling's distribution (1931), (3) its step-down form (Rao 1973, §8b.4): [`super::super::rising`] divides
//! by the distance of the coordinates before. h of (4) is that of the trained law: from two of its knots follow the
//! degrees of freedom of an F of the same shape, less those of the trained covariance. (5) is evaluated by its
//! continued fraction (Press et al., Numerical Recipes, §6.4), whose number of terms grows as √ν.

use crate::decide::{KNOTS, Law};
use crate::logarithm::ln;
use crate::regression::factor::pairs;

/// Largest h of (4): E d² exists.
const HEAVIEST: f32 = 0.4;
/// Least ν' of (4).
const LEAST_DEGREES: f32 = 2.1;
/// Terms of the continued fraction.
const TERMS: u32 = 200;
/// A quantile is within e^±`FAR`.
const FAR: f32 = 40.0;
/// Halvings of the intervals of a quantile and of h.
const HALVINGS: u32 = 28;
/// Surprise near which the shape of a trained law is compared with that at the limit, nats.
const BODY: f32 = 0.7;
/// Stirling's series is used from here on: its third term is below 6e-6.
const LARGE: f32 = 8.0;

/// The size of a baseline, as (1) has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Size {
    /// f.
    pub freedom: f32,
    /// g of (2).
    pub factor: f32,
    /// f of the trained covariance; infinite if it is not known.
    pub trained_freedom: f32,
}

impl Size {
    /// The law of d² of `count` coordinates that come after `before` others, in place of the trained law, at the same
    /// surprises.
    pub(super) fn law(&self, trained: &Law, [before, count]: [usize; 2], limit: f32) -> Law {
        let p = count as f32;
        let taken = before as f32 + p - 1.0;
        let remaining = self.freedom - taken;
        let h = heaviness(trained, p, limit) - 1.0 / (self.trained_freedom - taken).max(1.0);
        let degrees = (1.0 / (1.0 / remaining + h.clamp(0.0, HEAVIEST))).max(LEAST_DEGREES); // (4)
        let mean = |degrees: f32| degrees / (degrees - 2.0);
        let scale = p * self.freedom * self.factor / remaining * mean(remaining.max(LEAST_DEGREES)) / mean(degrees);
        let mut law = [[0.0; 2]; KNOTS];
        for (knot, [_, surprise]) in pairs(&mut law, trained) {
            *knot = [scale * quantile(p, degrees, *surprise), *surprise];
        }
        law
    }
}

/// 1/ν of the F distribution whose quantiles at the limit and in the body have the ratio of those of a law.
#[inline(never)]
fn heaviness(law: &Law, p: f32, limit: f32) -> f32 {
    let from = |surprise: f32| law.iter().find(|[_, s]| *s >= surprise).copied().unwrap_or([1.0; 2]);
    // The limit of one of several laws is not exactly a knot.
    let ([near, body], [far, tail]) = (from(BODY), from(limit));
    let (mut low, mut high) = (0.0, 0.5);
    for _ in 0..HALVINGS / 2 {
        let middle = 0.5 * (low + high);
        let ratio = quantile(p, 1.0 / middle, tail) / quantile(p, 1.0 / middle, body);
        if ratio * near < far {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// x of (5) with −ln P(F ≥ x) = `surprise`; 0 for 0.
#[inline(never)]
fn quantile(p: f32, degrees: f32, surprise: f32) -> f32 {
    if surprise <= 0.0 {
        return 0.0;
    }
    let (mut low, mut high) = (-FAR, FAR);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if -ln_tail(p, degrees, libm::expf(middle)) < surprise {
            low = middle;
        } else {
            high = middle;
        }
    }
    libm::expf(0.5 * (low + high))
}

/// ln P(F ≥ x) by (5).
#[inline(never)]
fn ln_tail(p: f32, degrees: f32, x: f32) -> f32 {
    let (a, b, t) = (0.5 * degrees, 0.5 * p, p * x / degrees);
    let more = libm::log1pf(t);
    let common = b * (ln(t) - more) - a * more - ln_beta(a, b);
    let y = 1.0 / (1.0 + t);
    if y * (a + b + 2.0) < a + 1.0 {
        common + ln(fraction(a, b, y) / a)
    } else {
        // The probability of less is the smaller one here.
        libm::log1pf(-libm::expf(common + ln(fraction(b, a, t * y) / b)).min(1.0))
    }
}

/// The continued fraction of the incomplete beta function, by Lentz's method.
#[inline(never)]
fn fraction(a: f32, b: f32, x: f32) -> f32 {
    let kept = |x: f32| if x.abs() < 1e-30 { 1e-30 } else { x };
    let (mut c, mut d) = (1.0, 1.0 / kept(1.0 - (a + b) * x / (a + 1.0)));
    let (mut value, mut m) = (d, 0.0);
    for _ in 0..TERMS {
        m += 1.0;
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        let mut change = 1.0;
        for term in [even, odd] {
            d = 1.0 / kept(1.0 + term * d);
            c = kept(1.0 + term / c);
            change = c * d;
            value *= change;
        }
        if (change - 1.0).abs() < 1e-7 {
            break;
        }
    }
    value
}

/// ln B(a, b) for b a multiple of ½.
#[inline(never)]
fn ln_beta(a: f32, b: f32) -> f32 {
    // ln Γ(b) from Γ(1) = 1 or Γ(½) = √π upwards.
    let (mut argument, mut of_b) = if 2.0 * (b - libm::floorf(b)) >= 1.0 { (0.5, 0.572_364_9) } else { (1.0, 0.0) };
    while argument < b {
        of_b += ln(argument);
        argument += 1.0;
    }
    let (mut a, mut ratio) = (a, 0.0); // ln Γ(a + b) − ln Γ(a)
    while a < LARGE {
        ratio -= ln((a + b) / a);
        a += 1.0;
    }
    let sum = a + b;
    ratio += (a - 0.5) * libm::log1pf(b / a) + b * (ln(sum) - 1.0) + (1.0 / sum - 1.0 / a) / 12.0;
    of_b - ratio
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_coordinates_have_a_closed_form() {
        // P(F(2, ν) ≥ x) = (1 + 2 x/ν)^(−ν/2).
        for degrees in [3.0_f32, 7.5, 27.0, 200.0, 3000.0] {
            for x in [1e-3_f32, 0.1, 0.7, 2.0, 9.0, 60.0] {
                let closed = -0.5 * degrees * (2.0 * x / degrees).ln_1p();
                let tail = ln_tail(2.0, degrees, x);
                // Roundings of terms of the size of ν ln ν.
                assert!(
                    (tail - closed).abs() < 2e-5 * closed.abs().max(1.0) + 2e-7 * degrees,
                    "{degrees} {x}: {tail} {closed}"
                );
                let back = quantile(2.0, degrees, -closed);
                assert!((back / x - 1.0).abs() < 1e-3, "{degrees} {x}: {back}");
            }
        }
    }

    #[test]
    fn tabulated_quantiles() {
        // The upper 1 % points of F (Abramowitz and Stegun, Table 26.9), and of chi-square/p.
        for (p, degrees, expected) in
            [(1.0, 10.0, 10.04), (3.0, 10.0, 6.55), (5.0, 20.0, 4.10), (10.0, 30.0, 2.98), (8.0, 5.0, 10.29)]
        {
            let point = quantile(p, degrees, 100.0_f32.ln());
            assert!((point / expected - 1.0).abs() < 2e-3, "{p} {degrees}: {point}");
        }
        let point = quantile(3.0, 1e5, 100.0_f32.ln());
        assert!((point - 11.345 / 3.0).abs() < 2e-3, "{point}");
    }

    #[test]
    fn the_heaviness_of_a_law_is_found_and_kept() {
        let mut grid = [[0.0; 2]; KNOTS];
        for (k, knot) in (0_u16..).zip(&mut grid) {
            *knot = [f32::from(k), 0.0625 * f32::from(k * k)];
        }
        let limit = 4.605_17;
        let known = Size { freedom: 1e5, factor: 1.0, trained_freedom: 1.0 };
        for (count, degrees) in [(1_u8, 8.0), (3, 30.0), (6, 15.0)] {
            let (p, place) = (f32::from(count), [0, usize::from(count)]);
            let heavy = grid.map(|[_, s]| [5.0 * quantile(p, degrees, s), s]);
            let heaviness_of_law = heaviness(&heavy, p, limit);
            assert!((heaviness_of_law * degrees - 1.0).abs() < 0.02, "{p} {degrees}: {heaviness_of_law}");
            let law = known.law(&heavy, place, limit);
            assert!(law.windows(2).all(|pair| pair[0][0] < pair[1][0]), "{law:?}");
            // Of known mean and covariance the normal law remains.
            let normal = Size { trained_freedom: degrees + p - 1.0, ..known }.law(&heavy, place, limit);
            let at = normal.iter().find(|[_, s]| *s >= limit).unwrap();
            assert!((at[0] / p / quantile(p, 1e5, at[1]) - 1.0).abs() < 0.02, "{at:?}");
        }
    }

    #[test]
    fn coordinates_before_cost_degrees_of_freedom() {
        // A normal law: chi-square of two degrees of freedom is twice its surprise.
        let mut normal = [[0.0; 2]; KNOTS];
        for (k, knot) in (0_u16..).zip(&mut normal) {
            *knot = [0.5 * f32::from(k), 0.25 * f32::from(k)];
        }
        let size = Size { freedom: 10.0, factor: 1.1, trained_freedom: f32::INFINITY };
        for (before, degrees) in [(0, 9.0_f32), (1, 8.0), (3, 6.0)] {
            // (1) with p = 2, and P(F(2, ν) ≥ x) = (1 + 2 x/ν)^(−ν/2).
            let expected = |s: f32| 2.0 * 10.0 * 1.1 / degrees * (0.5 * degrees * (2.0 * s / degrees).exp_m1());
            for [squared, s] in size.law(&normal, [before, 2], 4.605_17).into_iter().skip(1) {
                // The accuracy to which the shape of the trained law is found.
                assert!((squared / expected(s) - 1.0).abs() < 0.02, "{before}, {s}: {squared} {}", expected(s));
            }
        }
    }
}
