//! What a front end is made of, and why constants are refused.

use core::fmt;

use crate::drive::{BalanceLimits, PhaseSensor, RotorFrame, TrackingConstants};

/// Constants of a [`FrontEnd`](super::FrontEnd).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FrontEndConstants {
    /// Rate of the raw samples, Hz: 100 … 10⁶.
    pub control_rate_hz: f32,
    /// Current sensors of phases a, b, c, with offsets from an
    /// [`OffsetCalibration`](crate::drive::OffsetCalibration); with two sensors the third is not used.
    pub sensors: [PhaseSensor; 3],
    /// Equal counts in a row that mean a stuck converter; 0 if a quiet converter may repeat itself for ever.
    pub stuck_samples: u16,
    /// What the currents must be: the sum of three, offsets, and the power from which their direction is known.
    pub balance: BalanceLimits,
    /// The loop that follows the shaft angle.
    pub tracking: TrackingConstants,
    /// Pole pairs, offset of the angle and sign convention.
    pub frame: RotorFrame,
}

/// Why constants of a front end are refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum FrontEndError {
    /// The control rate is out of range or not a number.
    ControlRate,
    /// Offset, gain or usable range of a current sensor.
    Sensor,
    /// Noise, tolerance or window of the sum of the currents.
    Balance,
    /// Bandwidth, damping, limits or times of the tracking loop.
    Tracking,
    /// Amplitudes of the resolver.
    Resolver,
    /// There must be at least one pole pair.
    PolePairs,
}

impl FrontEndError {
    /// The error in words.
    #[must_use]
    pub const fn message(self) -> &'static str {
        match self {
            Self::ControlRate => "the control rate is not within 100 Hz and 1 MHz",
            Self::Sensor => "offset, gain or usable range of a current sensor is out of range",
            Self::Balance => "noise, tolerance or window of the sum of the currents is out of range",
            Self::Tracking => "bandwidth, damping, limit or times of the tracking loop are out of range",
            Self::Resolver => "the amplitudes of the resolver are out of range",
            Self::PolePairs => "a motor has at least one pole pair",
        }
    }
}

impl fmt::Display for FrontEndError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.message())
    }
}

impl core::error::Error for FrontEndError {}

impl FrontEndConstants {
    /// Checks every constant.
    ///
    /// # Errors
    /// The first that is out of range.
    pub fn check(&self) -> Result<(), FrontEndError> {
        let checks = [
            ((100.0..=1e6).contains(&self.control_rate_hz), FrontEndError::ControlRate),
            (self.sensors.iter().all(PhaseSensor::is_valid), FrontEndError::Sensor),
            (self.balance.is_valid(), FrontEndError::Balance),
            (self.tracking.is_valid(self.control_rate_hz), FrontEndError::Tracking),
            (self.tracking.resolver.is_valid(), FrontEndError::Resolver),
            (self.frame.pole_pairs > 0, FrontEndError::PolePairs),
        ];
        checks.into_iter().find(|(good, _)| !good).map_or(Ok(()), |(_, error)| Err(error))
    }
}
