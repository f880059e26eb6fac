//! Distribution of a rising coordinate's score given the coordinates before it.
//!
//! ```text
//! f(x) = 2/(γ + 1/γ) · (g(x/γ) for x ≥ 0,  g(γx) for x < 0)               (1)  Fernández & Steel 1998
//! E X = M₁(γ − 1/γ),   E X² = M₂(γ³ + γ⁻³)/(γ + γ⁻¹)                      (2)  M: moments of |T|, T ~ g
//! U = √V (X − E X)/√Var X                                                 (3)
//! the law       Σ_jk P(τ_j, γ_k | y₋₁ … y₋ₙ) F_jk                         (4)
//! ```
//!
//! g is Student's density, whose square has the law of the distance in one coordinate (`super::law`) and the variance V
//! of that law. A score need not be symmetric: an order's strength has a least value but no largest one, and the
//! friction of cold grease rises further than that of warm grease falls. A symmetric law would take the far side for as
//! rare as the near one, and call too many healthy segments novel. (4) averages over γ as it does over the tails, by
//! the scores y₋ᵢ of the training segments, each relative to mean and deviation of the others; γ = 1 has the largest
//! prior.

use std::f64::consts::LN_2;

use statrs::function::beta::{beta_reg, ln_beta};
use statrs::function::gamma::ln_gamma;

use super::excess::Excess;
use super::law::{DistanceLaw, HEAVIER, Scaled, probabilities, tail};

/// Prior probability of a symmetric law, and the number of others on each side, up to the largest ln γ. At ln γ = 0.8
/// the near side of the mode is a fifth of the far one.
const SYMMETRIC: f64 = 0.9;
const SKEWED: i32 = 8;
const MOST_SKEWED: f64 = 0.8;

/// (3).
#[derive(Clone, Copy, Debug, PartialEq)]
struct Skewed {
    /// ν of g.
    degrees: f64,
    /// γ.
    skewness: f64,
    /// x = mean + deviation · u.
    mean: f64,
    deviation: f64,
    /// ln of the largest density of u.
    ln_height: f64,
}

/// (4).
#[derive(Clone, Debug, PartialEq)]
pub struct ScoreLaw {
    /// Probabilities and laws.
    parts: Vec<(f64, Skewed)>,
    /// The correction of the law of its square, if it is symmetric.
    excess: Option<Excess>,
}

impl ScoreLaw {
    /// Returns the law of a score whose square has this law.
    #[must_use]
    pub fn symmetric(law: &DistanceLaw) -> Self {
        let excess = law.excess().cloned();
        Self { parts: law.parts().map(|(part, law)| (part, Skewed::new(law, 1.0))).collect(), excess }
    }

    /// Returns the law (4) of so many training segments; `left_out` are the scores of each from the others, in
    /// standard deviations.
    #[must_use]
    pub fn of(rows: usize, left_out: &[f64]) -> Self {
        Self::of_counts(rows, &left_out.iter().map(|y| (*y, 1.0)).collect::<Vec<_>>())
    }

    /// As [`ScoreLaw::of`], of scores with the number of times that each came.
    pub(crate) fn of_counts(rows: usize, left_out: &[(f64, f64)]) -> Self {
        let (law, others) = (Scaled::gaussian(1, rows), Scaled::gaussian(1, rows - 1));
        if !others.tells_tails() {
            return Self { parts: vec![(1.0, Skewed::new(law, 1.0))], excess: None };
        }
        let all = (0..=HEAVIER).flat_map(|k| (-SKEWED..=SKEWED).map(move |skew| (k, skew)));
        let each = |(k, skew): (usize, i32)| {
            let (weight, of_tail) = tail(k);
            let skewness = (MOST_SKEWED * f64::from(skew) / f64::from(SKEWED)).exp();
            let of_skewness = if skew == 0 { SYMMETRIC } else { (1.0 - SYMMETRIC) / f64::from(2 * SKEWED) };
            let observed = Skewed::new(others.heavier(weight), skewness);
            let likelihood: f64 = left_out.iter().map(|(y, count)| count * observed.ln_density(*y)).sum();
            ((of_tail * of_skewness).ln() + likelihood, Skewed::new(law.heavier(weight), skewness))
        };
        Self { parts: probabilities(all.map(each).collect()), excess: None }
    }

    /// Returns −ln P(U ≥ u), nats.
    #[must_use]
    pub fn surprise(&self, u: f64) -> f64 {
        let by_law = -self.parts.iter().map(|(part, law)| part * law.beyond(u)).sum::<f64>().ln();
        // One side has half of the probability of both.
        self.excess.as_ref().map_or(by_law, |excess| LN_2 + excess.surprise(by_law - LN_2))
    }

    /// Returns the law of −U.
    #[must_use]
    pub fn mirrored(&self) -> Self {
        Self { parts: self.parts.iter().map(|(part, law)| (*part, law.mirrored())).collect(), ..self.clone() }
    }

    /// Returns the u of a surprise, from `below` on: where the surprise is not larger.
    #[must_use]
    pub fn at(&self, surprise: f64, below: f64) -> f64 {
        let surprise = self.excess.as_ref().map_or(surprise, |excess| LN_2 + excess.by_law(surprise - LN_2));
        let (mut low, mut high, mut u) = (below, f64::INFINITY, below);
        // Newton's method; where it leaves the interval, the middle or a far point.
        for _ in 0..200 {
            let tail: f64 = self.parts.iter().map(|(part, law)| part * law.beyond(u)).sum();
            let density: f64 = self.parts.iter().map(|(part, law)| part * law.ln_density(u).exp()).sum();
            let missing = surprise + tail.ln();
            if missing > 0.0 {
                low = u;
            } else {
                high = u;
            }
            let step = missing * tail / density;
            if step.abs() <= 1e-10 * u.abs() || high <= low {
                break;
            }
            let next = u + step;
            let far = if high.is_finite() { 0.5 * (low + high) } else { 2.0 * low + 1.0 };
            u = if next > low && next < high { next } else { far };
        }
        u
    }
}

impl Skewed {
    fn new(law: Scaled, skewness: f64) -> Self {
        let Scaled { degrees, scale, .. } = law;
        let (g, inverse) = (skewness, 1.0 / skewness);
        let ln_first = ln_gamma(0.5 * (degrees + 1.0)) - ln_gamma(0.5 * degrees) - 0.5 * std::f64::consts::PI.ln();
        let first = 2.0 * degrees.sqrt() / (degrees - 1.0) * ln_first.exp(); // M₁
        let second = degrees / (degrees - 2.0); // M₂
        let mean = first * (g - inverse); // (2)
        let squared = second * (g.powi(3) + inverse.powi(3)) / (g + inverse);
        let deviation = ((squared - mean * mean) / (scale * second)).sqrt();
        let ln_student = -0.5 * degrees.ln() - ln_beta(0.5 * degrees, 0.5);
        Self { degrees, skewness, mean, deviation, ln_height: ln_student + (2.0 / (g + inverse) * deviation).ln() }
    }

    fn mirrored(self) -> Self {
        Self { skewness: 1.0 / self.skewness, mean: -self.mean, ..self }
    }

    /// P(U ≥ u).
    fn beyond(&self, u: f64) -> f64 {
        let (x, g) = (self.deviation.mul_add(u, self.mean), self.skewness);
        let side = 2.0 / (g + 1.0 / g);
        if x >= 0.0 { side * g * self.student_beyond(x / g) } else { 1.0 - side / g * self.student_beyond(-g * x) }
    }

    /// P(T ≥ t) for t ≥ 0.
    fn student_beyond(&self, t: f64) -> f64 {
        0.5 * beta_reg(0.5 * self.degrees, 0.5, self.degrees / (self.degrees + t * t))
    }

    /// ln of the density of u.
    fn ln_density(&self, u: f64) -> f64 {
        let (x, g, v) = (self.deviation.mul_add(u, self.mean), self.skewness, self.degrees);
        let t = if x >= 0.0 { x / g } else { g * x };
        self.ln_height - 0.5 * (v + 1.0) * (t * t / v).ln_1p()
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_distr::{Distribution, Gamma};

    use super::*;

    fn law(weight: f64, skewness: f64) -> Skewed {
        Skewed::new(Scaled::gaussian(1, 60).heavier(weight), skewness)
    }

    /// ∫ f(u) du by the trapezoidal rule on u = sinh s, which reaches far into the tails.
    fn integral(f: impl Fn(f64) -> f64) -> f64 {
        let h = 1e-3;
        (-14_000..=14_000).map(|k| f64::from(k) * h).map(|s| h * s.cosh() * f(s.sinh())).sum()
    }

    #[test]
    fn the_density_has_mean_zero_and_the_variance_of_the_distance() {
        for (weight, skewness) in [(0.0, 1.0), (0.1, 1.6), (0.2, 0.5)] {
            let law = law(weight, skewness);
            let of = |power: i32| integral(|u| u.powi(power) * law.ln_density(u).exp());
            let Scaled { degrees, scale, .. } = Scaled::gaussian(1, 60).heavier(weight);
            let variance = scale * degrees / (degrees - 2.0);
            // The corner of the density at x = 0 and the tails beyond sinh 14, whose variance falls as u^(2−ν).
            assert!((of(0) - 1.0).abs() < 1e-6 && of(1).abs() < 1e-5, "{} {}", of(0), of(1));
            assert!((of(2) / variance - 1.0).abs() < 1e-4, "{} for {variance}", of(2));
            for u in [-2.0, -0.3, 0.4, 3.0] {
                let tail = integral(|x| if x > u { law.ln_density(x).exp() } else { 0.0 });
                // One step of the rule at the edge.
                assert!((tail - law.beyond(u)).abs() < 2e-3, "{tail} for {}", law.beyond(u));
            }
        }
    }

    #[test]
    fn the_mirrored_law_has_the_tail_below_the_mean() {
        let skewed = ScoreLaw { parts: vec![(1.0, law(0.1, 1.6))], excess: None };
        for u in [-1.0, 0.0, 0.5, 2.0] {
            let [below, above] = [-skewed.mirrored().surprise(u), -skewed.surprise(-u)].map(f64::exp);
            // The rounding of the beta function.
            assert!((below + above - 1.0).abs() < 1e-12, "{u}: {below} {above}");
        }
    }

    #[test]
    fn a_symmetric_score_has_half_of_the_tail_of_its_square() {
        let distance = DistanceLaw::gaussian(1, 30);
        let score = ScoreLaw::symmetric(&distance);
        for u in [0.0, 0.7, 2.5, 8.0] {
            // The rounding of the beta function.
            assert!((score.surprise(u) - distance.surprise(u * u) - 2_f64.ln()).abs() < 1e-9);
            assert!((score.at(score.surprise(u), 0.0) - u).abs() < 1e-9);
        }
    }

    /// Scores of a gamma distribution: the one in a hundred of the far side, from 150 of them.
    #[test]
    fn skewed_scores_move_the_limit_to_the_far_side() {
        let gamma = Gamma::new(4.0, 0.5).expect("a law"); // mean 2, deviation 1, skewness 1
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(83_000);
        let (mut right, mut left, mut plain) = (0.0, 0.0, 0.0);
        for _ in 0..20 {
            let scores: Vec<f64> = (0..150).map(|_| gamma.sample(&mut random) - 2.0).collect();
            let mirrored: Vec<f64> = scores.iter().map(|y| -y).collect();
            let squared: Vec<f64> = scores.iter().map(|y| y * y).collect();
            right += ScoreLaw::of(150, &scores).at(100_f64.ln(), 0.0) / 20.0;
            left += ScoreLaw::of(150, &mirrored).at(100_f64.ln(), 0.0) / 20.0;
            plain += ScoreLaw::symmetric(&DistanceLaw::of(1, 150, &squared)).at(100_f64.ln(), 0.0) / 20.0;
        }
        println!("one in a hundred: {right:.2} on the far side, {left:.2} on the near one, {plain:.2} symmetric");
        // Quantiles of the gamma distribution: 3.02 and 1.59; a two-piece t is not a gamma distribution.
        assert!((2.8..3.3).contains(&right) && (1.4..1.9).contains(&left) && plain < 2.7, "{right} {left} {plain}");
    }
}
