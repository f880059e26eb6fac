//! Which temperatures explain the features of healthy segments.
//!
//! ```text
//! d = Σ_k w_k (r_k² − r'_k²),   w_k = 1/(σ_k² + v_k)                                                    (1)
//! ```
//!
//! r_k is the distance of feature k of a healthy segment from its mean, r'_k the same less what the temperature
//! explains ([`covariates`]), both by segments of other runs; v_k is the variance of the feature's error, σ_k² that of
//! r_k beyond it. A temperature is taken if the mean of (1) over the left-out segments is above twice its standard
//! error, which counts runs. Further temperatures must explain more than those that are taken, the best one first.

use std::collections::BTreeMap;

use bearing_watch::plan::MAX_COVARIATES;

use super::candidates;
use super::situation::Situation;
use super::why::Temperature;
use crate::Error;
use crate::core::features::averaged;
use crate::train::estimates::{Estimates, Used};
use crate::train::rows::covariates;
use crate::train::{Candidates, FeatureTable, Folds, Recipe, Validation};

/// Folds, as those of the compared recipes.
const FOLDS: usize = 5;
/// Standard errors that the mean of (1) is above 0.
const CLEAR: f64 = 2.0;
/// Least part of a feature's variance that does not come from the known errors.
const LEAST_PART: f64 = 1e-3;

/// r_k² of each left-out segment and feature; `None` where the feature is missing.
type Squares = Vec<Vec<Option<f64>>>;

/// Healthy segments with all temperatures.
struct Healthy {
    rows: Candidates,
    /// Means of the temperatures.
    temperatures: FeatureTable,
    recipe: Recipe,
    folds: Folds,
}

/// Judges the covariates of a training as temperatures of these columns.
///
/// # Errors
/// Features that no healthy segment has.
pub(in crate::train) fn judged(own: &Estimates<'_>) -> Result<Vec<Temperature>, Error> {
    let names = own.recipe.covariates.clone();
    let refused = |why: String| {
        let each = |name: &String| Temperature::refused(averaged(name).unwrap_or(name), why.clone());
        Ok(names.iter().map(each).collect())
    };
    let Some(class) = own.recipe.alarms.healthy else {
        return refused("no healthy class tells what it explains".into());
    };
    let features = candidates::features(&Situation::of(own));
    let plain = Recipe { features, covariates: vec![], automatic: false, ..own.recipe.clone() };
    let Used { candidates, chosen, .. } = own.rows_of(&plain)?;
    let healthy: Vec<usize> =
        (0..candidates.table.rows.len()).filter(|&k| candidates.table.classes[k] == class).collect();
    let mut all = candidates.rows(&healthy);
    (all.table.classes, all.table.names) = (vec![0; healthy.len()], vec![own.classes[class].clone()]);
    let rows = all.select(&chosen);
    let mut recipe = plain;
    recipe.alarms.healthy = Some(0);
    let validation = Validation { folds: FOLDS, ..recipe.validation.clone() };
    let folds = match Folds::new(&rows, &validation) {
        Ok(folds) => folds,
        Err(problem) => return refused(problem.to_string()),
    };
    let temperatures = all.table.select(&all.places(&names));
    Ok(Healthy { rows, temperatures, recipe, folds }.choose(&names))
}

impl Healthy {
    /// Takes the best temperature as long as it explains more.
    fn choose(&self, names: &[String]) -> Vec<Temperature> {
        let column = |place: usize| averaged(&names[place]).unwrap_or(&names[place]).to_string();
        let mut all: Vec<Option<Temperature>> =
            (0..names.len()).map(|place| Some(Temperature::refused(&column(place), self.unusable(place)?))).collect();
        let mut taken: Vec<usize> = vec![];
        let mut squares = self.squares(names, &[]).ok();
        while let (Some(before), true) = (&squares, taken.len() < MAX_COVARIATES) {
            let weights = self.weights(before);
            let mut best: Option<(f64, usize, Squares)> = None;
            let rest = (0..names.len()).filter(|place| all[*place].is_none()).collect::<Vec<_>>();
            for place in rest {
                let after = match self.squares(names, &[&taken[..], &[place]].concat()) {
                    Ok(after) => after,
                    Err(problem) => {
                        all[place] = Some(Temperature::refused(&column(place), problem.to_string()));
                        continue;
                    }
                };
                let gain = self.gain(&weights, before, &after);
                if gain > best.as_ref().map_or(CLEAR, |(other, ..)| *other) {
                    best = Some((gain, place, after));
                }
            }
            let Some((_, place, after)) = best else { break };
            let explained = self.parts(&weights, before, &after);
            all[place] = Some(Temperature { column: column(place), explained, refused: None });
            taken.push(place);
            squares = Some(after);
        }
        let more = if taken.is_empty() { "" } else { " beyond those that are used" };
        let nothing = format!("it explains nothing of left-out segments{more}");
        let of = |(place, own): (usize, Option<Temperature>)| {
            own.unwrap_or_else(|| Temperature::refused(&column(place), nothing.clone()))
        };
        all.into_iter().enumerate().map(of).collect()
    }

    /// Why a temperature cannot be a covariate.
    fn unusable(&self, place: usize) -> Option<String> {
        let known = self.temperatures.with(0, place).count();
        let of = self.temperatures.rows.len();
        if known < of {
            return Some(format!("it is missing in {} of {of} healthy segments", of - known));
        }
        let values = self.temperatures.rows.iter().map(|row| row[place]);
        (!covariates::varies(values)).then(|| "it is the same in all healthy segments".into())
    }

    /// The squares of the left-out segments, less what these temperatures explain.
    fn squares(&self, names: &[String], places: &[usize]) -> Result<Squares, Error> {
        let covariates = (!places.is_empty()).then(|| self.temperatures.select(places));
        let names = places.iter().map(|&place| names[place].clone()).collect();
        let recipe = Recipe { covariates: names, ..self.recipe.clone() };
        let rows = Candidates { covariates, ..self.rows.clone() };
        let mut all: Squares = vec![vec![]; rows.table.rows.len()];
        for fold in 0..self.folds.count {
            let (seen, left_out) = self.folds.split(fold);
            let seen = rows.rows(&seen);
            let explained = covariates::fit(&seen, &recipe)?;
            let centre = explained.as_ref().map_or_else(|| seen.table.mean(), |own| own.corrected(&seen).mean());
            for row in left_out {
                let (value, variance) = match &explained {
                    Some(explained) => explained.corrected_row(&rows, row),
                    None => (rows.table.rows[row].clone(), rows.table.variances[row].clone()),
                };
                let square = |k: usize| variance[k].is_finite().then(|| (value[k] - centre[k]).powi(2));
                all[row] = (0..value.len()).map(square).collect();
            }
        }
        Ok(all)
    }

    /// w of (1) of each segment and feature.
    fn weights(&self, squares: &Squares) -> Vec<Vec<f64>> {
        let variances = &self.rows.table.variances;
        let of_feature = |k: usize| {
            let own = squares.iter().zip(variances).filter_map(|(row, v)| Some((row[k]?, v[k])));
            let (sum, beyond, count) =
                own.fold((0.0, 0.0, 0.0), |(sum, beyond, n), (r, v)| (sum + r, beyond + r - v, n + 1.0_f64));
            (beyond.max(LEAST_PART * sum) / count.max(1.0)).max(f64::MIN_POSITIVE)
        };
        let spreads: Vec<f64> = (0..self.rows.features.len()).map(of_feature).collect();
        variances.iter().map(|row| row.iter().zip(&spreads).map(|(v, spread)| 1.0 / (spread + v)).collect()).collect()
    }

    /// The mean of (1) over its standard error; 0 if nothing is explained.
    fn gain(&self, weights: &[Vec<f64>], before: &Squares, after: &Squares) -> f64 {
        let runs = self.recipe.runs(&self.rows);
        let mut of_run: BTreeMap<usize, (f64, f64)> = BTreeMap::new();
        for (row, own) in weights.iter().enumerate() {
            let terms = own.iter().zip(before[row].iter().zip(&after[row]));
            let gained: f64 = terms.filter_map(|(w, (b, a))| Some(w * ((*b)? - (*a)?))).sum();
            let (sum, count) = of_run.entry(runs.as_ref().map_or(row, |runs| runs[row])).or_default();
            (*sum, *count) = (*sum + gained, *count + 1.0);
        }
        let (sum, count) = of_run.values().fold((0.0, 0.0), |(sum, n), (own, k)| (sum + own, n + k));
        let (mean, runs) = (sum / count, of_run.len() as f64);
        let squares: f64 = of_run.values().map(|(own, k)| (own - k * mean).powi(2)).sum();
        let error = (squares * runs / (runs - 1.0)).sqrt() / count;
        if error > 0.0 { mean / error } else { 0.0 }
    }

    /// Part of the left-out variance of each feature that is explained, largest first.
    fn parts(&self, weights: &[Vec<f64>], before: &Squares, after: &Squares) -> Vec<(String, f64)> {
        let part = |(k, name): (usize, &String)| {
            let rows = weights.iter().zip(before.iter().zip(after));
            let both = rows.filter_map(|(w, (b, a))| Some((w[k] * b[k]?, w[k] * a[k]?)));
            let (b, a) = both.fold((0.0, 0.0), |(b, a), (own, other)| (b + own, a + other));
            (name.clone(), if b > 0.0 { 1.0 - a / b } else { 0.0 })
        };
        let mut all: Vec<(String, f64)> = self.rows.features.iter().enumerate().map(part).collect();
        all.retain(|(_, part)| *part > 0.0);
        all.sort_by(|a, b| b.1.total_cmp(&a.1));
        all
    }
}
