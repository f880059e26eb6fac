//! Mean of the novelty's e-value for the drive at hand, over baselines of the size of the training set.
//!
//! ```text
//! e(s) = κ e^((1−κ)s), at most e^cap,   s* = (cap − ln κ)/(1 − κ)
//! E[e | m, S] = κ + κ(1−κ) ∫₀^s* e^((1−κ)s) P(d² > x(s) | m, S) ds        (1)  x(s): the knots' d² of surprise s
//! m ~ N(0, D/k),   S = D^½ W₁ D^½/(k−1) + (1−h)(I−Λ)^½ W₂ (I−Λ)^½/(N−k)   (2)
//! D = Λ + h(I−Λ),   W₁ ~ Wishart(I, k−1),   W₂ ~ Wishart(I, N−k)
//! ```
//!
//! The law of the distance is exact in the mean over baselines: E of (1) over (2) is that of an exact e-value. For a
//! single baseline, (1) is larger or smaller for as long as the model is in use. The alarm divides by the 95 % quantile
//! of (1), so that for 95 % of the baselines the mean time between false alarms is at least the set one. The distance
//! does not change with affine maps of the coordinates: (2) draws mean and covariance of k runs of N segments
//! ([`super::runs`], with its upper estimate Λ of the part of the variance between runs) in coordinates in which the
//! covariance of a segment is I and Λ is diagonal. Independent segments are runs of one segment: D = I, k = N.
//!
//! By (3) of the core's evidence a run's e-value is a mean over its segments, capped each: its mean is (1) too, however
//! many segments the run has and however they depend on each other.
//!
//! A model for other drives than those of its training set: groups are drives, and the offset u ~ N(0, Λ) of the drive
//! at hand from the others also lasts. Then the quantile is that over m, S and u, and P is that for segments with mean
//! u and covariance I − Λ.
//!
//! (1) is found for normally distributed features; tails that are heavier are in the law of the distance already. It
//! uses the saddle-point approximation of P ([`super::spread`]), whose relative error is below 5 %.

use bearing_watch::model::KNOTS;
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

use super::laws::knots::FOLLOWED;
use super::laws::spread::{tail, wishart};
use super::runs::RunSpread;

/// Part of the baselines for which the mean time between false alarms is at least the set one.
pub const COVERED: f64 = 0.95;
/// Interval of the integral (1), nats. With the lines between the knots, ln of the integral is too large by up to 0.04.
const STEP: f64 = 0.5;
/// Variance of a segment about its drive that is assumed at least.
const LEAST_WITHIN: f64 = 1e-3;
const SEED: u64 = 0xba5e;

/// The size of a training set.
#[derive(Clone, Debug)]
pub(super) struct Size {
    /// Λ, diagonal.
    shares: DVector<f64>,
    /// h.
    inverse_size: f64,
    /// k.
    runs: usize,
    /// N.
    rows: usize,
    /// Whether the drive at hand has an offset u that lasts.
    lasting: bool,
}

impl Size {
    pub(super) fn independent(coordinates: usize, rows: usize) -> Self {
        Self { shares: DVector::zeros(coordinates), inverse_size: 1.0, runs: rows, rows, lasting: false }
    }

    pub(super) fn of_runs(spread: &RunSpread, rows: usize, lasting: bool) -> Self {
        let RunSpread { shares, inverse_size, count, .. } = spread;
        Self { shares: shares.clone(), inverse_size: *inverse_size, runs: *count, rows, lasting }
    }

    /// Returns the terms (w, δ²) of the distance of a segment for one baseline (2); `None` if S is singular.
    fn draw(&self, random: &mut ChaCha8Rng) -> Option<Vec<(f64, f64)>> {
        let p = self.shares.len();
        let mut normal = |variances: &DVector<f64>| {
            variances.map(|variance| -> f64 {
                let x: f64 = StandardNormal.sample(random);
                variance.sqrt() * x
            })
        };
        let within = self.shares.map(|share| 1.0 - share);
        let of_means = &self.shares + &within * self.inverse_size;
        let mean = normal(&of_means) / (self.runs as f64).sqrt();
        let lasting = self.lasting.then(|| normal(&self.shares));
        let scaled = |scatter: DMatrix<f64>, variances: &DVector<f64>, degrees: usize| {
            let root = DMatrix::from_diagonal(&variances.map(|variance| variance.max(0.0).sqrt()));
            &root * scatter * &root / degrees.max(1) as f64
        };
        let (between, rest) = (self.runs - 1, self.rows - self.runs);
        let mut covariance = scaled(wishart(p, between, random), &of_means, between);
        if rest > 0 {
            covariance += scaled(wishart(p, rest, random), &within, rest) * (1.0 - self.inverse_size);
        }
        // z = u + V^½ g: the distance is Σ w (g + δ)² in the directions of V^½ S⁻¹ V^½.
        let variance = if self.lasting { within.map(|v| v.max(LEAST_WITHIN)) } else { DVector::repeat(p, 1.0) };
        let root = variance.map(f64::sqrt);
        let inverse = covariance.cholesky()?.inverse();
        let diagonal = DMatrix::from_diagonal(&root);
        let eigen = SymmetricEigen::new(&diagonal * inverse * &diagonal);
        let off = lasting.map_or_else(|| -mean.clone(), |own| own - &mean).component_div(&root);
        let shift = eigen.eigenvectors.transpose() * off;
        Some(eigen.eigenvalues.iter().zip(shift.iter()).map(|(w, shift)| (*w, shift * shift)).collect())
    }
}

/// Means (1) of e-values by baselines and caps.
#[derive(Clone, Debug)]
pub(super) struct Means {
    bet: f64,
    /// Of each baseline: the mean for caps whose s* is a multiple of [`STEP`].
    curves: Vec<Vec<f64>>,
}

impl Means {
    /// Draws baselines for a gate with these knots.
    pub(super) fn draw(size: &Size, knots: &[[f64; 2]; KNOTS], bet: f64) -> Self {
        let draws = (4000 / size.shares.len().max(1)).clamp(200, 1000) as u64;
        let steps = (FOLLOWED / STEP) as usize;
        let squared: Vec<f64> = (0..=steps).map(|k| squared_at(knots, STEP * k as f64)).collect();
        let curve = |draw: u64| {
            let mut random = ChaCha8Rng::seed_from_u64(SEED);
            random.set_stream(draw);
            let terms = size.draw(&mut random)?;
            let slope = |k: usize| {
                let beyond = if k == 0 { 1.0 } else { tail(&terms, squared[k]).clamp(0.0, 1.0) };
                bet * (1.0 - bet) * ((1.0 - bet) * STEP * k as f64).exp() * beyond
            };
            let slopes: Vec<f64> = (0..=steps).map(slope).collect();
            let mut mean = bet;
            let sums = slopes.windows(2).map(|pair| {
                mean += 0.5 * STEP * (pair[0] + pair[1]);
                mean
            });
            Some(std::iter::once(bet).chain(sums).collect())
        };
        // A singular baseline has infinite distances.
        let all = (0..draws).into_par_iter().map(|draw| curve(draw).unwrap_or_else(|| vec![f64::INFINITY; steps + 1]));
        Self { bet, curves: all.collect() }
    }

    /// Returns ln μ₀ for a cap, in nats, not below that of an exact surprise; `None` if the cap is beyond the largest
    /// surprise.
    pub(super) fn log_mean(&self, cap: f64) -> Option<f64> {
        let mut means = self.at(cap)?;
        means.sort_by(f64::total_cmp);
        let place = ((COVERED * means.len() as f64).ceil() as usize).clamp(1, means.len()) - 1;
        Some(means[place].ln().max(exact(self.bet, cap)))
    }

    /// Returns the mean of the e-value of every baseline.
    fn at(&self, cap: f64) -> Option<Vec<f64>> {
        let place = (cap - self.bet.ln()) / (1.0 - self.bet) / STEP;
        let (from, part) = (place.floor() as usize, place.fract());
        let each = |curve: &Vec<f64>| {
            let to = curve.get(from + 1)?;
            Some(curve[from] + part * (to - curve[from]))
        };
        self.curves.iter().map(each).collect()
    }
}

/// Returns ln μ₀ of an exact surprise, (7) of the core's evidence.
#[must_use]
pub fn exact(bet: f64, cap: f64) -> f64 {
    let ln_p = (bet.ln() - cap) / (1.0 - bet);
    (1.0 - (bet * ln_p).exp() + (cap + ln_p).exp()).ln()
}

/// Returns the d² at which the core has this surprise, at most that of the last knot.
fn squared_at(knots: &[[f64; 2]; KNOTS], surprise: f64) -> f64 {
    let to = knots.iter().position(|[_, s]| *s >= surprise).unwrap_or(KNOTS - 1).max(1);
    let ([x0, s0], [x1, s1]) = (knots[to - 1], knots[to]);
    x0 + (surprise - s0).max(0.0) * (x1 - x0) / (s1 - s0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::train::novelty::laws::knots::knots;
    use crate::train::novelty::laws::law::DistanceLaw;

    const BET: f64 = 0.2;
    const CAP: f64 = 7.0;

    fn means(size: &Size, law: &DistanceLaw) -> Vec<f64> {
        Means::draw(size, &knots(law, 100_f64.ln()), BET).at(CAP).expect("within the knots")
    }

    #[test]
    fn the_mean_over_baselines_is_that_of_an_exact_surprise() {
        for (p, n) in [(1, 12), (2, 20), (3, 40), (6, 100)] {
            let found = means(&Size::independent(p, n), &DistanceLaw::gaussian(p, n));
            let count = found.len() as f64;
            let mean = found.iter().sum::<f64>() / count;
            let error = (found.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / count / (count - 1.0)).sqrt();
            println!("{p} coordinates, {n} segments: {mean:.3} ± {error:.3}, exact {:.3}", exact(BET, CAP).exp());
            // Saddle point 5 %, knots 2 % of the surprise, 3 standard errors.
            assert!((mean / exact(BET, CAP).exp() - 1.0).abs() < 0.07 + 3.0 * error, "{p} {n}: {mean}");
        }
    }

    #[test]
    fn a_large_baseline_is_exact_and_a_small_one_is_not() {
        let of = |n: usize| {
            let knots = knots(&DistanceLaw::gaussian(2, n), 100_f64.ln());
            Means::draw(&Size::independent(2, n), &knots, BET).log_mean(CAP).expect("within the knots")
        };
        let found = [10, 30, 100, 1000, 100_000].map(of);
        println!("{found:?}, exact {}", exact(BET, CAP));
        assert!(found.windows(2).all(|pair| pair[0] > pair[1]), "{found:?}");
        // The lines between the knots.
        assert!((0.0..0.05).contains(&(found[4] - exact(BET, CAP))), "{found:?}");
        // Least by construction, and no more than a run adds at most.
        assert!(found.iter().all(|x| (exact(BET, CAP)..CAP).contains(x)));
    }

    #[test]
    fn one_coordinate_by_direct_integration() {
        // m = 0.5, s² = 0.8: E e by quadrature over z.
        let (law, terms) = (DistanceLaw::gaussian(1, 20), [(1.0 / 0.8, 0.25)]);
        let knots = knots(&law, 100_f64.ln());
        let ln_e = |z: f64| {
            let squared = (z - 0.5).powi(2) / 0.8;
            (BET.ln() + (1.0 - BET) * law.surprise(squared)).min(CAP)
        };
        let density = |z: f64| (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt();
        let direct: f64 = (-9000..9000).map(|k| 1e-3 * f64::from(k)).map(|z| 1e-3 * density(z) * ln_e(z).exp()).sum();
        let steps = 100;
        let slope = |s: f64| BET * (1.0 - BET) * ((1.0 - BET) * s).exp() * tail(&terms, squared_at(&knots, s));
        let most = (CAP - BET.ln()) / (1.0 - BET);
        let width = most / f64::from(steps);
        let layers: f64 = (0..steps).map(|k| width * slope(width * (f64::from(k) + 0.5))).sum::<f64>() + BET;
        println!("{direct} {layers}");
        assert!((layers / direct - 1.0).abs() < 0.02, "{layers} for {direct}"); // the knots
    }

    #[test]
    fn an_offset_that_lasts_counts() {
        let spread = RunSpread {
            count: 20,
            between: 0.6,
            shares: DVector::repeat(2, 0.6),
            inverse_size: 0.1,
            longest: 10,
            freedom: 25.0,
            slopes: vec![],
            drift: None,
        };
        let law = DistanceLaw::of_freedom(2, (25.0, 1.03), None);
        let of = |lasting: bool| {
            let means = Means::draw(&Size::of_runs(&spread, 200, lasting), &knots(&law, 100_f64.ln()), BET);
            let all = means.at(CAP).expect("within the knots");
            let mean = all.iter().sum::<f64>() / all.len() as f64;
            (means.log_mean(CAP).expect("within the knots"), mean)
        };
        let (run, drive) = (of(false), of(true));
        println!("{run:?} {drive:?}");
        assert!(drive.0 > run.0 + 0.2 && drive.0 < run.0 + 2.0, "{run:?} {drive:?}");
        // The mean over drives is that of a segment of any drive: 10 % are three standard errors of 1000 drives.
        assert!((drive.1 / run.1 - 1.0).abs() < 0.15, "{run:?} {drive:?}");
    }
}
