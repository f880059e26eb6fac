//! Labelled rows → projection and class densities: all of training that looks at classes.

use super::projection::AffineMap;
use super::shrinkage::{self, Choice, Shrink};
use super::{
    Candidates, ClassStatistics, FeatureTable, GaussianClasses, ProjectionKind, Recipe, discriminant, projection,
};
use crate::Error;

/// What rows taught.
#[derive(Clone, Debug)]
pub(crate) struct Fitted {
    pub(crate) projection: AffineMap,
    pub(crate) coordinates: FeatureTable,
    pub(crate) coordinate_names: Vec<String>,
    pub(crate) densities: GaussianClasses,
    pub(crate) choice: Option<Choice>,
}

/// Fits the recipe to rows; a shrinkage that is to be chosen is chosen on them alone.
pub(crate) fn fit(candidates: &Candidates, recipe: &Recipe) -> Result<Fitted, Error> {
    let Candidates { table, features, .. } = candidates;
    let projection = projection::train(table, features, recipe.projection)?;
    let coordinates = table.map(&projection);
    let coordinate_names = match recipe.projection {
        ProjectionKind::None => features.clone(),
        _ => (1..=projection.matrix.nrows()).map(|k| format!("z{k}")).collect(),
    };
    let choice = match recipe.shrink {
        Shrink::Chosen => Some(shrinkage::search(candidates, recipe)?),
        Shrink::Not | Shrink::To(_) => None,
    };
    let shrink = match (recipe.shrink, &choice) {
        (Shrink::To(shrinkage), _) => Some(shrinkage),
        (_, choice) => choice.as_ref().map(|choice| choice.shrinkage),
    };
    let densities = match shrink {
        Some(shrinkage) => {
            discriminant::shrunk(&ClassStatistics::new(&coordinates), &coordinate_names, recipe, shrinkage)?
        }
        None => discriminant::train(&coordinates, &coordinate_names, recipe)?,
    };
    Ok(Fitted { projection, coordinates, coordinate_names, densities, choice })
}
