//! The recipes that are compared, those first that found most in `campaign --field`.

use bearing_watch::plan::Kind;

use super::situation::Situation;
use crate::train::estimates::Estimates;
use crate::train::{Recipe, Shrink, Shrinkage};

/// Friction that a defect only raises.
const RISING: [&str; 3] = ["viscous_log", "viscous", "drag"];
/// Relative spread of the sizes of a defect.
const SIZE_SPREAD: f64 = 0.15;
/// Separate covariances with halved correlations: those of some twenty traces a class are uncertain.
const SEPARATE: Shrinkage = Shrinkage { lambda: 0.0, gamma: 0.5 };

/// Names of those that a defect only raises.
fn rising(features: &[String]) -> Vec<String> {
    features.iter().filter(|name| RISING.contains(&name.as_str())).cloned().collect()
}

/// Returns all features that the recipes of a gate use.
pub(super) fn features(situation: &Situation) -> Vec<String> {
    [situation.keep(&[situation.around(), &RISING].concat()), situation.orders.clone()].concat()
}

/// Adds the recipes without the covariates that may be left out, before those with them: firmware has to give a
/// covariate, so that it is kept only if it is clearly of use.
pub(super) fn with_and_without(recipes: Vec<Recipe>) -> Vec<Recipe> {
    let may_lack = |recipe: &&Recipe| recipe.offered && !recipe.covariates.is_empty();
    let without = recipes.iter().filter(may_lack).cloned().map(|recipe| Recipe { covariates: vec![], ..recipe });
    without.collect::<Vec<_>>().into_iter().chain(recipes).collect()
}

/// Returns the recipes for a gate of healthy segments alone.
pub(super) fn of_gate(own: &Estimates<'_>, situation: &Situation) -> Vec<Recipe> {
    let (orders, around) = (&situation.orders, situation.around());
    // A friction's mean for a given logarithm of it is a curve, and the laws of runs are symmetric: there one scale.
    let both_scales = !own.recipe.alarms.by_run;
    let frictions: [(&[&str], bool); 5] = [
        (&["viscous_log", "viscous", "drag"], both_scales),
        (&["viscous", "drag"], true),
        (&["viscous_log", "drag"], true),
        (&["drag"], true),
        (&[], true),
    ];
    let with_load = frictions.iter().filter(|(_, allowed)| *allowed).map(|(friction, _)| {
        let around = if friction.is_empty() { &[] } else { around };
        situation.keep(&[around, friction].concat())
    });
    let mut sets: Vec<Vec<String>> = with_load.map(|friction| [friction, orders.clone()].concat()).collect();
    if !situation.load && !orders.is_empty() {
        // Friction that contains the load is worth its part of the false alarms only if it finds clearly more.
        sets.rotate_right(1);
    }
    sets.dedup();
    sets.retain(|features| !features.is_empty());
    if sets.is_empty() {
        // The parameters of the difference model alone.
        sets.push(vec![]);
    }
    sets.into_iter().map(|features| with_features(own, features)).collect()
}

/// Returns the recipes of few features, for few runs: drag and orders, each without what follows temperature and load.
pub(super) fn of_few(own: &Estimates<'_>, situation: &Situation) -> Vec<Recipe> {
    let (drag, orders) = (situation.keep(&["drag"]), situation.orders.clone());
    let mut sets = vec![[drag.clone(), orders.clone()].concat(), orders, drag];
    sets.retain(|features| !features.is_empty());
    sets.dedup();
    sets.into_iter().map(|features| with_features(own, features)).collect()
}

fn with_features(own: &Estimates<'_>, features: Vec<String>) -> Recipe {
    Recipe { rising: rising(&features), features, automatic: false, ..own.recipe.clone() }
}

/// Returns the recipes that name classes of defects.
pub(super) fn of_classes(own: &Estimates<'_>, situation: &Situation) -> Vec<Recipe> {
    let (orders, around) = (&situation.orders, situation.around());
    let with = |friction: &[&str]| [situation.keep(friction), orders.clone()].concat();
    let parameters: Vec<String> = ["a", "b", "c"]
        .iter()
        .zip([own.recipe.structure.na, own.recipe.structure.nb, own.recipe.structure.nc])
        .filter(|(_, count)| *count > 0)
        .map(|(name, _)| (*name).to_string())
        .collect();
    let sets: Vec<(Vec<String>, bool)> = vec![
        (with(&[around, &["viscous", "drag"]].concat()), true),
        (with(&[&around[..around.len().min(1)], &["drag_log"]].concat()), true),
        (with(&["drag_log"]), true),
        ([parameters.clone(), with(&["drag"])].concat(), false),
        (parameters, false),
    ];
    let healthy = own.recipe.alarms.healthy.is_some();
    let recipe = |(features, physical): (Vec<String>, bool)| {
        let rising = if physical { rising(&features) } else { vec![] };
        let plain = Recipe { features, rising, automatic: false, ..own.recipe.clone() };
        // Settings that a user gives stay.
        let usual = matches!(plain.shrink, Shrink::Not) && plain.discriminant == Kind::Linear;
        if !(physical && usual) {
            return plain;
        }
        let size_spread = if healthy && plain.size_spread <= 0.0 { SIZE_SPREAD } else { plain.size_spread };
        Recipe { discriminant: Kind::Quadratic, shrink: Shrink::To(SEPARATE), size_spread, ..plain }
    };
    sets.into_iter().filter(|(features, _)| !features.is_empty()).map(recipe).collect()
}
