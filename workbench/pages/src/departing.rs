//! The coordinate by which a segment departs most from healthy.

use bearing_watch::model::Feature;
use bearing_watch::plan::Plan as _;
use model::core::features::Catalogue;
use model::core::{Embedded, SegmentReport};
use model::train::features_of;

/// Name of the coordinate without which the segment would be least surprising; `orders` are the names of the tracked
/// orders. `None` if the model has covariates, or if the segment lacks a feature.
#[must_use]
pub fn departing(model: &Embedded, orders: &[String], segment: &SegmentReport) -> Option<String> {
    let (plan, classifier) = (model.model().plan(), &model.model().constants().classifier);
    let layout = plan.layout();
    if layout.covariates > 0 || !segment.missing.is_empty() {
        return None;
    }
    let catalogue = model.catalogue(orders);
    let values: Vec<f32> = classifier.features.iter().map(|feature| value(&catalogue, segment, *feature)).collect();
    let (map, mean) = (&classifier.projection.matrix, &classifier.projection.mean);
    let rows: Vec<&[f32]> = map.chunks(values.len().max(1)).collect();
    let coordinate = |row: &&[f32]| row.iter().zip(&values).zip(mean).map(|((w, f), m)| w * (f - m)).sum();
    let coordinates: Vec<f32> = rows.iter().map(coordinate).collect();
    let without = |k: usize| {
        let variances: Vec<f32> = (0..rows.len()).map(|j| if j == k { f32::INFINITY } else { 0.0 }).collect();
        let decision = classifier.decide_at(plan, &coordinates, &variances);
        decision.map_or(f32::INFINITY, |decision| decision.surprise)
    };
    let place = (0..rows.len()).min_by(|one, other| without(*one).total_cmp(&without(*other)))?;
    model.coordinate_names(orders).into_iter().nth(place)
}

/// The value of a core feature in a segment.
fn value(catalogue: &Catalogue, segment: &SegmentReport, feature: Feature) -> f32 {
    if let Feature::Parameter(place) = feature {
        return segment.delta.get(usize::from(place)).copied().unwrap_or(f32::NAN);
    }
    let (values, _) = features_of(segment, catalogue);
    let place = (0..values.len()).find(|&place| catalogue.core_feature(place) == feature);
    place.map_or(f32::NAN, |place| values[place] as f32)
}
