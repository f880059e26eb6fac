//! Distribution of the distance of a further healthy segment from the healthy mean.
//!
//! ```text
//! d² = (z − m)ᵀ S⁻¹ (z − m),   m, S of n segments in p coordinates
//! Gaussian      d² ~ a F(p, ν),  ν = n − p,  a = p(n²−1)/(n(n−p))         (1)  Hotelling 1931
//! heavier       1/ν = 1/(n−p) + 1/τ,  a chosen so that E d² is as in (1)  (2)
//! the law       Σ_j P(τ_j | d²₋₁ … d²₋ₙ) F_j                              (3)
//! of k < p      (d²_p/p)^⅓ = 1 − c_p + √c_p u,  u = ((d²_k/k)^⅓ − 1 + c_k)/√c_k,  c = 2/(9k)       (4)
//! ```
//!
//! For many segments, (2) is exact for coordinates with a multivariate t distribution with τ degrees of freedom. The
//! probability of each τ follows from the training segments' own distances d²₋ᵢ, each relative to mean and covariance
//! of the other segments (`moments`). With the most probable τ alone, the mean false-alarm rate would exceed the set
//! one: a tail that is assumed too light adds more alarms than one that is assumed too heavy saves. (3) therefore
//! averages over τ; the prior is uniform in 1/τ from 0 on, and the Gaussian law has the largest prior. With k of the p
//! coordinates, (4) gives the d² of all coordinates that is as improbable (Wilson and Hilferty 1931), as in the core.

use statrs::distribution::{ChiSquared, ContinuousCDF};
use statrs::function::beta::{beta_reg, ln_beta};

use super::excess::Excess;

/// Prior probability of Gaussian features. With a larger value heavy tails would not be recognised; with a smaller one
/// the gate of Gaussian features would be far out.
const GAUSSIAN: f64 = 0.6;
/// Number of heavier laws, up to the largest 1/τ: the heaviest tail is about 1/d⁶.
pub(crate) const HEAVIER: usize = 16;
const HEAVIEST: f64 = 0.33;
/// Degrees of freedom below which the values of τ cannot be distinguished and E d² hardly exists.
const LEAST_DEGREES: f64 = 3.0;
/// Laws with a smaller relative probability are left out.
const NEGLIGIBLE: f64 = 1e-4;

/// d² ~ scale · F(coordinates, degrees).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scaled {
    coordinates: f64,
    pub(crate) degrees: f64,
    pub(crate) scale: f64,
}

/// (3).
#[derive(Clone, Debug, PartialEq)]
pub struct DistanceLaw {
    /// Probabilities and laws, the Gaussian one first.
    parts: Vec<(f64, Scaled)>,
    /// How much rarer than they are it takes rare segments for, if that is known.
    excess: Option<Excess>,
}

impl DistanceLaw {
    /// Returns the law (1) for `rows` > `coordinates` segments.
    #[must_use]
    pub fn gaussian(coordinates: usize, rows: usize) -> Self {
        Self { parts: vec![(1.0, Scaled::gaussian(coordinates, rows))], excess: None }
    }

    /// Returns the law (3) of so many training segments; `left_out` are the d² of each from the others.
    #[must_use]
    pub fn of(coordinates: usize, rows: usize, left_out: &[f64]) -> Self {
        let tails = TailDensities::new(coordinates, rows - 1).map(|own| own.likelihoods(left_out));
        Self::of_tails(coordinates, rows, tails)
    }

    /// Returns the law (3) of so many training segments, of which the likelihoods of the tails are given.
    pub(crate) fn of_tails(coordinates: usize, rows: usize, tails: Option<Likelihoods>) -> Self {
        Self::averaged(Scaled::gaussian(coordinates, rows), tails)
    }

    /// Returns the law (3) of a covariance with so many degrees of freedom, whose mean adds its error by a factor to
    /// the variance, of which the likelihoods of the tails are given.
    pub(crate) fn of_freedom(coordinates: usize, (freedom, factor): (f64, f64), tails: Option<Likelihoods>) -> Self {
        let p = coordinates as f64;
        let degrees = freedom - p + 1.0;
        let law = Scaled { coordinates: p, degrees, scale: p * freedom * factor / degrees };
        Self::averaged(law, tails)
    }

    /// Averages over the heavier forms of a law; without likelihoods there are none.
    fn averaged(law: Scaled, tails: Option<Likelihoods>) -> Self {
        let Some(tails) = tails else { return Self { parts: vec![(1.0, law)], excess: None } };
        let each = |(k, likelihood): (usize, f64)| {
            let (weight, before) = tail(k);
            (before.ln() + likelihood, law.heavier(weight))
        };
        Self { parts: probabilities(tails.into_iter().enumerate().map(each).collect()), excess: None }
    }

    /// The probabilities and laws of (3).
    pub(crate) fn parts(&self) -> impl Iterator<Item = (f64, Scaled)> {
        self.parts.iter().copied()
    }

    /// Returns the probability that the features are Gaussian, among the laws considered.
    pub(crate) fn gaussian_probability(&self) -> f64 {
        self.parts[0].0
    }

    /// Corrects the law by the surprises of segments by laws of others, each with its run, and whether they are skewed.
    pub(crate) fn corrected(self, surprises: &[(f64, usize)], skewed: bool) -> Self {
        Self { excess: Excess::of(surprises, skewed), ..self }
    }

    /// The correction of the law.
    pub(crate) const fn excess(&self) -> Option<&Excess> {
        self.excess.as_ref()
    }

    /// Returns −ln P(d² at least this large), nats.
    #[must_use]
    pub fn surprise(&self, squared: f64) -> f64 {
        let by_law = -self.parts.iter().map(|(part, law)| part * law.beyond(squared)).sum::<f64>().ln();
        self.excess.as_ref().map_or(by_law, |excess| excess.surprise(by_law))
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

/// ln of the probability density of the left-out distances for each tail, in the order of `tail`: a sum over the
/// segments. Zeros tell nothing, and leave the prior probabilities.
pub type Likelihoods = [f64; HEAVIER + 1];

/// The densities of left-out distances for each tail.
#[derive(Clone, Debug)]
pub struct TailDensities([Density; HEAVIER + 1]);

impl TailDensities {
    /// Of distances from so many segments; `None` if tails cannot be told apart.
    pub(crate) fn new(coordinates: usize, rows: usize) -> Option<Self> {
        let others = Scaled::gaussian(coordinates, rows.max(coordinates));
        others.tells_tails().then(|| Self(std::array::from_fn(|k| others.heavier(tail(k).0).density())))
    }

    /// ln of the density of one distance for each tail.
    #[must_use]
    pub fn each(&self, squared: f64) -> Likelihoods {
        std::array::from_fn(|k| self.0[k].ln(squared))
    }

    pub(crate) fn likelihoods(&self, left_out: &[f64]) -> Likelihoods {
        std::array::from_fn(|k| left_out.iter().map(|squared| self.0[k].ln(*squared)).sum())
    }
}

/// A density of d², its constants computed once.
#[derive(Clone, Copy, Debug)]
struct Density {
    constant: f64,
    /// Exponents of x and of 1 + px/ν.
    powers: [f64; 2],
    /// 1/scale, and p/ν.
    factors: [f64; 2],
}

impl Density {
    fn ln(&self, squared: f64) -> f64 {
        let x = (squared * self.factors[0]).max(f64::MIN_POSITIVE);
        self.constant + self.powers[0] * x.ln() - self.powers[1] * (self.factors[1] * x).ln_1p()
    }
}

/// Returns 1/τ of the k-th law and its prior probability.
pub(crate) fn tail(k: usize) -> (f64, f64) {
    // Denser at light tails, where the laws differ most at the observed distances.
    let steps = HEAVIER as f64;
    let prior = if k == 0 { GAUSSIAN } else { (1.0 - GAUSSIAN) * 2.0 * k as f64 / (steps * (steps + 1.0)) };
    (HEAVIEST * (k as f64 / steps).powi(2), prior)
}

/// Returns the laws that are not negligible, and the first one, with their probabilities, of the logarithms of these up
/// to a common factor.
pub(crate) fn probabilities<T>(judged: Vec<(f64, T)>) -> Vec<(f64, T)> {
    let most = judged.iter().map(|(ln, _)| *ln).fold(f64::NEG_INFINITY, f64::max);
    let relative = judged.into_iter().map(|(ln, law)| ((ln - most).exp(), law));
    let kept = relative.enumerate().filter(|(k, (part, _))| *k == 0 || *part > NEGLIGIBLE);
    let mut kept: Vec<(f64, T)> = kept.map(|(_, part)| part).collect();
    let total: f64 = kept.iter().map(|(part, _)| part).sum();
    kept.iter_mut().for_each(|(part, _)| *part /= total);
    kept
}

impl Scaled {
    pub(crate) fn gaussian(coordinates: usize, rows: usize) -> Self {
        let (p, n) = (coordinates as f64, rows as f64);
        Self { coordinates: p, degrees: n - p, scale: p * (n * n - 1.0) / (n * (n - p)) }
    }

    /// Returns the law (2) with 1/τ = `weight`.
    pub(crate) fn heavier(self, weight: f64) -> Self {
        if weight <= 0.0 {
            return self;
        }
        let degrees = (1.0 / (1.0 / self.degrees + weight)).max(2.05);
        let mean = |degrees: f64| degrees / (degrees - 2.0);
        Self { degrees, scale: self.scale * mean(self.degrees) / mean(degrees), ..self }
    }

    /// Whether values of τ can be told apart, and E d² exists.
    pub(crate) fn tells_tails(&self) -> bool {
        self.degrees >= LEAST_DEGREES
    }

    fn beyond(&self, squared: f64) -> f64 {
        let (p, v) = (self.coordinates, self.degrees);
        beta_reg(v / 2.0, p / 2.0, v / (v + p * squared / self.scale))
    }

    fn density(&self) -> Density {
        let (p, v) = (self.coordinates, self.degrees);
        let constant = 0.5 * p * (p / v).ln() - ln_beta(p / 2.0, v / 2.0) - self.scale.ln();
        Density { constant, powers: [0.5 * p - 1.0, 0.5 * (p + v)], factors: [1.0 / self.scale, p / v] }
    }
}

/// Returns the d² of `all` coordinates that is as improbable as this d² of `available` ones (4); 0 of none.
#[must_use]
pub fn equivalent(squared: f64, available: usize, all: usize) -> f64 {
    if available == all || available == 0 {
        return squared;
    }
    let [from, to] = [available, all].map(|count| count as f64);
    let [own, other] = [from, to].map(|count| 2.0 / (9.0 * count));
    let u = ((squared / from).cbrt() - 1.0 + own) / own.sqrt();
    to * (1.0 - other + other.sqrt() * u).max(0.0).powi(3)
}

/// A gate is refused if its d² exceeds that of known mean and covariance by this factor: only the largest defects would
/// reach it.
const FARTHEST: f64 = 10.0;

/// Returns the smallest number of independent segments from which a gate can be trained that is not too far out for its
/// rate.
#[must_use]
pub fn fewest(coordinates: usize, rate: f64) -> usize {
    fewest_near(coordinates, rate, FARTHEST)
}

/// Returns the smallest number of rows from which a gate is near enough by [`is_near`].
pub(crate) fn fewest_near(coordinates: usize, rate: f64, factor: f64) -> usize {
    let near = |&rows: &usize| is_near(coordinates, rows, rate, factor);
    (coordinates + 2..).take(1000).find(near).unwrap_or(coordinates + 1000)
}

/// Returns whether the d² of a gate of so many segments exceeds that of known mean and covariance by at most a factor.
pub(crate) fn is_near(coordinates: usize, rows: usize, rate: f64, factor: f64) -> bool {
    let known = ChiSquared::new(coordinates as f64).map_or(f64::NAN, |law| law.inverse_cdf(1.0 - rate));
    DistanceLaw::gaussian(coordinates, rows).squared_at(-rate.ln()) <= factor * known
}

#[cfg(test)]
mod tests {
    use statrs::distribution::{ChiSquared, ContinuousCDF};

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
            assert!((law.density().ln(x).exp() / slope - 1.0).abs() < 1e-6); // of order h²
        }
    }

    /// Exact quantiles of chi-square distributions: the d² of all coordinates with the probability of d² of some.
    #[test]
    fn some_coordinates_stand_for_all() {
        let law = |n: usize| ChiSquared::new(n as f64).expect("law");
        for (some, all) in [(1, 2), (1, 3), (1, 8), (2, 3), (2, 6), (4, 8), (7, 8)] {
            for (nats, within) in [(1.0, 0.012), (2.3, 0.04), (4.6, 0.04), (6.9, 0.1), (9.2, 0.35), (13.8, 1.0)] {
                let squared = law(some).inverse_cdf(1.0 - f64::exp(-nats));
                let surprise = -law(all).sf(equivalent(squared, some, all)).ln();
                println!("{some} of {all}: {surprise:.3} for {nats}");
                assert!((surprise - nats).abs() < within, "{some} of {all}: {surprise} for {nats}");
            }
            // The normal score of d² = 0 is not −∞.
            let least = -law(all).sf(equivalent(0.0, some, all)).ln();
            assert!((0.0..0.06).contains(&least), "{some} of {all}: {least}");
        }
        assert!((equivalent(3.3, 4, 4) - 3.3).abs() < 1e-15);
    }
}
