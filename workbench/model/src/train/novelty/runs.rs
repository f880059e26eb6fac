//! Mean, covariance and law of the distance for a segment of the next run, from healthy segments of several runs.
//!
//! ```text
//! z_ij = μ + b_i + e_ij,   b ~ N(0, Σ_b) of run i = 1 … k,   e ~ N(0, Σ_e) of segment j = 1 … n_i,   N = Σ n_i
//! m  = Σ ȳ_i / k,   B = Σ (ȳ_i − m)(ȳ_i − m)ᵀ/(k − 1),   E B = Σ_b + h Σ_e,   h = Σ (1/n_i) / k
//! W  = Σ (z_ij − ȳ_i)(z_ij − ȳ_i)ᵀ/(N − k),               E W = Σ_e
//! S  = B + (1 − h) W,                                     E S = Σ_b + Σ_e                     (1)
//! λ  = c e/(1 − e + c e),   e: eigenvalues of S⁻¹B,   1/c: 10 % quantile of F(k − 1, N − k)    (2)
//! 1/f = [Σλ² + (Σλ)²]/((k − 1)(p² + p)) + [Σ(1−λ)² + (Σ(1−λ))²]/((N − k)(p² + p))             (3)
//! d² = (z − m)ᵀ S⁻¹ (z − m) ~ a F(p, ν),   ν = f − p + 1,   a = p f (1 + λ̄/k)/ν               (4)
//! t  = slope of ȳ over i divided by its standard error, k − 2 degrees of freedom
//! S ← S + δδᵀ,   δ = slope · (k + 1)/2   if |t| is significant in any coordinate               (5)
//! ```
//!
//! (1) needs no iteration, is positive semidefinite and unbiased for any n_i: it is the covariance of one segment drawn
//! from each run, averaged over all draws. One segment of each run of the k runs and of the next are exchangeable, so
//! the degrees of freedom are at least those of the runs, k − 1. (3) is Satterthwaite's approximation for sums of
//! Wishart matrices (Nel and van der Merwe 1986, in the invariant form of Krishnamoorthy and Yu 2004): f is near N − k
//! if runs do not differ, and k − 1 if they differ much more than the segments within them. With the estimated e, runs
//! that happen to be alike would have too small an S and too large an f at the same time; λ is therefore the upper 90 %
//! confidence limit of the part of the variance that is between runs. In simulations the mean rate is never more than
//! 1.5 times the set one; at few runs it is lower. With one segment in each run, (4) is Hotelling's law of k segments.
//! Heavy tails of the segments within runs are considered as in [`super::law`].
//!
//! Values with errors or missing values: ȳ_i and W are those of `crate::train::distribution::moments` with the runs as
//! classes. The means then have larger errors than Σ_e/n_i and B is larger, so that S is too large rather than too
//! small.
//!
//! (5) A significant trend (5 %, Bonferroni over the coordinates) means that the next run is expected at δ from the
//! mean of the training runs, outside their spread. δδᵀ covers this distance on both sides of m, whether the drift goes
//! on or ends; the spread of B that the trend explains is kept as a margin. A drift that continues beyond the next run
//! leaves this covariance sooner or later: in its direction, a mean at t δ has the distance t a/√(1 + a²), a² = δᵀS⁻¹δ,
//! and reaches the gate d after
//!
//! ```text
//! r = (k + 1)/2 · d √(1 + a²)/a − (k − 1)/2   runs                       (6)
//! ```
//!
//! (`Drift::runs_to`). A trend that is not significant is in B with the spread of its runs.
//!
//! The rate rests on normally distributed runs. Without this assumption, the largest of k + 1 exchangeable runs is the
//! next one with probability 1/(k + 1): no rate below this is supported ([`supported`]).

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use super::laws::law::{DistanceLaw, Likelihoods, TailDensities, equivalent, fewest_near, is_near};
pub use super::trend::{Drift, Slope};
use super::trend::{Shift, trend};
use crate::train::FeatureTable;
use crate::train::distribution::covariance::{symmetric, whitening};
use crate::train::distribution::moments::{self, Moments, Observed};

/// Probability that the part of the variance between runs is larger than assumed.
const UNLIKELY: f64 = 0.1;
/// Largest factor between the d² of a gate whose spread is that of the runs alone and that of known mean and
/// covariance: twice the distance. It does not depend on the spread that is found, because runs that happen to be alike
/// would then be accepted most often.
const FARTHEST: f64 = 4.0;

/// Spread of healthy runs.
#[derive(Clone, Debug, PartialEq)]
pub struct RunSpread {
    /// Number of runs.
    pub count: usize,
    /// Part of the variance that is between runs, mean over the directions; an upper estimate (2).
    pub between: f64,
    /// λ (2), the part of the variance that is between runs in each direction.
    pub shares: DVector<f64>,
    /// h (1), the mean of 1/n over the runs.
    pub inverse_size: f64,
    /// Number of segments of the longest run.
    pub longest: usize,
    /// f (3), the degrees of freedom of the covariance.
    pub freedom: f64,
    /// Trend of each coordinate.
    pub slopes: Vec<Slope>,
    /// The trend, if it is significant.
    pub drift: Option<Drift>,
}

/// Mean, covariance, law and spread for a segment of the next run.
#[derive(Debug)]
pub(super) struct NextRun {
    pub(super) mean: DVector<f64>,
    pub(super) covariance: DMatrix<f64>,
    pub(super) law: DistanceLaw,
    pub(super) spread: RunSpread,
}

/// Returns the rows of runs in which every coordinate occurs, with runs numbered from 0 in their order, and the number
/// of these runs.
pub(super) fn complete(table: &FeatureTable, runs: &[usize]) -> (Vec<usize>, Vec<usize>, usize) {
    let coordinates = table.rows.first().map_or(0, DVector::len);
    let has = |run: usize, k: usize| {
        let mut own = table.variances.iter().zip(runs).filter(|(_, r)| **r == run);
        own.any(|(variance, _)| variance[k].is_finite())
    };
    let mut order: Vec<usize> = runs.to_vec();
    order.sort_unstable();
    order.dedup();
    order.retain(|&run| (0..coordinates).all(|k| has(run, k)));
    let place = |run: &usize| order.iter().position(|own| own == run);
    let (rows, numbers) = runs.iter().enumerate().filter_map(|(row, run)| Some((row, place(run)?))).unzip();
    (rows, numbers, order.len())
}

/// What (1) to (4) need of the runs.
#[derive(Clone, Debug)]
pub struct RunMoments {
    /// k, the number of runs.
    pub count: usize,
    /// N, the number of segments.
    pub rows: usize,
    /// Segments of the longest run.
    pub longest: usize,
    /// h.
    pub inverse_size: f64,
    /// m, the mean of the runs' means.
    pub mean: DVector<f64>,
    /// B, the covariance of the runs' means.
    pub between: DMatrix<f64>,
    /// W, the covariance of segments within runs.
    pub within: DMatrix<f64>,
}

impl RunMoments {
    /// The moments of z = W (f − m).
    #[must_use]
    pub fn map(&self, matrix: &DMatrix<f64>, centre: &DVector<f64>) -> Self {
        let covariance = |own: &DMatrix<f64>| symmetric(&(matrix * own * matrix.transpose()));
        let (between, within) = (covariance(&self.between), covariance(&self.within));
        Self { mean: matrix * (&self.mean - centre), between, within, ..*self }
    }
}

/// Computes (1) to (5) for healthy rows of runs numbered from 0 to `count` − 1, more rows than runs.
///
/// # Errors
/// The index of the first coordinate that is constant or a combination of those before it.
pub(super) fn next_run(table: &FeatureTable, runs: &[usize], count: usize) -> Result<NextRun, usize> {
    let of_runs = table.observed().into_iter().zip(runs).map(|(row, &class)| Observed { class, ..row });
    let observed: Vec<Observed<'_>> = of_runs.collect();
    let Moments { means, covariance: within } = moments::moments(&observed, count);
    let k = count as f64;
    let mean = means.iter().sum::<DVector<f64>>() / k;
    let between = means.iter().map(|own| (own - &mean) * (own - &mean).transpose()).sum::<DMatrix<f64>>() / (k - 1.0);
    let sizes: Vec<usize> = (0..count).map(|run| runs.iter().filter(|r| **r == run).count()).collect();
    let inverse_size = sizes.iter().map(|&n| 1.0 / n as f64).sum::<f64>() / k;
    let longest = sizes.iter().copied().max().unwrap_or(1);
    let tails = within_distances(table, &means, (runs, &sizes), &within).unwrap_or_default();
    let densities = TailDensities::new(within.nrows(), table.rows.len() - count).filter(|_| !tails.is_empty());
    let tails = densities.map(|densities| densities.likelihoods(&tails));
    let rows = table.rows.len();
    of_moments(RunMoments { count, rows, longest, inverse_size, mean, between, within }, tails, trend(&means))
}

/// Computes (1) to (5) from the moments of runs, the likelihoods of the tails, and the trend.
///
/// # Errors
/// As [`next_run`].
pub(super) fn of_moments(
    moments: RunMoments,
    tails: Option<Likelihoods>,
    (slopes, trend): (Vec<Slope>, Option<Shift>),
) -> Result<NextRun, usize> {
    let RunMoments { count, rows, longest, inverse_size, mean, between, within } = moments;
    let (p, k) = (within.nrows(), count as f64);
    let covariance = &between + &within * (1.0 - inverse_size); // (1)
    let (root, _) = whitening(&covariance)?;
    let shares = (&root * &between * root.transpose()).symmetric_eigenvalues();
    let larger = larger(count, rows);
    let shares = shares.map(|e| {
        let odds = larger * e.clamp(0.0, 1.0);
        odds / (1.0 - e.clamp(0.0, 1.0) + odds) // (2)
    });
    let freedom = freedom(&shares, count, rows);
    let part = shares.mean();
    let law = DistanceLaw::of_freedom(p, (freedom, 1.0 + part / k), tails); // (4)
    let deviation = |k: usize| covariance[(k, k)].sqrt();
    let relative =
        |(k, slope): (usize, &Slope)| Slope { value: slope.value / deviation(k), error: slope.error / deviation(k) };
    let slopes = slopes.iter().enumerate().map(relative).collect();
    let drift = trend.as_ref().map(|(coordinates, shift)| {
        let distance = (&root * shift).norm();
        Drift { coordinates: coordinates.clone(), distance }
    });
    let covariance = trend.map_or(covariance.clone(), |(_, shift)| covariance + &shift * shift.transpose()); // (5)
    let spread = RunSpread { count, between: part, shares, inverse_size, longest, freedom, slopes, drift };
    Ok(NextRun { mean, covariance, law, spread })
}

/// Returns c of (2).
fn larger(runs: usize, rows: usize) -> f64 {
    let law = FisherSnedecor::new(runs as f64 - 1.0, rows as f64 - runs as f64);
    1.0 / law.map_or(1.0, |law| law.inverse_cdf(UNLIKELY))
}

/// Computes (3) from the parts λ; not fewer degrees of freedom within the runs than between them.
fn freedom(shares: &DVector<f64>, runs: usize, rows: usize) -> f64 {
    let p = shares.len() as f64;
    let of_runs = runs as f64 - 1.0;
    let of_segments = (rows.saturating_sub(runs) as f64).max(of_runs);
    let square = |parts: &DVector<f64>| parts.norm_squared() + parts.sum().powi(2);
    let inverse = square(shares) / of_runs + square(&shares.map(|part| 1.0 - part)) / of_segments;
    (p * p + p) / inverse
}

/// Returns the d² of each segment from its run's mean, relative to the other segments, as if these distances had no
/// error from the run's mean. Runs of a single segment have none.
fn within_distances(
    table: &FeatureTable,
    means: &[DVector<f64>],
    (runs, sizes): (&[usize], &[usize]),
    within: &DMatrix<f64>,
) -> Option<Vec<f64>> {
    let own: Vec<usize> = (0..runs.len()).filter(|&row| sizes[runs[row]] > 1).collect();
    let mut residuals = table.keep(&own);
    for (value, &row) in residuals.rows.iter_mut().zip(&own) {
        let n = sizes[runs[row]] as f64;
        *value = (&*value - &means[runs[row]]) * (n / (n - 1.0)).sqrt();
    }
    residuals.classes = vec![0; own.len()];
    let p = within.nrows();
    let found = Moments { means: vec![DVector::zeros(p)], covariance: within.clone() };
    let squared = moments::left_out(&residuals.observed(), &found)?;
    Some(squared.into_iter().map(|(squared, available)| equivalent(squared, available, p)).collect())
}

/// Returns the smallest number of runs that support a false-alarm rate.
#[must_use]
pub fn fewest(coordinates: usize, rate: f64) -> usize {
    fewest_near(coordinates, rate, FARTHEST)
}

/// Returns the smallest false-alarm rate that so many runs support, with two digits: a gate of `coordinates` from
/// `runs` rows is not too far out for it. `None` if they support none.
#[must_use]
pub fn supported(coordinates: usize, runs: usize) -> Option<f64> {
    if runs < coordinates + 2 {
        return None;
    }
    let rates = (2..=10).flat_map(|decade| (10..100).map(move |digits| f64::from(digits) / 10_f64.powi(decade)));
    let mut rates: Vec<f64> = rates.filter(|rate| *rate <= 0.5).collect();
    rates.sort_by(f64::total_cmp);
    let first = rates.partition_point(|&rate| !is_near(coordinates, runs, rate, FARTHEST));
    rates.get(first).copied()
}

/// Says which rate so many runs support, and how many support the set one.
pub(super) fn refusal(coordinates: usize, runs: usize, rate: f64) -> String {
    let least = fewest(coordinates, rate);
    let of = if coordinates == 1 { "1 coordinate".into() } else { format!("{coordinates} coordinates") };
    let Some(possible) = supported(coordinates, runs) else {
        return format!(
            "{runs} runs support no false-alarm rate for the next run with {of}; give at least {least} runs, or use \
             fewer features"
        );
    };
    let free = 1.0 / (runs as f64 + 1.0);
    let other = if free > possible { format!(", otherwise {:.0} %", 100.0 * free) } else { String::new() };
    format!(
        "{runs} runs support a false-alarm rate of {} % for the next run with {of}, if runs are normally \
         distributed{other}; give at least {least} runs, use fewer features, or --false-alarm {possible}",
        (100.0 * possible) as f32
    )
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};
    use rayon::prelude::*;

    use super::*;

    fn exact(values: &[DVector<f64>]) -> FeatureTable {
        FeatureTable::exact(values.to_vec(), vec![0; values.len()], vec!["healthy".into()])
    }

    #[test]
    fn three_runs_by_hand() {
        // Means 1, 9, 5: B = 16, W = 2, h = 1/2, S = 17, e = 16/17.
        let values = [0.0, 2.0, 8.0, 10.0, 4.0, 6.0].map(|x| DVector::from_element(1, x));
        let found = next_run(&exact(&values), &[0, 0, 1, 1, 2, 2], 3).expect("regular");
        assert!((found.mean[0] - 5.0).abs() < 1e-12 && (found.covariance[(0, 0)] - 17.0).abs() < 1e-9);
        // F(2, ν) has the quantile ν/2 ((1 − P)^(−2/ν) − 1).
        let larger = 1.0 / (1.5 * (0.9_f64.powf(-2.0 / 3.0) - 1.0));
        let part = larger * 16.0 / (1.0 + larger * 16.0);
        let by_hand = 1.0 / (part.powi(2) / 2.0 + (1.0 - part).powi(2) / 3.0);
        let spread = found.spread;
        assert!((spread.between - part).abs() < 1e-6 && spread.drift.is_none(), "{spread:?}");
        assert!((spread.freedom - by_hand).abs() < 1e-5, "{spread:?}");
    }

    #[test]
    fn fewer_runs_support_higher_rates_only() {
        println!("smallest false-alarm rate for the next run, %, by runs and coordinates");
        for coordinates in 1..=4 {
            let each: Vec<Option<f64>> = (3..=20).map(|runs| supported(coordinates, runs)).collect();
            let shown: Vec<String> = each
                .iter()
                .map(|rate| rate.map_or("none".into(), |rate| ((100.0 * rate) as f32).to_string()))
                .collect();
            println!("{coordinates} coordinates, 3 to 20 runs: {}", shown.join(", "));
            assert!(each.windows(2).all(|pair| pair[0].is_none() || pair[0] >= pair[1]), "{each:?}");
            for rate in [1e-2, 1e-3] {
                let least = fewest(coordinates, rate);
                println!("{coordinates} coordinates: {least} runs for {rate}");
                assert!(supported(coordinates, least).is_some_and(|found| found <= rate));
                assert!(supported(coordinates, least - 1).is_none_or(|found| found > rate));
            }
        }
        let text = refusal(2, 5, 0.01);
        assert!(text.contains("5 runs support") && text.contains("at least 7 runs"), "{text}");
    }

    /// Segments of `counts` in each run. A coordinate has variance 1, of which `parts` are between runs, and the mean
    /// moves by `drift` in the first coordinate from run to run.
    fn simulated(counts: &[usize], parts: &[f64], drift: f64, random: &mut ChaCha8Rng) -> (FeatureTable, Vec<usize>) {
        let (mut values, mut runs) = (vec![], vec![]);
        for (run, &count) in counts.iter().enumerate() {
            let own = normal(parts, random);
            for _ in 0..count {
                let within: Vec<f64> = parts.iter().map(|part| 1.0 - part).collect();
                let mut value = &own + normal(&within, random);
                value[0] += drift * run as f64;
                values.push(value);
                runs.push(run);
            }
        }
        (exact(&values), runs)
    }

    fn normal(variances: &[f64], random: &mut ChaCha8Rng) -> DVector<f64> {
        DVector::from_fn(variances.len(), |k, _| {
            let x: f64 = StandardNormal.sample(random);
            variances[k].sqrt() * x
        })
    }

    /// Mean false-alarm rate of a segment of the next run at 1 %, and the part of training sets with a drift.
    fn rates(counts: &[usize], parts: &[f64], drift: f64) -> (f64, f64) {
        const DRAWS: u64 = 1000;
        const SEGMENTS: usize = 300;
        let one = |draw: u64| {
            let mut random = ChaCha8Rng::seed_from_u64(draw);
            let (table, runs) = simulated(counts, parts, drift, &mut random);
            let found = next_run(&table, &runs, counts.len()).expect("regular");
            let limit = found.law.squared_at(100_f64.ln());
            let inverse = found.covariance.cholesky().expect("regular").inverse();
            let beyond = |_: &usize| {
                let mut z = normal(&vec![1.0; parts.len()], &mut random) - &found.mean;
                z[0] += drift * counts.len() as f64;
                z.dot(&(&inverse * &z)) > limit
            };
            let alarms = (0..SEGMENTS).filter(beyond).count();
            (alarms as f64 / SEGMENTS as f64, f64::from(u8::from(found.spread.drift.is_some())))
        };
        let all: Vec<(f64, f64)> = (0..DRAWS).into_par_iter().map(one).collect();
        let mean = |of: fn(&(f64, f64)) -> f64| all.iter().map(of).sum::<f64>() / DRAWS as f64;
        (mean(|one| one.0), mean(|one| one.1))
    }

    #[test]
    fn the_next_run_has_the_set_rate() {
        for p in [1, 2, 4] {
            let least = fewest(p, 0.01);
            for runs in [least, 12, 20].into_iter().filter(|runs| p < 4 || *runs != 12) {
                for part in [0.0, 0.3, 0.7, 0.95] {
                    let (rate, drift) = rates(&vec![10; runs], &vec![part; p], 0.0);
                    println!(
                        "{p} coordinates, {runs} runs, {part} between: {:.2} %, drift in {:.1} %",
                        100.0 * rate,
                        100.0 * drift
                    );
                    assert!(rate < 0.015, "{p} {runs} {part}: {rate}");
                    // The ratio (2) and the weight of heavy tails lower the rate at few runs.
                    assert!(rate > 0.01 / 1.5 || runs < 10 * p.min(2), "{p} {runs} {part}: {rate}");
                    assert!(drift < 0.07, "{drift}"); // 5 % and 3 standard errors of 1000 draws
                }
            }
        }
    }

    #[test]
    fn unequal_runs_and_directions() {
        for (counts, parts) in [
            (vec![2, 30, 5, 5, 1, 12, 3, 8], vec![0.0, 0.0]),
            (vec![2, 30, 5, 5, 1, 12, 3, 8], vec![0.8, 0.3]),
            (vec![20; 6], vec![0.9, 0.0]),
            (vec![20; 12], vec![0.9, 0.0]),
        ] {
            let (rate, _) = rates(&counts, &parts, 0.0);
            println!("{counts:?} {parts:?}: {:.2} %", 100.0 * rate);
            assert!((0.003..0.015).contains(&rate), "{counts:?} {parts:?}: {rate}");
        }
    }

    #[test]
    fn a_drift_is_found_and_covered() {
        // Every run moves by a deviation of a segment; a tenth of the variance is between runs otherwise.
        for runs in [6, 8, 12] {
            let (rate, drift) = rates(&vec![10; runs], &[0.1, 0.1], 1.0);
            println!("{runs} runs with a drift: {:.2} %, drift in {:.1} %", 100.0 * rate, 100.0 * drift);
            assert!(rate < 0.015 && drift > 0.8, "{runs}: {rate} {drift}");
        }
    }
}
