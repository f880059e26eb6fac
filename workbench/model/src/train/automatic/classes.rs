//! The recipe with the least cost of wrong decisions, if there are classes of defects.

use rayon::prelude::*;

use super::candidates;
use super::situation::Situation;
use super::why::{Automatic, Rival};
use crate::Error;
use crate::train::estimates::{Estimates, Used};
use crate::train::{Folds, Prediction, Recipe, predict};

/// The cost of a recipe's decisions on held-out segments.
struct Judged {
    /// Mean cost.
    cost: f64,
    /// Standard error of the mean.
    error: f64,
}

/// Returns the earliest recipe whose cost is not above the least one by more than its standard error.
///
/// # Errors
/// No recipe can be trained; then the reason of the first one.
pub(super) fn choose(own: &Estimates<'_>, situation: &Situation) -> Result<(Recipe, Automatic), Error> {
    let recipes = candidates::with_and_without(candidates::of_classes(own, situation));
    let mut judged: Vec<Result<Judged, Error>> = recipes.par_iter().map(|recipe| of(own, recipe)).collect();
    let best = judged.iter().flatten().min_by(|a, b| a.cost.total_cmp(&b.cost));
    let Some(limit) = best.map(|best| best.cost + best.error) else {
        return Err(judged.swap_remove(0).err().unwrap_or_else(|| Error::Training("no recipe".into())));
    };
    let chosen = judged.iter().position(|own| own.as_ref().is_ok_and(|own| own.cost <= limit)).unwrap_or(0);
    let rival = |(recipe, judged): (&Recipe, &Result<Judged, Error>)| {
        let judged = judged.as_ref().map(|judged| (judged.cost, vec![]));
        Rival::of(recipe, Some(judged.map_err(ToString::to_string)))
    };
    let rivals = recipes.iter().zip(&judged).map(rival).collect();
    let notes = situation.notes.clone();
    let why = Automatic { rivals, chosen, held_out: true, by_classes: true, notes, temperatures: vec![] };
    Ok((recipes[chosen].clone(), why))
}

fn of(own: &Estimates<'_>, recipe: &Recipe) -> Result<Judged, Error> {
    let Used { candidates, chosen, .. } = own.rows_of(recipe)?;
    let rows = candidates.select(&chosen);
    let folds = Folds::new(&rows, &recipe.validation)?;
    let predictions = predict(&rows, recipe, &folds)?;
    let cost = |own: &Prediction| {
        let decided = own.decided.and_then(|decided| recipe.cost.get(decided)).and_then(|row| row.get(own.truth));
        own.weight * decided.copied().unwrap_or(if own.decided == Some(own.truth) { 0.0 } else { 1.0 })
    };
    let costs: Vec<f64> = predictions.iter().map(cost).collect();
    let count = costs.len().max(1) as f64;
    let mean = costs.iter().sum::<f64>() / count;
    let square = costs.iter().map(|own| (own - mean).powi(2)).sum::<f64>() / count;
    // One wrong decision more or less is chance even where none is wrong.
    Ok(Judged { cost: mean, error: (square / count).sqrt().max(1.0 / count) })
}
