//! What a coordinate of a model is called, wherever one is named: text, JSON, pages, DBC, exported models.
//!
//! ```text
//! z = W (raw − m)                                                        (1)
//! z_k is called as raw feature j if row k of W has a weight of j alone, above 0, else z1, z2, …
//! ```
//!
//! Such a coordinate rises where its feature does. A coordinate is no place among the features of the core: they are
//! in the order of the catalogue, the coordinates in the order in which training chose them, with those last that a
//! defect only raises. With a projection a coordinate is a combination of features, and has a number only. W of (1) is
//! that of training; the core has W T of δ-features ([`super::features`]), from which T⁻¹ returns.

use std::fmt;

use bearing_watch::Model;
use bearing_watch::plan::RunTime;
use nalgebra::{DMatrix, DVector};

use super::features::{self, Catalogue};

/// Name of a coordinate that is this feature, or a combination.
#[must_use]
pub fn name(place: usize, feature: Option<&str>) -> String {
    feature.map_or_else(|| format!("z{}", place + 1), String::from)
}

/// Names of the coordinates of a map (1) from features with these names.
#[must_use]
pub fn of_map(map: &DMatrix<f64>, features: &[String]) -> Vec<String> {
    let of_row = |place: usize| {
        let row = map.row(place);
        let mut used = row.iter().zip(features).filter(|(weight, _)| weight.abs() > 0.0);
        match (used.next(), used.next()) {
            (Some((weight, feature)), None) if *weight > 0.0 => name(place, Some(feature)),
            _ => name(place, None),
        }
    };
    (0..map.nrows()).map(of_row).collect()
}

/// Names of the coordinates of a model, by those of the tracked orders.
#[must_use]
pub fn of_model(model: &Model<RunTime>, orders: &[String]) -> Vec<String> {
    let catalogue = Catalogue::of_model(model, orders);
    let (names, classifier) = (catalogue.names(), &model.constants().classifier);
    let places = catalogue.places(&classifier.features);
    let mut map = DMatrix::zeros(usize::from(model.plan().layout().coordinates), names.len());
    for (row, weights) in classifier.projection.matrix.chunks(places.len().max(1)).enumerate().take(map.nrows()) {
        weights.iter().zip(&places).for_each(|(weight, place)| {
            if let Some(place) = place {
                map[(row, *place)] = f64::from(*weight);
            }
        });
    }
    of_map(&(map * delta_from_raw(&catalogue)), &names)
}

/// T⁻¹ of the catalogue, whose elements are 0 and ±1.
fn delta_from_raw(catalogue: &Catalogue) -> DMatrix<f64> {
    let n = catalogue.names().len();
    let origin = catalogue.delta_from_raw(&DVector::zeros(n));
    let column = |place: usize| {
        let unit = DVector::from_fn(n, |k, _| if k == place { 1.0 } else { 0.0 });
        catalogue.delta_from_raw(&unit) - &origin
    };
    DMatrix::from_columns(&(0..n).map(column).collect::<Vec<_>>())
}

/// Name of a coordinate for a reader.
#[must_use]
pub fn in_words(coordinate: &str) -> String {
    let plain = quantity(coordinate);
    if is_order(coordinate) {
        return format!("{plain} order");
    }
    match plain {
        "viscous" => "viscous friction".into(),
        "coulomb" => "Coulomb friction".into(),
        "inverse_kt" => "torque constant".into(),
        other => match other.strip_prefix('z').and_then(|number| number.parse::<u16>().ok()) {
            Some(number) => format!("coordinate {number}"),
            None => other.replace('_', " "),
        },
    }
}

/// Whether a feature is the strength of a bearing order.
#[must_use]
pub fn is_order(name: &str) -> bool {
    features::order(name).is_some()
}

/// What a feature tells on one of several scales: plain, as score or as logarithm; of an order as score or amplitude.
#[must_use]
pub fn quantity(name: &str) -> &str {
    features::friction(name).or_else(|| features::order(name)).unwrap_or(name)
}

/// Which way a coordinate has left what is usual.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// It is larger.
    Risen,
    /// It is smaller.
    Fallen,
}

impl Side {
    /// By the sign of its deviations.
    #[must_use]
    pub fn of(deviations: f32) -> Self {
        if deviations < 0.0 { Self::Fallen } else { Self::Risen }
    }

    /// Where it now lies.
    #[must_use]
    pub const fn place(self) -> &'static str {
        match self {
            Self::Risen => "above",
            Self::Fallen => "below",
        }
    }
}

impl fmt::Display for Side {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Risen => "risen",
            Self::Fallen => "fallen",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::Structure;

    #[test]
    fn a_row_of_one_feature_has_its_name_and_all_others_have_a_number() {
        let features = ["drag", "viscous", "order_outer"].map(String::from);
        #[rustfmt::skip]
        let map = DMatrix::from_row_slice(5, 3, &[
            0.0, 0.0, 1.0,
            1.0, 0.0, 0.0,
            1.0, 1.0, 0.0,
            0.0, -1.0, 0.0,
            0.0, 0.5, 0.0,
        ]);
        assert_eq!(of_map(&map, &features), ["order_outer", "drag", "z3", "z4", "viscous"]);
        let words = ["drag_log", "order_outer", "z3", "zone"].map(in_words);
        assert_eq!(words, ["drag", "outer order", "coordinate 3", "zone"]);
    }

    #[test]
    fn raw_parameters_return_from_the_core_s_map() {
        let catalogue = Catalogue {
            structure: Structure::new(2, 1, 2, 1, 1),
            orders: Some(vec!["outer".into()]),
            averaged: vec![],
        };
        let names = catalogue.names();
        // Each raw feature as a coordinate, the last one first.
        let reversed: Vec<usize> = (0..names.len()).rev().collect();
        // In single precision and scaled, as the core has it.
        let scaled = (catalogue.raw_from_delta() * 0.3).map(|weight| f64::from(weight as f32));
        let map = scaled.select_rows(&reversed) * delta_from_raw(&catalogue);
        assert_eq!(of_map(&map, &names), names.iter().rev().cloned().collect::<Vec<_>>());
    }

    #[test]
    fn sides_are_those_of_the_signs() {
        let sides = [0.0, 3.0, -0.1, f32::NAN].map(Side::of);
        assert_eq!(sides, [Side::Risen, Side::Risen, Side::Fallen, Side::Risen]);
        assert_eq!(sides.map(Side::place), ["above", "above", "below", "above"]);
    }
}
