//! A reading of the position sensor, and the angle that the tracking loop makes of it.

use super::resolver;
use crate::signal::{Angle, RAD};

/// What the position sensor delivers at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Position {
    /// Demodulated sine and cosine of a resolver, or of a sine/cosine encoder, in the unit of
    /// [`ResolverLimits`](super::ResolverLimits).
    Resolver {
        /// Amplitude times sine.
        sin: f32,
        /// Amplitude times cosine.
        cos: f32,
    },
    /// The angle from a converter or an absolute encoder; see [`Angle::from_counts`].
    Absolute(Angle),
    /// No reading, or one that the sensor says is wrong.
    Missing,
}

impl Position {
    /// An angle near to the reading, if there is one.
    pub(super) fn coarse(&self) -> Angle {
        match *self {
            Self::Resolver { sin, cos } => resolver::coarse(sin, cos),
            Self::Absolute(angle) => angle,
            Self::Missing => Angle::ZERO,
        }
    }
}

/// One tracked sample.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Tracked {
    /// The loop's angle θ̂ at the instant of the sample.
    pub angle: Angle,
    /// The error (1), rad; with a resolver its tangent, at most 1.
    pub error_rad: f32,
}

impl Tracked {
    /// The angle as measured, with its noise: θ̂ + e.
    #[inline]
    #[must_use]
    #[expect(clippy::cast_possible_truncation, reason = "at most π, which is 2³¹ counts; `as` saturates")]
    pub fn measured(&self) -> Angle {
        self.angle.turned((self.error_rad * (1.0 / RAD)) as i32)
    }
}
