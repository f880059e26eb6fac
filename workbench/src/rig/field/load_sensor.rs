//! The measurement of the load torque.
//!
//! ```text
//! T_m(t) = (1 + g) T(t − d) + o + n(t),   n white      (1)
//! ```
//!
//! T is linear between samples and constant before the first one.

use crate::rig::{NoiseSource, RigError, not_negative};

/// How the load torque is measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LoadMeasurement {
    /// The true load is recorded.
    Exact,
    /// The load is recorded by a sensor with errors.
    Sensor(LoadSensor),
    /// There is no load sensor: the load is not recorded.
    Absent,
}

/// Ranges of the sensor's errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadSensor {
    /// Largest |g| of (1).
    pub gain: f64,
    /// Largest |o| of (1).
    pub offset_nm: f64,
    /// Standard deviation of n of (1).
    pub noise_nm: f64,
    /// d of (1).
    pub delay_s: f64,
}

/// Values of one record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadSensorValues {
    /// 1 + g of (1).
    pub gain: f64,
    /// o of (1).
    pub offset_nm: f64,
    /// Standard deviation of n of (1).
    pub noise_nm: f64,
    /// d of (1).
    pub delay_s: f64,
}

impl LoadSensor {
    /// The ranges of the field.
    pub const FIELD: Self = Self { gain: 0.05, offset_nm: 0.01, noise_nm: 0.01, delay_s: 0.005 };

    pub(super) fn validate(&self) -> Result<(), RigError> {
        not_negative("field.load_sensor.gain", self.gain)?;
        not_negative("field.load_sensor.offset_nm", self.offset_nm)?;
        not_negative("field.load_sensor.noise_nm", self.noise_nm)?;
        not_negative("field.load_sensor.delay_s", self.delay_s)?;
        Ok(())
    }

    pub(super) fn draw(&self, mut source: NoiseSource) -> LoadSensorValues {
        LoadSensorValues {
            gain: 1.0 + source.uniform(-self.gain, self.gain),
            offset_nm: source.uniform(-self.offset_nm, self.offset_nm),
            noise_nm: self.noise_nm,
            delay_s: self.delay_s,
        }
    }
}

impl LoadSensorValues {
    /// A sensor without errors.
    pub const EXACT: Self = Self { gain: 1.0, offset_nm: 0.0, noise_nm: 0.0, delay_s: 0.0 };

    /// The measured loads (1) of the true loads at these times.
    #[must_use]
    pub fn measure(&self, t_s: &[f64], load_nm: &[f64], mut noise: NoiseSource) -> Vec<f64> {
        let mut segment = 0;
        t_s.iter()
            .map(|t| {
                let then = t - self.delay_s;
                while segment + 1 < t_s.len() && t_s[segment + 1] <= then {
                    segment += 1;
                }
                let load = interpolate(t_s, load_nm, segment, then);
                self.gain * load + self.offset_nm + self.noise_nm * noise.gaussian() // (1)
            })
            .collect()
    }
}

/// The value at `t` on the straight line from sample `k` to the next; constant beyond the ends.
fn interpolate(t_s: &[f64], values: &[f64], k: usize, t: f64) -> f64 {
    let Some((next_s, next)) = t_s.get(k + 1).zip(values.get(k + 1)) else { return values[k] };
    let part = ((t - t_s[k]) / (next_s - t_s[k])).max(0.0);
    values[k] + part * (next - values[k])
}
