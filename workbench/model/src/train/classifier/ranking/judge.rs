//! Scores of sets of features on one split, and the selection.

use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::Error;
use crate::train::classifier::cross_validation::predict;
use crate::train::classifier::fit::{self, fit};
use crate::train::classifier::scores::{Prediction, guarded_score};
use crate::train::classifier::shrinkage::Shrink;
use crate::train::classifier::{discriminant, shrinkage_search};
use crate::train::rows::folds::{Candidates, Folds, check};
use crate::train::{ClassStatistics, Recipe};

/// Number of standard errors below which a gain is regarded as chance.
const SURE: f64 = 2.0;
/// Correlation within classes from which on one feature is regarded as a repetition of another.
const ALIKE: f64 = 0.8;

/// Computes the scores of sets of features on one split.
pub(super) struct Judge<'a> {
    candidates: &'a Candidates,
    /// The same without what covariates explain.
    pub(super) corrected: Candidates,
    recipe: Recipe,
    pub(super) folds: Folds,
    pub(super) priors: Vec<f64>,
    weights: Vec<f64>,
}

/// Result of the selection.
pub(super) struct Path {
    pub(super) chosen: Vec<usize>,
    /// Gain of each feature when it was chosen, or beside all chosen features.
    pub(super) gains: BTreeMap<usize, Gain>,
    /// Whether features were removed from all of them, because none is of use alone.
    pub(super) backward: bool,
}

impl Gain {
    /// Whether the gain is more than chance.
    pub(super) fn is_sure(&self) -> bool {
        self.log > SURE * self.standard_error
    }
}

impl<'a> Judge<'a> {
    pub(super) fn new(candidates: &'a Candidates, recipe: &Recipe) -> Result<Self, Error> {
        let folds = Folds::new(candidates, &recipe.validation)?;
        let priors = discriminant::priors(&recipe.priors, candidates.table.names.len())?;
        let weights = candidates.weights(&priors);
        let shrink = match recipe.shrink {
            Shrink::Chosen => Shrink::To(shrinkage_search::search(candidates, recipe)?.shrinkage),
            given => given,
        };
        let corrected = fit::corrected(candidates, recipe)?;
        Ok(Self { candidates, corrected, recipe: Recipe { shrink, ..recipe.clone() }, folds, priors, weights })
    }

    /// Returns the posteriors with these features only; the priors without features, and `None` if the covariance is
    /// singular.
    pub(super) fn predict(&self, features: &[usize]) -> Option<Vec<Prediction>> {
        if features.is_empty() {
            let log_posteriors: Vec<f64> = self.priors.iter().map(|p| p.ln()).collect();
            let decided = (0..self.priors.len()).max_by(|&a, &b| self.priors[a].total_cmp(&self.priors[b]));
            let rows = self.candidates.table.classes.iter().zip(&self.weights);
            let prediction =
                |(&truth, &weight)| Prediction { truth, decided, log_posteriors: log_posteriors.clone(), weight };
            return Some(rows.map(prediction).collect());
        }
        predict(&self.candidates.select(features), &self.recipe, &self.folds).ok()
    }

    pub(super) fn gain(&self, before: &[Prediction], after: &[Prediction]) -> Gain {
        let wrong = |p: &Prediction| f64::from(u8::from(p.decided != Some(p.truth)));
        let total: f64 = self.weights.iter().sum();
        let mut of_group: BTreeMap<usize, f64> = BTreeMap::new();
        let (mut log, mut error) = (0.0, 0.0);
        for ((before, after), group) in before.iter().zip(after).zip(&self.candidates.groups) {
            let score = |p: &Prediction| guarded_score(&p.log_posteriors, p.truth, &self.priors);
            let gained = before.weight * (score(before) - score(after)) / total; // (3)
            *of_group.entry(*group).or_default() += gained;
            log += gained;
            error += before.weight * (wrong(before) - wrong(after)) / total;
        }
        let n = of_group.len() as f64;
        let squares: f64 = of_group.values().map(|sum| (sum - log / n).powi(2)).sum();
        Gain { log, standard_error: (squares * n / (n - 1.0)).sqrt(), error }
    }

    /// Forward selection; if no feature alone is better than the priors, but all together are, backward elimination.
    pub(super) fn select(&self) -> Path {
        let forward = self.forward();
        if forward.chosen.is_empty() { self.backward().unwrap_or(forward) } else { forward }
    }

    /// The gain of all features together over the priors; `None` if their covariance is singular.
    pub(super) fn gain_of_all(&self) -> Option<Gain> {
        let everything: Vec<usize> = (0..self.candidates.features.len()).collect();
        Some(self.gain(&self.predict(&[])?, &self.predict(&everything)?))
    }

    /// Removes the feature that is missed least, until every one is missed; `None` if all features together are not
    /// surely better than the priors.
    fn backward(&self) -> Option<Path> {
        self.gain_of_all().filter(Gain::is_sure)?;
        let everything = (0..self.candidates.features.len()).collect();
        let mut path = Path { chosen: everything, gains: BTreeMap::new(), backward: true };
        loop {
            let whole = self.predict(&path.chosen)?;
            let without = |&feature: &usize| {
                let others: Vec<usize> = path.chosen.iter().copied().filter(|other| *other != feature).collect();
                Some((feature, self.gain(&self.predict(&others)?, &whole)))
            };
            let gains: Vec<(usize, Gain)> = path.chosen.par_iter().map(without).collect::<Option<_>>()?;
            path.gains.extend(gains.iter().copied());
            let least = gains.into_iter().min_by(|(_, a), (_, b)| a.log.total_cmp(&b.log));
            let Some((feature, _)) = least.filter(|(_, gain)| !gain.is_sure() && path.chosen.len() > 1) else {
                path.chosen.sort_by(|a, b| path.gains[b].log.total_cmp(&path.gains[a].log));
                return Some(path);
            };
            path.chosen.retain(|other| *other != feature);
        }
    }

    fn forward(&self) -> Path {
        let mut path = Path { chosen: vec![], gains: BTreeMap::new(), backward: false };
        let mut before = self.predict(&[]).unwrap_or_default();
        loop {
            let rest: Vec<usize> = (0..self.candidates.features.len()).filter(|k| !path.chosen.contains(k)).collect();
            let tried = rest.par_iter().filter_map(|&feature| {
                let after = self.predict(&[&path.chosen[..], &[feature]].concat())?;
                Some((feature, self.gain(&before, &after), after))
            });
            let tried: Vec<_> = tried.collect();
            // Features that are singular beside the chosen ones no longer have a gain.
            path.gains.retain(|feature, _| path.chosen.contains(feature));
            path.gains.extend(tried.iter().map(|(feature, gain, _)| (*feature, *gain)));
            let best = tried.into_iter().max_by(|(_, a, _), (_, b, _)| a.log.total_cmp(&b.log));
            let Some((feature, _, after)) = best.filter(|(_, gain, _)| gain.is_sure()) else {
                return path;
            };
            path.chosen.push(feature);
            before = after;
        }
    }

    /// Returns the predictions for the rows of each fold by a selection, of features and of the shrinkage, without
    /// these rows.
    pub(super) fn honest(&self, recipe: &Recipe) -> Option<Vec<Prediction>> {
        let one = |fold: usize| -> Option<Vec<(usize, Prediction)>> {
            let (seen, held_out) = self.folds.split(fold);
            let rows = self.candidates.rows(&seen);
            check(&rows).ok()?;
            let inner = Judge::new(&rows, recipe).ok()?;
            let chosen = inner.select().chosen;
            if chosen.is_empty() {
                let guessed = self.predict(&[])?;
                return Some(held_out.into_iter().map(|row| (row, guessed[row].clone())).collect());
            }
            let candidates = self.candidates.select(&chosen);
            let fitted = fit(&candidates.rows(&seen), &inner.recipe).ok()?;
            let predicted = |row: usize| (row, fitted.predict(&candidates, row, self.weights[row]));
            Some(held_out.into_iter().map(predicted).collect())
        };
        let parts: Vec<Option<Vec<_>>> = (0..self.folds.count).into_par_iter().map(one).collect();
        let mut all: Vec<(usize, Prediction)> = parts.into_iter().collect::<Option<Vec<_>>>()?.concat();
        all.sort_by_key(|(row, _)| *row);
        Some(all.into_iter().map(|(_, prediction)| prediction).collect())
    }

    pub(super) fn reason(&self, path: &Path, feature: usize, ranked: &Ranked) -> String {
        let signed = |x: f64| format!("{}{:.3}", if x < 0.0 { "−" } else { "+" }, x.abs());
        let gain = |gain: &Gain| format!("{} ± {:.3}", signed(gain.log), gain.standard_error);
        if ranked.kept {
            let place = path.chosen.iter().position(|k| *k == feature).unwrap_or(0);
            let beside = match (path.backward, place) {
                (true, _) if path.chosen.len() > 1 => "the others kept",
                (_, 0) => "the priors",
                _ => "those above",
            };
            return ranked.beside_chosen.map_or_else(String::new, |g| format!("gains {} over {beside}", gain(&g)));
        }
        let Ok(own) = moments(&self.corrected, &[feature]) else {
            return "has a result in hardly any segment of a class".into();
        };
        if own.pooled[(0, 0)] <= 0.0 {
            return "is the same in all segments of a class".into();
        }
        let correlation = |other: usize| {
            let pair = moments(&self.corrected, &[feature, other]);
            pair.map_or(0.0, |m| m.pooled[(0, 1)] / (m.pooled[(0, 0)] * m.pooled[(1, 1)]).sqrt())
        };
        let mut parts = vec![];
        // For equal class means, N J is approximately χ² with C − 1 degrees of freedom: mean C − 1, sd √(2 (C − 1)).
        let degrees = own.counts.len() as f64 - 1.0;
        let rows: usize = own.counts.iter().sum();
        if ranked.fisher * (rows as f64) < degrees + SURE * (2.0 * degrees).sqrt() {
            parts.push("its class means differ no more than by chance".to_string());
        }
        let alike = path.chosen.iter().map(|&other| (&self.candidates.features[other], correlation(other)));
        let alike = alike.max_by(|(_, a), (_, b)| a.abs().total_cmp(&b.abs()));
        if let Some((name, r)) = alike.filter(|(_, r)| r.abs() >= ALIKE) {
            let sign = if r < 0.0 { "−" } else { "" };
            parts.push(format!("goes with {name} (correlation {sign}{:.2} within classes)", r.abs()));
        }
        parts.push(match &ranked.beside_chosen {
            None => "is a combination of those kept".into(),
            Some(g) if path.chosen.is_empty() => format!("gains nothing sure over the priors: {}", gain(g)),
            Some(g) if g.log < -SURE * g.standard_error => format!("makes it worse: {}", gain(g)),
            Some(g) => format!("adds nothing sure to those kept: {}", gain(g)),
        });
        parts.join("; ")
    }
}

/// Returns the moments of some features alone.
fn moments(candidates: &Candidates, features: &[usize]) -> Result<ClassStatistics, Error> {
    let some = candidates.select(features);
    ClassStatistics::of(&some.table, &some.features)
}

/// Returns (1) and (2); zeros for a feature that hardly any row of a class has.
pub(super) fn fisher(candidates: &Candidates, priors: &[f64], feature: usize) -> (f64, Vec<f64>) {
    let classes = priors.len();
    let Ok(statistics) = moments(candidates, &[feature]) else {
        return (0.0, vec![0.0; classes * (classes - 1) / 2]);
    };
    let means: Vec<f64> = statistics.means.iter().map(|mean| mean[0]).collect();
    let centre: f64 = means.iter().zip(priors).map(|(mean, p)| p * mean).sum();
    let between: f64 = means.iter().zip(priors).map(|(mean, p)| p * (mean - centre).powi(2)).sum();
    let ratio = |between: f64, within: f64| if within > 0.0 { between / within } else { 0.0 };
    let variance = |class: usize| statistics.covariances[class][(0, 0)];
    let pairs = (0..means.len()).flat_map(|i| (i + 1..means.len()).map(move |j| (i, j)));
    let pairs = pairs.map(|(i, j)| ratio((means[i] - means[j]).powi(2), variance(i) + variance(j))).collect();
    (ratio(between, statistics.pooled[(0, 0)]), pairs)
}

/// Gain of a change of features: scores before minus scores after, so that larger is better.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gain {
    /// Gain of the guarded log score, nats.
    pub log: f64,
    /// Its standard error, from the gains of the single groups.
    pub standard_error: f64,
    /// Gain of the error rate.
    pub error: f64,
}

/// One feature.
#[derive(Clone, Debug, PartialEq)]
pub struct Ranked {
    /// Its name.
    pub name: String,
    /// J of (1); 0 without spread.
    pub fisher: f64,
    /// J_ij of (2), for each pair of classes i < j in turn.
    pub pairs: Vec<f64>,
    /// Gain beside all other features; `None` if those or all together are singular.
    pub among_all: Option<Gain>,
    /// Gain when it was chosen, or beside the chosen features if it was not.
    pub beside_chosen: Option<Gain>,
    /// Whether forward selection chose it.
    pub kept: bool,
    /// Why it is kept or would be dropped.
    pub reason: String,
}
