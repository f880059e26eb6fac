//! `[bearing]`: the events per turn of its defects, and its load.

use serde::{Deserialize, Serialize};

use super::geometry::Geometry;
use super::merge::merges;

/// Largest relative slip that is searched: real cages slip by up to 2 %, and with the load on the contact angle.
pub(crate) const SLIP: f64 = 0.022;

/// The events per turn of the defects of a bearing, and its load.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Bearing {
    /// A designation, or balls, ball and pitch diameter, and degrees: 6205, or 9,7.94,39.04,0 with the contact angle in
    /// degrees. Tracks outer and inner race, ball and cage; where training chooses the features, the races alone
    #[serde(skip_serializing_if = "Geometry::is_empty")]
    #[cfg_attr(
        feature = "schema",
        schemars(with = "Vec<f64>", extend("x-value" = "BEARING", "x-shaft" = true, "examples" = ["6205"]))
    )]
    pub bearing: Geometry,
    /// Orders to track, events per turn, e.g. outer=3.718,sideband=4.718
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "NAME=ORDER", "x-pairs" = true, "x-shaft" = true)))]
    pub orders: Vec<String>,
    /// Weights of an order's first three harmonics [default: 1,0.5,0.25, or the first of them that find more]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "W1,W2,W3", "x-shaft" = true)))]
    pub harmonics: Vec<f64>,
    /// Largest relative slip of the bearing's cage that is searched [default: 0.022]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "PART", "x-shaft" = true)))]
    pub slip: Option<f64>,
    /// Basic dynamic load rating C of the catalogue, N: replay then gives load collective and nominal life by ISO 281
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "NEWTON")))]
    pub load_rating_n: Option<f64>,
    /// The rolling elements are rollers, not balls
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub rollers: bool,
    /// Load of the bearing that does not change, N
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "NEWTON")))]
    pub bearing_load_n: Option<f64>,
    /// Load of the bearing per torque, N/(N·m): of a gear or belt one over its radius, of a screw 2π over its lead
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "FACTOR")))]
    pub bearing_load_per_nm: Option<f64>,
    /// Torque constant of the motor, N·m/A: the torque of the bearing's load is that of the current, otherwise that of
    /// the load sensor
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "FACTOR")))]
    pub torque_constant_nm_a: Option<f64>,
}

merges!(Bearing {
    bearing,
    orders,
    harmonics,
    slip,
    load_rating_n,
    rollers,
    bearing_load_n,
    bearing_load_per_nm,
    torque_constant_nm_a,
});
