//! The recipe that training chooses if no features are asked for.
//!
//! ```text
//! healthy traces ─┬──────────────► features ─┐
//!                 └► + defects ──► features ─┴► each recipe, cross-validated ─► smallest sizes found ─► the best one
//! ```
//!
//! Without classes of defects, defects of every kind and size are added to healthy traces ([`defects`]), and the
//! recipe is best whose gate at the set rate finds the smallest ones ([`power`]). With classes, that with the fewest
//! wrong decisions ([`classes`]). Both are cross-validated over runs. Covariates that training itself has offered
//! ([`temperature`]) are left out if no recipe with them is clearly better. The recipes that are compared
//! ([`candidates`]) are in an order: an earlier one is kept unless a later one is clearly better, so that the choice
//! does not depend on chance.

mod candidates;
mod classes;
mod defects;
mod power;
mod situation;
pub(super) mod temperature;
mod why;

use rayon::prelude::*;

use super::Recipe;
use super::estimates::Estimates;
use crate::Error;
use power::Power;
use situation::Situation;
pub use why::{Automatic, Detected, Rival, Temperature};

/// A later recipe must find defects that are smaller by this part, in the mean over the kinds.
const SMALLER: f64 = 0.15;

/// Returns the recipe with the features that detect best, and why.
///
/// # Errors
/// No recipe can be trained; then the reason of the first one.
pub(super) fn choose(own: &Estimates<'_>) -> Result<(Recipe, Automatic), Error> {
    let situation = Situation::of(own);
    if own.classes.len() > 1 {
        return classes::choose(own, &situation);
    }
    let mut recipes = candidates::with_and_without(candidates::of_gate(own, &situation));
    let only = match &recipes[..] {
        [only] => Some(only),
        _ if own.recipe.trial => recipes.iter().find(|recipe| power::is_possible(own, recipe)),
        _ => None,
    };
    if let Some(only) = only {
        let why = Automatic {
            rivals: vec![Rival::of(only, None)],
            chosen: 0,
            held_out: false,
            by_classes: false,
            notes: situation.notes,
            temperatures: vec![],
        };
        return Ok((only.clone(), why));
    }
    let defects = defects::added(own, &situation)?;
    let judge = |recipe: &Recipe| power::of(own, recipe, &defects);
    let mut judged: Vec<Result<Power, Error>> = recipes.par_iter().map(judge).collect();
    let sees_friction = |(recipe, own): (&Recipe, &Result<Power, Error>)| own.is_ok() && !recipe.rising.is_empty();
    if !recipes.iter().zip(&judged).any(sees_friction) {
        // So few runs support a gate of fewer features only; one of orders alone would not see a dry bearing.
        let fewer = candidates::of_few(own, &situation);
        judged.extend(fewer.par_iter().map(judge).collect::<Vec<_>>());
        recipes.extend(fewer);
    }
    let chosen = best(&judged).unwrap_or(0);
    let held_out = judged.iter().flatten().all(|own| own.held_out);
    let rival = |(recipe, power): (&Recipe, &Result<Power, Error>)| {
        let judged = power.as_ref().map(|power| (power.rate, power.detected.clone()));
        Rival::of(recipe, Some(judged.map_err(ToString::to_string)))
    };
    let rivals = recipes.iter().zip(&judged).map(rival).collect();
    let why = Automatic { rivals, chosen, held_out, by_classes: false, notes: situation.notes, temperatures: vec![] };
    Ok((recipes[chosen].clone(), why))
}

/// The places of the features of a shaft that the recipes use.
pub(super) fn watched(own: &Estimates<'_>) -> Vec<usize> {
    let situation = Situation::of(own);
    let names = own.catalogue.names();
    let places = |name: &String| names.iter().position(|other| other == name);
    candidates::features(&situation).iter().filter_map(places).collect()
}

/// The place of the best recipe; an earlier one unless a later one finds clearly smaller defects.
fn best(judged: &[Result<Power, Error>]) -> Option<usize> {
    let mut best: Option<(usize, &Power)> = None;
    for (place, power) in judged.iter().enumerate() {
        let Ok(power) = power else { continue };
        let better = match best {
            None => true,
            Some((_, other)) if power.keeps_rate != other.keeps_rate => power.keeps_rate,
            Some((_, other)) => power.log_size < other.log_size - SMALLER,
        };
        if better {
            best = Some((place, power));
        }
    }
    best.map(|(place, _)| place)
}
