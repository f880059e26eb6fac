//! The map of raw features composed with that to the core's δ-features.

use nalgebra::DVector;

use super::AffineMap;
use crate::core::features::Catalogue;

/// Returns the map from the core's δ-features: z = W (raw − m) = W T_S (δ − δ_m), with δ_m the training mean of δ, and
/// the places of the δ-features that it uses. `raw` and `usual` are the means and usual errors of all features.
#[must_use]
pub fn compose(
    (mut raw, usual): (DVector<f64>, &DVector<f64>),
    chosen: &[usize],
    catalogue: &Catalogue,
    projection: &AffineMap,
) -> (Vec<usize>, AffineMap, DVector<f64>) {
    let map = catalogue.raw_from_delta().select_rows(chosen);
    let used: Vec<usize> = (0..map.ncols()).filter(|&k| map.column(k).amax() > 0.0).collect();
    // Both centres are the same point: of the chosen features the projection's centre, of the others any.
    chosen.iter().zip(projection.mean.iter()).for_each(|(&place, mean)| raw[place] = *mean);
    let mean = catalogue.delta_from_raw(&raw);
    let matrix = &projection.matrix * map.select_columns(&used);
    let centre = DVector::from_iterator(used.len(), used.iter().map(|&k| mean[k]));
    // The map from raw features leaves those with errors as they are.
    let usual = DVector::from_iterator(used.len(), used.iter().map(|&k| usual[k]));
    (used, AffineMap { matrix, mean: centre }, usual)
}
