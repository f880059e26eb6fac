//! Search for the shrinkage with the least cross-validated score on a grid of λ and γ.

use rayon::prelude::*;
use serde_json::{Value, json};

use super::scores::{Prediction, Scores};
use super::shrinkage::Shrinkage;
use super::{discriminant, projection};
use crate::Error;
use crate::train::distribution::moments::Observed;
use crate::train::rows::covariates;
use crate::train::rows::folds::{Candidates, Folds, check};
use crate::train::{ClassStatistics, FeatureTable, GaussianClasses, Recipe};

/// A point of the grid with its cross-validated scores.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridPoint {
    /// λ and γ.
    pub shrinkage: Shrinkage,
    /// Guarded log score, nats; infinite if a covariance is singular in some fold.
    pub score: f64,
    /// Error rate.
    pub error: f64,
}

/// The choice by cross-validation.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// The shrinkage of the best point.
    pub shrinkage: Shrinkage,
    /// All points of the grid.
    pub grid: Vec<GridPoint>,
    /// Number of folds.
    pub folds: usize,
}

const LAMBDAS: [f64; 8] = [1.0, 0.75, 0.5, 0.25, 0.1, 0.05, 0.01, 0.0];
const GAMMAS: [f64; 8] = [1.0, 0.5, 0.25, 0.1, 0.05, 0.01, 0.001, 0.0];

impl Choice {
    /// Returns JSON with the keys `lambda`, `gamma`, `folds` and `grid`; a score is null if a covariance is singular.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let point = |p: &GridPoint| {
            let score = p.score.is_finite().then_some((p.score, p.error)).unzip();
            json!({ "lambda": p.shrinkage.lambda, "gamma": p.shrinkage.gamma, "guarded_log_score": score.0, "error_rate": score.1 })
        };
        let Shrinkage { lambda, gamma } = self.shrinkage;
        let grid = self.grid.iter().map(point).collect::<Vec<_>>();
        json!({ "lambda": lambda, "gamma": gamma, "folds": self.folds, "grid": grid })
    }
}

/// Returns the point of the grid with the least cross-validated guarded log score; if several are equal, the one with
/// the most shrinkage. The projection is trained anew in every fold.
pub(crate) fn search(candidates: &Candidates, recipe: &Recipe) -> Result<Choice, Error> {
    let folds = Folds::new(candidates, &recipe.validation)?;
    let priors = discriminant::priors(&recipe.priors, candidates.table.names.len())?;
    let weights = candidates.weights(&priors);
    let parts: Vec<_> =
        (0..folds.count).into_par_iter().map(|fold| Part::new(candidates, recipe, &folds, fold)).collect();
    let parts: Vec<Part> = parts.into_iter().collect::<Result<_, _>>()?;
    let points: Vec<Shrinkage> =
        LAMBDAS.iter().flat_map(|&lambda| GAMMAS.iter().map(move |&gamma| Shrinkage { lambda, gamma })).collect();
    let score = |&shrinkage: &Shrinkage| {
        let mut predictions = Vec::new();
        for part in &parts {
            let Ok(densities) = discriminant::shrunk(&part.seen, &part.names, recipe, shrinkage) else {
                return GridPoint { shrinkage, score: f64::INFINITY, error: 1.0 };
            };
            predictions.extend(part.predict(&densities, &weights));
        }
        let scores = Scores::new(&predictions, &priors);
        GridPoint { shrinkage, score: scores.guarded.value, error: scores.error }
    };
    let grid: Vec<GridPoint> = points.par_iter().map(score).collect();
    // Of equal points the first: the grid begins with the most shrinkage.
    let best = grid.iter().min_by(|a, b| a.score.total_cmp(&b.score)).filter(|best| best.score.is_finite());
    let Some(best) = best else {
        let problem = "every shrunk covariance is singular: a feature is the same in every trace; leave it out";
        return Err(Error::Training(problem.into()));
    };
    Ok(Choice { shrinkage: best.shrinkage, folds: folds.count, grid })
}

/// One fold in projected coordinates: everything except the covariances.
struct Part {
    seen: ClassStatistics,
    names: Vec<String>,
    held_out: FeatureTable,
    rows: Vec<usize>,
}

impl Part {
    fn new(candidates: &Candidates, recipe: &Recipe, folds: &Folds, fold: usize) -> Result<Self, Error> {
        let (seen, rows) = folds.split(fold);
        let (seen, held_out) = (candidates.rows(&seen), candidates.rows(&rows));
        check(&seen)?;
        let (seen, held_out) = match covariates::fit(&seen, recipe)? {
            Some(own) => {
                let without = |of: &Candidates| Candidates { table: own.corrected(of), ..of.clone() };
                (without(&seen), without(&held_out))
            }
            None => (seen, held_out),
        };
        let raw = ClassStatistics::of(&seen.table, &seen.features)?;
        let map = projection::of_statistics(&raw, &seen.features, recipe.projection)?;
        let coordinates = seen.table.map(&map);
        let names = (0..map.matrix.nrows()).map(|k| format!("z{}", k + 1)).collect();
        Ok(Self { seen: raw.mapped(&map, &coordinates), names, held_out: held_out.table.map(&map), rows })
    }

    fn predict(&self, densities: &GaussianClasses, weights: &[f64]) -> Vec<Prediction> {
        let rows = self.held_out.observed().into_iter().zip(&self.rows);
        rows.map(|(Observed { value, variance, class: truth }, &row)| {
            let log_posteriors = densities.log_posteriors(value, variance);
            let decided = Some(densities.decide(&log_posteriors));
            Prediction { truth, decided, log_posteriors, weight: weights[row] }
        })
        .collect()
    }
}
