//! Training rows, and their split into folds: rows of one group (segments of a trace, strokes of a run), or of
//! one unit (drive) with several groups, are in the same fold.

use std::collections::BTreeMap;

use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use crate::Error;
use crate::train::FeatureTable;

/// Settings of the split into folds.
#[derive(Clone, Debug, PartialEq)]
pub struct Validation {
    /// Number of folds; fewer if a class comes from fewer groups.
    pub folds: usize,
    /// Seed of the split.
    pub seed: u64,
    /// Group (run) of each training trace; if empty, each trace is a group of its own.
    pub groups: Vec<String>,
    /// Unit (drive) of each training trace, which contains whole groups and stays in one fold; if empty, groups do.
    pub units: Vec<String>,
    /// Columns of the labels that may tell runs, each with the cell of every trace, if no groups are given: healthy
    /// traces are then tested for dependence. `None` takes them for independent.
    pub columns: Option<Vec<(String, Vec<String>)>>,
    /// Whether healthy traces of another population are looked for, unless they have runs.
    pub doubted: bool,
}

impl Default for Validation {
    fn default() -> Self {
        Self { folds: 10, seed: 1, groups: vec![], units: vec![], columns: None, doubted: false }
    }
}

impl Validation {
    /// The number of what must not be split: the first trace of the group's unit, or the group without units.
    pub(crate) fn whole(&self, group: usize) -> usize {
        let unit = self.units.get(group);
        unit.and_then(|unit| self.units.iter().position(|other| other == unit)).unwrap_or(group)
    }
}

/// Training rows: features with their names, classes and groups.
#[derive(Clone, Debug)]
pub struct Candidates {
    /// One row per segment, with its class.
    pub table: FeatureTable,
    /// Names of the features.
    pub features: Vec<String>,
    /// Group of each row.
    pub groups: Vec<usize>,
    /// The covariates of each row, in the order of the recipe; `None` without covariates.
    pub covariates: Option<FeatureTable>,
}

impl Candidates {
    /// Returns the given rows only.
    #[must_use]
    pub fn rows(&self, places: &[usize]) -> Self {
        let table = self.table.keep(places);
        let groups = places.iter().map(|&k| self.groups[k]).collect();
        let covariates = self.covariates.as_ref().map(|table| table.keep(places));
        Self { table, features: self.features.clone(), groups, covariates }
    }

    /// Returns the given features only.
    #[must_use]
    pub fn select(&self, places: &[usize]) -> Self {
        let features = places.iter().map(|&k| self.features[k].clone()).collect();
        let covariates = self.covariates.clone();
        Self { table: self.table.select(places), features, groups: self.groups.clone(), covariates }
    }

    /// Returns the indices of features by name.
    pub(crate) fn places(&self, names: &[String]) -> Vec<usize> {
        names.iter().filter_map(|name| self.features.iter().position(|feature| feature == name)).collect()
    }

    /// Returns the weight of each row, of mean 1: the total weight of a class is proportional to its prior, for any
    /// number of rows.
    pub(crate) fn weights(&self, priors: &[f64]) -> Vec<f64> {
        let classes = &self.table.classes;
        let count = |class: usize| classes.iter().filter(|&&c| c == class).count() as f64;
        let each: Vec<f64> = priors.iter().enumerate().map(|(k, p)| p * classes.len() as f64 / count(k)).collect();
        classes.iter().map(|&class| each[class]).collect()
    }
}

/// The fold of each row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Folds {
    /// The fold in which each row is held out.
    pub of_row: Vec<usize>,
    /// Number of folds.
    pub count: usize,
}

impl Folds {
    /// Splits the rows, stratified and in an order fixed by the seed: groups in random order, the large ones first,
    /// each into the fold that has the fewest rows of the group's classes.
    ///
    /// # Errors
    /// A class whose rows are all of one group.
    pub fn new(candidates: &Candidates, validation: &Validation) -> Result<Self, Error> {
        let classes = candidates.table.names.len();
        let mut groups: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        let whole = |group: usize| validation.whole(group);
        for (group, &class) in candidates.groups.iter().map(|&group| whole(group)).zip(&candidates.table.classes) {
            groups.entry(group).or_insert_with(|| vec![0; classes])[class] += 1;
        }
        let with = |class: usize| groups.values().filter(|counts| counts[class] > 0).count();
        let scarce = (0..classes).min_by_key(|&class| with(class)).unwrap_or(0);
        let count = validation.folds.min(with(scarce));
        if count < 2 {
            let name = &candidates.table.names[scarce];
            let problem = if validation.folds < 2 {
                "cross-validation needs at least 2 folds".into()
            } else {
                let one = if validation.units.is_empty() { "group" } else { "unit" };
                format!("all training traces of class {name} are of one {one}; cross-validation needs at least 2")
            };
            return Err(Error::Training(problem));
        }
        let mut order: Vec<(usize, Vec<usize>)> = groups.into_iter().collect();
        order.shuffle(&mut ChaCha8Rng::seed_from_u64(validation.seed));
        order.sort_by_key(|(_, counts)| std::cmp::Reverse(counts.iter().sum::<usize>()));
        let mut held = vec![vec![0_usize; classes]; count];
        let mut fold_of = BTreeMap::new();
        for (group, counts) in order {
            // The fold with the fewest rows of the group's classes; if equal, the fold with the fewest rows.
            let burden = |fold: &usize| {
                let shared: usize = held[*fold].iter().zip(&counts).map(|(there, here)| there * here).sum();
                (shared, held[*fold].iter().sum::<usize>())
            };
            let fold = (0..count).min_by_key(burden).unwrap_or(0);
            held[fold].iter_mut().zip(&counts).for_each(|(there, here)| *there += here);
            fold_of.insert(group, fold);
        }
        Ok(Self { of_row: candidates.groups.iter().map(|&group| fold_of[&whole(group)]).collect(), count })
    }

    /// Returns the rows to train on and the held-out rows.
    #[must_use]
    pub fn split(&self, fold: usize) -> (Vec<usize>, Vec<usize>) {
        (0..self.of_row.len()).partition(|&row| self.of_row[row] != fold)
    }
}

/// Returns an error if a class has no rows.
pub(crate) fn check(seen: &Candidates) -> Result<(), Error> {
    let names = &seen.table.names;
    match (0..names.len()).find(|class| !seen.table.classes.contains(class)) {
        Some(class) => Err(Error::Training(format!(
            "class {} is left without training traces in a fold of the cross-validation; use smaller groups",
            names[class]
        ))),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DVector;

    use super::*;

    /// Rows of (group, class).
    fn candidates(rows: &[(usize, usize)]) -> Candidates {
        let (groups, classes): (Vec<usize>, Vec<usize>) = rows.iter().copied().unzip();
        let values = rows.iter().map(|_| DVector::zeros(1)).collect();
        let table = FeatureTable::exact(values, classes, vec!["a".into(), "b".into()]);
        Candidates { table, features: vec!["x".into()], groups, covariates: None }
    }

    #[test]
    fn each_fold_has_all_classes_if_groups_suffice() {
        // Groups of one class: 6 rows of a, then 3 and 2 of b, and 1 of a. The second group of b goes to the large
        // group of a, although the other fold has fewer rows.
        let sizes = [(0, 0, 6), (1, 1, 3), (2, 1, 2), (3, 0, 1)];
        let rows: Vec<(usize, usize)> =
            sizes.iter().flat_map(|&(group, class, size)| std::iter::repeat_n((group, class), size)).collect();
        let own = candidates(&rows);
        let folds = Folds::new(&own, &Validation { folds: 2, ..Validation::default() }).expect("two groups a class");
        for fold in 0..2 {
            let (seen, held) = folds.split(fold);
            assert_eq!(seen.len() + held.len(), 12);
            for places in [seen, held] {
                assert!((0..2).all(|class| places.iter().any(|&row| rows[row].1 == class)), "{fold}: {places:?}");
            }
        }
    }

    #[test]
    fn rows_weigh_as_the_priors_of_their_classes() {
        let own = candidates(&[(0, 0), (1, 1), (2, 1), (3, 1)]);
        // 0.4 · 4/1, and 0.6 · 4/3: mean 1.
        let (weights, expected) = (own.weights(&[0.4, 0.6]), [1.6, 0.8, 0.8, 0.8]);
        assert!(weights.iter().zip(expected).all(|(one, other)| (one - other).abs() < 1e-12), "{weights:?}"); // rounding
    }
}
