//! Proper scores and calibration of posteriors.
//!
//! ```text
//! log score    −ln P(true class), nats                                   (1)  0 is perfect
//! guarded      −ln (0.99 P(true class) + 0.01 prior of it)               (5)
//! Brier score  Σ_k (P(k) − y_k)²,   y_k = 1 for the true class, else 0    (2)  0 is perfect, 2 the worst
//! calibration  ō_b − p̄_b of the rows whose P(k) is in bin b               (3)
//! Brier score ≈ Σ_kb w_b (p̄_b − ō_b)² − Σ_kb w_b (ō_b − ō_k)² + Σ_k ō_k (1 − ō_k)
//!               reliability             resolution              uncertainty (4)  Murphy 1973
//! ```
//!
//! (5) is the criterion of the choice between recipes: it is (1) of a model that regards one row in a hundred as an
//! outlier, for which only the prior is known. The posteriors of Gaussian densities are far too extreme for a row far
//! from all means, and one row of this kind would outweigh all others in (1).
//!
//! p̄ is the mean posterior of a bin, ō the share of class k in it, w the bin's share of the rows; (4) neglects the
//! variation of the posteriors within a bin. The expected calibration error is the mean of |(3)| over rows and classes.
//! A score must be compared with that of the priors, which do not depend on the row.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use crate::core::Finding;
use crate::evaluate::{Rate, TraceVerdict};

/// Bins of (3), of equal width.
const BINS: usize = 10;
/// 97.5 % quantile of the normal distribution.
const Q: f64 = 1.959_963_984_540_054;

/// The prediction for one row whose class is known.
#[derive(Clone, Debug, PartialEq)]
pub struct Prediction {
    /// Its class.
    pub truth: usize,
    /// The decided class, if there is a decision.
    pub decided: Option<usize>,
    /// ln P(k) of every class.
    pub log_posteriors: Vec<f64>,
    /// The weight of the row.
    pub weight: f64,
}

impl Prediction {
    fn is_wrong(&self) -> bool {
        self.decided != Some(self.truth)
    }
}

/// Mean of a score, with its standard error and that of the priors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Score {
    /// Score of the posteriors.
    pub value: f64,
    /// Standard error of the mean.
    pub standard_error: f64,
    /// Score of the priors on the same rows.
    pub of_prior: f64,
}

/// Rows whose posterior of a class is in one bin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bin {
    /// Middle of the bin.
    pub middle: f64,
    /// Mean posterior p̄.
    pub posterior: f64,
    /// Share of the class ō, with its binomial 95 % interval.
    pub observed: Rate,
    /// Number of rows.
    pub count: usize,
    /// Share of these rows in the sum of all weights.
    pub share: f64,
}

/// Terms of (4).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decomposition {
    /// Error of calibration; 0 is perfect.
    pub reliability: f64,
    /// Spread of the outcomes over the bins; larger is better.
    pub resolution: f64,
    /// Uncertainty that remains if only the shares of the classes are known.
    pub uncertainty: f64,
}

/// Scores of a set of predictions.
#[derive(Clone, Debug, PartialEq)]
pub struct Scores {
    /// Number of rows.
    pub count: usize,
    /// Share of rows with a wrong decision or none.
    pub error: f64,
    /// The same with an interval that considers groups of rows that are alike, if they are given.
    pub error_by_group: Option<Rate>,
    /// (1).
    pub log: Score,
    /// (5).
    pub guarded: Score,
    /// (2).
    pub brier: Score,
    /// (4).
    pub decomposition: Decomposition,
    /// Mean of |(3)|.
    pub calibration_error: f64,
    /// The bins that contain rows, for each class.
    pub bins: Vec<Vec<Bin>>,
}

impl Scores {
    /// Computes the scores of predictions with these priors.
    #[must_use]
    pub fn new(predictions: &[Prediction], priors: &[f64]) -> Self {
        let total: f64 = predictions.iter().map(|p| p.weight).sum();
        let mean = |of: &dyn Fn(&Prediction) -> f64| predictions.iter().map(|p| p.weight * of(p)).sum::<f64>() / total;
        let log_priors: Vec<f64> = priors.iter().map(|p| p.ln()).collect();
        let score = |of: &dyn Fn(&[f64], usize) -> f64| {
            let value = mean(&|p| of(&p.log_posteriors, p.truth));
            let squares = predictions.iter().map(|p| (p.weight * (of(&p.log_posteriors, p.truth) - value)).powi(2));
            let n = predictions.len() as f64;
            let standard_error = (squares.sum::<f64>() * n / (n - 1.0)).sqrt() / total;
            Score { value, standard_error, of_prior: mean(&|p| of(&log_priors, p.truth)) }
        };
        let bins: Vec<Vec<Bin>> = (0..priors.len()).map(|class| bins(predictions, class, total)).collect();
        let base = |class: usize| mean(&|p| f64::from(u8::from(p.truth == class)));
        Self {
            count: predictions.len(),
            error: mean(&|p| f64::from(u8::from(p.is_wrong()))),
            error_by_group: None,
            log: score(&log_score),
            guarded: score(&|log_posteriors, truth| guarded_score(log_posteriors, truth, priors)),
            brier: score(&brier_score),
            decomposition: decompose(&bins, &(0..priors.len()).map(base).collect::<Vec<_>>()),
            calibration_error: bins.iter().flatten().map(|b| b.share * b.gap().abs()).sum::<f64>() / bins.len() as f64,
            bins,
        }
    }

    /// Same as [`Scores::new`], with the group (run, drive) of each prediction.
    pub(crate) fn by_group(predictions: &[Prediction], priors: &[f64], groups: &[usize]) -> Self {
        let mut sums = BTreeMap::<usize, (f64, f64)>::new();
        for (prediction, group) in predictions.iter().zip(groups) {
            let sum = sums.entry(*group).or_default();
            sum.0 += if prediction.is_wrong() { prediction.weight } else { 0.0 };
            sum.1 += prediction.weight;
        }
        let rate = Rate::clustered_of(&sums.into_values().collect::<Vec<_>>());
        Self { error_by_group: Some(rate), ..Self::new(predictions, priors) }
    }

    /// Computes the scores of the embedded detector's verdicts; for an undetermined verdict the posteriors are the
    /// priors. The single-precision posteriors are limited from below to the smallest normal number, e^−87. Traces of
    /// classes without a prior, which were not trained, do not count.
    pub(crate) fn of_verdicts(verdicts: &[TraceVerdict], priors: &[f64], per_segment: bool) -> Self {
        let prediction = |truth: usize, decided: Option<usize>, posteriors: &[f32]| {
            let log_posteriors = match decided {
                Some(_) => posteriors.iter().map(|p| f64::from(p.max(f32::MIN_POSITIVE)).ln()).collect(),
                None => priors.iter().map(|p| p.ln()).collect(),
            };
            Prediction { truth, decided, log_posteriors, weight: 1.0 }
        };
        let each = |v: &TraceVerdict| -> Vec<Prediction> {
            if per_segment {
                let segments = v.segments.iter();
                segments
                    .map(|s| prediction(v.class, s.verdict.clone().ok().and_then(Finding::class), &s.posteriors))
                    .collect()
            } else {
                vec![prediction(v.class, v.decided.and_then(Finding::class), &v.posteriors)]
            }
        };
        let trained = verdicts.iter().filter(|verdict| verdict.class < priors.len());
        Self::new(&trained.flat_map(each).collect::<Vec<_>>(), priors)
    }

    /// Adds the keys `log_score`, `brier_score`, `expected_calibration_error`.
    pub(crate) fn add_to(&self, value: &mut Value) {
        let Decomposition { reliability, resolution, uncertainty } = self.decomposition;
        value["log_score"] = self.log.to_json();
        value["brier_score"] = self.brier.to_json();
        value["brier_score"]["reliability"] = reliability.into();
        value["brier_score"]["resolution"] = resolution.into();
        value["brier_score"]["uncertainty"] = uncertainty.into();
        value["expected_calibration_error"] = self.calibration_error.into();
    }

    /// Returns the error rate and the keys of `Scores::add_to`.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let mut value =
            json!({ "rows": self.count, "error_rate": self.error, "guarded_log_score": self.guarded.value });
        self.add_to(&mut value);
        value
    }

    /// Describes the scores in words.
    #[must_use]
    pub fn summary(&self) -> String {
        let Self { log, brier, calibration_error, .. } = self;
        if brier.of_prior.abs() < f64::EPSILON {
            return "one class: log score, Brier score and calibration do not apply".into();
        }
        format!(
            "log score {:.3} ± {:.3} (priors {:.3}), Brier score {:.3} ± {:.3} (priors {:.3}), calibration error {:.1} %",
            log.value,
            log.standard_error,
            log.of_prior,
            brier.value,
            brier.standard_error,
            brier.of_prior,
            100.0 * calibration_error
        )
    }
}

impl Score {
    fn to_json(self) -> Value {
        let half = Q * self.standard_error;
        json!({ "value": self.value, "low": (self.value - half).max(0.0), "high": self.value + half, "prior": self.of_prior })
    }
}

impl Bin {
    fn gap(&self) -> f64 {
        self.observed.value - self.posterior // (3)
    }
}

/// (1).
fn log_score(log_posteriors: &[f64], truth: usize) -> f64 {
    -log_posteriors[truth]
}

/// (5).
pub(crate) fn guarded_score(log_posteriors: &[f64], truth: usize, priors: &[f64]) -> f64 {
    const OUTLIERS: f64 = 0.01;
    -((1.0 - OUTLIERS) * log_posteriors[truth].exp() + OUTLIERS * priors[truth]).ln()
}

/// (2).
fn brier_score(log_posteriors: &[f64], truth: usize) -> f64 {
    let each = log_posteriors.iter().enumerate();
    each.map(|(k, log)| (log.exp() - f64::from(u8::from(k == truth))).powi(2)).sum()
}

fn bins(predictions: &[Prediction], class: usize, total: f64) -> Vec<Bin> {
    let mut bins = vec![vec![]; BINS];
    for prediction in predictions {
        let posterior = prediction.log_posteriors[class].exp();
        bins[((posterior * BINS as f64) as usize).min(BINS - 1)].push((posterior, prediction));
    }
    let bin = |(place, rows): (usize, &Vec<(f64, &Prediction)>)| {
        let sum = |of: &dyn Fn(f64, &Prediction) -> f64| rows.iter().map(|(p, row)| of(*p, row)).sum::<f64>();
        let weight = sum(&|_, row| row.weight);
        let share = sum(&|_, row| if row.truth == class { row.weight } else { 0.0 }) / weight;
        // The number of equal weights whose mean has the same variance.
        let equal = weight * weight / sum(&|_, row| row.weight * row.weight);
        Bin {
            middle: (place as f64 + 0.5) / BINS as f64,
            posterior: sum(&|p, row| p * row.weight) / weight,
            observed: Rate::wilson_of(share * equal, equal),
            count: rows.len(),
            share: weight / total,
        }
    };
    bins.iter().enumerate().filter(|(_, rows)| !rows.is_empty()).map(bin).collect()
}

fn decompose(bins: &[Vec<Bin>], base: &[f64]) -> Decomposition {
    let all = || bins.iter().zip(base).flat_map(|(bins, base)| bins.iter().map(move |bin| (bin, base)));
    Decomposition {
        reliability: all().map(|(bin, _)| bin.share * bin.gap().powi(2)).sum(),
        resolution: all().map(|(bin, base)| bin.share * (bin.observed.value - base).powi(2)).sum(),
        uncertainty: base.iter().map(|o| o * (1.0 - o)).sum(),
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    fn two(truth: usize, p: f64, weight: f64) -> Prediction {
        let decided = Some(usize::from(p < 0.5));
        Prediction { truth, decided, log_posteriors: vec![p.ln(), (1.0 - p).ln()], weight }
    }

    #[test]
    fn scores_by_hand() {
        let scores =
            Scores::new(&[two(0, 0.8, 1.0), two(0, 0.8, 1.0), two(1, 0.8, 1.0), two(1, 0.25, 1.0)], &[0.5, 0.5]);
        // −(2 ln 0.8 + ln 0.2 + ln 0.75)/4 = (0.446287 + 1.609438 + 0.287682)/4
        assert!((scores.log.value - 0.585_852).abs() < 1e-6, "{scores:?}");
        // 2 (2·0.04 + 0.64 + 0.0625)/4
        assert!((scores.brier.value - 0.391_25).abs() < 1e-12 && (scores.brier.of_prior - 0.5).abs() < 1e-12);
        let guarded = Scores::new(&[two(1, 1.0, 1.0)], &[0.5, 0.5]);
        assert!(guarded.log.value.is_infinite() && (guarded.guarded.value - 200_f64.ln()).abs() < 1e-12);
        assert!((scores.log.of_prior - 2_f64.ln()).abs() < 1e-12 && (scores.error - 0.25).abs() < 1e-12);
        // Bins with one value each: 2 of 3 at 0.8, 0 of 1 at 0.25; the same for the other class.
        let expected = 0.75 * (2.0 / 3.0 - 0.8_f64).abs() + 0.25 * 0.25;
        assert!((scores.calibration_error - expected).abs() < 1e-12);
        let Decomposition { reliability, resolution, uncertainty } = scores.decomposition;
        assert!((reliability - resolution + uncertainty - scores.brier.value).abs() < 1e-12, "Murphy's identity");
    }

    #[test]
    fn weights_stand_for_rows() {
        let thrice = Scores::new(&[vec![two(0, 0.7, 1.0); 3], vec![two(1, 0.4, 1.0)]].concat(), &[0.5, 0.5]);
        let once = Scores::new(&[two(0, 0.7, 3.0), two(1, 0.4, 1.0)], &[0.5, 0.5]);
        assert!((thrice.log.value - once.log.value).abs() < 1e-12);
        assert!((thrice.calibration_error - once.calibration_error).abs() < 1e-12);
        assert_eq!(once.bins[0][1].count, 1);
    }

    #[test]
    fn honest_posteriors_are_calibrated_and_bold_ones_are_not() {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let draws: Vec<(f64, usize)> = (0..4000)
            .map(|_| {
                let p: f64 = rng.random_range(0.02..0.98);
                (p, usize::from(rng.random::<f64>() > p))
            })
            .collect();
        let scores = |bend: f64| {
            let said = |p: f64| {
                let odds = (p / (1.0 - p)).powf(bend);
                odds / (1.0 + odds)
            };
            let predictions: Vec<_> = draws.iter().map(|&(p, truth)| two(truth, said(p), 1.0)).collect();
            Scores::new(&predictions, &[0.5, 0.5])
        };
        let (honest, bold) = (scores(1.0), scores(3.0));
        // The mean of |ō − p̄| over ten bins of 400 rows is about 0.8 √(0.17/400) = 1.6 %.
        assert!((0.004..0.03).contains(&honest.calibration_error), "{}", honest.calibration_error);
        assert!(
            bold.calibration_error > 0.1 && bold.log.value > honest.log.value && bold.brier.value > honest.brier.value
        );
        // 95 % intervals: of 20 bins, all but a few contain the stated posterior.
        let holds = |bin: &&Bin| bin.observed.low <= bin.posterior && bin.posterior <= bin.observed.high;
        let held = honest.bins.iter().flatten().filter(holds).count();
        assert!((16..=20).contains(&held), "{held}");
        assert!(bold.bins.iter().flatten().filter(holds).count() < 10);
    }

    #[test]
    fn the_standard_error_is_that_of_a_mean() {
        let prediction = |p: f64| Prediction {
            truth: 0,
            decided: Some(0),
            log_posteriors: vec![p.ln(), (1.0 - p).ln()],
            weight: 1.0,
        };
        // Log scores 1, 2, 3, 6: mean 3, deviation √(14/3), of four rows.
        let predictions: Vec<Prediction> = [1.0, 2.0, 3.0, 6.0_f64].map(|score| prediction((-score).exp())).to_vec();
        let Score { value, standard_error, .. } = Scores::new(&predictions, &[0.5, 0.5]).log;
        assert!((value - 3.0).abs() < 1e-12, "{value}");
        assert!((standard_error - (14.0_f64 / 3.0 / 4.0).sqrt()).abs() < 1e-12, "{standard_error}");
    }
}
