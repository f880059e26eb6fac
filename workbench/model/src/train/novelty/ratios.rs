//! Mean of the defects' likelihood ratios for the drive at hand, over training sets of the size of the own one.
//!
//! ```text
//! E_k = ∫ min(p̂(z|k)/p̂(z|h), e^cap) p(z|h) dz                            (1)  h: healthy
//!     ≈ Σ min(p̂(z|k)/p̂(z|h), e^cap) p(z|h)/q(z) / M,   z ~ q             (2)  q: p(z|h), its double width, each p(z|k)
//! rows of run i, class c:  z = μ_c + Σ_c^½ (√λ b_i + √(1−λ) e)           (3)  b, e ~ N(0, I)
//! mean ~ N(μ_c, (λ/k + (1−λ)/N) Σ_c),   scatter ~ Σ_c^½ [(λ N/k + 1 − λ) W(k−1) + (1 − λ) W(N−k)] Σ_c^½   (4)
//! ```
//!
//! With the true densities p, (1) is at most 1. The estimated ones p̂ are from finite training sets: the trained means
//! and covariances stand for the true ones (a parametric bootstrap), training sets of as many rows in as many runs are
//! drawn by (3), and the discriminant is trained on each. ln μ is the 95 % quantile of the largest ln E_k, not below 0.
//! q covers both densities, so that the weights of (2) are at most K + 1.
//!
//! Of sums ([`super::of_sums`]), means and scatters are drawn by (4), which is (3) for k runs of N/k rows each, W a
//! Wishart matrix of I; runs of different classes then have no offset in common.
//!
//! This covers the errors of means and covariances of all classes, runs with an offset in common, and, for a model of
//! other drives, the offset of the drive at hand. It does not cover features that are not normally distributed, errors
//! of the projection, or values that are missing.

use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

use super::baseline::COVERED;
use super::laws::spread::wishart;
use super::runs::RunSpread;
use crate::train::classifier::discriminant::{of_statistics, shrunk};
use crate::train::distribution::covariance::{log_density, whitening};
use crate::train::{ClassStatistics, FeatureTable, GaussianClasses, Recipe, Shrink};

const DRAWS: u64 = 200;
/// Values z of each part of q.
const VALUES: usize = 300;
/// Factor of the covariance of the second part of q.
const WIDER: f64 = 4.0;
/// Part of the variance of a segment about its drive that is assumed at least.
const LEAST_WITHIN: f64 = 1e-3;
const SEED: u64 = 0x0dd5;

/// Returns ln μ of the defects for a cap: at most the cap, which leaves them no evidence, if training sets of this size
/// have no densities.
pub(super) fn log_mean(
    (size, names): (&TrainingSet<'_>, &[String]),
    recipe: &Recipe,
    (densities, spread): (&GaussianClasses, Option<&RunSpread>),
    cap: f32,
) -> f32 {
    let classes = densities.means.len();
    let Some(healthy) = recipe.alarms.healthy.filter(|_| classes > 1) else { return 0.0 };
    let truth: Option<Vec<Normal>> = (0..classes).map(|k| Normal::of(densities, healthy, (k, recipe))).collect();
    let Some(truth) = truth else { return cap };
    let set = Set { size, names, recipe, healthy, share: spread.map_or(0.0, |spread| spread.between), truth };
    let mean = |draw: u64| {
        let mut random = ChaCha8Rng::seed_from_u64(SEED);
        random.set_stream(draw);
        set.mean(f64::from(cap), &mut random).unwrap_or(f64::INFINITY)
    };
    let mut means: Vec<f64> = (0..DRAWS).into_par_iter().map(mean).collect();
    means.sort_by(f64::total_cmp);
    let place = ((COVERED * DRAWS as f64).ceil() as usize).clamp(1, means.len()) - 1;
    (means[place].ln().max(0.0) as f32).min(cap)
}

/// A normal distribution: mean, L of LLᵀ = Σ, U of UᵀU = Σ⁻¹ and ln |Σ|.
#[derive(Clone, Debug)]
struct Normal {
    mean: DVector<f64>,
    root: DMatrix<f64>,
    inverse: DMatrix<f64>,
    log_determinant: f64,
}

impl Normal {
    fn new(mean: DVector<f64>, covariance: &DMatrix<f64>) -> Option<Self> {
        let (inverse, log_determinant) = whitening(covariance).ok()?;
        Some(Self { mean, root: covariance.clone().cholesky()?.l(), inverse, log_determinant })
    }

    /// A class, without the spread of sizes, which training adds again.
    fn of(densities: &GaussianClasses, healthy: usize, (class, recipe): (usize, &Recipe)) -> Option<Self> {
        let mean = &densities.means[class];
        let away = (mean - &densities.means[healthy]) * recipe.size_spread;
        let covariance = densities.covariances.get(class).unwrap_or(&densities.covariances[0]);
        Self::new(mean.clone(), &(covariance - &away * away.transpose()))
    }

    /// The distribution of a part of the variance about another mean.
    fn about(&self, mean: DVector<f64>, part: f64) -> Self {
        let log_determinant = self.log_determinant + self.mean.len() as f64 * part.ln();
        Self { mean, root: &self.root * part.sqrt(), inverse: &self.inverse / part.sqrt(), log_determinant }
    }

    fn at(&self, standard: &DVector<f64>) -> DVector<f64> {
        &self.mean + &self.root * standard
    }

    fn ln_density(&self, z: &DVector<f64>) -> f64 {
        log_density(z.len(), self.log_determinant, (&self.inverse * (z - &self.mean)).norm_squared())
    }
}

/// The size of the training set.
#[derive(Clone, Copy, Debug)]
pub(super) enum TrainingSet<'a> {
    /// Rows with their classes, and the run of each if the runs count.
    Rows { table: &'a FeatureTable, runs: Option<&'a [usize]> },
    /// Numbers of rows and of runs of each class.
    Counts(&'a [[usize; 2]]),
}

/// The training set and what stands for the truth.
struct Set<'a> {
    size: &'a TrainingSet<'a>,
    names: &'a [String],
    recipe: &'a Recipe,
    healthy: usize,
    /// λ, the part of the variance between runs.
    share: f64,
    truth: Vec<Normal>,
}

impl Set<'_> {
    /// Returns the largest of (1) for one training set; `None` if its densities are singular.
    fn mean(&self, cap: f64, random: &mut ChaCha8Rng) -> Option<f64> {
        let estimated = self.estimate(random)?;
        let own = &self.truth[self.healthy];
        let own = if self.recipe.alarms.other_drive {
            let lasting = own.about(own.mean.clone(), self.share.max(f64::MIN_POSITIVE)).at(&self.standard(random));
            own.about(lasting, (1.0 - self.share).max(LEAST_WITHIN))
        } else {
            own.clone()
        };
        let others = self.truth.iter().enumerate().filter(|(k, _)| *k != self.healthy).map(|(_, other)| other.clone());
        let parts: Vec<Normal> = [own.clone(), own.about(own.mean.clone(), WIDER)].into_iter().chain(others).collect();
        let mut sums = vec![0.0; self.truth.len()];
        for part in &parts {
            for _ in 0..VALUES {
                let z = part.at(&self.standard(random));
                let q = parts.iter().map(|part| part.ln_density(&z).exp()).sum::<f64>() / parts.len() as f64;
                let weight = own.ln_density(&z).exp() / q; // (2)
                let found = estimated.log_likelihoods(&z);
                for (sum, ln) in sums.iter_mut().zip(&found) {
                    *sum += (ln - found[self.healthy]).min(cap).exp() * weight;
                }
            }
        }
        let defects = sums.iter().enumerate().filter(|(k, _)| *k != self.healthy).map(|(_, sum)| *sum);
        Some(defects.fold(0.0, f64::max) / (VALUES * parts.len()) as f64)
    }

    /// Returns the densities of one training set (3).
    fn estimate(&self, random: &mut ChaCha8Rng) -> Option<GaussianClasses> {
        let statistics = match self.size {
            TrainingSet::Rows { table, runs } => ClassStatistics::new(&self.rows(table, *runs, random)),
            TrainingSet::Counts(sizes) => self.statistics(sizes, random),
        };
        // The names are those of errors, which are not told.
        let classes = vec![String::new(); self.truth.len()];
        let trained = match self.recipe.shrink {
            Shrink::To(shrinkage) => shrunk(&statistics, self.names, self.recipe, shrinkage),
            Shrink::Not | Shrink::Chosen => of_statistics(&statistics, (&classes, self.names), self.recipe),
        };
        trained.ok()
    }

    fn rows(&self, table: &FeatureTable, runs: Option<&[usize]>, random: &mut ChaCha8Rng) -> FeatureTable {
        let own: Vec<usize> = (0..table.rows.len()).collect();
        let runs = runs.unwrap_or(&own);
        let offsets: Vec<DVector<f64>> =
            (0..=runs.iter().copied().max().unwrap_or(0)).map(|_| self.standard(random)).collect();
        let row = |(class, run): (&usize, &usize)| {
            let within = self.standard(random);
            self.truth[*class].at(&(&offsets[*run] * self.share.sqrt() + within * (1.0 - self.share).sqrt()))
        };
        let rows = table.classes.iter().zip(runs).map(row).collect();
        FeatureTable::exact(rows, table.classes.clone(), table.names.clone())
    }

    /// Means and covariances of rows (3), drawn as such (4): no row is drawn.
    fn statistics(&self, sizes: &[[usize; 2]], random: &mut ChaCha8Rng) -> ClassStatistics {
        let p = self.names.len();
        let (mut means, mut covariances, mut pooled) = (vec![], vec![], DMatrix::zeros(p, p));
        for (truth, &[rows, runs]) in self.truth.iter().zip(sizes) {
            let (n, k) = (rows as f64, runs as f64);
            let of_mean = self.share / k + (1.0 - self.share) / n;
            means.push(truth.at(&(self.standard(random) * of_mean.sqrt())));
            let mut scatter = wishart(p, runs - 1, random) * (self.share * n / k + 1.0 - self.share);
            scatter += wishart(p, rows - runs, random) * (1.0 - self.share);
            let scatter = &truth.root * scatter * truth.root.transpose();
            pooled += &scatter;
            covariances.push(scatter / (n - 1.0).max(1.0));
        }
        let counts: Vec<usize> = sizes.iter().map(|[rows, _]| *rows).collect();
        pooled /= counts.iter().sum::<usize>().saturating_sub(counts.len()).max(1) as f64;
        // The densities do not use the moments of all rows.
        ClassStatistics { total_mean: DVector::zeros(p), total: pooled.clone(), means, covariances, counts, pooled }
    }

    fn standard(&self, random: &mut ChaCha8Rng) -> DVector<f64> {
        DVector::from_fn(self.names.len(), |_, _| StandardNormal.sample(random))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::Structure;

    const CAP: f32 = 7.0;

    /// ln μ of two classes, 2 deviations apart in the first coordinate, with so many rows each.
    fn found(coordinates: usize, rows: usize, runs: Option<(usize, f64)>, other_drive: bool) -> f32 {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let row = |k: usize| {
            DVector::from_fn(coordinates, |i, _| {
                let x: f64 = StandardNormal.sample(&mut random);
                x + if k % 2 == 1 && i == 0 { 2.0 } else { 0.0 }
            })
        };
        let values: Vec<DVector<f64>> = (0..2 * rows).map(row).collect();
        let classes = (0..2 * rows).map(|k| k % 2).collect();
        let table = FeatureTable::exact(values, classes, vec!["healthy".into(), "worn".into()]);
        let names: Vec<String> = (0..coordinates).map(|k| format!("z{k}")).collect();
        let mut recipe = Recipe::new(Structure::new(1, 1, 0, 1, 0));
        (recipe.alarms.healthy, recipe.alarms.other_drive) = (Some(0), other_drive);
        let densities = crate::train::classifier::discriminant::train(&table, &names, &recipe).expect("regular");
        let groups: Vec<usize> = (0..2 * rows).map(|k| runs.map_or(k, |(count, _)| k / 2 % count)).collect();
        let spread = runs.map(|(count, between)| RunSpread {
            count,
            between,
            shares: DVector::repeat(coordinates, between),
            inverse_size: count as f64 / rows as f64,
            longest: rows / count,
            freedom: count as f64,
            slopes: vec![],
            drift: None,
        });
        let set = TrainingSet::Rows { table: &table, runs: Some(&groups) };
        log_mean((&set, &names), &recipe, (&densities, spread.as_ref()), CAP)
    }

    #[test]
    fn fewer_rows_and_runs_have_larger_means() {
        let of = |rows| found(2, rows, None, false);
        let rows = [8, 30, 300, 10_000].map(of);
        let (runs, drives) = (found(2, 300, Some((10, 0.7)), false), found(2, 300, Some((10, 0.7)), true));
        println!("rows {rows:?}, runs {runs}, drives {drives}");
        assert!(rows.windows(2).all(|pair| pair[0] > pair[1]), "{rows:?}");
        // Two deviations of the ratio's slope and an error of 0.01 of the means.
        assert!(rows[3] < 0.08, "{rows:?}");
        assert!(runs > rows[2] + 0.1 && drives > rows[2] + 0.1 && runs.max(drives) < CAP, "{runs} {drives}");
        // Two degrees of freedom beyond the least say next to nothing.
        let few = found(3, 3, None, false);
        assert!(few > rows[0] && few <= CAP, "{few}");
    }
}
