//! Distribution of the distance of a further healthy segment from the healthy mean.
//!
//! ```text
//! d² = (z − m)ᵀ S⁻¹ (z − m),   m, S of n segments in p coordinates
//! Gaussian      d² ~ a F(p, ν),  ν = n − p,  a = p(n²−1)/(n(n−p))         (1)  Hotelling 1931
//! heavier       1/ν = 1/(n−p) + 1/τ,  a chosen so that E d² is as in (1)  (2)
//! left out      d²₋ᵢ = (n/(n−1))² (n−2) q/(1 − nq/(n−1)),  q = d²ᵢ/(n−1)   (3)
//! the law       Σ_j P(τ_j | d²₋₁ … d²₋ₙ) F_j                              (4)
//! ```
//!
//! For many segments, (2) is exact for coordinates with a multivariate t distribution with τ degrees of freedom. The
//! probability of each τ follows from the training segments' own distances (3), each relative to mean and covariance of
//! the other segments. With the most probable τ alone, the mean false-alarm rate would exceed the set one: a tail that
//! is assumed too light adds more alarms than one that is assumed too heavy saves. (4) therefore averages over τ; the
//! prior is uniform in 1/τ from 0 on, and the Gaussian law has the largest prior.

use statrs::function::beta::{beta_reg, ln_beta};

/// Prior probability of Gaussian features. With a larger value heavy tails would not be recognised; with a smaller one
/// the gate of Gaussian features would be far out.
const GAUSSIAN: f64 = 0.6;
/// Number of heavier laws, up to the largest 1/τ: the heaviest tail is about 1/d⁶.
const HEAVIER: usize = 16;
const HEAVIEST: f64 = 0.33;
/// Degrees of freedom below which the values of τ cannot be distinguished and E d² hardly exists.
const LEAST_DEGREES: f64 = 3.0;
/// Laws with a smaller relative probability are left out.
const NEGLIGIBLE: f64 = 1e-4;

/// d² ~ scale · F(coordinates, degrees).
#[derive(Clone, Copy, Debug, PartialEq)]
struct Scaled {
    coordinates: f64,
    degrees: f64,
    scale: f64,
}

/// (4).
#[derive(Clone, Debug, PartialEq)]
pub struct DistanceLaw {
    /// Probabilities and laws, the Gaussian one first.
    parts: Vec<(f64, Scaled)>,
}

impl DistanceLaw {
    /// Returns the law (1) for `rows` > `coordinates` segments.
    #[must_use]
    pub fn gaussian(coordinates: usize, rows: usize) -> Self {
        Self { parts: vec![(1.0, Scaled::gaussian(coordinates, rows))] }
    }

    /// Returns the law (4) of training segments; `squared` are their d² within the set.
    #[must_use]
    pub fn of(coordinates: usize, squared: &[f64]) -> Self {
        let law = Scaled::gaussian(coordinates, squared.len());
        let others = Scaled::gaussian(coordinates, squared.len() - 1);
        if others.degrees < LEAST_DEGREES {
            return Self { parts: vec![(1.0, law)] };
        }
        let left_out = left_out(squared);
        // Denser at light tails, where the laws differ most at the observed distances.
        let steps = HEAVIER as f64;
        let each = |k: usize| {
            let weight = HEAVIEST * (k as f64 / steps).powi(2);
            let before = if k == 0 { GAUSSIAN } else { (1.0 - GAUSSIAN) * 2.0 * k as f64 / (steps * (steps + 1.0)) };
            let likelihood: f64 = left_out.iter().map(|d| others.heavier(weight).ln_density(*d)).sum();
            (before.ln() + likelihood, law.heavier(weight))
        };
        let judged: Vec<(f64, Scaled)> = (0..=HEAVIER).map(each).collect();
        let most = judged.iter().map(|(ln, _)| *ln).fold(f64::NEG_INFINITY, f64::max);
        let kept = |(k, (ln, law)): (usize, (f64, Scaled))| {
            let part = (ln - most).exp();
            (k == 0 || part > NEGLIGIBLE).then_some((part, law))
        };
        let mut parts: Vec<(f64, Scaled)> = judged.into_iter().enumerate().filter_map(kept).collect();
        let total: f64 = parts.iter().map(|(part, _)| part).sum();
        parts.iter_mut().for_each(|(part, _)| *part /= total);
        Self { parts }
    }

    /// Returns the probability that the features are Gaussian, among the laws considered.
    #[must_use]
    pub fn gaussian_probability(&self) -> f64 {
        self.parts[0].0
    }

    /// Returns −ln P(d² at least this large), nats.
    #[must_use]
    pub fn surprise(&self, squared: f64) -> f64 {
        -self.parts.iter().map(|(part, law)| part * law.beyond(squared)).sum::<f64>().ln()
    }

    /// Returns the d² of a surprise, by bisection.
    #[must_use]
    pub fn squared_at(&self, surprise: f64) -> f64 {
        if surprise <= 0.0 {
            return 0.0;
        }
        // 25 nats at two degrees of freedom are d² ≈ 1e11.
        let (mut low, mut high) = (-60.0_f64, 60.0_f64);
        for _ in 0..42 {
            let middle = 0.5 * (low + high);
            if self.surprise(middle.exp()) < surprise { low = middle } else { high = middle }
        }
        high.exp()
    }
}

impl Scaled {
    fn gaussian(coordinates: usize, rows: usize) -> Self {
        let (p, n) = (coordinates as f64, rows as f64);
        Self { coordinates: p, degrees: n - p, scale: p * (n * n - 1.0) / (n * (n - p)) }
    }

    /// Returns the law (2) with 1/τ = `weight`.
    fn heavier(self, weight: f64) -> Self {
        if weight <= 0.0 {
            return self;
        }
        let degrees = (1.0 / (1.0 / self.degrees + weight)).max(2.05);
        let mean = |degrees: f64| degrees / (degrees - 2.0);
        Self { degrees, scale: self.scale * mean(self.degrees) / mean(degrees), ..self }
    }

    fn beyond(&self, squared: f64) -> f64 {
        let (p, v) = (self.coordinates, self.degrees);
        beta_reg(v / 2.0, p / 2.0, v / (v + p * squared / self.scale))
    }

    fn ln_density(&self, squared: f64) -> f64 {
        let (p, v) = (self.coordinates, self.degrees);
        let x = (squared / self.scale).max(f64::MIN_POSITIVE);
        let powers = 0.5 * p * (p / v).ln() + (0.5 * p - 1.0) * x.ln() - 0.5 * (p + v) * (p * x / v).ln_1p();
        powers - ln_beta(p / 2.0, v / 2.0) - self.scale.ln()
    }
}

/// (3).
fn left_out(squared: &[f64]) -> Vec<f64> {
    let n = squared.len() as f64;
    let each = |d: &f64| {
        let q = d / (n - 1.0);
        (n / (n - 1.0)).powi(2) * (n - 2.0) * q / (1.0 - n * q / (n - 1.0)).max(f64::EPSILON)
    };
    squared.iter().map(each).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_coordinates_have_a_closed_form() {
        // P(F(2, ν) > x) = (1 + 2x/ν)^(−ν/2); the tolerance is the rounding of logarithms of numbers down to e⁻²⁵.
        let law = DistanceLaw::gaussian(2, 12);
        let scale = 2.0 * 143.0 / 120.0;
        for squared in [0.01, 1.0, 30.0, 1000.0] {
            let closed = 5.0 * (2.0 * squared / scale / 10.0_f64).ln_1p();
            assert!((law.surprise(squared) - closed).abs() < 1e-10 * closed.max(1.0), "{squared}");
            assert!((law.squared_at(closed) / squared - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn density_is_the_slope_of_the_tail() {
        for law in [Scaled::gaussian(3, 20), Scaled::gaussian(3, 20).heavier(0.2)] {
            let (x, h) = (4.0, 1e-4);
            let slope = (law.beyond(x - h) - law.beyond(x + h)) / (2.0 * h);
            assert!((law.ln_density(x).exp() / slope - 1.0).abs() < 1e-6); // of order h²
        }
    }

    #[test]
    fn left_out_distances_by_hand() {
        // Values 0, 1, 3, 8. Without 8: mean 4/3, variance 7/3. All four: mean 3, variance 38/3.
        let squared: Vec<f64> = [0.0, 1.0, 3.0, 8.0_f64].iter().map(|x| (x - 3.0).powi(2) / (38.0 / 3.0)).collect();
        let by_hand = (8.0 - 4.0 / 3.0_f64).powi(2) / (7.0 / 3.0);
        assert!((left_out(&squared)[3] - by_hand).abs() < 1e-9);
    }
}
