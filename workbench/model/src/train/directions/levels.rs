//! Mean and spreads of one direction, from healthy records of runs of drives.
//!
//! ```text
//! y_itr = c + u_i + b_it + e_itr,   drive i = 1 … I, run t = 1 … m_i, record r = 1 … n_it
//! u ~ (0, U),  b ~ (0, B),  e ~ N(0, W + v_itr)                           v: known excess variance of the error
//! ω = 1/(1 + v/W),   N = Σ_r ω,   x = Σ_r ω y/N                                                   (1)  of a run
//! W = Σ ω (y − x)²/Σ (n − 1)                                              (2)  solved with (1)
//! C = Σ (x − x̄_i)²/f,   f = Σ (m_i − 1) − k                               (3)  k: fitted weights of the background
//! B = max(C − W mean(1/N), C/50),   B, W ← × f/χ²_0.3(f)                  (4)
//! U = max(v (1 + 1/I) (I − 1)/χ²_0.05(I − 1) − C/m, C/(2m)),   v: variance of the x̄_i            (5)
//! U = C/m                                                                 (6)  for a single drive
//! γ = skewness of (y − h û_i)/s + ½ √(6/Σ m_i),   0.01 … 1.5              (7)  y, h, s, û of [`super::lasting`]
//! ```
//!
//! The offsets of successive runs may resemble each other: [`super::lasting`] finds ρ, and B in the place of (4).
//!
//! (4) takes the noise at its upper limit of 70 %, (5) the spread of drives at that of 95 % for a drive that is not
//! among them, and never below what the means of the drives resolve: an offset that is thought to be impossible would
//! never be learned. A single drive is judged from its mean, which has the variance (6); of other drives it says
//! nothing. With ρ = 0, (7) is that of x − x̄_i, and unbiased for the third moment: m/((m − 1)(m − 2)) Σ (x − x̄)³ of
//! each drive, weighted by m − 2.

use super::lasting;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Fewest degrees of freedom (3).
pub const FEWEST: f64 = 10.0;
/// Probability that the noise is larger than (4) says is 70 %.
const NOISE: f64 = 0.3;
/// Probability that U is larger than (5) says is 5 %.
const BETWEEN: f64 = 0.05;
/// Least part of the spread of runs that is between them.
const LEAST_PART: f64 = 0.02;
/// The same of a first estimate.
const LEAST_FIRST: f64 = 0.1;
/// Least Σω of a run that counts.
pub(super) const LEAST_WEIGHT: f64 = 0.5;
/// Bounds of the skewness (7), and that without a drive of three runs.
const SKEWNESS: [f64; 2] = [0.01, 1.5];
const UNKNOWN_SKEWNESS: f64 = 1.0;
/// Iterations of (1) with (2).
const ITERATIONS: usize = 50;

/// Values of one direction by drive, run and record, each with the excess variance of its error.
pub type Sample = Vec<Vec<Vec<[f64; 2]>>>;

/// The constants of a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Levels {
    /// c, the mean of the drives' means.
    pub centre: f64,
    /// U.
    pub between: f64,
    /// B.
    pub run: f64,
    /// W.
    pub record: f64,
    /// γ.
    pub skewness: f64,
    /// ρ; `None` if too few runs of a drive follow each other.
    pub correlation: Option<f64>,
    /// f.
    pub freedom: f64,
}

impl Levels {
    /// s₀², the variance of the mean of a run of so many records.
    pub(super) fn usual(&self, records: f64) -> f64 {
        self.run + self.record / records
    }

    /// Estimates (1) to (7) of a direction with so many fitted weights; `None` if the records say too little or are
    /// constant.
    #[must_use]
    pub fn of(sample: &Sample, fitted: usize) -> Option<Self> {
        let record = record(sample)?;
        let means = means(sample, record);
        let drives: Vec<Vec<[f64; 2]>> = means.into_iter().filter(|runs| !runs.is_empty()).collect();
        let runs = drives.iter().map(|runs| runs.len()).sum::<usize>() as f64;
        let count = drives.len() as f64;
        let freedom = runs - count - fitted as f64;
        if freedom < FEWEST {
            return None;
        }
        let of_drives: Vec<f64> = drives.iter().map(|runs| mean(runs.iter().map(|[x, _]| *x))).collect();
        let deviations = || drives.iter().zip(&of_drives).map(|(runs, mean)| runs.iter().map(move |[x, _]| x - mean));
        let spread = deviations().flatten().map(|deviation| deviation * deviation).sum::<f64>() / freedom; // C
        let inverse = mean(drives.iter().flatten().map(|[_, weight]| 1.0 / weight));
        let larger = larger(freedom, NOISE)?;
        let single = spread - record * inverse;
        let lasting = lasting::of(&drives, single.max(LEAST_FIRST * spread), record);
        let (correlation, run) = match lasting {
            // The fitted weights took degrees of freedom.
            Some((rho, run)) => (Some(rho), (run * (runs - count) / freedom).max(LEAST_PART * spread * larger)),
            None => (None, single.max(LEAST_PART * spread) * larger), // (4)
        };
        let centre = mean(of_drives.iter().copied());
        let of_mean = spread * mean(drives.iter().map(|runs| 1.0 / runs.len() as f64)); // C/m
        let between = if drives.len() > 1 {
            let variance = of_drives.iter().map(|mean| (mean - centre).powi(2)).sum::<f64>() / (count - 1.0);
            let widest = variance * (1.0 + 1.0 / count) * self::larger(count - 1.0, BETWEEN)?;
            (widest - of_mean).max(0.5 * of_mean) // (5)
        } else {
            of_mean // (6)
        };
        let skewness = skewness(&drives, (correlation.unwrap_or(0.0), run, record), runs - count);
        let levels = Self { centre, between, run, record: record * larger, skewness, correlation, freedom };
        let regular = [levels.between, levels.run, levels.record].iter().all(|x| x.is_finite() && *x > 0.0);
        (regular && levels.centre.is_finite()).then_some(levels)
    }
}

/// (2); `None` with fewer than [`FEWEST`] degrees of freedom, or if the records of runs are equal.
pub(super) fn record(sample: &Sample) -> Option<f64> {
    let runs = || sample.iter().flatten();
    let freedom = runs().map(|run| run.len().saturating_sub(1)).sum::<usize>() as f64;
    if freedom < FEWEST {
        return None;
    }
    let mut within = f64::INFINITY;
    for _ in 0..ITERATIONS {
        let squares = |run: &Vec<[f64; 2]>| {
            let (mean, _) = weighted(run, within);
            run.iter().map(|[y, v]| (y - mean).powi(2) / (1.0 + v / within)).sum::<f64>()
        };
        let next = runs().map(squares).sum::<f64>() / freedom;
        if !(next.is_finite() && next > 0.0) {
            return None;
        }
        let close = (next / within - 1.0).abs() < 1e-9;
        within = next;
        if close {
            break;
        }
    }
    Some(within)
}

/// x and N (1) of each run that counts, by drive.
pub(super) fn means(sample: &Sample, within: f64) -> Vec<Vec<[f64; 2]>> {
    let of_run = |run: &Vec<[f64; 2]>| {
        let (mean, weight) = weighted(run, within);
        (weight >= LEAST_WEIGHT).then_some([mean, weight])
    };
    sample.iter().map(|runs| runs.iter().filter_map(of_run).collect()).collect()
}

/// x and N (1).
pub(super) fn weighted(run: &[[f64; 2]], within: f64) -> (f64, f64) {
    let weight = |v: f64| 1.0 / (1.0 + v / within);
    let (sum, total) = run.iter().fold((0.0, 0.0), |(sum, total), [y, v]| (sum + weight(*v) * y, total + weight(*v)));
    (if total > 0.0 { sum / total } else { 0.0 }, total)
}

/// (7) by ρ, B and W; `freedom` is the number of runs less that of drives.
fn skewness(drives: &[Vec<[f64; 2]>], law: (f64, f64, f64), freedom: f64) -> f64 {
    let deviations = |runs: &Vec<[f64; 2]>| -> Vec<f64> {
        let news = lasting::news(runs, law);
        let [mean, _] = lasting::mean(&news);
        news.iter().map(|[y, h, variance]| (y - h * mean) / variance.sqrt()).collect()
    };
    let all: Vec<Vec<f64>> = drives.iter().map(deviations).collect();
    let spread = all.iter().flatten().map(|x| x * x).sum::<f64>() / freedom;
    let enough = || all.iter().filter(|runs| runs.len() > 2).map(|runs| (runs.len() as f64, runs));
    let runs: f64 = enough().map(|(m, _)| m).sum();
    if runs <= 0.0 {
        return UNKNOWN_SKEWNESS;
    }
    let third: f64 = enough().map(|(m, runs)| m / (m - 1.0) * runs.iter().map(|x| x.powi(3)).sum::<f64>()).sum();
    let skewness = third / enough().map(|(m, _)| m - 2.0).sum::<f64>() / spread.powf(1.5);
    (skewness + 0.5 * (6.0 / runs).sqrt()).clamp(SKEWNESS[0], SKEWNESS[1])
}

/// ν/χ²_p(ν): the factor to the upper limit of a variance with ν degrees of freedom.
fn larger(freedom: f64, probability: f64) -> Option<f64> {
    let law = ChiSquared::new(freedom).ok()?;
    Some(freedom / law.inverse_cdf(probability))
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0_f64), |(sum, count), x| (sum + x, count + 1.0));
    sum / count.max(1.0)
}
