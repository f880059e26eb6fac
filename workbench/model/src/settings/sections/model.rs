//! `[model]`: how the detector estimates, and how it decides.

use serde::{Deserialize, Serialize};

use super::choices::{Discriminant, Method, Projection, VelocityFrom};
use super::merge::merges;
use super::order::Order;

/// Part of the variance that a projection keeps.
pub(crate) const VARIANCE: f64 = 0.99;

/// How the detector estimates, and how it decides.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Model {
    /// na,nb,nc,nkb,nkc; of `train` 2,1,2,1,1 if not given, or 2,1,0,1,1 without a second input
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "ORDER")))]
    pub order: Option<Order>,
    /// Estimate a constant term too (recorded signals have operating points)
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub offset: bool,
    /// How the detector estimates a segment's parameters
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("default" = Method::default())))]
    pub method: Option<Method>,
    /// The class whose mean is the nominal model, the starting point of the estimation; the healthy class if not given,
    /// or else the first
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "CLASS")))]
    pub nominal: Option<String>,
    /// Samples per segment (after averaging and decimation); if not given the longest training trace, or equal parts
    /// of it of at least 10 s, 100 turns and 10 000 samples
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "N")))]
    pub segment: Option<usize>,
    /// Average blocks of N samples first
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "N", "default" = 1)))]
    pub block_mean: Option<usize>,
    /// Then apply an anti-alias filter and keep every N-th sample
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "N", "default" = 1)))]
    pub decimate: Option<usize>,
    /// Forgetting factor per sample (0.5 to 0.9999), instead of a new start at every segment
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "FACTOR")))]
    pub memory: Option<f64>,
    /// Samples into the next segment at which a segment's model takes over, for firmware that solves in its main loop
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "N", "default" = 0)))]
    pub handover: Option<u16>,
    /// Magnitudes at which the sensors of y, u1, u2 are saturated: samples at or above them are not used
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "Y,U1,U2")))]
    pub saturation: Vec<f64>,
    /// Number of equal samples of y in a row that indicates a stuck sensor; the segment then has no verdict; 0 for no
    /// limit
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "N", "default" = 0)))]
    pub stuck: Option<u16>,
    /// Where the shaft takes the velocity from
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend(
        "x-value" = "SOURCE", "default" = VelocityFrom::default(), "x-shaft" = true
    )))]
    pub velocity_from: Option<VelocityFrom>,
    /// Lag of the current behind velocity and load, samples; without it, the lags of all three are estimated from the
    /// nominal class
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "SAMPLES", "x-shaft" = true)))]
    pub current_delay: Option<f64>,
    /// Cut-off of the torque balance's filter, Hz
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "HZ", "x-shaft" = true)))]
    pub balance_cutoff_hz: Option<f64>,
    /// Turns of the motor for one turn of an axis behind a gear or belt that carries a weight, where no load is
    /// measured: the detector then estimates the weight with the friction; found in the healthy traces if not given;
    /// 0: no weight
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "TURNS", "x-shaft" = true)))]
    pub gear_ratio: Option<f64>,
    /// a, b, c, offset, log_variance, friction, friction_scores, friction_logs, orders, or single ones such as a1,
    /// viscous_score, viscous_log or order_outer; mean_CHANNEL or rms_CHANNEL of any column; if not given, training
    /// chooses those that detect best where the angle is known, and takes every parameter elsewhere
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "NAMES")))]
    pub features: Vec<String>,
    /// Features that explain a part of the others in healthy traces, e.g. mean_temperature_c: that part is subtracted;
    /// outside the range of the healthy traces, what they explain is missing; if neither they nor features are given,
    /// training takes the temperatures that explain the features it chooses
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "NAMES")))]
    pub covariates: Vec<String>,
    /// Features that a defect only raises, e.g. viscous: the gate judges them upwards only, given the others, as it
    /// does with the scores of orders
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "NAMES")))]
    pub rising: Vec<String>,
    /// Let the detector also estimate what no feature reads, for reports and telemetry: the parameters of the
    /// difference model and, if features are given, each order of the bearing
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub identify: bool,
    /// Projection of the features
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("default" = Projection::default())))]
    pub projection: Option<Projection>,
    /// Components to keep (pca, pca-raw, fisher)
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "N")))]
    pub components: Option<usize>,
    /// Part of the variance to keep if no number of components is given (pca, pca-raw)
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "PART", "default" = VARIANCE)))]
    pub variance: Option<f64>,
    /// Class covariances: shared, separate, or between the two
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("default" = Discriminant::default())))]
    pub discriminant: Option<Discriminant>,
    /// Fixed shrinkage of class covariances instead: towards the shared one, and of their correlations, each 0 to 1
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "SHARED,DIAGONAL")))]
    pub shrinkage: Vec<f64>,
    /// Relative deviation of a defect's size from that in training, e.g. 0.25: classes reach towards the healthy one,
    /// so that smaller defects keep their name; needs a healthy class and separate covariances
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "PART", "default" = 0)))]
    pub size_spread: Option<f64>,
}

merges!(Model {
    order,
    offset,
    method,
    nominal,
    segment,
    block_mean,
    decimate,
    memory,
    handover,
    saturation,
    stuck,
    velocity_from,
    current_delay,
    balance_cutoff_hz,
    gear_ratio,
    features,
    covariates,
    rising,
    identify,
    projection,
    components,
    variance,
    discriminant,
    shrinkage,
    size_spread
});
