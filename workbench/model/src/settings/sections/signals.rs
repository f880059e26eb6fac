//! `[channels]`: which column is which signal.

use serde::{Deserialize, Serialize};

use super::choices::Park;
use super::merge::merges;

/// Which column, or which formula of columns, is which signal.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Signals {
    /// Output: a column, or a formula of columns (as a rule the quadrature current): a-b, 0.5*(a + b),
    /// "speed_rpm rad/s", "integrate(speed_rpm) rad"
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "CHANNEL")))]
    pub y: Option<String>,
    /// First input (reference, or reference-measured, of the controlled variable)
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "CHANNEL")))]
    pub u1: Option<String>,
    /// Second input (load); without one, an order with nc = 0
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "CHANNEL")))]
    pub u2: Option<String>,
    /// Current, A; same as y if not given
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "CHANNEL", "x-shaft" = true)))]
    pub current: Option<String>,
    /// Measured velocity, rad/s; without it, the differences of the angle
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "CHANNEL", "x-shaft" = true)))]
    pub velocity: Option<String>,
    /// Reference of the velocity, rad/s: without a load, training needs it for a torque balance without bias
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "CHANNEL", "x-shaft" = true)))]
    pub velocity_ref: Option<String>,
    /// Angle of the shaft, rad: watches friction and bearing orders
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "CHANNEL", "x-shaft" = true)))]
    pub angle: Option<String>,
    /// Load torque, N·m; not measured if not given
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "CHANNEL", "x-shaft" = true)))]
    pub load: Option<String>,
    /// Sign convention of the quadrature current in the recordings; the model then refuses a front end that differs
    #[serde(skip_serializing_if = "Option::is_none")]
    pub park: Option<Park>,
}

merges!(Signals { y, u1, u2, current, velocity, velocity_ref, angle, load, park });
