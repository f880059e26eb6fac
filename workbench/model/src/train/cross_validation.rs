//! Cross-validation: the quality of a recipe on rows that were not used in training.
//!
//! ```text
//! fold f:  rows outside f ──► fit (projection, shrinkage, densities) ──► ln P(k|z) of the rows in f
//! ```
//!
//! Every step that uses the classes is repeated in each fold, by the same [`fit`] as the final training, so that no
//! information on a held-out row enters its own posterior.

use rayon::prelude::*;

use super::fit::fit;
use super::folds::{Candidates, Folds, check};
use super::scores::{Prediction, Scores};
use super::{Recipe, Trained};
use crate::Error;

/// Returns the posteriors of every row, in the order of the rows, each from the training without the row's group.
///
/// # Errors
/// A class without rows in the training part of a fold, and the errors of `fit` there.
pub fn predict(candidates: &Candidates, recipe: &Recipe, folds: &Folds) -> Result<Vec<Prediction>, Error> {
    let priors = super::discriminant::priors(&recipe.priors, candidates.table.names.len())?;
    let weights = candidates.weights(&priors);
    let one = |fold: usize| -> Result<Vec<(usize, Prediction)>, Error> {
        let (seen, held_out) = folds.split(fold);
        let seen = candidates.rows(&seen);
        check(&seen)?;
        let fitted = fit(&seen, recipe)?;
        let predicted = |row: usize| (row, fitted.predict(candidates, row, weights[row]));
        Ok(held_out.into_iter().map(predicted).collect())
    };
    // Collects all results first, so that every run reports the error of the first bad fold.
    let parts: Vec<_> = (0..folds.count).into_par_iter().map(one).collect();
    let mut all: Vec<(usize, Prediction)> = Vec::new();
    for part in parts {
        all.extend(part?);
    }
    all.sort_by_key(|(row, _)| *row);
    Ok(all.into_iter().map(|(_, prediction)| prediction).collect())
}

impl Trained {
    /// Returns the scores of the whole recipe by cross-validation on the training segments.
    ///
    /// # Errors
    /// As [`Folds::new`] and [`predict`].
    pub fn cross_validated(&self) -> Result<Scores, Error> {
        let chosen = self.candidates.places(&self.feature_names);
        let candidates = self.candidates.select(&chosen);
        let folds = Folds::new(&candidates, &self.recipe.validation)?;
        let predictions = predict(&candidates, &self.recipe, &folds)?;
        Ok(Scores::by_group(&predictions, &self.densities.priors, &candidates.groups))
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DVector;
    use rand::SeedableRng;
    use rand::seq::SliceRandom;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;
    use crate::identify::Structure;
    use crate::train::{FeatureTable, ProjectionKind, Shrink, Validation};

    /// Returns pure noise in `features` features, with random labels.
    fn noise(rows: usize, features: usize, seed: u64) -> Candidates {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut classes: Vec<usize> = (0..rows).map(|k| k % 3).collect();
        classes.shuffle(&mut rng);
        let row = |_| DVector::from_fn(features, |_, _| StandardNormal.sample(&mut rng));
        let names = ["a", "b", "c"].map(String::from).into();
        let table = FeatureTable::exact((0..rows).map(row).collect(), classes, names);
        Candidates {
            table,
            features: (0..features).map(|k| format!("f{k}")).collect(),
            groups: (0..rows).collect(),
            covariates: None,
        }
    }

    fn recipe(projection: ProjectionKind, shrink: Shrink) -> Recipe {
        let structure = Structure::new(1, 1, 1, 1, 1);
        Recipe { projection, shrink, ..Recipe::new(structure) }
    }

    fn error(candidates: &Candidates, recipe: &Recipe) -> f64 {
        let folds = Folds::new(candidates, &recipe.validation).expect("enough rows");
        Scores::new(&predict(candidates, recipe, &folds).expect("regular"), &[1.0 / 3.0; 3]).error
    }

    #[test]
    fn noise_with_random_labels_is_guessed() {
        let candidates = noise(300, 40, 7);
        // 300 random guesses among three classes: standard deviation √(2/9/300) = 2.7 %; the bracket is ± 3 of them.
        let chance = 0.585..0.749;
        for (projection, shrink) in [
            (ProjectionKind::None, Shrink::Not),
            (ProjectionKind::Fisher { components: None }, Shrink::Not),
            (ProjectionKind::Fisher { components: None }, Shrink::Chosen),
            (ProjectionKind::None, Shrink::Chosen),
        ] {
            let found = error(&candidates, &recipe(projection, shrink));
            assert!(chance.contains(&found), "{projection:?} {shrink:?}: {found}");
        }
        // The bracket detects a leak: here the directions were trained with the labels of the held-out rows.
        let whole = recipe(ProjectionKind::Fisher { components: None }, Shrink::Not);
        let leaked = fit(&candidates, &whole).expect("regular").coordinates;
        let leaked = Candidates { table: leaked, features: vec!["z1".into(), "z2".into()], ..candidates };
        let found = error(&leaked, &recipe(ProjectionKind::None, Shrink::Not));
        assert!(found < chance.start, "{found}");
    }

    #[test]
    fn groups_stay_together_and_classes_are_spread() {
        let mut candidates = noise(60, 1, 3);
        candidates.table.classes = (0..60).map(|k| k / 20).collect();
        // Five rows per group, four groups per class.
        candidates.groups = (0..60).map(|k| k / 5).collect();
        let folds = Folds::new(&candidates, &Validation { folds: 10, ..Validation::default() }).expect("groups");
        assert_eq!(folds.count, 4);
        for group in 0..12 {
            let of = &folds.of_row[5 * group..5 * group + 5];
            assert!(of.iter().all(|fold| *fold == of[0]), "{group}: {of:?}");
        }
        for fold in 0..4 {
            let (seen, held_out) = folds.split(fold);
            assert_eq!((seen.len(), held_out.len()), (45, 15));
            for class in 0..3 {
                assert_eq!(held_out.iter().filter(|&&row| candidates.table.classes[row] == class).count(), 5);
            }
        }
        // Runs that contain every class, as on a test rig: each run is either trained on or held out as a whole.
        candidates.groups = (0..60).map(|k| k % 5).collect();
        let folds = Folds::new(&candidates, &Validation { folds: 3, ..Validation::default() }).expect("groups");
        assert!((0..60).all(|row| folds.of_row[row] == folds.of_row[row % 5]));
        candidates.groups = (0..60).map(|k| k / 20).collect();
        let refused = Folds::new(&candidates, &Validation::default()).expect_err("a group a class").to_string();
        assert!(refused.contains("class a are of one group"), "{refused}");
    }

    #[test]
    fn a_seed_fixes_the_split() {
        let candidates = noise(60, 1, 3);
        let folds = |seed| Folds::new(&candidates, &Validation { seed, ..Validation::default() }).expect("rows");
        assert_eq!(folds(4), folds(4));
        assert_ne!(folds(4), folds(5));
    }

    #[test]
    fn memorising_groups_does_not_help() {
        // The ten rows of a group share a random offset far above their spread, and the class of a group is random: a
        // split by rows recognises the groups, a split by groups can only guess.
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let mut candidates = noise(240, 12, 5);
        let offsets: Vec<DVector<f64>> = (0..24)
            .map(|_| {
                DVector::from_fn(12, |_, _| {
                    let x: f64 = StandardNormal.sample(&mut rng);
                    10.0 * x
                })
            })
            .collect();
        for (k, row) in candidates.table.rows.iter_mut().enumerate() {
            *row += &offsets[k / 10];
        }
        candidates.table.classes = (0..240).map(|k| k / 10 % 3).collect();
        let recipe = recipe(ProjectionKind::None, Shrink::Not);
        let by_rows = error(&candidates, &recipe);
        candidates.groups = (0..240).map(|k| k / 10).collect();
        let by_groups = error(&candidates, &recipe);
        // Random guesses for 24 groups among three classes: standard deviation 9.6 %; the bracket is ± 2.5 of them.
        assert!((0.42..0.91).contains(&by_groups) && by_rows < by_groups - 0.2, "{by_rows} {by_groups}");
    }
}
