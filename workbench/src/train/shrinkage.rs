//! Covariances between those of a quadratic and of a linear discriminant (Friedman 1989, Regularized Discriminant
//! Analysis), chosen by cross-validation.
//!
//! ```text
//! S_k(λ) = ((1 − λ) ν_k S_k + λ ν S) / ((1 − λ) ν_k + λ ν),   ν_k = N_k − 1, ν = N − C        (1)
//! Σ_k(λ, γ) = (1 − γ) S_k(λ) + γ diag S_k(λ)                                                 (2)
//! ```
//!
//! S_k is the own, S the pooled covariance: λ = 0 is quadratic, λ = 1 linear, γ = 1 takes the coordinates as
//! independent. Friedman's (2) goes towards tr(S_k(λ))/d · I, which depends on the units of the features; their
//! diagonal does not.

use nalgebra::DMatrix;
use rayon::prelude::*;
use serde_json::{Value, json};

use super::cross_validation::{Candidates, Folds, check};
use super::scores::{Prediction, Scores};
use super::{ClassStatistics, GaussianClasses, Recipe, discriminant, projection};
use crate::Error;

/// λ and γ of (1) and (2), each from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shrinkage {
    /// λ: from the classes' own covariances to the pooled one.
    pub lambda: f64,
    /// γ: from there to its diagonal.
    pub gamma: f64,
}

/// Whether covariances are shrunk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shrink {
    /// Linear or quadratic, as the recipe says.
    Not,
    /// By these numbers.
    To(Shrinkage),
    /// By the numbers of the best cross-validated guarded log score.
    Chosen,
}

/// A point of the grid with its cross-validated scores.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridPoint {
    /// λ and γ.
    pub shrinkage: Shrinkage,
    /// Guarded log score, nats; infinite where a covariance is singular in some fold.
    pub score: f64,
    /// Error rate.
    pub error: f64,
}

/// What cross-validation chose.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// The best point's.
    pub shrinkage: Shrinkage,
    /// Every point.
    pub grid: Vec<GridPoint>,
    /// Folds.
    pub folds: usize,
}

const LAMBDAS: [f64; 8] = [1.0, 0.75, 0.5, 0.25, 0.1, 0.05, 0.01, 0.0];
const GAMMAS: [f64; 8] = [1.0, 0.5, 0.25, 0.1, 0.05, 0.01, 0.001, 0.0];

impl Shrinkage {
    /// Whether all classes have one covariance.
    #[must_use]
    pub fn is_shared(self) -> bool {
        self.lambda >= 1.0
    }

    /// Σ_k(λ, γ) of every class, or of all where it is shared.
    #[must_use]
    pub fn covariances(self, statistics: &ClassStatistics) -> Vec<DMatrix<f64>> {
        let towards_diagonal = |mut covariance: DMatrix<f64>| {
            let diagonal = covariance.diagonal();
            covariance *= 1.0 - self.gamma; // (2)
            covariance.set_diagonal(&diagonal);
            covariance
        };
        if self.is_shared() {
            return vec![towards_diagonal(statistics.pooled.clone())];
        }
        let freedom = |rows: usize, means: usize| rows.saturating_sub(means) as f64;
        let rows = statistics.counts.iter().sum();
        let pooled = self.lambda * freedom(rows, statistics.counts.len());
        let each = statistics.covariances.iter().zip(&statistics.counts);
        each.map(|(own, &rows)| {
            let weight = (1.0 - self.lambda) * freedom(rows, 1);
            towards_diagonal((own * weight + &statistics.pooled * pooled) / (weight + pooled)) // (1)
        })
        .collect()
    }
}

impl Choice {
    /// Keys `lambda`, `gamma`, `folds` and `grid`; a score is null where a covariance is singular.
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

/// The point of the grid of least cross-validated guarded log score; of equals the most shrunk. The projection is learnt anew in
/// every fold.
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
    // The first of equals; the grid begins with the most shrunk.
    let best = grid.iter().min_by(|a, b| a.score.total_cmp(&b.score)).filter(|best| best.score.is_finite());
    let Some(best) = best else {
        let problem = "every shrunk covariance is singular: a feature is the same in every trace; leave it out";
        return Err(Error::Training(problem.into()));
    };
    Ok(Choice { shrinkage: best.shrinkage, folds: folds.count, grid })
}

/// One fold in coordinates: all of it but the covariances.
struct Part {
    seen: ClassStatistics,
    names: Vec<String>,
    held_out: super::FeatureTable,
    rows: Vec<usize>,
}

impl Part {
    fn new(candidates: &Candidates, recipe: &Recipe, folds: &Folds, fold: usize) -> Result<Self, Error> {
        let (seen, rows) = folds.split(fold);
        let (seen, held_out) = (candidates.rows(&seen), candidates.rows(&rows));
        check(&seen)?;
        let map = projection::train(&seen.table, &seen.features, recipe.projection)?;
        let names = (0..map.matrix.nrows()).map(|k| format!("z{}", k + 1)).collect();
        Ok(Self { seen: ClassStatistics::new(&seen.table.map(&map)), names, held_out: held_out.table.map(&map), rows })
    }

    fn predict(&self, densities: &GaussianClasses, weights: &[f64]) -> Vec<Prediction> {
        let rows = self.held_out.rows.iter().zip(&self.held_out.classes).zip(&self.rows);
        rows.map(|((z, &truth), &row)| {
            let log_posteriors = densities.log_posteriors(z);
            let decided = Some(densities.decide(&log_posteriors));
            Prediction { truth, decided, log_posteriors, weight: weights[row] }
        })
        .collect()
    }
}

#[cfg(test)]
mod tests {
    use bearing_watch::decide::Kind;
    use nalgebra::DVector;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;
    use crate::identify::{Order, Structure};
    use crate::train::fit::fit;
    use crate::train::{FeatureTable, Shrink};

    fn recipe(shrink: Shrink) -> Recipe {
        let structure = Structure { order: Order::new(1, 1, 1, 1, 1), offset: false };
        Recipe { shrink, ..Recipe::new(structure) }
    }

    /// Two classes of normal rows: the second at `shift` in the first feature and its deviations `spread` times those
    /// of the first; `correlation` within both.
    fn two(rows: usize, features: usize, (shift, spread, correlation): (f64, f64, f64)) -> Candidates {
        let mut rng = ChaCha8Rng::seed_from_u64(17);
        let row = |k: usize| {
            let (class, common): (_, f64) = (k % 2, StandardNormal.sample(&mut rng));
            let scale = if class == 1 { spread } else { 1.0 };
            DVector::from_fn(features, |i, _| {
                let own: f64 = StandardNormal.sample(&mut rng);
                let x = correlation.sqrt() * common + (1.0 - correlation).sqrt() * own;
                scale * x + if class == 1 && i == 0 { shift } else { 0.0 }
            })
        };
        let rows: Vec<DVector<f64>> = (0..rows).map(row).collect();
        let classes = (0..rows.len()).map(|k| k % 2).collect();
        let groups = (0..rows.len()).collect();
        let table = FeatureTable { rows, classes, names: vec!["a".into(), "b".into()] };
        Candidates { table, features: (0..features).map(|k| format!("f{k}")).collect(), groups }
    }

    #[test]
    fn the_ends_are_quadratic_and_linear() {
        let candidates = two(60, 4, (1.0, 2.0, 0.3));
        for (lambda, kind) in [(0.0, Kind::Quadratic), (1.0, Kind::Linear)] {
            let shrunk = fit(&candidates, &recipe(Shrink::To(Shrinkage { lambda, gamma: 0.0 }))).expect("regular");
            let plain = fit(&candidates, &Recipe { discriminant: kind, ..recipe(Shrink::Not) }).expect("regular");
            assert_eq!(shrunk.densities.kind, kind);
            for (a, b) in shrunk.densities.whitening.iter().zip(&plain.densities.whitening) {
                assert!((a - b).amax() < 1e-12, "{a} {b}"); // the divisors cancel but for rounding
            }
        }
    }

    #[test]
    fn the_choice_follows_the_data() {
        let chosen = |rows, features, truth| {
            let choice = search(&two(rows, features, truth), &recipe(Shrink::Chosen)).expect("enough rows");
            let at = |lambda: f64, gamma: f64| {
                let point =
                    choice.grid.iter().find(|p| p.shrinkage == Shrinkage { lambda, gamma }).expect("in the grid");
                point.score
            };
            let [linear, quadratic] = [at(1.0, 0.0), at(0.0, 0.0)];
            let best = choice.grid.iter().map(|p| p.score).fold(f64::INFINITY, f64::min);
            (choice.shrinkage, best, linear, quadratic)
        };
        // Few rows of one common covariance: near the shared end; the classes' own are poor.
        let (shrinkage, best, linear, quadratic) = chosen(30, 6, (1.5, 1.0, 0.5));
        assert!(
            shrinkage.lambda >= 0.5 && best <= linear && quadratic > linear + 0.05,
            "{shrinkage:?} {linear} {quadratic}"
        );
        // Many rows that differ in spread only: near the own end; one covariance knows nothing.
        let (shrinkage, best, linear, quadratic) = chosen(400, 4, (0.0, 3.0, 0.5));
        assert!(shrinkage.lambda <= 0.25 && best <= quadratic && linear > 0.65, "{shrinkage:?} {linear} {quadratic}");
        // Fewer rows of a class than features, which are independent: only a diagonal can be estimated.
        let (shrinkage, best, linear, quadratic) = chosen(24, 14, (2.5, 1.0, 0.0));
        assert!(shrinkage.gamma >= 0.25 && best < linear && quadratic.is_infinite(), "{shrinkage:?} {best} {linear}");
    }
}
