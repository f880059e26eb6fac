//! How long the offsets of runs last, from the order of the runs of each drive.
//!
//! ```text
//! x_t = u + b_t + ē_t,   b_t = ρ b_{t−1} + √(1 − ρ²) β_t,   β ~ N(0, B),   ē_t ~ N(0, W/N_t)               (1)
//! y_t = x_t − α_t,   h_t = 1 − c_t,   s_t²                              (2)  by the filter of the core's alarm
//! L(ρ, B) = −½ Σ_i [Σ_t ln s_t² + ln Λ_i + Σ_t (y_t − h_t û_i)²/s_t²],   Λ_i = Σ h_t²/s_t²                 (3)
//! ```
//!
//! (3) is the likelihood of the runs less the mean û of their drive (REML), so that short series bias it as little as
//! long ones. With equal probability of all ρ from 0 to 0.95, and of all ln B, ρ is the value that is exceeded with 5 %
//! and B likewise where ρ is this value. Two or three runs of a drive hardly tell a lasting offset from the drive's
//! own: unless all drives have together [`FEWEST`] runs beyond the second, ρ is 0.

/// Fewest runs beyond the second of each drive.
pub const FEWEST: usize = 16;
/// Largest ρ: of offsets that last longer, so few runs say nothing.
const LONGEST: f64 = 0.95;
const STEPS: usize = 19;
/// Probability that ρ, and B at this ρ, are larger.
const UNLIKELY: f64 = 0.05;
/// B is searched by eighths of octaves between these, relative to a first estimate.
const OCTAVES: [i32; 2] = [-20, 32];

/// x and N of the runs of each drive, in the order of time.
pub(super) type Means = [Vec<[f64; 2]>];

/// y, h and s² of (2) of the runs of one drive.
pub(super) fn news(runs: &[[f64; 2]], (rho, run, record): (f64, f64, f64)) -> Vec<[f64; 3]> {
    let (mut offset, mut part, mut variance) = (0.0, 0.0, run);
    let mut of_run = |[x, weight]: &[f64; 2]| {
        (offset, part, variance) = (rho * offset, rho * part, rho * rho * variance + (1.0 - rho * rho) * run);
        let [y, h, total] = [x - offset, 1.0 - part, variance + record / weight];
        let gain = variance / total;
        (offset, part, variance) = (offset + gain * y, part + gain * h, variance * (1.0 - gain));
        [y, h, total]
    };
    runs.iter().map(&mut of_run).collect()
}

/// û and Λ of (3).
pub(super) fn mean(news: &[[f64; 3]]) -> [f64; 2] {
    let sum = |of: &dyn Fn(&[f64; 3]) -> f64| news.iter().map(of).sum::<f64>();
    let precision = sum(&|[_, h, variance]| h * h / variance);
    [sum(&|[y, h, variance]| h * y / variance) / precision, precision]
}

/// (3).
fn likelihood(means: &Means, law: (f64, f64, f64)) -> f64 {
    let of_drive = |runs: &Vec<[f64; 2]>| {
        let news = news(runs, law);
        let [mean, precision] = mean(&news);
        let term = |[y, h, variance]: &[f64; 3]| variance.ln() + (y - h * mean).powi(2) / variance;
        -0.5 * (news.iter().map(term).sum::<f64>() + precision.ln())
    };
    means.iter().map(of_drive).sum()
}

/// ρ, and the upper limit of B, from a first estimate of B and from W; `None` with too few runs.
pub(super) fn of(means: &Means, run: f64, record: f64) -> Option<(f64, f64)> {
    if means.iter().map(|runs| runs.len().saturating_sub(2)).sum::<usize>() < FEWEST {
        return None;
    }
    let correlations: Vec<f64> = (0..=STEPS).map(|k| LONGEST * k as f64 / STEPS as f64).collect();
    let variances: Vec<f64> = (OCTAVES[0]..=OCTAVES[1]).map(|k| run * (f64::from(k) / 8.0).exp2()).collect();
    let row = |rho: &f64| -> Vec<f64> { variances.iter().map(|b| likelihood(means, (*rho, *b, record))).collect() };
    let all: Vec<Vec<f64>> = correlations.iter().map(row).collect();
    let highest = all.iter().flatten().copied().fold(f64::NEG_INFINITY, f64::max);
    let weigh = |row: &Vec<f64>| -> Vec<f64> { row.iter().map(|l| (l - highest).exp()).collect() };
    let all: Vec<Vec<f64>> = all.iter().map(weigh).collect();
    let place = upper(&all.iter().map(|row| row.iter().sum()).collect::<Vec<f64>>());
    let limits = all.get(place).map(|row| upper(row))?;
    Some((correlations[place], variances[limits]))
}

/// The first place beyond which there is at most [`UNLIKELY`] of the sum.
fn upper(weights: &[f64]) -> usize {
    let all: f64 = weights.iter().sum();
    let mut sum = 0.0;
    let reached = weights.iter().position(|weight| {
        sum += weight;
        sum >= (1.0 - UNLIKELY) * all
    });
    reached.unwrap_or(weights.len() - 1)
}
