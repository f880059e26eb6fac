//! Cross-validation: the quality of a recipe on rows that were not used in training.
//!
//! ```text
//! fold f:  rows outside f ──► fit (projection, shrinkage, densities) ──► ln P(k|z) of the rows in f
//! ```
//!
//! Every step that uses the classes is repeated in each fold, by the same [`fit`] as the final training, so that no
//! information on a held-out row enters its own posterior.
//!
//! And the false alarms of gates that have not seen what they judge: of folds, and forward in time.
//!
//! ```text
//! runs 1 … s ──► fit, gate for the next run ──► healthy segments of the runs s + 1 … k,   s = 2 … k − 1
//! rows outside a fold ──► fit, gate ──► healthy segments of the fold
//! ```
//!
//! Cross-validation judges each run by runs before and after it, and does not show what a drift does to a gate.

use rayon::prelude::*;
use serde_json::{Value, json};

use super::fit::fit;
use super::scores::{Prediction, Scores};
use crate::Error;
use crate::evaluate::FalseAlarms;
use crate::train::novelty::{self, Rows};
use crate::train::rows::folds::{Candidates, Folds, check};
use crate::train::{Explained, Recipe, Trained};

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

/// Fewest healthy runs for a validation forward in time.
const LEAST_RUNS: usize = 4;
/// Most rows of the printed table.
const MOST_ROWS: usize = 12;

/// The run of a segment, and whether a gate calls the segment novel.
type Judged = (String, bool);

/// The gate of the first runs, judged on all later ones.
#[derive(Debug)]
pub struct Forward {
    /// Number of runs in training.
    pub seen: usize,
    /// False alarms of the later runs, or why there is no gate.
    pub later: Result<FalseAlarms, Error>,
}

impl Trained {
    /// Returns the gates of the first 2, 3, … healthy runs, judged on the later runs; none if the false-alarm rate is
    /// not that of the next run, or with fewer than four runs.
    #[must_use]
    pub fn forward(&self) -> Vec<Forward> {
        let Some(healthy) = self.recipe.alarms.healthy.filter(|_| self.recipe.runs(&self.candidates).is_some()) else {
            return vec![];
        };
        let rows = self.candidates.groups.iter().zip(&self.candidates.table.classes);
        let mut runs: Vec<usize> = rows.filter(|(_, class)| **class == healthy).map(|(run, _)| *run).collect();
        runs.sort_unstable();
        runs.dedup();
        if runs.len() < LEAST_RUNS {
            return vec![];
        }
        (2..runs.len()).into_par_iter().map(|seen| Forward { seen, later: self.later(healthy, runs[seen]) }).collect()
    }

    /// Returns the false alarms from the run `first` on of a gate of the runs before it.
    fn later(&self, healthy: usize, first: usize) -> Result<FalseAlarms, Error> {
        let candidates = self.candidates.select(&self.candidates.places(&self.feature_names));
        let (before, after): (Vec<usize>, Vec<usize>) =
            (0..candidates.groups.len()).partition(|&row| candidates.groups[row] < first);
        let mut alarms = FalseAlarms::default();
        let judged = self.judge((&candidates, healthy), (&before, &after))?;
        judged.iter().for_each(|(run, is_novel)| alarms.add(run, *is_novel));
        Ok(alarms)
    }

    /// Returns the false alarms of healthy segments, each by a gate without its fold; `None` without a gate.
    #[must_use]
    pub fn false_alarms(&self) -> Option<Result<FalseAlarms, Error>> {
        let healthy = self.watch.gate.as_ref()?.class;
        let candidates = self.candidates.select(&self.candidates.places(&self.feature_names));
        let all = || {
            let folds = Folds::new(&candidates, &self.recipe.validation)?;
            let judge = |fold: usize| {
                let (seen, held_out) = folds.split(fold);
                self.judge((&candidates, healthy), (&seen, &held_out))
            };
            // As a list first: the first fold without a gate is told, whichever thread is first.
            let judged: Vec<Result<Vec<Judged>, Error>> = (0..folds.count).into_par_iter().map(judge).collect();
            let mut alarms = FalseAlarms::default();
            for fold in judged {
                fold?.iter().for_each(|(run, is_novel)| alarms.add(run, *is_novel));
            }
            Ok(alarms)
        };
        Some(all())
    }

    /// Judges the healthy rows of `after` by a gate of the rows `before`.
    fn judge(
        &self,
        (candidates, healthy): (&Candidates, usize),
        (before, after): (&[usize], &[usize]),
    ) -> Result<Vec<Judged>, Error> {
        let before = candidates.rows(before);
        check(&before)?;
        let fitted = fit(&before, &self.recipe)?;
        let fitted_terms = fitted.explained.as_ref().map_or(0, Explained::fitted);
        let rising = self.recipe.rising(&fitted.coordinate_names);
        let (table, names) = (&fitted.coordinates, fitted.coordinate_names.as_slice());
        let rows = Rows { table, names, fitted: fitted_terms, rising };
        let gate = novelty::required_gate(rows, self.recipe.runs(&before).as_deref(), &self.recipe.alarms)?;
        let judge = |row: usize| {
            let (z, variances) = fitted.coordinates_of(candidates, row);
            let group = candidates.groups[row];
            let run = self.recipe.validation.groups.get(group).cloned().unwrap_or_else(|| group.to_string());
            (run, gate.is_novel(&z, &variances))
        };
        let healthy_rows = after.iter().copied().filter(|&row| candidates.table.classes[row] == healthy);
        Ok(healthy_rows.map(judge).collect())
    }
}

impl Forward {
    /// JSON object with the keys `runs_in_training` and either `false_alarms` or `refused`.
    #[must_use]
    pub fn to_json(&self) -> Value {
        match &self.later {
            Ok(found) => json!({ "runs_in_training": self.seen, "false_alarms": found.to_json() }),
            Err(reason) => json!({ "runs_in_training": self.seen, "refused": reason.to_string() }),
        }
    }
}

impl Forward {
    /// A table with a row for a number of runs, or for all numbers in a row that have the same refusal; of many numbers
    /// every n-th.
    #[must_use]
    pub fn lines(all: &[Self]) -> Vec<String> {
        let refusal = |one: &Self| one.later.as_ref().err().map(ToString::to_string);
        let same = |a: &Self, b: &Self| refusal(a).is_some() && refusal(a) == refusal(b);
        let alike: Vec<&[Self]> = all.chunk_by(same).collect();
        let step = alike.len().div_ceil(MOST_ROWS).max(1);
        let every =
            if step > 1 { format!(" (every {step}-th row of {}; --json has all)", alike.len()) } else { String::new() };
        let title = format!("forward in time, gates of the first runs on later ones{every}:");
        let shown = alike.iter().enumerate().filter(|(k, _)| k % step == 0 || k + 1 == alike.len());
        let rows =
            shown.filter_map(|(_, own)| Some((own.first()?, own.last()?))).map(|(one, last)| one.line(last.seen));
        (!all.is_empty()).then_some(title).into_iter().chain(rows).collect()
    }

    fn line(&self, until: usize) -> String {
        let runs = if until > self.seen { format!("{} to {until}", self.seen) } else { self.seen.to_string() };
        let found = match &self.later {
            Ok(found) => found.summary(),
            Err(reason) => format!("no gate, {reason}"),
        };
        format!("  {runs:>10} runs  {found}")
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DVector;
    use rand::SeedableRng;
    use rand::seq::SliceRandom;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use crate::identify::Structure;
    use crate::train::{FeatureTable, ProjectionKind, Shrink, Validation};

    use super::*;

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

    #[test]
    fn a_refusal_of_several_numbers_of_runs_is_told_once() {
        let refused = |reason: &str| Err(Error::Training(reason.into()));
        let later = [
            refused("no spall"),
            refused("no spall"),
            refused("few runs"),
            Ok(FalseAlarms::default()),
            refused("no spall"),
        ];
        let all: Vec<Forward> = (2..).zip(later).map(|(seen, later)| Forward { seen, later }).collect();
        let lines = Forward::lines(&all);
        let starts = [
            "2 to 3 runs  no gate, no spall",
            "4 runs  no gate, few runs",
            "5 runs  0 of 0",
            "6 runs  no gate, no spall",
        ];
        assert_eq!(lines.len(), starts.len() + 1);
        for (line, start) in lines[1..].iter().zip(starts) {
            assert!(line.trim_start().starts_with(start), "{line}");
        }
    }

    #[test]
    fn many_numbers_of_runs_are_a_short_table() {
        let all: Vec<Forward> = (2..334).map(|seen| Forward { seen, later: Ok(FalseAlarms::default()) }).collect();
        let lines = Forward::lines(&all);
        assert!(lines.len() <= MOST_ROWS + 2 && lines[0].contains("every 28-th row of 332"), "{lines:?}");
        assert!(lines[1].contains(" 2 runs") && lines[lines.len() - 1].contains(" 333 runs"), "{lines:?}");
        assert_eq!(Forward::lines(&[]), Vec::<String>::new());
    }
}
