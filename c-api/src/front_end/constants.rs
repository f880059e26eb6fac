//! The constants of a front end.

use bearing_watch::Angle;
use bearing_watch::drive::{
    BalanceLimits, FrontEndConstants, PhaseSensor, ResolverLimits, RotorFrame, TrackingConstants,
};

use crate::about::park;
use crate::code::Outcome;

/// One current sensor with its converter.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BwPhaseSensor {
    /// Counts at no current; `bw_calibration_finish` measures them.
    pub offset_counts: f32,
    /// Amperes a count; negative if the sensor counts against the direction into the motor.
    pub gain_a: f32,
    /// Lowest usable count; below it sensor or converter is saturated.
    pub lowest_counts: u16,
    /// Highest usable count.
    pub highest_counts: u16,
}

/// Sign convention of the Park transform.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BwPark {
    /// The current is not from a Park transform, or the model does not say.
    Unknown = 0,
    /// With the angle on the magnet axis, positive q current produces positive torque.
    Standard = 1,
    /// The +sin row of the source's Eq. 5.1.
    Thesis = 2,
}

/// What a front end is made of. `bearing-watch train --front-end … --c model.h` writes it as `bw_front_end`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BwFrontEndConstants {
    /// Rate of the raw samples, Hz: 100 … 1e6.
    pub control_rate_hz: f32,
    /// Number of raw samples per clean sample: 1, 2, 4, 8, 16, 32, 6, 12, 24, 48, 10, 20 or 40.
    pub factor: u16,
    /// Number of further channels, at most `BW_MAX_FURTHER`.
    pub further: u16,
    /// Current sensors of phases a, b, c; with two sensors the third is not used, but must be valid.
    pub sensors: [BwPhaseSensor; 3],
    /// Equal counts in a row that mean a stuck converter; 0 if a quiet converter may repeat itself for ever.
    pub stuck_samples: u16,
    /// Samples in a window of the sum of three currents, at least 16: sixteen are an electrical turn.
    pub balance_window_samples: u16,
    /// Noise of the sum of the three currents, its standard deviation, A.
    pub balance_noise_a: f32,
    /// Largest offset of a sensor, and of the sum of the three, that is removed, A.
    pub balance_offset_a: f32,
    /// Tolerated relative error of a gain.
    pub balance_gain_tolerance: f32,
    /// Bandwidth of the loop that follows the shaft angle, Hz: 1/2000 … 1/10 of the control rate.
    pub tracking_bandwidth_hz: f32,
    /// Its damping, 0.5 … 1.
    pub tracking_damping: f32,
    /// Largest error of the locked loop, rad: 0.001 … 0.5.
    pub tracking_error_limit_rad: f32,
    /// Samples in a row, missing or beyond the limit, after which the loop searches again; at least 1.
    pub tracking_lost_samples: u16,
    /// Samples in a row below half of the limit that make the lock; at least 1.
    pub tracking_settle_samples: u16,
    /// Lowest amplitude of resolver signals, in their unit; valid, but not used, for absolute angles.
    pub resolver_lowest_amplitude: f32,
    /// Highest amplitude.
    pub resolver_highest_amplitude: f32,
    /// Largest relative difference of the amplitudes of sine and cosine, noise included.
    pub resolver_mismatch: f32,
    /// Pole pairs of the motor.
    pub pole_pairs: u32,
    /// Electrical angle of the magnet axis when the shaft angle is zero; 2^32 is one turn. A negative angle wraps.
    pub electrical_offset_turn32: u32,
    /// Sign convention of the quadrature current, `BW_PARK_STANDARD` or `BW_PARK_THESIS`.
    pub park: i32,
}

impl BwFrontEndConstants {
    /// The constants of the core, checked.
    ///
    /// # Errors
    /// The first that is out of range.
    pub(crate) fn core(&self) -> Outcome<FrontEndConstants> {
        let constants = FrontEndConstants {
            control_rate_hz: self.control_rate_hz,
            sensors: self.phase_sensors(),
            stuck_samples: self.stuck_samples,
            balance: BalanceLimits {
                noise_a: self.balance_noise_a,
                offset_a: self.balance_offset_a,
                gain_tolerance: self.balance_gain_tolerance,
                window: self.balance_window_samples,
            },
            tracking: TrackingConstants {
                bandwidth_hz: self.tracking_bandwidth_hz,
                damping: self.tracking_damping,
                error_limit_rad: self.tracking_error_limit_rad,
                lost_samples: self.tracking_lost_samples,
                settle_samples: self.tracking_settle_samples,
                resolver: ResolverLimits {
                    low: self.resolver_lowest_amplitude,
                    high: self.resolver_highest_amplitude,
                    mismatch: self.resolver_mismatch,
                },
            },
            frame: RotorFrame {
                pole_pairs: self.pole_pairs,
                electrical_offset: Angle::from_bits(self.electrical_offset_turn32),
                park: park(self.park)?,
            },
        };
        constants.check()?;
        Ok(constants)
    }

    /// The current sensors of the core.
    pub(crate) fn phase_sensors(&self) -> [PhaseSensor; 3] {
        self.sensors.map(|own| PhaseSensor {
            offset_counts: own.offset_counts,
            gain_a: own.gain_a,
            usable: [own.lowest_counts, own.highest_counts],
        })
    }
}
