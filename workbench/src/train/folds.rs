//! Rows to learn from, and their split into folds: rows of one group (segments of a trace, strokes of a run) lie in
//! one fold.

use std::collections::BTreeMap;

use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use super::FeatureTable;
use crate::Error;

/// How rows are split.
#[derive(Clone, Debug, PartialEq)]
pub struct Validation {
    /// Folds; fewer where a class comes from fewer groups.
    pub folds: usize,
    /// Seed of the split.
    pub seed: u64,
    /// Group of each training trace; each its own where empty.
    pub groups: Vec<String>,
}

impl Default for Validation {
    fn default() -> Self {
        Self { folds: 10, seed: 1, groups: vec![] }
    }
}

/// Rows to learn from: features with their names, classes and groups.
#[derive(Clone, Debug)]
pub struct Candidates {
    /// A row a segment, with its class.
    pub table: FeatureTable,
    /// Names of the features.
    pub features: Vec<String>,
    /// Group of each row.
    pub groups: Vec<usize>,
}

impl Candidates {
    /// The given rows only.
    #[must_use]
    pub fn rows(&self, places: &[usize]) -> Self {
        let table = FeatureTable {
            rows: places.iter().map(|&k| self.table.rows[k].clone()).collect(),
            classes: places.iter().map(|&k| self.table.classes[k]).collect(),
            names: self.table.names.clone(),
        };
        Self { table, features: self.features.clone(), groups: places.iter().map(|&k| self.groups[k]).collect() }
    }

    /// The given features only.
    #[must_use]
    pub fn select(&self, places: &[usize]) -> Self {
        let features = places.iter().map(|&k| self.features[k].clone()).collect();
        Self { table: self.table.select(places), features, groups: self.groups.clone() }
    }

    /// Places of features by name.
    pub(crate) fn places(&self, names: &[String]) -> Vec<usize> {
        names.iter().filter_map(|name| self.features.iter().position(|feature| feature == name)).collect()
    }

    /// What each row counts, of mean one: classes weigh as their priors, however many rows they have.
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
    /// The fold that holds a row out.
    pub of_row: Vec<usize>,
    /// Folds.
    pub count: usize,
}

impl Folds {
    /// Seeded and stratified: groups in random order, the large ones first, each to the fold that has least of its
    /// classes.
    ///
    /// # Errors
    /// A class whose rows are all of one group.
    pub fn new(candidates: &Candidates, validation: &Validation) -> Result<Self, Error> {
        let classes = candidates.table.names.len();
        let mut groups: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (&group, &class) in candidates.groups.iter().zip(&candidates.table.classes) {
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
                format!("all training traces of class {name} are of one group; cross-validation needs at least 2")
            };
            return Err(Error::Training(problem));
        }
        let mut order: Vec<(usize, Vec<usize>)> = groups.into_iter().collect();
        order.shuffle(&mut ChaCha8Rng::seed_from_u64(validation.seed));
        order.sort_by_key(|(_, counts)| std::cmp::Reverse(counts.iter().sum::<usize>()));
        let mut held = vec![vec![0_usize; classes]; count];
        let mut fold_of = BTreeMap::new();
        for (group, counts) in order {
            // Most of its classes there already first, then rows at all.
            let burden = |fold: &usize| {
                let shared: usize = held[*fold].iter().zip(&counts).map(|(there, here)| there * here).sum();
                (shared, held[*fold].iter().sum::<usize>())
            };
            let fold = (0..count).min_by_key(burden).unwrap_or(0);
            held[fold].iter_mut().zip(&counts).for_each(|(there, here)| *there += here);
            fold_of.insert(group, fold);
        }
        Ok(Self { of_row: candidates.groups.iter().map(|group| fold_of[group]).collect(), count })
    }

    /// Rows to train on and rows held out.
    #[must_use]
    pub fn split(&self, fold: usize) -> (Vec<usize>, Vec<usize>) {
        (0..self.of_row.len()).partition(|&row| self.of_row[row] != fold)
    }
}

/// Every class has rows.
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
