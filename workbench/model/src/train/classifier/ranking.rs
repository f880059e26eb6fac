//! Ranking of the features by their contribution, and the choice of features to drop.
//!
//! ```text
//! Fisher ratio   J = Σ_k P_k (μ_k − μ)² / σ²,   μ = Σ_k P_k μ_k, σ² pooled within classes      (1)
//! of a pair      J_ij = (μ_i − μ_j)² / (σ_i² + σ_j²)                                          (2)
//! gain           cross-validated guarded log score without the feature − with it, same rows   (3)
//! ```
//!
//! (1) and (2) use one feature alone, in the rows that have it. (3) is computed beside other features: by removing the
//! feature from all ("drop one"), and by adding it to those already chosen (forward selection, which stops if the best
//! gain is below twice its standard error). If no feature alone is of use but all together are, features are removed
//! instead, one by one, while the loss is below twice its standard error. The features are not projected. The score of
//! the chosen set on the rows of the choice is too optimistic; the selection is therefore repeated within every fold,
//! which measures its real quality.

mod judge;

pub use judge::{Gain, Ranked};
use judge::{Judge, fisher};
use rayon::prelude::*;
use serde_json::{Value, json};

use super::scores::{Prediction, Scores};
use crate::Error;
use crate::train::rows::folds::Candidates;
use crate::train::{ProjectionKind, Recipe, Trained};

/// The features, in order from the first to keep to the first to drop.
#[derive(Clone, Debug, PartialEq)]
pub struct Ranking {
    /// Class names.
    pub classes: Vec<String>,
    /// The chosen features in the order of choice, then the others by Fisher ratio.
    pub features: Vec<Ranked>,
    /// Scores of all features together; `None` if their covariance is singular.
    pub all: Option<Scores>,
    /// Scores of the kept features, on the rows on which they were chosen.
    pub kept: Option<Scores>,
    /// Scores of the selection repeated without each fold.
    pub honest: Option<Scores>,
    /// Number of folds.
    pub folds: usize,
    /// Gain of all features together over the priors; `None` if their covariance is singular.
    pub gain_of_all: Option<Gain>,
    /// Number of groups (runs, traces) over which gains are judged.
    pub groups: usize,
}

impl Ranking {
    /// Returns the names of the kept features, best first.
    #[must_use]
    pub fn names(&self) -> Vec<&str> {
        self.features.iter().filter(|f| f.kept).map(|f| f.name.as_str()).collect()
    }

    /// Returns JSON with the keys `folds`, `keep`, `drop`, `scores` and `features`.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let gain = |gain: &Gain| json!({ "guarded_log_score": gain.log, "standard_error": gain.standard_error, "error_rate": gain.error });
        let pairs = (0..self.classes.len()).flat_map(|i| (i + 1..self.classes.len()).map(move |j| (i, j)));
        let pairs: Vec<String> = pairs.map(|(i, j)| format!("{}:{}", self.classes[i], self.classes[j])).collect();
        let feature = |f: &Ranked| {
            let of_pairs = pairs.iter().cloned().zip(f.pairs.iter().map(|&ratio| Value::from(ratio)));
            json!({
                "name": f.name,
                "fisher_ratio": f.fisher,
                "fisher_ratio_of_pairs": of_pairs.collect::<serde_json::Map<_, _>>(),
                "gain_among_all": f.among_all.as_ref().map(gain),
                "gain_beside_chosen": f.beside_chosen.as_ref().map(gain),
                "keep": f.kept,
                "reason": f.reason,
            })
        };
        json!({
            "folds": self.folds,
            "keep": self.names(),
            "drop": self.features.iter().filter(|f| !f.kept).map(|f| f.name.as_str()).collect::<Vec<_>>(),
            "scores": {
                "all": self.all.as_ref().map(Scores::to_json),
                "kept": self.kept.as_ref().map(Scores::to_json),
                "chosen_in_each_fold": self.honest.as_ref().map(Scores::to_json),
            },
            "features": self.features.iter().map(feature).collect::<Vec<_>>(),
        })
    }

    /// Describes the kept features and the score of each set of features in words.
    #[must_use]
    pub fn summary(&self) -> String {
        let score = |of: &Option<Scores>| {
            let text = of
                .as_ref()
                .map(|s| format!("guarded log score {:.3}, error {:.1} %", s.guarded.value, 100.0 * s.error));
            text.unwrap_or_else(|| "singular".into())
        };
        let dropped = self.features.iter().filter(|f| !f.kept).count();
        let names = self.names();
        let what = match (names.len(), dropped) {
            (0, _) => match self.gain_of_all.filter(|gain| gain.log > gain.standard_error) {
                Some(Gain { log, standard_error, .. }) => format!(
                    "Too few groups: over {} of them, all features together gain {log:.3} ± {standard_error:.3} over the \
                     priors, and no single one surely gains; give more traces or runs.",
                    self.groups
                ),
                None => "No feature tells these classes apart better than the priors do.".to_string(),
            },
            (_, 0) => "Every feature earns its place.".to_string(),
            (_, dropped) => format!("Keep {}; drop the other {dropped}.", names.join(", ")),
        };
        format!(
            "{what} Cross-validated in {} folds: all features {}; those kept {}; the choice made anew in every fold {}. \
             Worth is for these classes, sizes and conditions: a fault too easy for all features to be needed makes \
             most of them droppable.",
            self.folds,
            score(&self.all),
            score(&self.kept),
            score(&self.honest)
        )
    }
}

impl std::fmt::Display for Ranking {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let width = self.features.iter().map(|feature| feature.name.len()).max().unwrap_or(0).max("feature".len());
        writeln!(f, "{:width$}  Fisher ratio  gain among all", "feature")?;
        for Ranked { name, fisher, among_all, kept, reason, .. } in &self.features {
            let among = |g: Gain| format!("{:.3} ± {:.3}", g.log, g.standard_error).replace('-', "−");
            let among = among_all.map_or_else(|| "–".into(), among);
            let advice = if *kept { "keep" } else { "drop" };
            writeln!(f, "{name:width$}  {fisher:>12.3}  {among:>15}  {advice}: {reason}")?;
        }
        write!(f, "{}", self.summary())
    }
}

/// Ranks the candidates for the recipe's discriminant, priors and costs; if the recipe chooses the shrinkage, it is
/// chosen once for all of them.
///
/// # Errors
/// Too few groups for folds, and priors or costs that do not match the classes.
pub fn rank(candidates: &Candidates, recipe: &Recipe) -> Result<Ranking, Error> {
    let recipe = Recipe { projection: ProjectionKind::None, ..recipe.clone() };
    let judge = Judge::new(candidates, &recipe)?;
    let everything: Vec<usize> = (0..candidates.features.len()).collect();
    let all = judge.predict(&everything);
    let path = judge.select();
    let among_all = |&feature: &usize| {
        let others: Vec<usize> = everything.iter().copied().filter(|k| *k != feature).collect();
        Some(judge.gain(&judge.predict(&others)?, all.as_ref()?))
    };
    let among_all: Vec<Option<Gain>> = everything.par_iter().map(among_all).collect();
    let honest = judge.honest(&recipe);
    let scores = |predictions: &Vec<Prediction>| Scores::new(predictions, &judge.priors);
    let ratios: Vec<_> =
        everything.par_iter().map(|&feature| fisher(&judge.corrected, &judge.priors, feature)).collect();
    let ranked = |&feature: &usize| {
        let (fisher, pairs) = ratios[feature].clone();
        let kept = path.chosen.contains(&feature);
        let beside_chosen = path.gains.get(&feature).copied();
        let ranked = Ranked {
            name: candidates.features[feature].clone(),
            fisher,
            pairs,
            among_all: among_all[feature],
            beside_chosen,
            kept,
            reason: String::new(),
        };
        let reason = judge.reason(&path, feature, &ranked);
        Ranked { reason, ..ranked }
    };
    let mut rest: Vec<usize> = everything.iter().copied().filter(|k| !path.chosen.contains(k)).collect();
    rest.sort_by(|&a, &b| ratios[b].0.total_cmp(&ratios[a].0));
    Ok(Ranking {
        classes: candidates.table.names.clone(),
        features: path.chosen.iter().chain(&rest).map(ranked).collect(),
        all: all.as_ref().map(scores),
        kept: judge.predict(&path.chosen).as_ref().map(scores),
        honest: honest.as_ref().map(scores),
        folds: judge.folds.count,
        gain_of_all: judge.gain_of_all(),
        groups: candidates.groups.iter().collect::<std::collections::HashSet<_>>().len(),
    })
}

impl Trained {
    /// Ranks the requested features, or all features if none were requested.
    ///
    /// # Errors
    /// As [`rank`].
    pub fn rank(&self) -> Result<Ranking, Error> {
        if self.recipe.features.is_empty() {
            return rank(&self.candidates, &self.recipe);
        }
        rank(&self.candidates.select(&self.candidates.places(&self.feature_names)), &self.recipe)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DVector;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;
    use crate::identify::Structure;
    use crate::train::FeatureTable;

    /// Returns three classes. The mean of `shift` is 2 in the second class, that of `other` is 3 in the third; `copy`
    /// is `shift` with a little noise, `noise` is independent of the class, and `mate` has equal class means but shares
    /// the noise of `shift`.
    fn candidates(rows: usize) -> Candidates {
        let mut rng = ChaCha8Rng::seed_from_u64(23);
        let mut draw = || -> f64 { StandardNormal.sample(&mut rng) };
        let classes: Vec<usize> = (0..rows).map(|k| k % 3).collect();
        let row = |class: &usize| {
            let common = draw();
            let shift = if *class == 1 { 2.0 } else { 0.0 } + 0.9 * common + 0.44 * draw();
            let other = if *class == 2 { 3.0 } else { 0.0 } + draw();
            DVector::from_vec(vec![draw(), shift + 0.3 * draw(), shift, common, other])
        };
        let names = ["a", "b", "c"].map(String::from).into();
        let table = FeatureTable::exact(classes.iter().map(row).collect(), classes, names);
        let features = ["noise", "copy", "shift", "mate", "other"].map(String::from).into();
        Candidates { table, features, groups: (0..rows).collect(), covariates: None }
    }

    fn recipe() -> Recipe {
        Recipe::new(Structure::new(1, 1, 1, 1, 1))
    }

    #[test]
    fn what_helps_is_kept_and_the_rest_is_dropped_with_its_reason() {
        let ranking = rank(&candidates(240), &recipe()).expect("regular");
        let mut kept = ranking.names();
        kept.sort_unstable();
        assert_eq!(kept, ["mate", "other", "shift"], "{ranking:#?}");
        let of = |name: &str| ranking.features.iter().find(|f| f.name == name).expect("ranked");
        assert!(of("noise").reason.contains("no more than by chance") && of("noise").reason.contains("adds nothing"));
        assert!(of("copy").reason.contains("goes with shift"), "{}", of("copy").reason);
        // J = 2/9 · 2² = 0.89 and 2/9 · 3² = 2 over a variance of 1.0; of the pairs 2 and 4.5, others 0.
        for (name, whole, pairs) in [("shift", 8.0 / 9.0, [2.0, 0.0, 2.0]), ("other", 2.0, [0.0, 4.5, 4.5])] {
            let found = of(name);
            // 80 rows per class: standard deviation 0.11 of a mean and 16 % of a variance; ± 50 % is three of these
            // together.
            assert!((0.6 * whole..1.5 * whole).contains(&found.fisher), "{found:?}");
            for (found, expected) in found.pairs.iter().zip(pairs) {
                assert!((0.6 * expected..1.5 * expected + 0.1).contains(found), "{found} {expected}");
            }
        }
        // Alone, "mate" does not distinguish the classes; beside "shift" it contributes much, which a Fisher ratio
        // cannot show.
        assert!(of("mate").fisher < 0.1 && of("mate").among_all.expect("regular").log > 0.1);
        assert!(of("noise").among_all.expect("regular").log < 0.02);
        let (all, honest) = (ranking.all.expect("regular"), ranking.honest.expect("regular"));
        // Two noise features cost little at 240 rows, and so does the selection.
        assert!((honest.guarded.value - all.guarded.value).abs() < 0.05, "{honest:?} {all:?}");
    }

    #[test]
    fn of_noise_nothing_is_kept() {
        let mut candidates = candidates(90);
        candidates.table.classes.rotate_left(1);
        let mut rng = ChaCha8Rng::seed_from_u64(29);
        for row in &mut candidates.table.rows {
            *row = DVector::from_fn(5, |_, _| StandardNormal.sample(&mut rng));
        }
        let ranking = rank(&candidates, &recipe()).expect("regular");
        assert!(ranking.names().is_empty() && ranking.summary().starts_with("No feature"), "{ranking:#?}");
        let honest = ranking.honest.expect("guesses");
        // 90 random guesses among three classes: standard deviation 5 %. A fold in which noise was chosen is no better.
        assert!((0.52..0.82).contains(&honest.error) && honest.guarded.value > 1.05, "{honest:?}");
    }

    #[test]
    fn constants_and_combinations_are_named() {
        let mut candidates = candidates(120);
        for row in &mut candidates.table.rows {
            row[0] = 4.0;
            row[1] = 2.0 * row[2] + 1.0;
        }
        let ranking = rank(&candidates, &recipe()).expect("regular");
        let of = |name: &str| ranking.features.iter().find(|f| f.name == name).expect("ranked");
        assert_eq!(of("noise").reason, "is the same in all segments of a class");
        let (first, second) = if of("shift").kept { ("copy", "shift") } else { ("shift", "copy") };
        assert!(of(first).reason.contains("is a combination of those kept"), "{}", of(first).reason);
        assert!(of(second).kept && ranking.all.is_none() && of("other").among_all.is_none());
    }

    /// Two features of which only the sum tells the classes apart: the large common part hides it from each alone.
    #[test]
    fn features_that_only_help_together_are_kept() {
        let mut rng = ChaCha8Rng::seed_from_u64(31);
        let mut draw = || -> f64 { StandardNormal.sample(&mut rng) };
        let classes: Vec<usize> = (0..60).map(|k| k % 2).collect();
        let row = |class: &usize| {
            let (common, shift) = (10.0 * draw(), *class as f64);
            DVector::from_vec(vec![common, shift - common + 0.1 * draw(), draw()])
        };
        let table =
            FeatureTable::exact(classes.iter().map(row).collect(), classes, ["a", "b"].map(String::from).into());
        let features = ["one", "other", "noise"].map(String::from).into();
        let candidates = Candidates { table, features, groups: (0..60).collect(), covariates: None };
        let ranking = rank(&candidates, &recipe()).expect("regular");
        let mut kept = ranking.names();
        kept.sort_unstable();
        assert_eq!(kept, ["one", "other"], "{ranking:#?}");
        assert!(ranking.features[0].reason.contains("over the others kept"), "{ranking:#?}");
        assert!(ranking.kept.expect("regular").error < 0.05 && ranking.honest.expect("regular").error < 0.1);
    }
}
