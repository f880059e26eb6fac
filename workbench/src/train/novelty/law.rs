//! How far from the healthy mean a further healthy segment lies.
//!
//! ```text
//! d² = (z − m)ᵀ S⁻¹ (z − m),   m, S of n segments in p coordinates
//! Gaussian      d² ~ a F(p, ν),  ν = n − p,  a = p(n²−1)/(n(n−p))         (1)  Hotelling 1931
//! heavier       1/ν = 1/(n−p) + 1/τ,  a such that E d² stays that of (1)  (2)
//! left out      d²₋ᵢ = (n/(n−1))² (n−2) q/(1 − nq/(n−1)),  q = d²ᵢ/(n−1)   (3)
//! ```
//!
//! For many segments (2) is exact for coordinates of a multivariate t distribution with τ degrees of freedom. τ is that
//! of largest likelihood for the training segments' own distances (3), each from mean and covariance of the others.

use statrs::function::beta::{beta_reg, ln_beta};

/// ν of (2) is above this: at 2 the mean is infinite.
const LEAST_DEGREES: f64 = 2.05;
/// Twice the gain in log-likelihood from which a heavier tail is believed: 5 % of Gaussian sets show it by chance
/// (Chernoff 1954: half the 10 % point's mass of χ²₁, for a parameter on its border).
const BELIEVED: f64 = 2.706;

/// d² ~ scale · F(coordinates, degrees).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DistanceLaw {
    /// p.
    pub coordinates: usize,
    /// ν.
    pub degrees: f64,
    scale: f64,
}

impl DistanceLaw {
    /// (1) for `rows` > `coordinates` segments.
    #[must_use]
    pub fn gaussian(coordinates: usize, rows: usize) -> Self {
        let (p, n) = (coordinates as f64, rows as f64);
        Self { coordinates, degrees: n - p, scale: p * (n * n - 1.0) / (n * (n - p)) }
    }

    /// (2) with 1/τ = `weight`.
    fn heavier(self, weight: f64) -> Self {
        let degrees = 1.0 / (1.0 / self.degrees + weight);
        let mean = |degrees: f64| degrees / (degrees - 2.0);
        Self { degrees, scale: self.scale * mean(self.degrees) / mean(degrees), ..self }
    }

    /// (1), or (2) where the training segments' distances from each other show a heavier tail. `squared` are their d²
    /// within the set.
    #[must_use]
    pub fn of(coordinates: usize, squared: &[f64]) -> Self {
        let gaussian = Self::gaussian(coordinates, squared.len());
        let others = Self::gaussian(coordinates, squared.len() - 1);
        // Of so few segments no likelihood tells more than the spread of their covariance.
        if others.degrees < 10.0 {
            return gaussian;
        }
        let left_out = left_out(squared);
        let likelihood = |weight: f64| left_out.iter().map(|d| others.heavier(weight).ln_density(*d)).sum::<f64>();
        let most = 1.0 / LEAST_DEGREES - 1.0 / others.degrees;
        let weights = (0..=200).map(|k| most * f64::from(k) / 200.0);
        let judged: Vec<(f64, f64)> = weights.map(|weight| (weight, likelihood(weight))).collect();
        let best = judged.iter().copied().fold(judged[0], |best, next| if next.1 > best.1 { next } else { best });
        let gain = best.1 - judged[0].1;
        if 2.0 * gain > BELIEVED { gaussian.heavier(best.0) } else { gaussian }
    }

    /// −ln P(d² at least this large), nats.
    #[must_use]
    pub fn surprise(&self, squared: f64) -> f64 {
        let (p, x) = (self.coordinates as f64, squared / self.scale);
        -beta_reg(self.degrees / 2.0, p / 2.0, self.degrees / (self.degrees + p * x)).ln()
    }

    /// The d² of a surprise, by bisection.
    #[must_use]
    pub fn squared_at(&self, surprise: f64) -> f64 {
        if surprise <= 0.0 {
            return 0.0;
        }
        // 25 nats at two degrees of freedom are d² ≈ 1e11.
        let (mut low, mut high) = (-80.0_f64, 60.0_f64);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.surprise(middle.exp()) < surprise { low = middle } else { high = middle }
        }
        high.exp()
    }

    fn ln_density(&self, squared: f64) -> f64 {
        let (p, v) = (self.coordinates as f64, self.degrees);
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
        // P(F(2, ν) > x) = (1 + 2x/ν)^(−ν/2); rounding of a logarithm of numbers down to e⁻²⁵.
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
        for law in [DistanceLaw::gaussian(3, 20), DistanceLaw::gaussian(3, 20).heavier(0.2)] {
            let (x, h) = (4.0, 1e-4);
            let slope = ((-law.surprise(x - h)).exp() - (-law.surprise(x + h)).exp()) / (2.0 * h);
            assert!((law.ln_density(x).exp() / slope - 1.0).abs() < 1e-6); // of order h²
        }
    }

    #[test]
    fn left_out_distances_by_hand() {
        // Of 0, 1, 3, 8 leave 8 out: mean 4/3, variance 7/3. All four: mean 3, variance 38/3.
        let squared: Vec<f64> = [0.0, 1.0, 3.0, 8.0_f64].iter().map(|x| (x - 3.0).powi(2) / (38.0 / 3.0)).collect();
        let by_hand = (8.0 - 4.0 / 3.0_f64).powi(2) / (7.0 / 3.0);
        assert!((left_out(&squared)[3] - by_hand).abs() < 1e-9);
    }
}
