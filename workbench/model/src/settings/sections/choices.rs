//! Settings that are one of a few words.

use bearing_watch::plan::Method as CoreMethod;
use serde::{Deserialize, Serialize};

use crate::train::VelocitySource;

/// Sign convention of the quadrature current.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Park {
    /// With the angle on the magnet axis, positive q current produces positive torque
    Standard,
    /// The +sin row of the source's Eq. 5.1
    Thesis,
}

impl Park {
    pub(crate) const fn core(self) -> bearing_watch::Park {
        match self {
            Self::Standard => bearing_watch::Park::Standard,
            Self::Thesis => bearing_watch::Park::Thesis,
        }
    }
}

/// How the detector estimates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Least squares: cheapest, biased by output noise
    #[default]
    Ls,
    /// Streaming instrumental variables: consistent under output noise
    Instruments,
}

impl Method {
    /// As the core names it.
    #[must_use]
    pub const fn core(self) -> CoreMethod {
        match self {
            Self::Ls => CoreMethod::LeastSquares,
            Self::Instruments => CoreMethod::Instruments,
        }
    }
}

/// Where the shaft takes the velocity from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum VelocityFrom {
    /// Channel or angle, whichever leaves less noise at the bearing orders
    #[default]
    Best,
    /// The channel of the velocity
    Channel,
    /// Differences of the angle
    Angle,
}

impl From<VelocityFrom> for VelocitySource {
    fn from(source: VelocityFrom) -> Self {
        match source {
            VelocityFrom::Best => Self::Best,
            VelocityFrom::Channel => Self::Channel,
            VelocityFrom::Angle => Self::Angle,
        }
    }
}

/// Projection of the features.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Projection {
    /// Every feature, scaled
    #[default]
    None,
    /// Principal components of the standardised features
    Pca,
    /// Principal components of the centred features, as in the source
    PcaRaw,
    /// Fisher's directions: largest spread between classes relative to the spread within them
    Fisher,
}

/// Covariances of the classes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Discriminant {
    /// One covariance for all classes
    #[default]
    Linear,
    /// A separate covariance for each class
    Quadratic,
    /// Between the two and a diagonal, by the best cross-validated log score
    Shrunk,
}

/// Whether a model has a novelty gate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Novelty {
    /// If there is a healthy class, and its traces support the rate
    #[default]
    Gate,
    /// No gate and no alarm: the nearest class is the verdict
    None,
}
