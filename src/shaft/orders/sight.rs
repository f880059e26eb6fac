//! What a segment would have shown: the amplitude of the smallest defect at an order.
//!
//! Enters: turns and noise of the segment, as the score of [`super::slip`] has them, and the expected score that a
//! defect needs. Leaves: the amplitude of its first harmonic.
//!
//! ```text
//! score = ((1 − b) x − u)/√(v + b x²),   x = prominence^⅓                                              (1)
//! x_n:  score(x_n) = n                                                                                (2)
//! E prominence = 1 + g ρ²,   g = ⅘ Z σ_c²/W(1)² Σ_h w_h q_h W(h)/σ_h² / Σ_h w_h                        (3)
//! Z = V(0) + 2 Σ_d (1 − d/7) V(d)
//! E x = (1 + κ)^⅓ (1 − a (1 + c)/(1 + κ)),   κ = g ρ²,   c = κ/(1 + κ)                                (4)
//! smallest amplitude = 2 ρ σ_c,   where E x = x_n                                                      (5)
//! ```
//!
//! (1) is the score of [`super::slip`] as a function of the cube root of the prominence: a = 2/(9ν), u its usual mean,
//! v its variance, b the uncertainty of the noise. ρ is the amplitude |A| of the defect over the deviation `σ_c` of
//! the noise at the order. (3): blocks of a defect are A W with the phases of its angle, so that R(h, d) has `|A_h|²`
//! V(d) W(h)²/W(1)². The harmonics of pulses of a tenth to half of a period have the powers q = 1, ½, ¼ of the first
//! one. Pulses vary with load, slip and lubrication: four fifths of their power are taken as that which stays in
//! phase. (4) is the mean of the cube root of a noncentral χ² (Abdel-Aty 1954). A record of more turns has larger V
//! and W, and so shows a smaller defect; where the shaft hardly turned none does.
//!
//! The score n that a defect needs contains what else differs between healthy segments: the model has it
//! ([`TrackedOrder::needed_score`](super::blocks::TrackedOrder::needed_score)), by the gate of its classifier.

use crate::logarithm::cube_root;
use crate::plan::MAX_HARMONICS;

/// q of (3).
pub(super) const POWERS: [f32; MAX_HARMONICS] = [1.0, 0.5, 0.25];
/// Part of the power of a defect that stays in phase.
pub(super) const IN_PHASE: f32 = 0.8;
/// Steps of (4): each divides the error by about ν.
const STEPS: usize = 3;

/// The law of the prominence without a defect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ProminenceLaw {
    /// a of (4).
    pub relative: f32,
    /// u, v and b of (1).
    pub usual: f32,
    pub variance: f32,
    pub uncertain: f32,
}

impl ProminenceLaw {
    /// (1).
    #[inline(never)]
    pub(super) fn score(&self, prominence: f32) -> f32 {
        let root = cube_root(prominence);
        let excess = (1.0 - self.uncertain) * root - self.usual;
        excess / libm::sqrtf(self.variance + self.uncertain * root * root)
    }

    /// 2 ρ of (5) for an expected score n; infinite if no defect has it.
    #[inline(never)]
    pub(super) fn smallest(&self, needed: f32, gain: f32) -> f32 {
        let root = self.root_of(needed);
        let mut level = root * root * root;
        for _ in 0..STEPS {
            level = self.level_of(root, level);
        }
        let ratio = (level - 1.0) / gain;
        // Written so that a value that is not a number shows nothing.
        if ratio < f32::INFINITY { 2.0 * libm::sqrtf(ratio.max(0.0)) } else { f32::INFINITY }
    }

    /// 1 + κ of (4) for the cube root in it, from a level near it.
    #[inline(never)]
    fn level_of(&self, root: f32, near: f32) -> f32 {
        let crossed = if near > 1.0 { 1.0 - 1.0 / near } else { 0.0 };
        let mean = 1.0 - self.relative * (1.0 + crossed) / near.max(1.0);
        let of_root = root / mean.max(0.1);
        of_root * of_root * of_root
    }

    /// (2): the larger root of ((1 − b) x − u)² = n² (v + b x²); infinite if the score stays below n.
    fn root_of(&self, needed: f32) -> f32 {
        let Self { usual, variance, uncertain, .. } = *self;
        let (slope, square) = (1.0 - uncertain, needed * needed);
        let leading = slope * slope - square * uncertain;
        let inner = slope * slope * usual * usual - leading * (usual * usual - square * variance);
        if leading > 0.0 && needed > 0.0 {
            (slope * usual + libm::sqrtf(inner.max(0.0))) / leading
        } else {
            f32::INFINITY
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of so many degrees of freedom, one slip, and noise that is known but for b.
    fn law(freedom: f32, uncertain: f32) -> ProminenceLaw {
        let relative = 2.0 / (9.0 * freedom);
        ProminenceLaw { relative, usual: 1.0 - relative, variance: relative, uncertain }
    }

    #[test]
    fn the_smallest_defect_has_the_needed_score_in_the_mean() {
        for (freedom, uncertain, needed) in [(20.0, 0.0, 4.0), (60.0, 0.002, 4.0), (200.0, 0.001, 2.5)] {
            let (law, gain) = (law(freedom, uncertain), 5.0);
            let amplitude = law.smallest(needed, gain);
            let noncentral = gain * amplitude * amplitude / 4.0;
            // Sankaran's moments of the cube root, by numerical integration of a normal law of the prominence: the
            // prominence has the mean 1 + κ and the variance (2 + 4 κ)/ν.
            let (mean, deviation) =
                (f64::from(1.0 + noncentral), (f64::from(2.0 + 4.0 * noncentral) / f64::from(freedom)).sqrt());
            let (mut sum, mut total) = (0.0, 0.0);
            for k in -400..=400 {
                let z = f64::from(k) / 100.0;
                let weight = (-0.5 * z * z).exp();
                sum += weight * f64::from(law.score((mean + z * deviation) as f32));
                total += weight;
            }
            // The normal law has no skewness; its cube root differs in the second order.
            assert!((sum / total / f64::from(needed) - 1.0).abs() < 0.05, "{freedom}: {} for {needed}", sum / total);
        }
    }

    #[test]
    fn more_turns_show_less_and_none_show_nothing() {
        let amplitude = |freedom: f32, gain: f32| law(freedom, 0.0).smallest(4.0, gain);
        assert!(amplitude(40.0, 20.0) < 0.8 * amplitude(20.0, 10.0));
        assert_eq!([amplitude(20.0, 0.0), amplitude(20.0, f32::NAN)], [f32::INFINITY; 2]);
        // Noise so uncertain that the score stays below 1/√b.
        assert_eq!(law(20.0, 0.1).smallest(4.0, 10.0), f32::INFINITY);
        assert!(law(20.0, 0.05).smallest(4.0, 10.0).is_finite());
    }
}
