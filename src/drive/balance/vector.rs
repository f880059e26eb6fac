//! The current vector of a window: does it turn with the rotor, and around which point?
//!
//! Enters: phase currents and electrical angles, about uniform over whole turns. Leaves: (3) and (4).
//!
//! ```text
//! i = α + j β,   e = exp(j θ),   d + j q = i e*                                             (1)
//! S = Σ (d + j q)²,   M = Σ (d + j q),   A = Σ i,   E = Σ e,   P = Σ |i|²                   (2)
//! D = Σ (d + j q)ₖ (d + j q)*ₖ₋₁, its conjugate where the shaft turned backward
//! aligned if |S| > 0.3 P or |M|² > 0.1 n P, and beyond what noise gives once in 10⁶ windows  (3)
//! misaligned if neither holds, |D| > ½ P and |A|² < 0.1 n P
//! o = (A − E M/n) / (n − |E|²/n),   σ_o = √((P/n − |M|²/n²)/n)                              (4) offset of i
//! ```
//!
//! Under field-oriented control d + j q has one direction or its opposite, so that its square does not average out:
//! |S| = P; a current along d (field weakening) has a mean. Seen at another angle than that of the rotor, because the
//! angle or two phases are exchanged or the pole pairs are wrong, the vector turns, and so do d + j q and its square.
//! That it turns, and is not noise, shows in D, to which white noise adds nothing; that it is no offset, in A. Neither
//! needs the noise of the sensors. Of complex white noise |S|²/P² has the mean 2/n, |M|²/(n P) the mean 1/n, both with
//! an exponential distribution: 14 means are exceeded once in 10⁶ windows.
//!
//! Offsets of the sensors stand still in α, β. (4) is the least-squares solution of i = o + e (d + j q) with constant
//! d + j q, and its deviation that of a d + j q with independent changes.

use crate::signal::{Abc, AlphaBeta, Dq0, Park, SinCos};

/// Parts of P below which S and M are those of a vector that turns in the frame of the rotor.
const COHERENT: f32 = 0.3;
const MEAN: f32 = 0.1;
/// What noise reaches once in 10⁶ windows, in means.
const CHANCE: f32 = 14.0;
/// Part of P from which on D is that of a vector that turns.
const TURNS: f32 = 0.5;
/// Part of n P from which on A is that of offsets.
const STANDS: f32 = 0.1;
/// Largest |E|²/n² for (4): the angles must be about uniform.
const UNIFORM: f32 = 0.25;

/// The sums (2), without P.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Vector {
    square: [f32; 2],
    mean: [f32; 2],
    stator: AlphaBeta,
    turn: [f32; 2],
    lag: [f32; 2],
    /// d and q of the sample before.
    last: [f32; 2],
}

impl Vector {
    /// No samples of the window that follows this one.
    pub(super) fn restart(&mut self) {
        *self = Self { last: self.last, ..Self::default() };
    }

    /// Takes the currents at one instant, to which the shaft has turned forward or backward.
    #[inline(always)]
    pub(super) fn take(&mut self, currents: Abc, turn: SinCos, backward: bool) {
        let stator = currents.clarke();
        // The convention of the sign of q is of no account in (3) and (4).
        let Dq0 { d, q, .. } = Park::Standard.forward(stator, turn);
        let ([re, im], [d_sum, q_sum], [cos, sin]) = (&mut self.square, &mut self.mean, &mut self.turn);
        *re += d * d - q * q;
        *im += 2.0 * d * q;
        *d_sum += d;
        *q_sum += q;
        *cos += turn.cos;
        *sin += turn.sin;
        let [d_last, q_last] = core::mem::replace(&mut self.last, [d, q]);
        let ([lag_re, lag_im], turned) = (&mut self.lag, q * d_last - d * q_last);
        *lag_re += d * d_last + q * q_last;
        *lag_im += if backward { -turned } else { turned };
        self.stator.alpha += stator.alpha;
        self.stator.beta += stator.beta;
        self.stator.zero += stator.zero;
    }

    /// (3) of n samples with the power P: whether they turn with the rotor; `None` if they do not tell.
    pub(super) fn is_aligned(&self, power: f32, n: f32) -> Option<bool> {
        let AlphaBeta { alpha, beta, .. } = self.stator;
        let of = [self.square, self.mean, self.lag, [alpha, beta]].map(|[re, im]| re * re + im * im);
        let [square, mean, lag, stands] = of.map(|sum| sum / (power * power));
        // Compared so that quotients that are not numbers tell nothing.
        let chance = CHANCE / n;
        if square > (COHERENT * COHERENT).max(2.0 * chance) || mean * power > n * MEAN.max(chance) {
            return Some(true);
        }
        let apart = square < COHERENT * COHERENT && mean * power < n * MEAN;
        (apart && lag > TURNS * TURNS && stands * power < n * STANDS).then_some(false)
    }

    /// The deviation of (4).
    pub(super) fn deviation(&self, power: f32, n: f32) -> f32 {
        let [d, q] = self.mean;
        libm::sqrtf(((power - (d * d + q * q) / n) / (n * n)).max(0.0))
    }

    /// o of (4), as offsets of the phases; `None` if the angles were not uniform.
    pub(super) fn offsets(&self, n: f32) -> Option<[f32; 3]> {
        let [[d, q], [cos, sin]] = [self.mean, self.turn];
        let spread = (cos * cos + sin * sin) / n;
        if spread > UNIFORM * n {
            return None;
        }
        let AlphaBeta { alpha, beta, zero } = self.stator;
        let left = n - spread;
        let offset = AlphaBeta {
            alpha: (alpha - (cos * d - sin * q) / n) / left,
            beta: (beta - (cos * q + sin * d) / n) / left,
            zero: zero / n,
        };
        let Abc { a, b, c } = offset.inverse_clarke();
        Some([a, b, c])
    }

    /// Mean of the phase currents.
    pub(super) fn phase_means(&self, n: f32) -> [f32; 3] {
        let Abc { a, b, c } = self.stator.inverse_clarke();
        [a / n, b / n, c / n]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::Angle;

    #[test]
    fn the_offset_of_a_window_that_is_not_one_of_whole_turns_is_exact() {
        let (mut vector, mut n, mut power) = (Vector::default(), 0.0, 0.0);
        // One turn and a third; 5 A along q, 1 A along d, and offsets of 0.3 and −0.2 A.
        for k in 0..64_u32 {
            let turn = Angle::from_bits(k.wrapping_mul(89_478_485)).sin_cos();
            let current = Park::Standard.inverse(Dq0 { d: 1.0, q: 5.0, zero: 0.0 }, turn).inverse_clarke();
            let currents = Abc { a: current.a + 0.3, b: current.b - 0.2, c: current.c };
            vector.take(currents, turn, false);
            let AlphaBeta { alpha, beta, .. } = currents.clarke();
            (n, power) = (n + 1.0, power + alpha * alpha + beta * beta);
        }
        let [a, b, c] = vector.offsets(n).unwrap();
        // Sums of 64 numbers of 5 A.
        assert!((a - 0.3).abs() < 1e-4 && (b + 0.2).abs() < 1e-4 && c.abs() < 1e-4, "{a} {b} {c}");
        assert_eq!(vector.is_aligned(power, n), Some(true));
        // The offset itself turns in the frame of the rotor: 0.29 A, in 64 samples.
        assert!((0.02..0.06).contains(&vector.deviation(power, n)), "{}", vector.deviation(power, n));
    }

    #[test]
    fn a_shaft_that_swings_tells_no_offset() {
        let mut vector = Vector::default();
        for k in 0..64_u32 {
            let turn = Angle::from_bits((k % 2) * (1 << 28)).sin_cos();
            vector.take(Abc { a: 1.0, b: -0.5, c: -0.5 }, turn, k % 2 == 0);
        }
        assert_eq!(vector.offsets(64.0), None);
    }
}
